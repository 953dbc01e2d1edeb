"""How a predicted curve answers to a small change of the reducer: one product in place of new equilibria.

Gaps, bearing fits, stiffnesses and plays all act like small changes of a gap or of a fit at the forces that are there
(docs/theory.md, Eqs. 50, 51).
"""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.influence import Influence, influence
from cycloid_profile.contact.support import support_misfit
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.rig.hysteresis import stage_torque
from cycloid_profile.rig.prediction import CurvePrediction, Term, torque_before
from cycloid_profile.units import NEWTON_METRE


class FlankWeights(NamedTuple):
    """Loaded pins of one disc in the poses of one term: number of the ``pose``, phase ``along`` the disc where the pin
    presses [rad], and ``weight``, what a row of this pose gains per removal there; all of one shape.

    ``of`` which pose each row is like, shape (rows,).
    """

    pose: IntArray
    along: FloatArray
    weight: FloatArray
    of: IntArray

    @property
    def poses(self) -> int:
        """How many poses there are."""
        return int(np.max(self.of)) + 1


class FirstOrder:
    """Changes of one predicted curve to first order."""

    def __init__(self, prediction: CurvePrediction) -> None:
        self.prediction = prediction
        self._terms = [_TermAnswer(prediction, term) for term in prediction.terms]

    def change(self, after: Built) -> FloatArray:
        """What the column gains when the reducer becomes ``after``, in its unit, shape (rows,); not NaN anywhere."""
        changed = sum(answer.term.weight * answer.rotation(after) for answer in self._terms)
        return np.asarray(changed) / self.prediction.unit

    def flank_weights(self, disc: int) -> list[FlankWeights]:
        """What the column gains by a small removal at each place of a disc, counted from 0, that a pin presses on: the
        sum over the terms.
        """
        return [answer.flank_weights(disc, answer.term.weight / self.prediction.unit) for answer in self._terms]


