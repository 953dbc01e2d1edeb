"""The numbers of a hysteresis loop in the words of the standards, each with its construction (docs/rig.md)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError

LOST_MOTION_SHARE = 0.03


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


def evaluate_loop(torque: FloatArray, angle: FloatArray) -> LoopFigures:
    """Read a loop of any start that holds at least one whole turn between its extremes.

    Raises
    ------
    MeasurementError
        If the torque does not run from its largest to its smallest and back.
    """
    peak = float(np.max(torque))
    top, bottom, end = _branch_ends(torque, peak)
    falling, rising = slice(top, bottom + 1), slice(bottom, end + 1)
    down = _at(torque[falling][::-1], angle[falling][::-1])
    up = _at(torque[rising], angle[rising])
    three = LOST_MOTION_SHARE * peak
    low, high = (0.5 * (down(T) + up(T)) for T in (-three, three))
    zero = (up(0.0), down(0.0))
    last = float(torque[rising][-1])
    half = 0.5 * peak
    forward = (last - half) / (up(last) - up(half)) if last > half else np.nan
    least = float(torque[bottom])
    backward = (-half - least) / (down(-half) - down(least))
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
    # A file can hold several turns: the visits to the peak next to the bottom.
    last = np.split(high[high < bottom], np.flatnonzero(np.diff(high[high < bottom]) > 1) + 1)[-1]
    first = np.split(high[high > bottom], np.flatnonzero(np.diff(high[high > bottom]) > 1) + 1)[0]
    top = int(last[-1] - np.argmax(torque[last][::-1]))
    return top, bottom, int(first[np.argmax(torque[first])])


def _at(torque: FloatArray, angle: FloatArray) -> Callable[[float], float]:
    """The angle of a branch at a torque, linear between its points."""

    def read(T: float) -> float:
        return float(np.interp(T, torque, angle))

    return read
