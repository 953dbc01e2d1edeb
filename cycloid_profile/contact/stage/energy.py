"""Energy of the stage with gaps linearised at a configuration, and its minimum (docs/theory.md, Eqs. 36–38, 81).

Pins push but never pull, and bearings have play: the energy is convex with a continuous first derivative.
A Newton search that never raises the energy therefore ends at its only minimum.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import BearingLaw, SupportModel
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.laws import ContactLaw, LineContact, compiled_law, contact_constants
from cycloid_profile.contact.mesh import Gaps
from cycloid_profile.contact.stage.over_width import PinTilt, WidthState, no_slices

if TYPE_CHECKING:
    from cycloid_profile.contact.stage._kernels import StageArrays


class EnergyPoint(NamedTuple):
    """Energy, forces and stiffnesses of each pose at one displacement.

    ``energy`` shape (poses,) [N·mm]; ``gradient`` shape (poses, unknowns), the generalised forces out of
    balance; ``approach`` [mm], ``force`` [N] and ``stiffness`` [N/mm] of the pins, shape (poses, discs, pins);
    ``receded``, how far an elastic disc gives way at each pin, of the same shape [mm];
    ``stretch`` [mm] and ``bearing_force`` [N] of the bearings, shape (poses, bearings, 2); ``tilt`` of pins, None
    without slices over the width.
    """

    energy: FloatArray
    gradient: FloatArray
    approach: FloatArray
    force: FloatArray
    stiffness: FloatArray
    receded: FloatArray
    stretch: FloatArray
    bearing_force: FloatArray
    tilt: PinTilt | None = None


@dataclass(frozen=True, eq=False, slots=True)
class StageEnergy:
    """Π(u) of Eqs. 37 and 81 about the displacement at which the gaps were taken.

    ``law`` and ``contact`` of the pins, ``gap`` [mm] and their frames ``normal_x``, ``normal_y``, ``lever``
    [mm], shape (poses, discs, pins); ``disc_unknowns`` and ``spring_stretch`` as in ``SupportModel``;
    ``stretch`` of the bearings there, shape (poses, bearings, 2) [mm]; their law ``bearing`` and
    ``play``, one or shape (poses, 1) [mm]; ``torque`` shape (poses,) and carrier ``rotation`` there [N·mm, rad];
    ``arm`` as in ``SupportModel``.

    ``compliance`` of elastic discs, shape (poses, forces, forces) [mm/N], and the forces ``load`` that deform them,
    shape (poses, forces) [N]: of the pins, disc by disc, then the two components of each bearing. Rigid discs have no
    forces, both arrays are empty. ``width``, the slices over the face width; None for an even load.
    """

    law: ContactLaw
    contact: LineContact
    gap: FloatArray
    normal_x: FloatArray
    normal_y: FloatArray
    lever: FloatArray
    disc_unknowns: IntArray
    spring_stretch: FloatArray
    stretch: FloatArray
    bearing: BearingLaw
    play: float | FloatArray
    torque: FloatArray
    rotation: FloatArray
    arm: FloatArray
    compliance: FloatArray
    load: FloatArray
    width: WidthState | None = None

    @classmethod
    def about(
        cls,
        case: LoadCase,
        support: SupportModel,
        gaps: Gaps,
        u: FloatArray,
        torque: FloatArray,
        compliance: FloatArray,
        load: FloatArray,
    ) -> StageEnergy:
        """Energy about unknowns ``u`` of ``support``, shape (poses, unknowns), where the pins have these ``gaps``."""
        tilt = support.tilt_unknowns
        return cls(
            law=case.law,
            contact=case.line_contact(gaps.curvature),
            gap=gaps.gap,
            normal_x=gaps.normal.real.copy(),
            normal_y=gaps.normal.imag.copy(),
            lever=gaps.lever,
            disc_unknowns=support.disc_unknowns,
            spring_stretch=support.spring_stretch,
            stretch=support.misfit + np.einsum("psdu,pu->psd", support.spring_stretch, u),
            bearing=support.bearing,
            play=support.play,
            torque=torque,
            rotation=u[:, 0],
            arm=support.arm,
            compliance=compliance,
            load=load,
            width=None if case.width is None else WidthState(case.width, tilt, u[:, tilt], support.tilt_stiffness),
        )

    def poses(self, which: BoolArray) -> StageEnergy:
        """The energy of the poses that ``which`` selects."""
        one_for_all = {"law", "contact", "disc_unknowns", "bearing", "arm", "width"}
        if not isinstance(self.play, np.ndarray):
            one_for_all.add("play")
        cut = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name not in one_for_all}
        width = None if self.width is None else replace(self.width, slope=self.width.slope[which])
        return replace(self, **cut, contact=replace(self.contact, curvature=self.contact.curvature[which]), width=width)

    def at(self, step: FloatArray) -> EnergyPoint:
        """Energy and forces a ``step`` away, shape (poses, unknowns) [mm, rad], the discs under their ``load``."""
        moved = step[:, self.disc_unknowns][..., np.newaxis, :]
        yielded = self._yielded()
        receded, at_bearings = self._at_pins_and_bearings(yielded)
        approach = self.normal_x * moved[..., 0] + self.normal_y * moved[..., 1] + self.lever * moved[..., 2] - self.gap
        approach -= receded
        tilt = None
        if self.width is None:
            force, stiffness, stored = self._pressed(approach)
        else:
            force, stiffness, stored, tilt = self._on_slices(self.width, approach, self.width.moved(step))
        on_disc = np.stack(
            [np.einsum("pdk,pdk->pd", force, along) for along in (self.normal_x, self.normal_y, self.lever)], axis=-1
        )
        stretch = self.stretch + np.einsum("psdu,pu->psd", self.spring_stretch, step) - at_bearings
        length = np.hypot(stretch[..., 0], stretch[..., 1])
        held = self.bearing.response(length, self.play)
        bearing_force = held.secant[..., np.newaxis] * stretch
        gradient = np.einsum("psdu,psd->pu", self.spring_stretch, bearing_force)
        for j, own in enumerate(self.disc_unknowns):
            gradient[:, own] += on_disc[:, j]
        gradient[:, 0] -= self.torque
        if self.width is not None and tilt is not None and self.width.unknowns.size:
            slope = self.width.moved(step)
            for i, along in enumerate((self.normal_x, self.normal_y)):
                gradient[:, self.width.unknowns[:, i]] += np.sum(tilt.moment * along, axis=2)
                gradient[:, self.width.unknowns[:, i]] += self.width.stiffness * slope[..., i]
        energy = np.sum(stored, axis=(1, 2)) + np.sum(held.energy, axis=1)
        energy += 0.5 * np.sum(self.load * yielded, axis=1)
        energy -= self.torque * (self.rotation + step[:, 0])
        if self.width is not None:
            energy += 0.5 * self.width.stiffness * np.sum(self.width.moved(step) ** 2, axis=(1, 2))
        return EnergyPoint(energy, gradient, approach, force, stiffness, receded, stretch, bearing_force, tilt)

    def _pressed(self, approach: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Force, stiffness and energy at approaches of any sign, shape of ``gap``."""
        touching = approach > 0.0
        force, stiffness, stored = (np.zeros_like(approach) for _ in range(3))
        force[touching], stiffness[touching], stored[touching] = self.law.response(
            approach[touching], self.contact.at(touching)
        )
        return force, stiffness, stored

    def _on_slices(
        self, width: WidthState, approach: FloatArray, slopes: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray, PinTilt]:
        """Force, stiffness and energy of the slices of each pin together, shape of ``gap`` (Eqs. 115, 116)."""
        slope = np.zeros_like(approach)
        if slopes.size:
            slope += self.normal_x * slopes[..., :1] + self.normal_y * slopes[..., 1:]
        force, moment, stored, k0, k1, k2 = (np.zeros_like(approach) for _ in range(6))
        heights, weights = width.face.rule
        for z, w, relief in zip(heights, weights, width.face.relief(heights), strict=True):
            each = self._pressed(approach + z * slope - relief)
            force += w * each[0]
            moment += w * z * each[0]
            k0 += w * each[1]
            k1 += w * z * each[1]
            k2 += w * z**2 * each[1]
            stored += w * each[2]
        centre = k1 / np.where(k0 > 0.0, k0, 1.0)
        return force, k0, stored, PinTilt(slope, moment, centre, np.maximum(k2 - centre * k1, 0.0))

    def _yielded(self) -> FloatArray:
        """How far all elastic bodies give way under their ``load``, shape of ``load`` [mm]."""
        return np.asarray(np.einsum("pij,pj->pi", self.compliance, self.load))

    def _at_pins_and_bearings(self, yielded: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The same at pins, shape of ``gap``, and at bearings, shape of ``stretch`` [mm]; zero for rigid discs."""
        if not yielded.size:
            return np.zeros_like(self.gap), np.zeros_like(self.stretch)
        pins = self.gap[0].size
        return yielded[:, :pins].reshape(self.gap.shape), yielded[:, pins:].reshape(self.stretch.shape)

    @property
    def pins_and_bearings(self) -> int:
        """Number of forces on pins and bearings, without those on slopes over the width."""
        return int(self.gap[0].size + self.stretch[0].size)

    @property
    def by_motion(self) -> FloatArray:
        """J, deformation of pins and bearings per motion, shape (poses, forces, unknowns).

        With slices over the width, the slope of the tooth at each pin and both slopes of each disc follow.
        """
        poses, discs, pins = self.gap.shape
        plane, unknowns = self.pins_and_bearings, self.arm.size
        slopes = 0 if self.width is None else self.gap[0].size + self.width.unknowns.size
        found = np.zeros((poses, plane + slopes, unknowns))
        for j, own in enumerate(self.disc_unknowns):
            for unknown, along in zip(own, (self.normal_x, self.normal_y, self.lever), strict=True):
                found[:, j * pins : (j + 1) * pins, unknown] += along[:, j]
        found[:, discs * pins : plane] = self.spring_stretch.reshape(poses, -1, unknowns)
        if self.width is None:
            return found
        for j, tilts in enumerate(self.width.unknowns):
            for unknown, along in zip(tilts, (self.normal_x, self.normal_y), strict=True):
                found[:, plane + j * pins : plane + (j + 1) * pins, unknown] = along[:, j]
        found[:, range(found.shape[1] - self.width.unknowns.size, found.shape[1]), self.width.unknowns.ravel()] = 1.0
        return found

    def stiffness_times(self, point: EnergyPoint, deformation: FloatArray) -> FloatArray:
        """Forces of pins and bearings due to small deformations, shape (poses, forces, columns): K (I + C K)⁻¹ times
        each column, K the stiffness of contacts and bearings alone (Eq. 82). Rows as in ``by_motion``.
        """
        if point.tilt is None or self.width is None:
            return self._plane_stiffness_times(point, deformation)
        # Eq. 118: a force acts at the centre of its stiffness, the spread about that centre resists the slope.
        poses, pins, plane = len(deformation), self.gap[0].size, self.pins_and_bearings
        centre, spread = (each.reshape(poses, -1, 1) for each in (point.tilt.centre, point.tilt.spread))
        slope, slopes = deformation[:, plane : plane + pins], deformation[:, plane + pins :]
        closed = deformation[:, :plane].copy()
        closed[:, :pins] += centre * slope
        force = self._plane_stiffness_times(point, closed)
        moment = centre * force[:, :pins] + spread * slope
        return np.concatenate([force, moment, self.width.stiffness * slopes], axis=1)

    def _plane_stiffness_times(self, point: EnergyPoint, deformation: FloatArray) -> FloatArray:
        if self.load.size:
            from cycloid_profile.compiled import on_all_cores
            from cycloid_profile.contact.stage._kernels import elastic_stiffness_times

            found, columns = np.empty_like(deformation), np.ascontiguousarray(deformation)
            fill = partial(elastic_stiffness_times, self.arrays(), self.load, columns, found)
            on_all_cores(fill, len(found))
            return found
        pins = point.stiffness.reshape(len(deformation), -1, 1)
        at = deformation[:, pins.shape[1] :].reshape(*point.stretch.shape, deformation.shape[2])
        bearings = np.einsum("psde,psec->psdc", self.bearing_tangent(point), at)
        flat = bearings.reshape(len(deformation), point.stretch[0].size, deformation.shape[2])
        return np.concatenate([pins * deformation[:, : pins.shape[1]], flat], axis=1)

    def hessian(self, point: EnergyPoint) -> FloatArray:
        """Second derivative of the energy by the motion, the discs deformed by what presses on them; shape
        (poses, unknowns, unknowns), positive semidefinite.
        """
        J = self.by_motion
        total: FloatArray = np.swapaxes(J, 1, 2) @ self.stiffness_times(point, J)
        return total

    def bearing_tangent(self, point: EnergyPoint) -> FloatArray:
        """Tangent stiffness of each bearing, shape (poses, bearings, 2, 2) [N/mm].

        Along its stretch r it is dF/dr, across it F/r.
        """
        length = np.hypot(point.stretch[..., 0], point.stretch[..., 1])
        held = self.bearing.response(length, self.play)
        unit = point.stretch / np.where(length > 0.0, length, 1.0)[..., np.newaxis]
        outer = unit[..., :, np.newaxis] * unit[..., np.newaxis, :]
        along, across = (one[..., np.newaxis, np.newaxis] for one in (held.tangent, held.secant))
        tangent: FloatArray = across * np.eye(2) + (along - across) * outer
        return tangent

    def imbalance(self, point: EnergyPoint) -> FloatArray:
        """Largest generalised force out of balance, as a moment over the torque, shape (poses,).

        In elastic discs also the largest difference between a force and the one that deforms the disc.
        """
        worst: FloatArray = np.max(np.abs(point.gradient) * self.arm, axis=-1)
        if self.load.size:
            flat = (len(worst), -1)
            force = np.concatenate([point.force.reshape(flat), point.bearing_force.reshape(flat)], axis=1)
            worst = np.maximum(worst, np.max(np.abs(force - self.load), axis=1) * np.max(self.arm))
        return np.asarray(worst / np.abs(self.torque))

    def arrays(self) -> StageArrays:
        """The problem in the form of the compiled search."""
        from cycloid_profile.contact.stage._kernels import StageArrays

        law = compiled_law(self.law, self.contact)
        return StageArrays(
            law=law,
            constant=contact_constants(law, self.contact),
            gap=np.ascontiguousarray(self.gap),
            frame=np.stack([self.normal_x, self.normal_y, self.lever], axis=1),
            own=self.disc_unknowns,
            spring_stretch=np.ascontiguousarray(self.spring_stretch),
            stretch=np.ascontiguousarray(self.stretch),
            bearing=self.bearing.compiled(),
            play=np.zeros(len(self.gap)) + np.ravel(self.play),
            torque=np.ascontiguousarray(self.torque),
            rotation=np.ascontiguousarray(self.rotation),
            arm=self.arm,
            compliance=np.ascontiguousarray(self.compliance),
            width=no_slices(np.zeros((len(self.gap), 0, 2))) if self.width is None else self.width.arrays(),
        )


def minimise(problem: StageEnergy, start: FloatArray, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Step to the least energy, shape (poses, unknowns) [mm, rad], by Newton from ``start``, and the forces that deform
    elastic discs there, shape of ``problem.load`` [N].

    Each pose ends when its imbalance is below ``tolerance``, independent of the others; the energy never rises.
    """
    from cycloid_profile.contact.stage._kernels import least_energies

    step, load = np.array(start, order="C"), np.array(problem.load, order="C")
    least_energies(problem.arrays(), tolerance, step, load)
    return step, load
