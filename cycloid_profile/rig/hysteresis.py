"""Hysteresis loop at one angle of the output, torque up and down, and its figures (docs/rig.md, "Hysteresis loop").

The loop is quasi-static. Friction carries part of the applied torque: while the applied torque varies within the
friction band, the torque on the stage stays constant.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
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
# The rigidity is the slope of a loading branch between these shares of the same torque.
RIGIDITY_SHARES = ((LOST_MOTION_SHARE, 0.5), (0.5, 1.0))
_SHORT_OF_END = 0.05  # share of that torque by which a loop may end too early
_CLOSED_SHARE = 0.1  # of the largest torque: a loop that ends this close to its start is closed
# Share of the rated torque below which the stage is unloaded inside the backlash: it rests on the flank touched last.
UNLOADED_SHARE = 1e-4


@dataclass(frozen=True, eq=False, slots=True, repr=False)
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


@dataclass(frozen=True, eq=False, slots=True)
class LoopFigures:
    """Figures of a loop and the points they were read at; angles [rad], torques [N·mm]; NaN beyond the loop.

    ``lost_motion``, centreline angle between ±3 % of the rated torque; ``hysteresis_loss``, width of the loop at zero
    torque; ``torsional_rigidity`` b/a, slope of the loading branches between half and full torque, mean of both
    directions [N·mm/rad]; ``loss_energy``, area of the loop [N·mm]. ``rigidity`` of the loading branches, shape (2, 2):
    a row for each of ``RIGIDITY_SHARES``, columns of the forward and the backward torque [N·mm/rad]. ``centreline`` and
    ``zero`` hold the angles at ±3 % and of the two branches at zero, for drawing; ``light``, the torque of 3 %.
    ``crossed``: at 3 % friction still holds the branches on opposite flanks. ``coarse``: both branches pass the play
    between the same two rows about zero torque, so that these do not show the width. ``joint``: step of the angle where
    a branch was read from the end and the start of the file, 0 where each was measured whole [rad].
    """

    torque: FloatArray
    angle: FloatArray
    lost_motion: float
    hysteresis_loss: float
    torsional_rigidity: float
    loss_energy: float
    rigidity: FloatArray
    light: float
    crossed: bool
    coarse: bool
    joint: float
    centreline: tuple[float, float]
    zero: tuple[float, float]
    rigidity_points: tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False, slots=True)
class Branch:
    """All sweeps of a loop in one direction, as pairs of increasing torque [N·mm] and angle [rad].

    ``joint``: step of the angle where end and start of the file make one sweep [rad].
    """

    sweeps: tuple[tuple[FloatArray, FloatArray], ...]
    joint: float = 0.0

    @property
    def largest(self) -> float:
        """Largest torque [N·mm]."""
        return max(float(T[-1]) for T, _ in self.sweeps)

    @property
    def step_at_zero(self) -> float:
        """Largest change of the angle between the rows on either side of zero torque [rad]."""
        before = [int(np.searchsorted(T, 0.0)) for T, _ in self.sweeps]
        return max(abs(float(angle[k] - angle[k - 1])) for k, (_, angle) in zip(before, self.sweeps, strict=True))

    def at(self, torque: FloatArray) -> FloatArray:
        """Mean angle of the sweeps that reach a torque, linear between rows, NaN where none does [N·mm → rad]."""
        each = np.stack([np.interp(torque, T, angle, left=np.nan, right=np.nan) for T, angle in self.sweeps])
        reached = np.isfinite(each)
        total, count = np.sum(np.where(reached, each, 0.0), axis=0), np.count_nonzero(reached, axis=0)
        return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))


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


def evaluate_loop(torque: FloatArray, angle: FloatArray, rated: float | None = None) -> LoopFigures:
    """Figures of a loop from any start, in either sense, means of all its whole sweeps; shape (rows,) both.

    ``rated`` torque that the shares refer to, the largest of the loop unless given [N·mm]. Raises ``MeasurementError``
    if the torque does not run from its largest to its smallest and back, or the angle does not move with it.
    """
    falling, rising = loop_branches(torque, angle)
    reference = float(np.max(torque)) if rated is None else abs(rated)
    light = LOST_MOTION_SHARE * reference
    marks = np.array([-light, 0.0, light])
    down, up = falling.at(marks), rising.at(marks)
    centre = 0.5 * (down + up)
    rigidity = np.array([[_slope(rising, 1.0, low, high, reference), _slope(falling, -1.0, low, high, reference)]
                         for low, high in RIGIDITY_SHARES])  # fmt: skip
    if np.any(np.isinf(rigidity[-1])):
        limit = "does not change between half and full torque"
        raise MeasurementError("angle of the loop", "", limit, "take less friction or more torque", "")
    of_full = rigidity[-1][np.isfinite(rigidity[-1])]
    half, full = 0.5 * reference, min(reference, rising.largest)
    read = rising.at(np.array([half, full])).tolist()
    return LoopFigures(
        torque=torque,
        angle=angle,
        lost_motion=float(centre[2] - centre[0]),
        hysteresis_loss=float(down[1] - up[1]),
        torsional_rigidity=float(np.mean(of_full)) if of_full.size else math.nan,
        loss_energy=_area(falling, rising),
        rigidity=rigidity,
        light=light,
        crossed=bool(up[2] < down[0]),
        coarse=min(falling.step_at_zero, rising.step_at_zero) > 0.5 * abs(float(centre[2] - centre[0])),
        joint=falling.joint + rising.joint,
        centreline=(float(centre[0]), float(centre[2])),
        zero=(float(up[1]), float(down[1])),
        rigidity_points=((half, read[0]), (full, read[1])),
    )


def loop_branches(torque: FloatArray, angle: FloatArray) -> tuple[Branch, Branch]:
    """The falling and the rising branch of a loop; raises ``MeasurementError`` as ``evaluate_loop`` does."""
    ends = _turning_points(torque)
    sweeps: dict[bool, list[tuple[FloatArray, FloatArray]]] = {False: [], True: []}
    joint = {False: 0.0, True: 0.0}
    for (_, first), (last, _) in pairwise(ends):
        rows = np.arange(first, last + 1)
        sweeps[bool(torque[last] > torque[first])].append(_increasing(torque[rows], angle[rows]))
    # A loop from zero and back to zero passes one branch in two parts: at its end and at its start.
    if len(ends) > 1 and abs(torque[-1] - torque[0]) < _CLOSED_SHARE * float(np.max(torque)):
        (start, _), (_, end) = ends[0], ends[-1]
        rising = bool(torque[start] > torque[end])
        if not sweeps[rising]:
            rows = np.concatenate([np.arange(end, torque.size), np.arange(start + 1)])
            sweeps[rising].append(_increasing(torque[rows], angle[rows]))
            joint[rising] = float(angle[0] - angle[-1])
    if not (sweeps[False] and sweeps[True]):
        raise MeasurementError(
            "torque of the loop",
            f"{np.min(torque) / NEWTON_METRE:.4g} to {np.max(torque) / NEWTON_METRE:.4g} N·m",
            "does not run from one end to the other and back",
            "measure 0 → +T → −T → +T",
        )
    return Branch(tuple(sweeps[False]), joint[False]), Branch(tuple(sweeps[True]), joint[True])


def _turning_points(torque: FloatArray) -> list[tuple[int, int]]:
    """First and last row of the extreme torque of every stay beyond half of the largest or of the smallest torque."""
    high, low = 0.5 * float(np.max(torque)), 0.5 * float(np.min(torque))
    if not low < 0.0 < high:
        return []
    side = np.where(torque > high, 1.0, np.where(torque < low, -1.0, 0.0))
    beyond = np.flatnonzero(side)
    stays = np.split(beyond, np.flatnonzero(np.diff(side[beyond])) + 1)
    found = []
    for rows in stays:
        size = np.abs(torque[rows])
        found.append((int(rows[np.argmax(size)]), int(rows[-1 - np.argmax(size[::-1])])))
    return found


def _increasing(torque: FloatArray, angle: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rows of a sweep by increasing torque, those of one torque averaged: a measured torque is not quite monotone."""
    levels, level = np.unique(torque, return_inverse=True)
    return levels, np.asarray(np.bincount(level, weights=angle) / np.bincount(level))


