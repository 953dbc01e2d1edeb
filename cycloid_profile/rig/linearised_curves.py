"""First-order change of a predicted curve by a small change of the reducer, without new equilibria.

A change of gap, bearing fit, stiffness or play acts like a small change of a gap or a fit under the present forces
(docs/theory.md, Eqs. 50, 51).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import DiscCompliance, stage_displacements
from cycloid_profile.contact.stage import LoadedContacts, StageTangent
from cycloid_profile.effects import AsBuiltReducer, ReducerChange
from cycloid_profile.measurement import HYSTERESIS
from cycloid_profile.rig.prediction import CurvePrediction, Term, loop_path


class FlankWeights(NamedTuple):
    """Loaded pins of one disc in the poses of one term: number of the ``pose``, phase ``along`` the disc where the pin
    presses [rad], and ``weight``, the change of a row of this pose per removal there; all of one shape.

    ``of`` the pose to which each row is equivalent, shape (rows,).
    """

    pose: IntArray
    along: FloatArray
    weight: FloatArray
    of: IntArray

    @property
    def poses(self) -> int:
        """Number of poses."""
        return int(np.max(self.of)) + 1


class LinearisedCurve:
    """Changes of one predicted curve to first order."""

    def __init__(self, prediction: CurvePrediction) -> None:
        self.prediction = prediction
        self._terms = [_TermTangent(prediction, term) for term in prediction.terms]

    def change(self, after: AsBuiltReducer) -> FloatArray:
        """Change of the column when the reducer becomes ``after``, in its unit, shape (rows,); finite everywhere."""
        changed = sum(one.term.weight * one.rotation(after) for one in self._terms)
        # A pose without an equilibrium has no change.
        return np.nan_to_num(np.asarray(changed) / self.prediction.unit, posinf=0.0, neginf=0.0)

    def opened(self, by: Callable[[LoadedContacts], FloatArray]) -> FloatArray:
        """Change of the column when each loaded contact opens by a gap, a function of the contacts [mm], shape
        (rows,).
        """
        changed = sum(one.term.weight * one.opened(by) for one in self._terms)
        return np.asarray(changed) / self.prediction.unit

    def softened(self, by: tuple[DiscCompliance, ...]) -> FloatArray:
        """Change of the column by discs with a further compliance ``by``, one each, shape (rows,)."""
        changed = sum(one.term.weight * one.softened(by) for one in self._terms)
        return np.asarray(changed) / self.prediction.unit

    def flank_weights(self, disc: int) -> list[FlankWeights]:
        """Change of the column by a small removal at each place of a disc, counted from 0, that a pin presses on: the
        sum over the terms.
        """
        return [one.flank_weights(disc, one.term.weight / self.prediction.unit) for one in self._terms]


class _TermTangent:
    """Linearisation of one term.

    Flanks and bearings are evaluated at one pose of each set of equivalent ones, pins row by row.
    """

    def __init__(self, prediction: CurvePrediction, term: Term) -> None:
        self.reducer, self.term = prediction.reducer, term
        self.measurement, self.rows = prediction.measurement, prediction.rows
        self.tangent = StageTangent(term.sharing, prediction.reducer.deviations)

    @cached_property
    def weight(self) -> FloatArray:
        """Rotation per gap of each loaded contact, shape (contacts,) [rad/mm]."""
        at = self.tangent.contacts
        return self.tangent.pins[at.pose, at.disc, at.pin]

    @cached_property
    def by_pins(self) -> tuple[ComplexArray, FloatArray]:
        """Derivative of the rotation by the shift of each pin, to be taken as the real part of the product, and by its
        oversize, shape (rows, pins) [rad/mm].
        """
        stage = self.term.sharing.stage
        assert stage is not None
        shift = np.sum(self.tangent.pins * np.conj(stage.normal), axis=1)
        oversize: FloatArray = -np.sum(self.tangent.pins, axis=1)
        equivalent = self.term.equivalent
        turned = np.conj(equivalent.turn(shift.shape[-1]))[:, np.newaxis]
        return equivalent.over_pins(shift) * turned, equivalent.over_pins(oversize)

    def rotation(self, after: AsBuiltReducer) -> FloatArray:
        """Change of the angle read, shape (rows,) [rad]."""
        before = self.reducer
        change = ReducerChange(before, after)
        turned: FloatArray = self._at_poses(change)[self.term.equivalent.representative]
        if after.pin_shift is not before.pin_shift or after.pin_oversize is not before.pin_oversize:
            by_shift, by_oversize = self.by_pins
            turned += (by_shift @ (after.pin_shift - before.pin_shift)).real
            turned += by_oversize @ (after.pin_oversize - before.pin_oversize)
        if change.sun_shift:
            turned += self._by_misfit_row_by_row(change)
        if (after.encoder, after.input_error) != (before.encoder, before.input_error):
            turned += change.angle_error(self.term.output_angle)
        return turned + self._path_change(after)

    def _at_poses(self, change: ReducerChange) -> FloatArray:
        """Rotation by flanks, contact law and bearings, which equivalent poses have in common, shape (poses,)."""
        tangent = self.tangent
        turned = np.zeros(self.term.sharing.torque.size)
        for opened in (change.removal(tangent.contacts), change.softening(tangent.contacts)):
            if opened is not None:
                turned += np.bincount(tangent.contacts.pose, self.weight * opened, turned.size)
        misfit = None if change.sun_shift else change.misfit(tangent.crank_angle)
        if misfit is not None:
            turned += np.sum(tangent.bearings * misfit, axis=(1, 2))
        if change.after.case is not change.before.case:
            bearing_deflection_change = change.bearing_deflection_change(tangent.point.bearing_force)
            if bearing_deflection_change is not None:
                turned -= np.sum(tangent.bearings * bearing_deflection_change, axis=(1, 2))
        return turned

    def opened(self, by: Callable[[LoadedContacts], FloatArray]) -> FloatArray:
        """Rotation by gaps opened at the loaded contacts, shape (rows,) [rad]."""
        at = self.tangent.contacts
        turned = np.bincount(at.pose, self.weight * by(at), self.term.sharing.torque.size)
        return np.asarray(turned[self.term.equivalent.representative])

    def softened(self, by: tuple[DiscCompliance, ...]) -> FloatArray:
        """Rotation by discs with a further compliance under the present forces, shape (rows,) [rad]."""
        sharing, bearings = self.term.sharing, self.tangent.bearings
        assert sharing.stage is not None
        moved = stage_displacements(by, sharing.stage.meshing, sharing.load)
        flanks, holes = np.split(moved, [sharing.force[0].size], axis=1)
        receded = flanks.reshape(sharing.force.shape)
        by_holes = np.sum(bearings * holes.reshape(bearings.shape), axis=(1, 2))
        by_flanks = self.opened(lambda at: receded[at.pose, at.disc, at.pin])
        turned: FloatArray = by_flanks - by_holes[self.term.equivalent.representative]
        return turned

    def _by_misfit_row_by_row(self, change: ReducerChange) -> FloatArray:
        """Rotation by the fits of the bearings, shape (rows,): the sun can differ between equivalent poses."""
        tangent, equivalent = self.tangent, self.term.equivalent
        solved = tangent.crank_angle[equivalent.representative]
        trochoid = self.reducer.case.drive.trochoid
        ahead = -trochoid.lobes * self.term.output_angle - solved[:, 0]
        misfit = change.misfit(solved + ahead[:, np.newaxis])
        assert misfit is not None
        weight = (tangent.bearings[..., 0] + 1j * tangent.bearings[..., 1])[equivalent.representative]
        weight = weight * equivalent.turn(trochoid.pins)[:, np.newaxis]
        return np.asarray(np.sum(weight.real * misfit[..., 0] + weight.imag * misfit[..., 1], axis=1))

    def flank_weights(self, disc: int, scale: float) -> FlankWeights:
        """``scale`` times the rotation per removal at each loaded pin [rad/mm]."""
        at = self.tangent.contacts
        (own,), foot, lobe = at.by_disc[disc]
        return FlankWeights(
            at.pose[own], foot + 2.0 * np.pi * lobe, scale * self.weight[own], self.term.equivalent.representative
        )

    def _path_change(self, after: AsBuiltReducer) -> FloatArray | float:
        """Change by friction and by what twists in series, along the path of a loop, shape (rows,) [rad]."""
        before, through = self.reducer, self.term.through
        names = (
            "series_compliance",
            "further_twists",
            "coulomb_torque",
            "friction_spread",
            "proportional_friction",
            "breakaway_torque",
            "breakaway_travel",
        )
        if all(getattr(after, name) == getattr(before, name) for name in names):
            return 0.0
        if self.measurement.kind is not HYSTERESIS:
            return after.series_twist(through) - before.series_twist(through)
        transmitted, twisted = loop_path(after, self.measurement)
        compliance = self.tangent.torsional_compliance[self.term.equivalent.representative]
        turned = compliance * (transmitted[self.rows] - through)
        return np.asarray(turned + twisted[self.rows] - self.term.twist)