class _TermAnswer:
    """Answer of one term; loaded pins only, because the others do not matter.

    What does not tell one pin from another is worked out at the poses that are alike no other.
    """

    def __init__(self, prediction: CurvePrediction, term: Term) -> None:
        self.built, self.term = prediction.built, term
        self.measurement, self.rows = prediction.measurement, prediction.rows

    @cached_property
    def influence(self) -> Influence:
        return influence(self.term.sharing, self.built.parts)

    @cached_property
    def loaded(self) -> list[tuple[IntArray, FloatArray, FloatArray, FloatArray]]:
        """For each disc the pose of each loaded pin, its influence, phase of the foot and lobe."""
        stage = self.term.sharing.stage
        assert stage is not None
        found = []
        sense = np.sign(self.term.sharing.torque)[:, np.newaxis]
        for j in range(self.built.discs):
            weight: FloatArray = self.influence.pins[:, j]
            some = weight != 0.0
            # The phase of the pin is that of its foot within the approach: micrometres along the flank.
            psi = (sense * self.term.sharing.phase[:, j])[some]
            found.append((np.nonzero(some)[0], weight[some], psi, stage.meshing.lobe[:, j][some]))
        return found

    @cached_property
    def of_pins(self) -> tuple[ComplexArray, FloatArray]:
        """Angle read per shift of each pin, of which the real part counts, and per its oversize, shape (rows, pins)
        [rad/mm].
        """
        stage = self.term.sharing.stage
        assert stage is not None
        shift = np.sum(self.influence.pins * np.conj(stage.normal), axis=1)
        oversize: FloatArray = -np.sum(self.influence.pins, axis=1)
        alike = self.term.alike
        turned = np.conj(alike.turn(shift.shape[-1]))[:, np.newaxis]
        return alike.over_pins(shift) * turned, alike.over_pins(oversize)

    @cached_property
    def misfit(self) -> FloatArray:
        return self._misfit(self.built)

    def rotation(self, after: Built) -> FloatArray:
        """Angle read gains [rad]."""
        before, sharing = self.built, self.term.sharing
        at_poses = np.zeros(sharing.torque.size)
        for j, (old, new) in enumerate(zip(before.teeth, after.teeth, strict=True)):
            if new is not old:
                at_poses += self._of_tooth(j, old, new)
        if after.case is not before.case:
            at_poses += self._of_stiffness(after)
        if any(
            getattr(after, name) is not getattr(before, name)
            for name in ("eccentric_shift", "bore_shift", "crank_lead")
        ):
            at_poses += np.sum(self.influence.bearings * (self._misfit(after) - self.misfit), axis=(1, 2))
        turned = at_poses[self.term.alike.of]
        if after.pin_shift is not before.pin_shift or after.pin_oversize is not before.pin_oversize:
            by_shift, by_oversize = self.of_pins
            turned += (by_shift @ (after.pin_shift - before.pin_shift)).real
            turned += by_oversize @ (after.pin_oversize - before.pin_oversize)
        turned += (after.series_compliance - before.series_compliance) * self.term.through
        if after.encoder != before.encoder:
            turned += ((after.encoder - before.encoder) * np.exp(-1j * self.term.output_angle)).real
        return turned + self._of_friction(after)

    def flank_weights(self, disc: int, scale: float) -> FlankWeights:
        """``scale`` times the angle read per removal at each loaded pin [rad/mm]."""
        pose, weight, psi, lobe = self.loaded[disc]
        return FlankWeights(pose, psi + 2.0 * np.pi * lobe, scale * weight, self.term.alike.of)

    def _of_tooth(self, j: int, old: ToothProfile, new: ToothProfile) -> FloatArray:
        pose, weight, psi, lobe = self.loaded[j]
        opened = weight * removal_between(old, new, psi, lobe)
        return np.asarray(np.bincount(pose, opened, self.term.sharing.torque.size), dtype=np.float64)

    def _misfit(self, built: Built) -> FloatArray:
        stage = self.term.sharing.stage
        assert stage is not None
        return support_misfit(built.case.drive, stage.meshing.crank_angle, built.parts)

    def _of_stiffness(self, after: Built) -> FloatArray:
        """Softer contacts open like gaps, softer or looser bearings stretch like misfits, by what their force takes."""
        sharing, old, new = self.term.sharing, self.built.case, after.case
        turned = np.zeros(sharing.torque.size)
        if new.law is not old.law:
            contact = old.line_contact(sharing.curvature)
            opened = new.law.approach(sharing.force, contact) - old.law.approach(sharing.force, contact)
            turned += np.sum(self.influence.pins * np.where(sharing.force > 0.0, opened, 0.0), axis=(1, 2))
        softer = 1.0 / new.drive.support.bearing_stiffness - 1.0 / old.drive.support.bearing_stiffness
        looser = new.drive.support.bearing_play - old.drive.support.bearing_play
        stage = sharing.stage
        if stage is not None and (softer or looser):
            force = stage.bearing_force.reshape(sharing.torque.size, -1)
            size = np.abs(force)
            along = force / np.where(size > 0.0, size, 1.0)
            slack = softer * force + looser * along
            misfit = -np.stack([slack.real, slack.imag], axis=-1)
            turned += np.sum(self.influence.bearings * misfit, axis=(1, 2))
        return turned

    def _of_friction(self, after: Built) -> FloatArray | float:
        before = self.built
        same = (
            after.coulomb_torque == before.coulomb_torque
            and after.proportional_friction == before.proportional_friction
        )
        if same or self.measurement.kind != "hysteresis":
            return 0.0
        torque = self.measurement["torque_nm"] * NEWTON_METRE
        pushed = torque_before(self.measurement)
        left = stage_torque(torque, after.coulomb_torque, after.proportional_friction, pushed)[self.rows]
        stiffness = self.term.sharing.torsional_stiffness[self.term.alike.of]
        compliance = 1.0 / stiffness + before.series_compliance
        wound: FloatArray = np.nan_to_num(compliance) * (left - self.term.through)
        return wound