def _slope(branch: Branch, sign: float, low: float, high: float, reference: float) -> float:
    """Slope of a branch from ``low`` to ``high`` shares of ``reference``, mean of its sweeps [N·mm/rad].

    NaN if all end before, infinite where friction holds the angle.
    """
    compliances = []
    for torque, angle in branch.sweeps:
        reach = max(sign * float(torque[0]), sign * float(torque[-1]))
        if reach >= (high - _SHORT_OF_END) * reference:
            ends = sign * np.array([low * reference, min(high * reference, reach)])
            compliances.append(float(np.diff(np.interp(ends, torque, angle))[0] / np.diff(ends)[0]))
    if not compliances:
        return math.nan
    mean = float(np.mean(compliances))
    return 1.0 / mean if mean else math.inf


def _area(falling: Branch, rising: Branch) -> float:
    """∮ θ dT over the torques that all sweeps reach: it needs no zero and no closed end [N·mm]."""
    low = max(float(T[0]) for T, _ in (*falling.sweeps, *rising.sweeps))
    high = min(float(T[-1]) for T, _ in (*falling.sweeps, *rising.sweeps))
    torque = np.unique(np.concatenate([[low, high], *(T for T, _ in (*falling.sweeps, *rising.sweeps))]))
    torque = torque[(torque >= low) & (torque <= high)]
    return float(np.trapezoid(falling.at(torque) - rising.at(torque), torque))
