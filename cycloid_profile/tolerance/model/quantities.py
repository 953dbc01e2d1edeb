"""Quantities of a reducer: backlash by geometry; lost motion, transmission error and pressure by load."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.effects import AsBuiltReducer, ReducerChange
from cycloid_profile.geometry import Trochoid
from cycloid_profile.rig import LOST_MOTION_SHARE
from cycloid_profile.tolerance.inputs import Tolerances
from cycloid_profile.tolerance.model._crank_locked import CrankLockedBacklash, crank_locked_backlash, pose_count
from cycloid_profile.tolerance.model._loaded import LoadedStage, loaded_stage
from cycloid_profile.units import ARCMIN, ARCSEC

# Poses of the derivatives.
BACKLASH_POSES, LOST_MOTION_POSES, TURN_POSES = 47, 17, 97
# Poses per turn of the crank: between them the backlash of each pin is interpolated, under rated load some are chosen.
# Backlash of the RV-40E, 31,219 poses as the reference: mean off by 0.0019′ with 20, 0.0014′ with 24, 0.0004′ with 40.
_POSES_PER_CRANK_TURN = 40
# Poses of a whole turn under rated load, at least: the load of few pins has kinks.
_LEAST_RATED_POSES = 1500
# Poses per turn of the crank at light load. For each extreme under load as many poses are solved as are chosen by their
# estimate, and both neighbours of the best.
LOADED_PER_CRANK_TURN, LOST_MOTION_CHOSEN, TURN_CHOSEN = 12, 8, 16
# Quantities in the order of reports, each with its definition.
QUANTITIES = {
    "backlash_arcmin": "backlash, crank locked, largest over a turn",
    "least_backlash_arcmin": "least backlash over a turn, negative where the reducer binds",
    "lost_motion_arcmin": "lost motion at ±3 % of rated torque, largest over a turn",
    "transmission_error_arcsec": "transmission error at rated torque, peak to peak over a turn",
    "peak_pressure_mpa": "highest contact pressure at rated torque",
}
# Small against every curvature of the profile, large against rounding: a share of the tolerance.
_STEP = 0.01


def unit_changes(reducer: AsBuiltReducer, tolerances: Tolerances) -> list[ReducerChange]:
    """Change of the reducer by a unit of every coordinate, in the order of ``Draws.coordinates``."""
    found = []
    for one in tolerances.scatters:
        width = one.axes.size.tolerance or 1.0
        step = _STEP * (1.0 / width if one.axes.reciprocal else width)
        found += [
            ReducerChange(reducer, one.axes.effect(step * unit, choice).apply(reducer), step)
            for choice in one.choices
            for unit in np.eye(one.axes.count)
        ]
    return found


def crank_angles(trochoid: Trochoid, poses: int) -> FloatArray:
    """Crank angles of about ``poses`` poses over a turn of the output, shape (count,) [rad]."""
    return output_turn(trochoid, pose_count(poses, trochoid.lobes * trochoid.pins))


def lost_motion_loads(reducer: AsBuiltReducer, poses: int = LOST_MOTION_POSES) -> tuple[FloatArray, FloatArray]:
    """Crank angles [rad] and torques [N·mm] of a lost-motion map: all poses forwards, then all backwards."""
    crank = crank_angles(reducer.case.drive.trochoid, poses)
    light = LOST_MOTION_SHARE * abs(reducer.case.torque)
    return np.tile(crank, 2), np.repeat([light, -light], len(crank))


def rated_loads(reducer: AsBuiltReducer, poses: int = TURN_POSES) -> tuple[FloatArray, FloatArray]:
    """Crank angles [rad] and torques [N·mm] of a turn under the rated torque."""
    crank = crank_angles(reducer.case.drive.trochoid, poses)
    return crank, np.full(len(crank), abs(reducer.case.torque))


class Quantities(Protocol):
    """A method to compute some quantities of many reducers."""

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities, each named with its unit."""
        ...

    def of(self, x: FloatArray) -> FloatArray:
        """Values of reducers with coordinates ``x``, shape (reducers, quantities); NaN where there is no answer."""
        ...


