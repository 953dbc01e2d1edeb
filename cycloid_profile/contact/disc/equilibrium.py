"""True moment balance of one disc on a rigid crank: every pin nonlinear, with its own curvature."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact._blocks import over_blocks, poses_and_torques, poses_per_block
from cycloid_profile.contact.bodies import LinearBearing, stage_compliance
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.laws import ContactLaw, LineContact, compiled_law
from cycloid_profile.contact.mesh import OVERLAP_TOLERANCE, first_touch, mesh
from cycloid_profile.contact.result import STATUSES, LoadSharing, SolveStatus, joined
from cycloid_profile.contact.stage import StageEnergy, WidthState, minimise

# A pin with less than this share of the longest lever hardly turns the disc.
_LONG_ARM = 0.5
_LEAST_APPROACH = 1e-30  # mm; replaces 0 where a law divides by the approach
_POSES_PER_BLOCK = 512
_WORTH_COMPILING = 200_000  # poses × pins; below, the compiled code would take longer to load than it saves


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
        """Load on the pins of one disc that carries its ideal share of the torque, over ``LoadCase.cycle``."""
        return self.at(case, case.cycle(self.poses))

    def at(self, case: LoadCase, crank_angle: ArrayLike, torque: ArrayLike | None = None) -> LoadSharing:
        """Load on the pins at crank angles [rad], under ``torque`` on the output [N·mm] or that of the case.

        Crank angles and torques are broadcast to poses; the answer of a pose does not depend on the others.
        Raises ``LoadError`` if a crank angle or torque is not finite, or a torque is zero.
        """
        return joined(list(self.blocks(case, crank_angle, torque)))

    def blocks(self, case: LoadCase, crank_angle: ArrayLike, torque: ArrayLike | None = None) -> Iterator[LoadSharing]:
        """Results of ``at`` for consecutive blocks of poses, when all poses together exceed the memory."""
        phi, T = poses_and_torques(crank_angle, case.torque if torque is None else torque)
        forces = case.drive.trochoid.pins if case.disc_bodies else 0
        size = poses_per_block(forces, _POSES_PER_BLOCK)
        return over_blocks(lambda cut: self._block(case, phi[cut], T[cut]), phi.size, size)

    def _block(self, case: LoadCase, crank_angle: FloatArray, torque: FloatArray) -> LoadSharing:
        longest = case.drive.trochoid.longest_lever
        direction = np.sign(torque)
        meshing = mesh(case.drive.trochoid, crank_angle)
        touch = first_touch(case.profile, case.drive.pin_radius, meshing, direction[:, np.newaxis])
        found = touch.gaps
        # Rounding leaves the touching gap a few 1e-16 either side of zero.
        gap, lever = np.maximum(found.gap[:, 0], 0.0), direction[:, np.newaxis] * found.lever[:, 0]
        contact = case.line_contact(found.curvature[:, 0])
        share = np.abs(torque) / case.drive.discs
        compliance = stage_compliance(case.disc_bodies, meshing)
        if compliance.size or case.width is not None:
            answer = _least_energy(case, contact, gap, lever, share, self.tolerance, compliance)
        else:
            answer = balance_moments(case.law, contact, gap, lever, share, self.tolerance, self.max_iterations)
        outcome = np.full(len(torque), STATUSES.index(SolveStatus.CONVERGED))
        outcome[np.min(found.gap, axis=(1, 2)) < -OVERLAP_TOLERANCE] = STATUSES.index(SolveStatus.INTERFERENCE)
        outcome[~(answer.residual < self.tolerance)] = STATUSES.index(SolveStatus.NOT_CONVERGED)
        outcome[~touch.settled[:, 0]] = STATUSES.index(SolveStatus.NO_CONTACT)
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
            receded=answer.receded[:, np.newaxis],
            rotation=turned + direction * answer.rotation,
            touch=turned,
            torsional_stiffness=case.drive.discs * answer.torsional_stiffness,
            residual=answer.residual,
            outcome=outcome,
            max_force=float(np.max(answer.force)),
            deformation=answer.rotation * longest,
            history=tuple((force, turn * longest) for force, turn in answer.history),
        )


@dataclass(frozen=True, eq=False, slots=True)
class MomentBalance:
    """Rotation beyond touch, shape (poses,) [rad], and the pins there, shape (poses, pins).

    ``receded``, how far an elastic disc gives way there; ``torsional_stiffness`` of the disc, shape (poses,)
    [N·mm/rad]; ``residual`` shape (poses,), relative; ``history`` the largest force [N] and rotation [rad] of each
    step.
    """

    rotation: FloatArray
    approach: FloatArray
    force: FloatArray
    stiffness: FloatArray
    receded: FloatArray
    torsional_stiffness: FloatArray
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

    ``gap`` Δ ≥ 0 [mm] and ``lever`` l [mm] have shape (poses, pins), as has the curvature of ``contact``. Many poses
    are solved in compiled code, which reports one step of ``history``.
    """
    if gap.size >= _WORTH_COMPILING:
        from cycloid_profile.compiled import on_all_cores
        from cycloid_profile.contact.disc._kernels import balance

        poses = len(torque)
        rotation, residual, converged = np.empty(poses), np.empty(poses), np.zeros(poses, dtype=np.bool_)
        approach, force, stiffness = (np.zeros_like(gap, order="C") for _ in range(3))
        fill = partial(
            balance, compiled_law(law, contact), *map(np.ascontiguousarray, (gap, lever, contact.curvature, torque)),
            tolerance, rotation, approach, force, stiffness, residual, converged,
        )  # fmt: skip
        on_all_cores(fill, poses)
        if np.all(converged):
            steps = ((float(np.max(force)), float(np.max(rotation))),)
            stiff = np.sum(stiffness * lever**2, axis=-1)
            return MomentBalance(rotation, approach, force, stiffness, np.zeros_like(gap), stiff, residual, steps)
    return balance_moments_numpy(law, contact, gap, lever, torque, tolerance, max_iterations)


