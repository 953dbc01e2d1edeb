"""True moment balance of one disc on a rigid crank: every pin nonlinear, with its own curvature."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from importlib.util import find_spec

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.backlash import OVERLAP_TOLERANCE, first_touch
from cycloid_profile.contact.batch import over_blocks, poses_and_torques
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.hertz import ContactLaw, LineContact
from cycloid_profile.contact.law_forms import Logarithmic
from cycloid_profile.contact.meshing import mesh, mesh_cycle
from cycloid_profile.contact.sharing import STATUSES, LoadSharing, Status, joined

# A pin with less than this share of the longest lever hardly turns the disc.
_LONG_ARM = 0.5
_POSES_PER_BLOCK = 512
# Poses × pins; below, the compiled twin would take longer to load than it saves.
_WORTH_COMPILING = 200_000
_NUMBA = find_spec("numba") is not None


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """Solves Σ F_i(β l_i − Δ_i) l_i = T/discs for the rotation β (docs/theory.md, Eq. 34).

    Gaps Δ_i are exact and taken where the disc first touches; levers and curvatures stay those of first touch
    (at rated torque of an RV-40E that costs 0.1 % of the rotation and 0.6 % of a pin's force; ``StageEquilibrium``
    takes them under load); ``poses`` cover one mesh cycle.
    ``tolerance`` bounds the relative error of the moment balance.
    """

    poses: int = 24
    tolerance: float = 1e-12
    max_iterations: int = 60

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of one disc that carries its ideal share of the torque, over one mesh cycle."""
        return self.at(case, mesh_cycle(case.drive.trochoid, self.poses))

    def at(self, case: LoadCase, crank_angle: ArrayLike, torque: ArrayLike | None = None) -> LoadSharing:
        """The same at crank angles [rad], under ``torque`` on the output [N·mm] or that of the case.

        Crank angles and torques are broadcast to poses; the answer of a pose does not depend on the others.
        Raises ``LoadError`` if one is not finite or a torque is zero.
        """
        return joined(list(self.blocks(case, crank_angle, torque)))

    def blocks(self, case: LoadCase, crank_angle: ArrayLike, torque: ArrayLike | None = None) -> Iterator[LoadSharing]:
        """The same, a block of poses at a time in order: for more poses than the memory holds pins of."""
        phi, T = poses_and_torques(crank_angle, case.torque if torque is None else torque)
        return over_blocks(lambda cut: self._block(case, phi[cut], T[cut]), phi.size, _POSES_PER_BLOCK)

    def _block(self, case: LoadCase, crank_angle: FloatArray, torque: FloatArray) -> LoadSharing:
        longest = case.drive.trochoid.longest_lever
        direction = np.sign(torque)
        meshing = mesh(case.drive.trochoid, crank_angle)
        touch = first_touch(case.profile, case.drive.pin_radius, meshing, direction[:, np.newaxis])
        found = touch.gaps
        # Rounding leaves the touching gap a few 1e-16 either side of zero.
        gap, lever = np.maximum(found.gap[:, 0], 0.0), direction[:, np.newaxis] * found.lever[:, 0]
        contact = case.line_contact(found.curvature[:, 0])
        answer = balance_moments(
            case.law, contact, gap, lever, np.abs(torque) / case.drive.discs, self.tolerance, self.max_iterations
        )
        outcome = np.full(len(torque), STATUSES.index(Status.CONVERGED))
        outcome[np.min(found.gap, axis=(1, 2)) < -OVERLAP_TOLERANCE] = STATUSES.index(Status.INTERFERENCE)
        outcome[~(answer.residual < self.tolerance)] = STATUSES.index(Status.NOT_CONVERGED)
        outcome[~touch.settled[:, 0]] = STATUSES.index(Status.NO_CONTACT)
        turned = touch.rotation[:, 0]
        return LoadSharing(
            case=case,
            solver="equilibrium",
            crank_angle=crank_angle,
            torque=torque,
            phase=direction[:, np.newaxis, np.newaxis] * meshing.phase,
            gap=gap[:, np.newaxis],
            approach=answer.approach[:, np.newaxis],
            force=answer.force[:, np.newaxis],
            pressure=case.law.peak_pressure(answer.force, contact)[:, np.newaxis],
            lever=lever[:, np.newaxis],
            curvature=found.curvature,
            pin_stiffness=answer.stiffness[:, np.newaxis],
            rotation=turned + direction * answer.rotation,
            touch=turned,
            torsional_stiffness=case.drive.discs * np.sum(answer.stiffness * lever**2, axis=-1),
            residual=answer.residual,
            outcome=outcome,
            max_force=float(np.max(answer.force)),
            delta_max=float(np.max(answer.rotation)) * longest,
            history=tuple((force, turn * longest) for force, turn in answer.history),
        )


