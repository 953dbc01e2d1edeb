"""The loaded stage: where the carrier comes to rest, by Levenberg's damped Newton steps on the forces."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from .clearance import Clearance, clearance
from .contact import Body, Law, Roark
from .hidden import Hidden
from .parts import Parts, parts
from .pose import Poses
from .reducer import Reducer
from .tooth import ground

Array = np.ndarray
_BLOCK = 300
_STEPS = 30
_ROUNDS = 5
_SETTLED, _USABLE = 1e-9, 1e-4
_ROUNDING = 1e-14  # of an energy, over the torque [rad]
_CALMER = 0.7
_TOUCHING = 1e-5  # overlap that no ground tooth shows [mm]
# Pins that may come to carry; the others are looked at when the rest has settled.
_NEAR = 22
# Misfits load the bearings at no torque: the balance is a share of this one at least [N·mm].
_LEAST_TORQUE = 1e3
_STIFFNESS = 2e9  # about that of the stage [N·mm/rad]
# Rounds of forces and teeth pushed by them; each leaves about a third of the error.
_PUSHES, _PUSHED = 40, 2e-10  # change of the output angle that ends them [rad]


@dataclass(frozen=True)
class Stage:
    """A reducer with its hidden effects. The clearances are found once, for all loads and angles.

    ``contact`` law of pins and teeth, ``body`` of the discs.
    """

    reducer: Reducer
    effects: tuple[Hidden, ...]
    contact: Law = field(default_factory=Roark)
    body: Body = field(default_factory=Body)

    @cached_property
    def parts(self) -> Parts:
        """Pins, cranks, bearings."""
        return parts(self.reducer, self.effects)

    @cached_property
    def clearances(self) -> list[Clearance]:
        """Clearance round each disc."""
        return [clearance(ground(self.reducer, self.effects, j + 1)) for j in range(self.reducer.discs)]

    def binds(self, poses: int = 240) -> bool:
        """Whether discs overlap pins somewhere in the turn, unloaded, when the parts are turned to either touch."""
        output = 2.0 * np.pi * np.arange(poses) / poses
        for side in (1.0, -1.0):
            free = Poses(self.reducer, self.parts, self.clearances, output, np.full(poses, side))
            if np.max(free.overlap(free.touch())) > _TOUCHING:
                return True
        return False

    def twist(self, output: Array, torque: Array) -> Array:
        """Turn of the carrier beyond its ideal angle ``output`` [rad] under ``torque``, not zero [N·mm]."""
        output, torque = np.broadcast_arrays(np.asarray(output, float), np.asarray(torque, float))
        found = []
        for at in range(0, output.size, _BLOCK):
            some = slice(at, at + _BLOCK)
            poses = Poses(
                self.reducer, self.parts, self.clearances, output[some], torque[some], self.contact, self.body
            )
            start = poses.touch() + poses.turned(poses.torque / _STIFFNESS)
            few = poses.near(start, min(_NEAR, self.reducer.pins))
            u = rest(few, start)
            # A pin left out that overlaps: once more with all of them.
            missed = np.sum(poses.overlap(u) > 0.0, axis=(1, 2)) > np.sum(few.overlap(u) > 0.0, axis=(1, 2))
            if np.any(missed):
                u[missed] = rest(poses.at(missed), u[missed])
            found.append(u[:, 0])
        return np.concatenate(found)


def rest(poses: Poses, u: Array) -> Array:
    """Unknowns at rest, from a start ``u``; raises RuntimeError where there is no rest."""
    u = _rest(poses, u)
    if poses.body.rigid:
        return u
    for _ in range(_PUSHES):
        poses = poses.seen_from(u).pushed(u)
        before, u = u, _rest(poses, u)
        if np.max(np.abs(u - before)[:, 0]) < _PUSHED:
            return u
    raise RuntimeError("the pushed teeth do not settle: make the body stiffer or its reach shorter")


def _rest(poses: Poses, u: Array) -> Array:
    """Unknowns at rest with the teeth pushed as they are.

    Curvatures are computed again where the pins come to touch, and that a few times more where a disc with play swings.
    """
    u = u.copy()
    left = np.arange(u.shape[0])
    for tolerance in (1e-3, 1e-6, *[_SETTLED] * _ROUNDS):
        some = poses.at(left)
        u[left], residual = settle(some.seen_from(u[left]), u[left], tolerance)
        if tolerance == _SETTLED:
            left, residual = left[residual > tolerance], residual[residual > tolerance]
            if not left.size:
                return u
    if np.max(residual) > _USABLE:
        raise RuntimeError(f"{np.count_nonzero(residual > _USABLE)} poses without an equilibrium")
    return u


def settle(poses: Poses, u: Array, tolerance: float) -> tuple[Array, Array]:
    """Unknowns where the forces balance to a share of the torque, as far as that goes, and the share."""
    u = u.copy()
    r = poses.reducer
    torque = np.maximum(np.abs(poses.torque), _LEAST_TORQUE)
    arm, free = poses.arm, poses.free
    arm_of = r.pin_circle_radius_mm / arm
    damping = np.full(torque.size, 1e-4)
    left = np.arange(torque.size)
    residual = np.full(torque.size, np.inf)
    state = poses.state(u)
    for _ in range(_STEPS):
        residual[left] = np.max(np.abs(state.slope * arm), axis=1) / torque[left]
        moving = residual[left] > tolerance
        if not np.all(moving):
            left, poses, state = left[moving], poses.at(moving), state.at(moving)
        if not left.size:
            break
        # What is slack gets some stiffness of its own.
        diagonal = np.maximum(np.diagonal(state.stiffness, axis1=1, axis2=2), poses.parts.stiffness * arm_of**2)
        damped = state.stiffness + (damping[left, None] * diagonal)[:, None, :] * np.eye(arm.size)
        tried = u[left] - np.linalg.solve(damped, state.slope[..., None])[..., 0] @ free.T
        after = poses.state(tried)
        # A fall of the energy within its rounding is none, but then the forces decide.
        fallen = after.energy < state.energy - _ROUNDING * torque[left]
        calmer = np.max(np.abs(after.slope * arm), axis=1) / torque[left] < _CALMER * residual[left]
        better = fallen | calmer
        u[left[better]] = tried[better]
        damping[left] = np.where(better, 0.02 * damping[left], np.maximum(20.0 * damping[left], 1e-6))
        state = after.where(better, state)
    return u, residual