@dataclass(frozen=True)
class BacklashQuantities:
    """Largest and least crank-locked backlash over a turn of the output; the least is negative where a disc binds.

    Large negative values are not meaningful, because near root and tip no rotation opens a gap.
    """

    backlash: CrankLockedBacklash
    names: tuple[str, ...] = ("backlash_arcmin", "least_backlash_arcmin")

    def of(self, x: FloatArray) -> FloatArray:
        return self.backlash.extremes(x) / ARCMIN


@dataclass(frozen=True)
class LostMotionQuantities:
    """Largest rotation between ∓3 % of the rated torque over a turn of the output.

    ``stage`` at all poses forwards, then backwards. Equilibria are solved at the poses of largest ``backlash``.
    """

    stage: LoadedStage
    backlash: CrankLockedBacklash
    names: tuple[str, ...] = ("lost_motion_arcmin",)

    def of(self, x: FloatArray) -> FloatArray:
        def solved(poses: IntArray, _part: IntArray | None) -> SolvedPoses:
            rotation, _ = self.stage.answers(x, np.concatenate([poses, poses + self.backlash.poses], axis=1))
            there, back = np.split(rotation, 2, axis=1)
            return SolvedPoses.smooth((there - back)[np.newaxis])

        return largest_over_turn(self.backlash.by_pose(x)[np.newaxis], solved, LOST_MOTION_CHOSEN) / ARCMIN


@dataclass(frozen=True)
class RatedLoadQuantities:
    """Transmission error, peak to peak over a turn, and the highest peak pressure, at rated torque.

    Equilibria are solved where rotation or pressure are extreme to first order.
    """

    stage: LoadedStage
    names: tuple[str, ...] = ("transmission_error_arcsec", "peak_pressure_mpa")

    def of(self, x: FloatArray) -> FloatArray:
        def solved(poses: IntArray, contact: IntArray | None) -> SolvedPoses:
            found = self.stage.following(x, poses, contact)
            turned = (found.rotation, -found.rotation)
            return SolvedPoses(np.stack([*turned, found.pressure]), np.stack([*turned, found.followed]), found.contact)

        rotation, pressure = self.stage.first_order.rotations(x), self.stage.first_order.pressures(x)
        estimate = np.stack([rotation, -rotation, pressure])
        ahead, behind, pressed = largest_over_turn(estimate, solved, TURN_CHOSEN, kinked=(2,)).T
        return np.stack([(ahead + behind) / ARCSEC, pressed], axis=1)


class SolvedPoses(NamedTuple):
    """Values of quantities at some poses, shape (quantities, reducers, poses).

    ``followed``: the same of the part that was asked for, such as one contact: smooth from pose to pose, where the
    largest of all parts is not. ``part``: that of the largest value, shape (reducers, poses).
    """

    value: FloatArray
    followed: FloatArray
    part: IntArray

    @classmethod
    def smooth(cls, value: FloatArray) -> SolvedPoses:
        """Of quantities without parts."""
        return cls(value, value, np.zeros(value.shape[1:], np.int64))


