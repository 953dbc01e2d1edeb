"""Planar equilibrium of the whole stage: carrier and all discs on elastic bearings (docs/theory.md, Eqs. 35–38).

Quasi-static, input held, housing fixed. The pins are one-sided nonlinear springs along their own
normals; the energy is convex, so Newton with a guarded step finds the one equilibrium.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.backlash import closing_turn
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.gap import Gaps, gaps
from cycloid_profile.contact.hertz import LineContact
from cycloid_profile.contact.meshing import Meshing, mesh
from cycloid_profile.contact.sharing import Status
from cycloid_profile.contact.support import SupportModel, support_model

_REFRESHES = 40
_NEWTON_STEPS = 60
_TOUCH_STEPS = 40


@dataclass(frozen=True, slots=True)
class ReducerState:
    """Equilibrium of the stage under the torque of ``case`` at each pose.

    ``rotation`` of the carrier, shape (poses,) [rad]; ``motion`` of the discs (x, y, θ), shape
    (poses, discs, 3) [mm, mm, rad]; ``force`` on the pins, shape (poses, discs, pins) [N];
    ``residual``, shape (poses,), largest unbalanced generalised force over the torque's;
    ``status`` of each pose.
    """

    case: LoadCase
    meshing: Meshing
    rotation: FloatArray
    motion: FloatArray
    force: FloatArray
    residual: FloatArray
    status: tuple[Status, ...]

    @property
    def settled(self) -> BoolArray:
        """Which poses converged, shape (poses,)."""
        return np.array([status is Status.CONVERGED for status in self.status])

    @property
    def converged(self) -> bool:
        """Whether every pose converged."""
        return bool(np.all(self.settled))


class _Linear(NamedTuple):
    """Contact problem linear about a displacement: approach = J·step − gap."""

    gap: FloatArray
    jacobian: FloatArray
    contact: LineContact


def reducer_equilibrium(case: LoadCase, crank_angle: ArrayLike, tolerance: float = 1e-8) -> ReducerState:
    """Solve for carrier rotation and disc motions at crank angles of disc 1, shape (poses,) [rad].

    ``tolerance`` bounds the residual; rounding of the gaps (1e-14 mm) alone leaves about 1e-9. A pose
    that fails keeps its status and never stops the others.
    """
    meshing = mesh(case.drive.trochoid, crank_angle, case.drive.discs)
    support = support_model(case.drive, meshing.crank_angle)
    u, touched = _rigid_touch(case, meshing, support)
    start = u + support.rigid_motion * _overclosure(case)
    u, lost = start, np.zeros(len(start), dtype=np.bool_)
    load = np.zeros_like(u)
    load[:, 0] = case.torque
    springs = support.stiffness * np.einsum("psdu,psdv->puv", support.spring_stretch, support.spring_stretch)
    residual = np.full(u.shape[0], math.inf)
    force = np.zeros(meshing.phase.shape)
    for _ in range(_REFRESHES):
        linear = _linearise(case, meshing, support, u)
        gradient, force = _unbalanced(case, linear, springs, load, u, np.zeros_like(u))
        residual = np.max(np.abs(gradient) * support.arm, axis=-1) / abs(case.torque)
        if np.all(lost | (residual < tolerance)):
            break
        u = u + _newton(case, linear, springs, load, u, support.arm, 0.1 * tolerance)
        # A turn by a radian or a shift by the pin circle's radius is no small motion: such a pose is lost,
        # and rests at its start so that it cannot disturb the others.
        lost |= ~(np.max(np.abs(u / support.arm), axis=-1) < 1.0)
        u = np.where(lost[:, np.newaxis], start, u)
    motion = np.einsum("pdiu,pu->pdi", support.disc_motion, u)
    status = tuple(
        Status.NO_CONTACT if not ok else Status.CONVERGED if r < tolerance and not gone else Status.NOT_CONVERGED
        for ok, r, gone in zip(touched, residual, lost, strict=True)
    )
    return ReducerState(case, meshing, u[:, 0], motion, force, residual, status)


def _gaps_at(case: LoadCase, meshing: Meshing, motion: FloatArray) -> Gaps:
    return gaps(case.profile, case.drive.pin_radius, meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])


def _pin_jacobian(found: Gaps, support: SupportModel) -> FloatArray:
    """How each pin's approach grows with the unknowns, shape (poses, discs, pins, unknowns)."""
    frame = np.stack([found.normal.real, found.normal.imag, found.lever], axis=-1)
    jacobian: FloatArray = np.einsum("pdki,pdiu->pdku", frame, support.disc_motion)
    return jacobian


