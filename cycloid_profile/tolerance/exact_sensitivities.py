"""Sensitivity of the backlash to part errors, measured on the exact model (docs/budget.md, "From geometry").

Each kind of error has its own way to be measured; all give the change of the backlash per mm of the error, over poses
of one turn of the output. The crank is held, so that a first stage does not matter, and the bearings are unstretched.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import first_touch
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.meshing import mesh, output_turn
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.effects.crank import CrankBearingClearance
from cycloid_profile.effects.effect import Effect
from cycloid_profile.errors import SolveError
from cycloid_profile.rig.maps import lost_motion_map
from cycloid_profile.tolerance.first_stage import InvolutePair, crank_held, output_per_sun_play
from cycloid_profile.units import UM

# No factor in common with the mesh cycles of any usual drive: every pose stands at its own place of a mesh cycle.
POSES = 101
# Where a pose costs more, or many rings are seen.
_FEW_POSES = 31
_SEED = 1
# Far above what the bearings yield by, so that what is measured is their play.
_BEARING_PLAY = 5.0 * UM
_BEARING_TORQUE_SHARE = 1e-3


@dataclass(frozen=True, slots=True)
class Slope:
    """Change of the backlash per mm of an error [rad/mm], positive where the error opens play.

    ``mean``, ``least`` and ``greatest`` over the poses of the reducer, whose nearest disc stops it; ``one_disc`` the
    mean of disc 1 by itself, None where the error is not one of the mesh; ``statistic`` says over what and per what.
    """

    mean: float
    least: float
    greatest: float
    one_disc: float | None
    statistic: str


@dataclass(frozen=True, slots=True)
class Held:
    """Backlash with the crank held, arrays of shape (poses,) [rad]: of the ``reducer``, and of ``disc`` 1 by itself."""

    reducer: FloatArray
    disc: FloatArray


def held_backlash(built: Built, crank_angle: FloatArray) -> Held:
    """Turn of all discs as one from first touch to first touch, by exact contact.

    Raises
    ------
    SolveError
        If at some pose no first touch is found.
    """
    drive = built.case.drive
    meshing = mesh(drive.trochoid, crank_angle, drive.discs)
    meshing = replace(meshing, pin_centre=meshing.pin_in_lobe(pin_shift=built.pin_shift))
    radius = drive.pin_radius + built.pin_oversize
    turned = np.empty((2, drive.discs, len(crank_angle)))
    for j, tooth in enumerate(built.teeth):
        for k, direction in enumerate((1.0, -1.0)):
            touch = first_touch(tooth, radius, meshing.disc(j), direction)
            if not np.all(touch.settled):
                raise SolveError("first touch", "not found", "at some pose", "check the modification amounts", " ")
            turned[k, j] = touch.rotation[:, 0]
    forward, backward = turned
    return Held(np.min(forward, axis=0) - np.max(backward, axis=0), forward[0] - backward[0])


@dataclass(frozen=True)
class Bench:
    """What errors are measured on: ``case`` with its tooth as ground, ``step`` of the errors [mm], number of poses."""

    case: LoadCase
    step: float = 1.0 * UM
    poses: int = POSES

    @cached_property
    def crank_angle(self) -> FloatArray:
        """Crank angles of one turn of the output, shape (poses,) [rad]."""
        return output_turn(self.case.drive.trochoid, self.poses)

    @cached_property
    def as_drawn(self) -> Held:
        """Backlash of the reducer without errors."""
        return self.held(as_drawn(self.case))

    def held(self, built: Built) -> Held:
        """Backlash of a reducer over the poses."""
        return held_backlash(built, self.crank_angle)


class Measure(Protocol):
    """A way to measure one kind of error."""

    def slope(self, bench: Bench) -> Slope:
        """Change of the backlash per mm of the error."""
        ...


@dataclass(frozen=True, slots=True)
class Opening:
    """An error with a sign, alike on all teeth or pins, in the sense that opens play: a tight tooth does not bind."""

    reducer: Callable[[LoadCase, float], Built]

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``."""
        found, before = bench.held(self.reducer(bench.case, bench.step)), bench.as_drawn
        return _over_poses(
            (found.reducer - before.reducer) / bench.step,
            (found.disc - before.disc) / bench.step,
            f"mean over a turn, at {bench.step / UM:g} µm",
        )


