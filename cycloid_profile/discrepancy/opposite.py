"""The opposite of a tooth's errors on its drawing, and what the machine makes of a program when they come again.

The set-up (wheel, infeed, eccentricity) is mirrored about the drawing, every removal is taken the other way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import NormalRemoval, RemovalJet
from cycloid_profile.geometry.trochoid import Trochoid


@dataclass(frozen=True, slots=True)
class Opposite:
    """A removal the other way round: what ``of`` takes off is left on."""

    of: NormalRemoval

    @property
    def whole_disc(self) -> bool:
        """See ``NormalRemoval``."""
        return self.of.whole_disc

    @property
    def spacing(self) -> float | None:
        """See ``NormalRemoval``."""
        return self.of.spacing

    @property
    def corners(self) -> tuple[float, ...]:
        """See ``NormalRemoval``."""
        return self.of.corners

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        value, first, second = self.of.jet(phase, side, trochoid)
        return RemovalJet(-value, -first, -second)


def opposite(drawing: ToothProfile, tooth: ToothProfile) -> ToothProfile:
    """The drawing with the opposite of all that ``tooth`` departs from it; the drawing itself where nothing does.

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
    turned = tuple(_turned(removal) for removal in tooth.removals[count:])
    return ToothProfile(trochoid, 2.0 * drawing.pin_radius - tooth.pin_radius, (*drawing.removals, *turned))


def repeated(drawing: ToothProfile, built: ToothProfile, program: ToothProfile) -> ToothProfile:
    """The program with what the spec already held against the drawing: the machine does it again."""
    if built is drawing:
        return program
    trochoid = replace(
        program.trochoid,
        pin_circle_radius=program.trochoid.pin_circle_radius
        + (built.trochoid.pin_circle_radius - drawing.trochoid.pin_circle_radius),
        eccentricity=program.trochoid.eccentricity + (built.trochoid.eccentricity - drawing.trochoid.eccentricity),
    )
    radius = program.pin_radius + (built.pin_radius - drawing.pin_radius)
    return ToothProfile(trochoid, radius, (*program.removals, *built.removals[len(drawing.removals) :]))


def _turned(removal: NormalRemoval) -> NormalRemoval:
    return removal.of if isinstance(removal, Opposite) else Opposite(removal)