def _rigid_touch(case: LoadCase, meshing: Meshing, support: SupportModel) -> tuple[FloatArray, list[bool]]:
    """Turn carrier and discs as one, bearings unstretched, until the first pin of any disc touches."""
    direction = math.copysign(1.0, case.torque)
    u = np.zeros_like(support.rigid_motion)
    step = np.full(u.shape[0], math.inf)
    for _ in range(_TOUCH_STEPS):
        motion = np.einsum("pdiu,pu->pdi", support.disc_motion, u)
        found = _gaps_at(case, meshing, motion)
        arm = direction * np.einsum("pdku,pu->pdk", _pin_jacobian(found, support), support.rigid_motion)
        step = direction * np.min(closing_turn(case.profile, found.gap, arm), axis=(1, 2))
        u = u + support.rigid_motion * step[:, np.newaxis]
        if float(np.max(np.abs(step))) < 1e-13:
            break
    return u, [bool(abs(s) < 1e-9) for s in step]


def _overclosure(case: LoadCase) -> float:
    """A rotation that surely closes several pins, so that Newton starts with contact [rad]."""
    per_disc = abs(case.torque) / case.drive.discs / case.drive.trochoid.longest_lever
    contact = case.line_contact(np.zeros(1))
    delta = float(case.law.approach(per_disc, contact)[0])
    return math.copysign(delta / case.drive.trochoid.longest_lever, case.torque)


def _linearise(case: LoadCase, meshing: Meshing, support: SupportModel, u: FloatArray) -> _Linear:
    motion = np.einsum("pdiu,pu->pdi", support.disc_motion, u)
    found = _gaps_at(case, meshing, motion)
    return _Linear(found.gap, _pin_jacobian(found, support), case.line_contact(found.curvature))


def _unbalanced(
    case: LoadCase, linear: _Linear, springs: FloatArray, load: FloatArray, u: FloatArray, step: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Gradient of the energy after ``step``, shape (poses, unknowns), and the pin forces [N]."""
    approach = np.einsum("pdku,pu->pdk", linear.jacobian, step) - linear.gap
    force = case.law.force(np.maximum(approach, 0.0), linear.contact)
    gradient = np.einsum("puv,pv->pu", springs, u + step) + np.einsum("pdku,pdk->pu", linear.jacobian, force) - load
    return gradient, force


def _newton(
    case: LoadCase,
    linear: _Linear,
    springs: FloatArray,
    load: FloatArray,
    u: FloatArray,
    arm: FloatArray,
    tolerance: float,
) -> FloatArray:
    """Minimise the convex energy of the linearised problem; returns the step from ``u``."""
    step = np.zeros_like(u)
    gradient, force = _unbalanced(case, linear, springs, load, u, step)
    for _ in range(_NEWTON_STEPS):
        if float(np.max(np.abs(gradient) * arm)) < tolerance * abs(case.torque):
            break
        stiffness = np.where(force > 0.0, case.law.stiffness(force, linear.contact), 0.0)
        hessian = springs + np.einsum("pdku,pdk,pdkv->puv", linear.jacobian, stiffness, linear.jacobian)
        # A trace of damping keeps the matrix regular while the discs still float between the pins.
        diagonal = np.einsum("puu->pu", hessian)
        diagonal += 1e-9 * np.max(diagonal, axis=-1, keepdims=True) / arm**2
        direction = -np.linalg.solve(hessian, gradient[..., np.newaxis])[..., 0]
        slope = np.sum(gradient * direction, axis=-1)
        fraction = np.ones(u.shape[0])
        for _ in range(30):
            trial = step + fraction[:, np.newaxis] * direction
            trial_gradient, trial_force = _unbalanced(case, linear, springs, load, u, trial)
            # Convex along the line: a slope that turned strongly positive means the step overshot.
            overshot = np.sum(trial_gradient * direction, axis=-1) > 0.9 * np.abs(slope)
            if not np.any(overshot):
                break
            fraction = np.where(overshot, 0.5 * fraction, fraction)
        step, gradient, force = trial, trial_gradient, trial_force
    return step
