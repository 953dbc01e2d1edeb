"""Energy of the stage with gaps linear about a place, and its minimum (docs/theory.md, Eqs. 36–38).

Pins push but never pull, bearings have play: the energy is convex with one continuous derivative, so a
Newton step guarded by the energy itself ends at the one minimum.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.hertz import ContactLaw, LineContact

NEWTON_STEPS = 80
HALVINGS = 40
ARMIJO = 1e-4
# Energies this close, relative, differ by rounding alone.
ROUNDING = 1e-13
# A trace of damping keeps the matrix regular while a disc floats between pins or in the play of its bearings.
DAMPING = 1e-9


class EnergyPoint(NamedTuple):
    """Energy of each pose at one place, with all that acts there.

    ``energy`` shape (poses,) [N·mm]; ``gradient`` shape (poses, unknowns), the generalised forces out of
    balance; ``approach`` [mm], ``force`` [N] and ``stiffness`` [N/mm] of the pins, shape (poses, discs, pins);
    ``stretch`` [mm] and ``bearing_force`` [N] of the bearings, shape (poses, bearings, 2).
    """

    energy: FloatArray
    gradient: FloatArray
    approach: FloatArray
    force: FloatArray
    stiffness: FloatArray
    stretch: FloatArray
    bearing_force: FloatArray


@dataclass(frozen=True, slots=True)
class StageEnergy:
    """Π(u) of Eq. 37 about the displacement at which the gaps were taken.

    ``law`` and ``contact`` of the pins, ``gap`` [mm] and their frames ``normal_x``, ``normal_y``, ``lever``
    [mm], shape (poses, discs, pins); ``disc_unknowns``, ``spring_stretch`` and ``spring_matrix`` as in
    ``SupportModel``;
    ``stretch`` of the bearings there, shape (poses, bearings, 2) [mm]; ``bearing_stiffness`` [N/mm] and
    ``play``, one or shape (poses, 1) [mm]; ``torque`` shape (poses,) and carrier ``rotation`` there [N·mm, rad];
    ``arm`` as in ``SupportModel``.
    """

    law: ContactLaw
    contact: LineContact
    gap: FloatArray
    normal_x: FloatArray
    normal_y: FloatArray
    lever: FloatArray
    disc_unknowns: IntArray
    spring_stretch: FloatArray
    spring_matrix: FloatArray
    stretch: FloatArray
    bearing_stiffness: float
    play: float | FloatArray
    torque: FloatArray
    rotation: FloatArray
    arm: FloatArray

    def poses(self, which: BoolArray) -> StageEnergy:
        """The same at some of the poses."""
        one_for_all = {"law", "contact", "disc_unknowns", "bearing_stiffness", "arm"}
        if not isinstance(self.play, np.ndarray):
            one_for_all.add("play")
        cut = {f.name: getattr(self, f.name)[which] for f in fields(self) if f.name not in one_for_all}
        return replace(self, **cut, contact=replace(self.contact, curvature=self.contact.curvature[which]))

    def at(self, step: FloatArray) -> EnergyPoint:
        """Energy and forces a ``step`` away, shape (poses, unknowns) [mm, rad]."""
        moved = step[:, self.disc_unknowns][..., np.newaxis, :]
        approach = self.normal_x * moved[..., 0] + self.normal_y * moved[..., 1] + self.lever * moved[..., 2] - self.gap
        touching = approach > 0.0
        force, stiffness, stored = (np.zeros_like(approach) for _ in range(3))
        force[touching], stiffness[touching], stored[touching] = self.law.response(
            approach[touching], self.contact.at(touching)
        )
        on_disc = np.stack(
            [np.einsum("pdk,pdk->pd", force, along) for along in (self.normal_x, self.normal_y, self.lever)], axis=-1
        )
        stretch = self.stretch + np.einsum("psdu,pu->psd", self.spring_stretch, step)
        length = np.hypot(stretch[..., 0], stretch[..., 1])
        beyond = np.maximum(length - self.play, 0.0)
        share = np.where(length > self.play, beyond / np.where(length > 0.0, length, 1.0), 0.0)
        bearing_force = self.bearing_stiffness * share[..., np.newaxis] * stretch
        gradient = np.einsum("psdu,psd->pu", self.spring_stretch, bearing_force)
        for j, own in enumerate(self.disc_unknowns):
            gradient[:, own] += on_disc[:, j]
        gradient[:, 0] -= self.torque
        energy = np.sum(stored, axis=(1, 2)) + 0.5 * self.bearing_stiffness * np.sum(beyond**2, axis=1)
        energy -= self.torque * (self.rotation + step[:, 0])
        return EnergyPoint(energy, gradient, approach, force, stiffness, stretch, bearing_force)

    def hessian(self, point: EnergyPoint) -> FloatArray:
        """Second derivative at a point, shape (poses, unknowns, unknowns); semidefinite."""
        total = self._springs_with_play(point) if np.any(self.play) else self.spring_matrix.copy()
        along = (self.normal_x, self.normal_y, self.lever)
        for i in range(3):
            weighted = point.stiffness * along[i]
            for k in range(i, 3):
                stiffness = np.einsum("pdk,pdk->pd", weighted, along[k])
                for j, own in enumerate(self.disc_unknowns):
                    total[:, own[i], own[k]] += stiffness[:, j]
                    if k > i:
                        total[:, own[k], own[i]] += stiffness[:, j]
        return total

    def _springs_with_play(self, point: EnergyPoint) -> FloatArray:
        bent = self.bearing_tangent(point) @ self.spring_stretch
        flat = (len(bent), -1, self.arm.size)
        total: FloatArray = np.swapaxes(self.spring_stretch.reshape(flat), 1, 2) @ bent.reshape(flat)
        return total

    def bearing_tangent(self, point: EnergyPoint) -> FloatArray:
        """Tangent stiffness of each bearing, shape (poses, bearings, 2, 2) [N/mm].

        Along its stretch a spring has its whole stiffness, across it only that of what is beyond the play.
        """
        length = np.hypot(point.stretch[..., 0], point.stretch[..., 1])
        pressed = (length > self.play) & (length > 0.0)
        safe = np.where(pressed, length, 1.0)
        unit = np.where(pressed[..., np.newaxis], point.stretch, 0.0) / safe[..., np.newaxis]
        across = np.where(pressed, 1.0 - self.play / safe, np.equal(self.play, 0.0))[..., np.newaxis, np.newaxis]
        outer = unit[..., :, np.newaxis] * unit[..., np.newaxis, :]
        tangent: FloatArray = self.bearing_stiffness * (across * np.eye(2) + (1.0 - across) * outer)
        return tangent

    def imbalance(self, point: EnergyPoint) -> FloatArray:
        """Largest generalised force out of balance, as a moment over the torque, shape (poses,)."""
        worst: FloatArray = np.max(np.abs(point.gradient) * self.arm, axis=-1) / np.abs(self.torque)
        return worst


class Minimum(NamedTuple):
    """Step to the least energy, shape (poses, unknowns), and the energies on the way, each shape (poses,)."""

    step: FloatArray
    energies: list[FloatArray]


def minimise(problem: StageEnergy, start: FloatArray, tolerance: float) -> Minimum:
    """Newton from ``start`` until the imbalance is below ``tolerance``; the energy never rises.

    Poses are independent: one that has arrived rests while others go on.
    """
    step = start.copy()
    point = problem.at(step)
    energies = [point.energy]
    for _ in range(NEWTON_STEPS):
        moving = problem.imbalance(point) >= tolerance
        if not np.any(moving):
            break
        hessian = problem.hessian(point)
        diagonal = np.einsum("puu->pu", hessian)
        diagonal += DAMPING * np.max(diagonal, axis=-1, keepdims=True) / problem.arm**2
        direction = -np.linalg.solve(hessian, point.gradient[..., np.newaxis])[..., 0]
        direction[~moving] = 0.0
        slope = np.sum(point.gradient * direction, axis=-1)
        slack = ROUNDING * (np.abs(point.energy) + np.abs(problem.torque * problem.rotation))
        fraction = np.ones(len(step))
        for _ in range(HALVINGS):
            trial = step + fraction[:, np.newaxis] * direction
            found = problem.at(trial)
            too_far = found.energy > point.energy + ARMIJO * fraction * slope + slack
            if not np.any(too_far):
                break
            fraction[too_far] *= 0.5
        step, point = trial, found
        energies.append(point.energy)
    return Minimum(step, energies)