@dataclass(frozen=True, slots=True)
class TwoSided:
    """An error that may close play either way: half the difference between more and less of it."""

    reducer: Callable[[LoadCase, float], Built]

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``."""
        more, less = (bench.held(self.reducer(bench.case, sign * bench.step)) for sign in (1.0, -1.0))
        share = 0.5 / bench.step
        return _over_poses(
            share * (more.reducer - less.reducer),
            share * (more.disc - less.disc),
            f"mean over a turn, from ±{bench.step / UM:g} µm",
        )


@dataclass(frozen=True, slots=True)
class Directed:
    """An error with a direction, which comes round: what an ``effect`` of the given amplitude [µm] changes."""

    effect: Callable[[float], Effect]
    amplitude: str

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``."""
        found, before = bench.held(self.effect(bench.step / UM).apply(as_drawn(bench.case))), bench.as_drawn
        return _over_poses(
            (found.reducer - before.reducer) / bench.step,
            (found.disc - before.disc) / bench.step,
            f"mean over a turn per mm of {self.amplitude}, at {bench.step / UM:g} µm",
        )


@dataclass(frozen=True, slots=True)
class ScatteredPins:
    """Every pin hole out of its place along the circle by a normal number of its own; ``rings`` are drawn."""

    rings: int = 24

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``; each ring is seen at few poses."""
        bench = replace(bench, poses=min(bench.poses, _FEW_POSES))
        pins = bench.case.drive.trochoid.pins
        along = 1j * np.exp(2j * np.pi * np.arange(pins) / pins)
        sigma, drawn, before = np.random.default_rng(_SEED), as_drawn(bench.case), bench.as_drawn
        found = [
            bench.held(replace(drawn, pin_shift=bench.step * sigma.standard_normal(pins) * along))
            for _ in range(self.rings)
        ]
        return _over_poses(
            np.concatenate([one.reducer - before.reducer for one in found]) / bench.step,
            np.concatenate([one.disc - before.disc for one in found]) / bench.step,
            f"mean over a turn of {self.rings} drawn rings per mm of standard deviation, at {bench.step / UM:g} µm",
        )


@dataclass(frozen=True, slots=True)
class BearingPlay:
    """Play of every crank bearing, per mm of diametral clearance: what it adds to the lost motion of the stage."""

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``."""
        case = replace(bench.case, drive=crank_held(bench.case.drive))
        torque, poses = _BEARING_TORQUE_SHARE * abs(case.torque), min(bench.poses, _FEW_POSES)
        looser = CrankBearingClearance(_BEARING_PLAY / UM).apply(as_drawn(case))
        lost = [lost_motion_map(built, torque, poses).value for built in (as_drawn(case), looser)]
        if not np.all(np.isfinite(lost)):
            raise SolveError("lost motion", "not found", "at some pose", "check the modification amounts", " ")
        return _over_poses(
            (lost[1] - lost[0]) / (2.0 * _BEARING_PLAY),
            None,
            f"mean over a turn of the lost motion at ±{100.0 * _BEARING_TORQUE_SHARE:g} % torque, "
            f"{_BEARING_PLAY / UM:g} µm radial play",
        )


@dataclass(frozen=True, slots=True)
class SunPlay:
    """An error of the involute stage: play of the pair by exact involutes, taken to the output by the stage model.

    ``comes_round`` where the error is an offset that turns with the planet, ±``step`` instead of ``step``.
    """

    play: Callable[[InvolutePair, float], float]
    statistic: str
    comes_round: bool = False

    def slope(self, bench: Bench) -> Slope:
        """See ``Measure.slope``."""
        stage = bench.case.drive.first_stage
        assert stage is not None
        pair, output = InvolutePair(stage), output_per_sun_play(bench.case)
        angle = 2.0 * np.pi * np.arange(24) / 24
        amounts = bench.step * np.cos(angle) if self.comes_round else np.array([bench.step])
        play = np.array([self.play(pair, float(amount)) for amount in amounts]) * output / bench.step
        return _over_poses(play, None, self.statistic)


def by_effect(effect: Callable[[float], Effect]) -> Callable[[LoadCase, float], Built]:
    """The reducer with one effect, by its size [mm]; ``effect`` takes it in µm."""
    return lambda case, amount: effect(amount / UM).apply(as_drawn(case))


def _over_poses(change: FloatArray, disc: FloatArray | None, statistic: str) -> Slope:
    return Slope(
        float(np.mean(change)),
        float(np.min(change)),
        float(np.max(change)),
        None if disc is None else float(np.mean(disc)),
        statistic,
    )