def largest_over_turn(
    estimate: FloatArray,
    solved: Callable[[IntArray, IntArray | None], SolvedPoses],
    count: int,
    kinked: Sequence[int] = (),
) -> FloatArray:
    """Largest value of each quantity over a turn, shape (reducers, quantities).

    ``estimate`` of the quantities at all poses, which close the turn, shape (quantities, reducers, poses). ``solved``
    gives their values at poses of each reducer and of the parts to follow, shapes (reducers, some): at the ``count``
    poses of the largest estimates, then at both neighbours of the best, for its part. The largest value is the vertex
    of the parabola through these three.

    ``kinked`` quantities: the load of a contact has a kink where another one ends, which a parabola would overshoot.
    Of these the lower vertex counts, of that parabola and of the one through the poses on the side of the top alone.
    """
    poses = estimate.shape[2]
    chosen = np.concatenate([_largest(one, count) for one in estimate], axis=1)
    found = solved(chosen, None)
    best = np.argmax(found.value, axis=2)
    place, part = (np.take_along_axis(of, best.T, axis=1) for of in (chosen, found.part))
    adjacent = solved(np.hstack([place - 1, place + 1]) % poses, np.hstack([part, part]))
    here, (before, after) = np.max(found.value, axis=2), _of_each(adjacent.followed)
    top = _top(0.5 * (after - before), 2.0 * here - before - after)
    for i in kinked:
        ahead = after[i] >= before[i]
        further = (place[:, i] + np.where(ahead, 2, -2)) % poses
        beyond = solved(further[:, np.newaxis], part[:, i, np.newaxis]).followed[i, :, 0]
        higher = np.where(ahead, after[i], before[i])
        slope = np.maximum(2.0 * higher - 1.5 * here[i] - 0.5 * beyond, 0.0)
        top[i] = np.minimum(top[i], _top(slope, 2.0 * higher - here[i] - beyond))
        # No parabola goes through a pose where the contact does not touch.
        top[i] *= (before[i] > 0.0) & (after[i] > 0.0) & (beyond > 0.0)
    return np.asarray(np.maximum(here + top, np.max(_of_each(adjacent.value), axis=0)).T)


def _top(slope: FloatArray, bend: FloatArray) -> FloatArray:
    """Height of the top of a parabola above its value where it has this ``slope``; 0 where it bends upwards."""
    return np.asarray(slope**2 / (2.0 * np.where(bend > 0.0, bend, np.inf)))


def _of_each(values: FloatArray) -> FloatArray:
    """Values of each quantity at the poses near its own best, shape (sides, quantities, reducers)."""
    count = len(values)
    sides = range(values.shape[2] // count)
    return np.stack([[values[i, :, side * count + i] for i in range(count)] for side in sides])


def _largest(values: FloatArray, count: int) -> IntArray:
    """Columns of the largest ``values`` of each row, shape (rows, count)."""
    some = min(count, values.shape[1])
    return np.argpartition(values, -some, axis=1)[:, values.shape[1] - some :]


@dataclass(frozen=True)
class QuantityModel:
    """The quantities ``wanted`` of reducers that differ from ``reducer`` by some ``changes``."""

    reducer: AsBuiltReducer
    changes: Sequence[ReducerChange]
    wanted: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Computed quantities: those wanted, and others that the same computations give."""
        return tuple(name for answers in self.answers for name in answers.names)

    @cached_property
    def answers(self) -> tuple[Quantities, ...]:
        """The methods that compute them, made once for all reducers."""
        reducer, changes = self.reducer, self.changes
        found: list[Quantities] = []
        turn = _POSES_PER_CRANK_TURN * reducer.case.drive.trochoid.lobes
        if {"backlash_arcmin", "least_backlash_arcmin"} & set(self.wanted):
            found.append(BacklashQuantities(crank_locked_backlash(reducer, changes, turn)))
        if "lost_motion_arcmin" in self.wanted:
            light = LOADED_PER_CRANK_TURN * reducer.case.drive.trochoid.lobes
            stage = loaded_stage(reducer, changes, *lost_motion_loads(reducer, light))
            found.append(
                LostMotionQuantities(stage, crank_locked_backlash(reducer, changes, len(stage.crank_angle) // 2))
            )
        if {"transmission_error_arcsec", "peak_pressure_mpa"} & set(self.wanted):
            rated = rated_loads(reducer, max(turn, _LEAST_RATED_POSES))
            found.append(RatedLoadQuantities(loaded_stage(reducer, changes, *rated)))
        return tuple(found)

    def of(self, x: FloatArray) -> FloatArray:
        """Values of reducers with coordinates ``x``, shape (reducers, quantities), in the units of ``names``."""
        return np.concatenate([answers.of(x) for answers in self.answers], axis=1)