@dataclass(frozen=True, slots=True)
class MomentBalance:
    """Rotation beyond touch, shape (poses,) [rad], and the pins there, shape (poses, pins).

    ``residual`` shape (poses,), relative; ``history`` the largest force [N] and rotation [rad] of each step.
    """

    rotation: FloatArray
    approach: FloatArray
    force: FloatArray
    stiffness: FloatArray
    residual: FloatArray
    history: tuple[tuple[float, float], ...]


def balance_moments(
    law: ContactLaw,
    contact: LineContact,
    gap: FloatArray,
    lever: FloatArray,
    torque: FloatArray,
    tolerance: float = 1e-12,
    max_iterations: int = 60,
) -> MomentBalance:
    """Rotations β with Σ F_i(β l_i − Δ_i) l_i = ``torque``, shape (poses,) [N·mm].

    ``gap`` Δ ≥ 0 [mm] and ``lever`` l [mm] have shape (poses, pins), as has the curvature of ``contact``. Many
    poses of a logarithmic law go to the compiled twin of this function, where numba is installed.
    """
    if gap.size >= _WORTH_COMPILING and isinstance(law, Logarithmic) and _NUMBA:
        from cycloid_profile.contact.compiled import balanced

        rotation, approach, force, stiffness, residual, settled = balanced(law, contact, gap, lever, torque, tolerance)
        if np.all(settled):
            steps = ((float(np.max(force)), float(np.max(rotation))),)
            return MomentBalance(rotation, approach, force, stiffness, residual, steps)
    return balance_moments_plainly(law, contact, gap, lever, torque, tolerance, max_iterations)


def balance_moments_plainly(
    law: ContactLaw,
    contact: LineContact,
    gap: FloatArray,
    lever: FloatArray,
    torque: FloatArray,
    tolerance: float = 1e-12,
    max_iterations: int = 60,
) -> MomentBalance:
    """``balance_moments`` in numpy, for any law: the reference."""
    beta = _upper_bound(law, contact, gap, lever, torque)
    # Pins that the first, largest rotation does not reach never carry: the rest of the work leaves them out.
    reached = np.flatnonzero(beta[:, np.newaxis] * lever > gap)
    pose, pin = np.divmod(reached, gap.shape[1])
    arm, wait, prepared = lever.ravel()[reached], gap.ravel()[reached], law.prepare(contact.at((pose, pin)))
    poses = len(beta)

    def per_pose(value: FloatArray) -> FloatArray:
        total: FloatArray = np.bincount(pose, value, poses).astype(np.float64, copy=False)
        return total

    start: FloatArray | None = None
    approach, force, stiffness = (np.zeros_like(arm) for _ in range(3))
    residual = np.full(poses, np.inf)
    history: list[tuple[float, float]] = []
    for _ in range(max_iterations):
        approach = beta[pose] * arm - wait
        touching = approach > 0.0
        answer = prepared.response(np.maximum(approach, _LEAST_APPROACH), start)
        # The rotation only falls: a pin that lets go never comes back, and its start no longer matters.
        start = answer.start
        force, stiffness = answer.force * touching, answer.stiffness * touching
        moment = per_pose(force * arm)
        residual = np.abs(moment / torque - 1.0)
        history.append((float(np.max(force, initial=0.0)), float(np.max(beta))))
        rate = per_pose(stiffness * (arm * arm))
        # Without a pin in reach there is nothing to step by: a load that no law covers ends here.
        moving = ~(residual < tolerance) & (rate > 0.0)
        if not np.any(moving):
            break
        # The carried moment is convex and rising in β: Newton from above descends without overshoot.
        beta = np.where(moving, beta - (moment - torque) / np.where(moving, rate, 1.0), beta)
    approach = np.maximum(approach, 0.0)

    def all_pins(reached_ones: FloatArray) -> FloatArray:
        every = np.zeros_like(gap)
        every[pose, pin] = reached_ones
        return every

    return MomentBalance(beta, all_pins(approach), all_pins(force), all_pins(stiffness), residual, tuple(history))


_LEAST_APPROACH = 1e-30  # mm; stands in for none where a law divides by it


def _upper_bound(
    law: ContactLaw, contact: LineContact, gap: FloatArray, lever: FloatArray, torque: FloatArray
) -> FloatArray:
    """Rotation at which one pin alone carries all, a pin that does so early, shape (poses,) [rad]."""
    # Pins with a short lever are left out: alone they would need a force no contact law covers.
    long_arm = _LONG_ARM * np.max(lever, axis=-1, keepdims=True)
    flat = law.approach(torque / long_arm[:, 0], replace(contact, curvature=np.zeros(len(torque))))
    alone = np.where(lever >= long_arm, (gap + flat[:, np.newaxis]) / np.maximum(lever, long_arm), np.inf)
    early = (np.arange(len(torque)), np.argmin(alone, axis=-1))
    bound: FloatArray = (gap[early] + law.approach(torque / lever[early], contact.at(early))) / lever[early]
    return bound
