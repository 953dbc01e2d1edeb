"""How fast a polar path may be run: constant speed of the contact, slower where an axis reaches its limit.

With b = (way's speed)² both speeds and accelerations of the axes are linear in b at the steps, so that the
fastest run is a linear program (Verscheure et al., IEEE Trans. Automatic Control 54 (2009) 2318, Eqs. 13–17):
X″ b + X′ b′/2 is the acceleration of X at a place where X′ and X″ are derivatives by the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.export.polar import PolarPath


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Largest speeds and accelerations: of C [rad/s, rad/s²], of X [mm/s, mm/s²]."""

    c_speed: float
    c_acceleration: float
    x_speed: float
    x_acceleration: float


@dataclass(frozen=True, slots=True)
class FeedProfile:
    """``speed`` of the contact along the flank at every step, shape (n + 1,) [mm/s]; ``time`` of every step [s]."""

    speed: FloatArray
    time: FloatArray


def feed_profile(path: PolarPath, speed: float, limits: AxisLimits, repeats: int = 1) -> FeedProfile:
    """The fastest run at no more than ``speed`` [mm/s] along the flank, without end: it begins as it ends.

    ``repeats`` equal parts that the path consists of, such as lobes that are alike: one is solved.
    """
    steps = (path.c.size - 1) // repeats
    squares = _squares(path, steps, speed, limits)
    at = np.sqrt(np.append(np.tile(squares, repeats), squares[0]))
    return FeedProfile(speed=at, time=2.0 * np.diff(path.way) / (at[:-1] + at[1:]))


def _squares(path: PolarPath, steps: int, speed: float, limits: AxisLimits) -> FloatArray:
    """Square of the speed at the first ``steps`` places, which repeat."""
    axes = (
        (path.c_rate[:steps], path.c_bend[:steps], limits.c_speed, limits.c_acceleration),
        (path.x_rate[:steps], path.x_bend[:steps], limits.x_speed, limits.x_acceleration),
    )
    most = np.full(steps, speed**2)
    for rate, _, fastest, _ in axes:
        with np.errstate(divide="ignore"):
            bound = (fastest / np.abs(rate)) ** 2
        most = np.minimum(most, np.minimum(bound[:, 0], np.roll(bound[:, 1], 1)))
    half = 0.5 / np.diff(path.way[: steps + 1])
    # Coefficients of b at the start and at the end of each step, for the acceleration at either of them.
    rows = []
    for rate, bend, _, largest in axes:
        for end in (0, 1):
            start_b, end_b = -rate[:, end] * half, rate[:, end] * half
            (start_b, end_b)[end][:] += bend[:, end]
            rows.append((start_b / largest, end_b / largest))
    return _largest(most, rows)


def _largest(most: FloatArray, rows: list[tuple[FloatArray, FloatArray]]) -> FloatArray:
    """The largest b ≤ ``most`` whose accelerations, as shares of what is allowed, stay within ±1."""
    following = np.roll(most, -1)
    if all(np.all(np.abs(p * most + q * following) <= 1.0) for p, q in rows):
        return most
    from scipy.optimize import linprog
    from scipy.sparse import coo_array, vstack

    n = most.size
    i = np.arange(n)
    blocks = [
        coo_array(
            (np.concatenate([p * most, q * following]), (np.tile(i, 2), np.concatenate([i, (i + 1) % n]))), (n, n)
        )
        for p, q in rows
    ]
    matrix = vstack(blocks)
    # In shares of the bound, which keeps the numbers near 1 whatever the speed.
    found = linprog(
        -np.ones(n), A_ub=vstack([matrix, -matrix]).tocsr(), b_ub=np.ones(2 * matrix.shape[0]), bounds=(0.0, 1.0)
    )
    if not found.success or not float(np.min(found.x)) > 0.0:
        raise ArithmeticError(f"the feed profile was not found: {found.message}")
    squares: FloatArray = most * found.x
    return squares


def axis_motion(path: PolarPath, feed: FeedProfile) -> tuple[FloatArray, FloatArray]:
    """Mean speeds of C [rad/s] and X [mm/s] during every step, shape (n,) both."""
    return np.diff(path.c) / feed.time, np.diff(path.x) / feed.time


def seconds(feed: FeedProfile) -> float:
    """Duration of one turn [s]."""
    return math.fsum(feed.time.tolist())
