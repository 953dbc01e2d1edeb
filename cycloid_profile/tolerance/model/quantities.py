"""Quantities of a reducer: backlash by geometry; lost motion, transmission error and pressure by load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

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

# Poses of the derivatives; at ``TURN_POSES`` of them reducers of a study are solved, too.
BACKLASH_POSES, LOST_MOTION_POSES, TURN_POSES = 47, 17, 97
# Poses per turn of the crank between which the backlash of each pin is interpolated. RV-40E, 31,219 poses as the
# reference: mean off by 0.0019′ with 20, 0.0014′ with 24, 0.0004′ with 40.
_POSES_PER_CRANK_TURN = 40
# Poses per turn of the crank at light load, of which as many are solved as are chosen. At rated torque one pose per
# mesh cycle of the whole turn, of which as many are chosen at either end.
LOADED_PER_CRANK_TURN, LOST_MOTION_CHOSEN, TURN_CHOSEN = 12, 8, 8
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
        poses = _largest(self.backlash.by_pose(x), LOST_MOTION_CHOSEN)
        rotation, _ = self.stage.answers(x, np.concatenate([poses, poses + self.backlash.poses], axis=1))
        there, back = np.split(rotation, 2, axis=1)
        return np.asarray(np.max(there - back, axis=1)[:, np.newaxis] / ARCMIN)


@dataclass(frozen=True)
class RatedLoadQuantities:
    """Transmission error, peak to peak over a turn, and the highest peak pressure, at rated torque.

    Equilibria are solved at some poses evenly over the turn, and at those where the rotation to first order is largest
    or least.
    """

    stage: LoadedStage
    names: tuple[str, ...] = ("transmission_error_arcsec", "peak_pressure_mpa")

    def of(self, x: FloatArray) -> FloatArray:
        linear = self.stage.linear_rotation(x)
        loads = linear.shape[1]
        even = np.unique(np.round(np.arange(TURN_POSES) * loads / TURN_POSES).astype(np.intp) % loads)
        extreme = [_largest(sign * linear, TURN_CHOSEN) for sign in (1.0, -1.0)]
        chosen = np.concatenate([np.broadcast_to(even, (len(x), even.size)), *extreme], axis=1)
        rotation, pressure = self.stage.answers(x, chosen)
        return np.stack([np.ptp(rotation, axis=1) / ARCSEC, np.max(pressure, axis=1)], axis=1)


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
            trochoid = reducer.case.drive.trochoid
            rated = rated_loads(reducer, trochoid.lobes * trochoid.pins)
            found.append(RatedLoadQuantities(loaded_stage(reducer, changes, *rated)))
        return tuple(found)

    def of(self, x: FloatArray) -> FloatArray:
        """Values of reducers with coordinates ``x``, shape (reducers, quantities), in the units of ``names``."""
        return np.concatenate([answers.of(x) for answers in self.answers], axis=1)