def balance_moments_numpy(
    law: ContactLaw,
    contact: LineContact,
    gap: FloatArray,
    lever: FloatArray,
    torque: FloatArray,
    tolerance: float = 1e-12,
    max_iterations: int = 60,
) -> MomentBalance:
    """``balance_moments`` in numpy: the reference."""
    beta = _upper_bound(law, contact, gap, lever, torque)
    # Pins that the first, largest rotation does not reach never carry: the rest of the work leaves them out.
    reached = np.flatnonzero(beta[:, np.newaxis] * lever > gap)
    pose, pin = np.divmod(reached, gap.shape[1])
    arm, wait, at = lever.ravel()[reached], gap.ravel()[reached], contact.at((pose, pin))
    poses = len(beta)

    def per_pose(value: FloatArray) -> FloatArray:
        total: FloatArray = np.bincount(pose, value, poses).astype(np.float64, copy=False)
        return total

    approach, force, stiffness = (np.zeros_like(arm) for _ in range(3))
    residual = np.full(poses, np.inf)
    history: list[tuple[float, float]] = []
    for _ in range(max_iterations):
        approach = beta[pose] * arm - wait
        touching = approach > 0.0
        force, stiffness, _ = (each * touching for each in law.response(np.maximum(approach, _LEAST_APPROACH), at))
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

    each = all_pins(stiffness)
    stiff, rigid = np.sum(each * lever**2, axis=-1), np.zeros_like(gap)
    return MomentBalance(beta, all_pins(approach), all_pins(force), each, rigid, stiff, residual, tuple(history))


def _least_energy(
    case: LoadCase,
    contact: LineContact,
    gap: FloatArray,
    lever: FloatArray,
    torque: FloatArray,
    tolerance: float,
    compliance: FloatArray,
) -> MomentBalance:
    """``balance_moments`` of elastic discs, ``compliance`` shape (poses, forces, forces), or of slices over the width:
    the least energy of a stage of one disc that can only turn.
    """
    poses, pins = gap.shape
    one, none = (poses, 1, pins), np.zeros((poses, 0, 2))
    law, forces = case.law, min(pins, compliance.shape[1])
    upright = np.zeros((0, 2), dtype=np.intp)
    problem = StageEnergy(
        law=law,
        contact=replace(contact, curvature=contact.curvature.reshape(one)),
        gap=gap.reshape(one),
        normal_x=np.zeros(one),
        normal_y=np.zeros(one),
        lever=lever.reshape(one),
        disc_unknowns=np.zeros((1, 3), dtype=np.intp),
        spring_stretch=np.zeros((poses, 0, 2, 1)),
        stretch=none,
        bearing=LinearBearing(0.0),
        play=0.0,
        torque=torque,
        rotation=np.zeros(poses),
        arm=np.ones(1),
        compliance=np.ascontiguousarray(compliance[:, :forces, :forces]),
        load=np.zeros((poses, forces)),
        width=None if case.width is None else WidthState(case.width, upright, np.zeros((poses, 0, 2)), 0.0),
    )
    step, load = minimise(problem, _upper_bound(law, contact, gap, lever, torque)[:, np.newaxis], tolerance)
    problem = replace(problem, gap=problem.gap - step[:, :1, np.newaxis] * problem.lever, load=load)
    point = problem.at(np.zeros_like(step))
    stiffness = problem.hessian(point)[:, 0, 0]
    steps = ((float(np.max(point.force)), float(np.max(step))),)
    approach = np.where(point.force > 0.0, point.approach, 0.0)[:, 0]
    return MomentBalance(
        step[:, 0], approach, point.force[:, 0], point.stiffness[:, 0], point.receded[:, 0], stiffness,
        problem.imbalance(point), steps,
    )  # fmt: skip


def _upper_bound(
    law: ContactLaw, contact: LineContact, gap: FloatArray, lever: FloatArray, torque: FloatArray
) -> FloatArray:
    """Upper bound of the rotation, at which one early pin alone carries the torque, shape (poses,) [rad]."""
    # Pins with a short lever are left out: alone they would need a force no contact law covers.
    long_arm = _LONG_ARM * np.max(lever, axis=-1, keepdims=True)
    flat = law.approach(torque / long_arm[:, 0], replace(contact, curvature=np.zeros(len(torque))))
    alone = np.where(lever >= long_arm, (gap + flat[:, np.newaxis]) / np.maximum(lever, long_arm), np.inf)
    early = (np.arange(len(torque)), np.argmin(alone, axis=-1))
    bound: FloatArray = (gap[early] + law.approach(torque / lever[early], contact.at(early))) / lever[early]
    return bound
