"""Hysteresis loop at one angle of the output, torque up and down, and its figures (docs/rig.md, "Hysteresis loop").

The loop is quasi-static. Friction carries part of the applied torque: while the applied torque varies within the
friction band, the torque on the stage stays constant.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE

POINTS = 400  # rows of a loop; its figures are interpolated between them
# Lost motion is read between ± this share of the rated torque, or of the peak of a loop.
LOST_MOTION_SHARE = 0.03
# Share of the rated torque below which the stage is unloaded inside the backlash: it rests on the flank touched last.
UNLOADED_SHARE = 1e-4


@dataclass(frozen=True, slots=True, repr=False)
class Loop(Described):
    """A hysteresis loop: 0 → +T → −T → +T.

    ``torque`` applied to the output [N·mm], ``angle`` read [rad] and ``stage_torque`` after friction [N·mm],
    shape (points,); ``output_angle`` of the pose [rad].
    """

    reducer: AsBuiltReducer
    output_angle: float
    torque: FloatArray
    stage_torque: FloatArray
    angle: FloatArray

    @property
    def figures(self) -> LoopFigures:
        """Lost motion, hysteresis loss, rigidity and loss energy."""
        return evaluate_loop(self.torque, self.angle)

    def to_frame(self) -> Any:
        """``torque_nm``, ``stage_torque_nm`` and ``angle_arcmin`` as a ``pandas.DataFrame``."""
        torques = {"torque_nm": self.torque, "stage_torque_nm": self.stage_torque}
        columns = {name: torque / NEWTON_METRE for name, torque in torques.items()}
        return frame({**columns, "angle_arcmin": self.angle / ARCMIN})

    def _key_figures(self) -> dict[str, str]:
        figures = self.figures
        return {
            "peak torque": f"{np.max(np.abs(self.torque)) / NEWTON_METRE:.4g} N·m",
            "output angle": f"{self.output_angle / DEGREE:.4g}°",
            "points": str(self.torque.size),
            "lost motion": f"{figures.lost_motion / ARCMIN:.4g}′",
            "hysteresis loss": f"{figures.hysteresis_loss / ARCMIN:.4g}′",
            "torsional rigidity": f"{figures.torsional_rigidity * ARCMIN / NEWTON_METRE:.4g} N·m/′",
        }


@dataclass(frozen=True, slots=True)
class LoopFigures:
    """Four numbers of a loop and the points they were read at; angles [rad], torques [N·mm].

    ``lost_motion``, centreline angle between ±3 % of the peak torque; ``hysteresis_loss``, width of the loop at zero
    torque; ``torsional_rigidity`` b/a, slope of the loading branches between half and full torque, mean of both
    directions [N·mm/rad]; ``loss_energy``, area of the loop [N·mm]. ``centreline`` and ``zero`` hold the angles at ±3 %
    and of the two branches at zero, for drawing.
    """

    torque: FloatArray
    angle: FloatArray
    lost_motion: float
    hysteresis_loss: float
    torsional_rigidity: float
    loss_energy: float
    centreline: tuple[float, float]
    zero: tuple[float, float]
    rigidity_points: tuple[tuple[float, float], tuple[float, float]]


def torque_path(peak: float, points: int = POINTS) -> FloatArray:
    """0 → +peak → −peak → +peak, with finer steps near zero torque, shape (about points,) [N·mm]."""
    quarter = max(points // 5, 2)
    legs = [np.arange(quarter), np.arange(quarter, -quarter, -1), np.arange(-quarter, quarter + 1)]
    u = np.concatenate(legs) / quarter
    return np.asarray(peak * u * (0.1 + 0.9 * np.abs(u)))


def hysteresis_loop(
    reducer: AsBuiltReducer,
    peak: float | None = None,
    points: int = POINTS,
    output_angle: float = 0.0,
    before: float = -1.0,
) -> Loop:
    """The loop up to ``peak`` torque, rated unless given [N·mm], with the output at ``output_angle`` [rad].

    ``before``, the sign of the preceding torque, sets the initially loaded flank within the backlash.
    """
    T = torque_path(abs(reducer.case.torque) if peak is None else peak, points)
    transmitted = reducer.stage_torque(T, before)
    crank = -output_angle * reducer.case.drive.trochoid.lobes
    least = UNLOADED_SHARE * abs(reducer.case.torque)
    unloaded = np.abs(transmitted) < least
    side = np.sign(transmitted)
    for i in np.flatnonzero(unloaded):
        side[i] = side[i - 1] if i else math.copysign(1.0, before)
    solved_torque = np.where(unloaded, side * least, transmitted)
    stage = StageEquilibrium(deviations=reducer.deviations)
    solved = stage.at(reducer.case, crank, solved_torque)
    angle = np.where(solved.settled, solved.rotation, np.nan)
    read = angle + reducer.series_twist(transmitted, T) + reducer.angle_error(output_angle)
    return Loop(reducer, output_angle, T, transmitted, read)


def evaluate_loop(torque: FloatArray, angle: FloatArray) -> LoopFigures:
    """Figures of a loop from any start that holds at least one whole cycle between its extremes.

    Raises ``MeasurementError`` if the torque does not run from its largest to its smallest and back, or the angle does
    not move with it.
    """
    peak = float(np.max(torque))
    top, bottom, end = _branch_ends(torque, peak)
    falling, rising = slice(top, bottom + 1), slice(bottom, end + 1)
    down = _interpolated(torque[falling][::-1], angle[falling][::-1])
    up = _interpolated(torque[rising], angle[rising])
    light = LOST_MOTION_SHARE * peak
    low, high = (0.5 * (down(T) + up(T)) for T in (-light, light))
    zero = (up(0.0), down(0.0))
    last = float(torque[rising][-1])
    half = 0.5 * peak
    least = float(torque[bottom])
    turns = (up(last) - up(half), down(-half) - down(least))
    if (last > half and turns[0] == 0.0) or turns[1] == 0.0:
        limit = "does not change between half and full torque"
        raise MeasurementError("angle of the loop", "", limit, "take less friction or more torque", "")
    forward = (last - half) / turns[0] if last > half else np.nan
    backward = (-half - least) / turns[1]
    return LoopFigures(
        torque=torque,
        angle=angle,
        lost_motion=high - low,
        hysteresis_loss=zero[1] - zero[0],
        torsional_rigidity=float(np.nanmean([forward, backward])),
        loss_energy=float(abs(np.trapezoid(torque[top : end + 1], angle[top : end + 1]))),
        centreline=(low, high),
        zero=zero,
        rigidity_points=((half, up(half)), (last, up(last))),
    )


def _branch_ends(torque: FloatArray, peak: float) -> tuple[int, int, int]:
    """Rows of the peak before the bottom, of the bottom, and of the peak after it."""
    high = np.flatnonzero(torque > 0.5 * peak)
    bottom = int(high[0] + np.argmin(torque[high[0] : high[-1] + 1])) if high.size else 0
    if not torque[bottom] < 0.0 < peak:
        raise MeasurementError(
            "torque of the loop",
            f"{np.min(torque):.4g} to {peak:.4g} N·mm",
            "does not run from one end to the other and back",
            "measure 0 → +T → −T → +T",
        )
    # A file can hold several cycles: the visits to the peak next to the bottom.
    last = np.split(high[high < bottom], np.flatnonzero(np.diff(high[high < bottom]) > 1) + 1)[-1]
    first = np.split(high[high > bottom], np.flatnonzero(np.diff(high[high > bottom]) > 1) + 1)[0]
    top = int(last[-1] - np.argmax(torque[last][::-1]))
    return top, bottom, int(first[np.argmax(torque[first])])


def _interpolated(torque: FloatArray, angle: FloatArray) -> Callable[[float], float]:
    """The angle of a branch at a torque, linear between its points."""
    return lambda T: float(np.interp(T, torque, angle))
