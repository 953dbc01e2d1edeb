"""Correction profile: errors of a tooth negated about its drawing, and the tooth that the machine then produces.

The set-up (wheel, infeed, eccentricity) and every removal change sign relative to the drawing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry import NormalRemoval, RemovalDerivatives, ToothProfile, Trochoid


@dataclass(frozen=True, slots=True)
class NegatedRemoval:
    """Negated removal: material that ``of`` removes is left as stock."""

    of: NormalRemoval

    @property
    def whole_disc(self) -> bool:
        return self.of.whole_disc

    @property
    def point_spacing(self) -> float | None:
        return self.of.point_spacing

    @property
    def corners(self) -> tuple[float, ...]:
        return self.of.corners

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        value, first, second = self.of.derivatives(phase, side, trochoid)
        return RemovalDerivatives(-value, -first, -second)


def correction_profile(drawing: ToothProfile, tooth: ToothProfile) -> ToothProfile:
    """The drawing with all deviations of ``tooth`` negated; the drawing itself if there are none.

    Raises
    ------
    GeometryError
        If that tooth cannot exist.
    """
    if tooth is drawing:
        return drawing
    count = len(drawing.removals)
    trochoid = replace(
        drawing.trochoid,
        pin_circle_radius=2.0 * drawing.trochoid.pin_circle_radius - tooth.trochoid.pin_circle_radius,
        eccentricity=2.0 * drawing.trochoid.eccentricity - tooth.trochoid.eccentricity,
    )
    negated = tuple(_negated(removal) for removal in tooth.removals[count:])
    return ToothProfile(trochoid, 2.0 * drawing.pin_radius - tooth.pin_radius, (*drawing.removals, *negated))


def with_machine_errors(drawing: ToothProfile, actual: ToothProfile, program: ToothProfile) -> ToothProfile:
    """The program with the deviations of the ``actual`` tooth from the drawing: the machine repeats them."""
    if actual is drawing:
        return program
    trochoid = replace(
        program.trochoid,
        pin_circle_radius=program.trochoid.pin_circle_radius
        + (actual.trochoid.pin_circle_radius - drawing.trochoid.pin_circle_radius),
        eccentricity=program.trochoid.eccentricity + (actual.trochoid.eccentricity - drawing.trochoid.eccentricity),
    )
    radius = program.pin_radius + (actual.pin_radius - drawing.pin_radius)
    return ToothProfile(trochoid, radius, (*program.removals, *actual.removals[len(drawing.removals) :]))


def _negated(removal: NormalRemoval) -> NormalRemoval:
    return removal.of if isinstance(removal, NegatedRemoval) else NegatedRemoval(removal)
