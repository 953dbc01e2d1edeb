"""First-order difference of two reducers: gaps, bearing fits and flank geometry (docs/tolerance.md, Eq. 57).

Small errors superpose: one pattern for each error replaces repeated solves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.bodies import PartDeviations, bearing_law, support_misfit
from cycloid_profile.contact.stage import ContactChange, ContactPoints, CurvedContacts, LoadedContacts
from cycloid_profile.effects.reducer import AsBuiltReducer, encoder_error, output_error_by_input
from cycloid_profile.geometry import ToothProfile, flank_side

_BEARING_SHIFTS = ("eccentric_shift", "bore_shift", "crank_lead", "sun_shift")


def removal_between(before: ToothProfile, after: ToothProfile, phase: FloatArray, lobe: FloatArray) -> FloatArray:
    """Normal removal from ``before`` to ``after``, to first order, in the shape of ``phase`` [mm].

    Added removals are summed directly. Any other change of the curve is found from points of the same phase.
    """
    more = len(before.removals)
    same = after.trochoid == before.trochoid and after.pin_radius == before.pin_radius
    if same and after.removals[:more] == before.removals:
        along = phase + 2.0 * np.pi * lobe
        side = flank_side(phase)
        added = (one.derivatives(along, side, after.trochoid).value for one in after.removals[more:])
        return sum(added, np.zeros_like(along))
    return -_flank_change(before, after, phase, lobe).shift.real


class _FlankChange(NamedTuple):
    """Change of a flank at points of the same phase: ``shift`` along the normal (real) and the tangent (imaginary)
    [mm], ``turn`` of the normal [rad] and gain of ``curvature`` [1/mm].
    """

    shift: ComplexArray
    turn: FloatArray
    curvature: FloatArray


def _flank_change(before: ToothProfile, after: ToothProfile, phase: FloatArray, lobe: FloatArray) -> _FlankChange:
    old, new = before.at(phase, None, lobe), after.at(phase, None, lobe)
    along = np.conj(old.normal)
    return _FlankChange(
        along * (new.position - old.position), (along * (new.normal - old.normal)).imag, new.curvature - old.curvature
    )


@dataclass(frozen=True)
class ReducerChange:
    """The reducer ``before`` and ``after`` a small change, ``step`` units of a parameter; all results are per unit.

    A method returns None where its quantity does not change.
    """

    before: AsBuiltReducer
    after: AsBuiltReducer
    step: float = 1.0

    @property
    def play(self) -> float:
        """Increase of the radial bearing play [mm]."""
        return (self.after.case.drive.support.bearing_play - self.before.case.drive.support.bearing_play) / self.step

    def series_twist(self, torque: FloatArray) -> FloatArray:
        """Increase of the settled twist in series with the stage, in the shape of ``torque`` [N·mm → rad]."""
        return np.asarray((self.after.series_twist(torque) - self.before.series_twist(torque)) / self.step)

    @property
    def sun_shift(self) -> complex:
        """Change of the sun's offset [mm]."""
        return (self.after.sun_shift - self.before.sun_shift) / self.step

    def angle_error(self, output_angle: FloatArray | float) -> FloatArray:
        """Change of the errors of encoder and input, in the shape of ``output_angle`` [rad]."""
        ahead = self.after.input_error - self.before.input_error
        read = encoder_error(self.after.encoder - self.before.encoder, output_angle)
        return (read + output_error_by_input(self.before.case.drive, ahead, output_angle)) / self.step

    def removal(self, at: ContactPoints) -> FloatArray | None:
        """Increase of the gap by the flanks alone, in the shape of the points [mm]."""
        if self.after.teeth is self.before.teeth:
            return None
        found = np.zeros(at.foot.shape)
        for old, new, (own, foot, lobe) in zip(self.before.teeth, self.after.teeth, at.by_disc, strict=True):
            if new is not old:
                found[own] = removal_between(old, new, foot, lobe)
        return found / self.step

    def gap(self, at: ContactPoints) -> FloatArray | None:
        """Increase of the gap by flanks and pins, in the shape of the points [mm]."""
        flanks, ring = self.removal(at), self._ring(at)
        if ring is None:
            return flanks
        moved: FloatArray = ring.real / self.step
        return moved if flanks is None else flanks + moved

    def _ring(self, at: ContactPoints) -> ComplexArray | None:
        """Shift of pins along the normal, less their growth (real), and along the tangent, for the whole step [mm]."""
        if self.after.pin_shift is self.before.pin_shift and self.after.pin_oversize is self.before.pin_oversize:
            return None
        moved = np.conj(at.normal) * (self.after.pin_shift - self.before.pin_shift)[at.pin]
        return np.asarray(moved - (self.after.pin_oversize - self.before.pin_oversize)[at.pin])

    def softening(self, at: LoadedContacts) -> FloatArray | None:
        """Increase of the approach under the acting forces by another contact law, shape (contacts,) [mm]."""
        old, new = self.before.case.law, self.after.case.law
        if new is old:
            return None
        contact = self.before.case.line_contact(at.curvature)
        return np.asarray((new.approach(at.force, contact) - old.approach(at.force, contact)) / self.step)

    def contact_change(self, at: CurvedContacts) -> ContactChange:
        """Gaps and flank geometry of loaded contacts."""
        softer, ring = self.softening(at), self._ring(at)
        gap, pin_across, foot_across, turn, curvature = (np.zeros(at.force.shape) for _ in range(5))
        if ring is not None:
            gap += ring.real / self.step
            # The tangent is −i times the normal.
            pin_across -= ring.imag / self.step
            foot_across += pin_across
        for old, new, (own, foot, lobe) in zip(self.before.teeth, self.after.teeth, at.by_disc, strict=True):
            if new is not old:
                flank = _flank_change(old, new, foot, lobe)
                gap[own] -= flank.shift.real / self.step
                turn[own] = flank.turn / self.step
                # The centre of the pin lies ``distance`` beyond the foot on the normal.
                foot_across[own] += (flank.shift.imag + at.distance[own] * flank.turn) / self.step
                curvature[own] = flank.curvature / self.step
        return ContactChange(gap if softer is None else gap + softer, pin_across, foot_across, turn, curvature)

    def misfit(self, crank_angle: FloatArray) -> FloatArray | None:
        """Change of the unloaded bearing deflection by eccentric, bore and planet errors, shape (poses, bearings, 2)
        [mm].
        """
        if all(getattr(self.after, name) is getattr(self.before, name) for name in _BEARING_SHIFTS):
            return None
        moved = {name: getattr(self.after, name) - getattr(self.before, name) for name in _BEARING_SHIFTS}
        return support_misfit(self.before.case.drive, crank_angle, PartDeviations(**moved)) / self.step

    def bearing_deflection_change(self, bearing_force: FloatArray) -> FloatArray | None:
        """Change of the deflection under the acting forces, by law and play, shape (poses, bearings, 2) [mm]."""
        old, new = self.before.case.drive.support, self.after.case.drive.support
        before, after = bearing_law(old), bearing_law(new)
        if before == after and not self.play:
            return None
        size = np.hypot(bearing_force[..., 0], bearing_force[..., 1])
        more = after.displacement(size, new.bearing_play) - before.displacement(size, old.bearing_play)
        # The direction first: play over the force of an idle bearing, which is rounding, would overflow.
        direction = bearing_force / np.where(size > 0.0, size, 1.0)[..., np.newaxis]
        return np.asarray((more / self.step)[..., np.newaxis] * direction)
