"""Contrasts of the branches of a loop: elastic effects follow the torque alone, and cancel in them.

What is left of a loop is noise and what depends on the path, friction and creep, which varies slowly. The noise of a
loop cannot be read from its residual: an effect that brings pins into contact has corners, whose spectrum hides it.
"""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.effects import loop_branches

_LEAST_ROWS = 8  # of a branch at torques that those before it reach, too


def contrasts_of_branches(
    residual: FloatArray, rows: IntArray, torque: FloatArray
) -> tuple[FloatArray, IntArray] | None:
    """Each branch minus the mean of those before it at equal torque, and the row of each value.

    None if no branch repeats torques of another.

    Parameters
    ----------
    residual : measured minus predicted at ``rows``, shape (rows,); the contrasts are scaled to the same noise
    torque : of the whole file, in any unit
    """
    ends = np.flatnonzero(np.diff(2.0 * loop_branches(torque) + np.sign(torque))) + 1
    part = np.searchsorted(ends, rows, side="right")
    contrasts: list[FloatArray] = []
    numbers: list[IntArray] = []
    for sign in (1.0, -1.0):
        before: list[IntArray] = []
        for one in np.unique(part[np.sign(torque[rows]) == sign]):
            here = np.flatnonzero(part == one)
            if before:
                values = _contrast(residual, torque[rows], here, before)
                inside = np.isfinite(values)
                if np.count_nonzero(inside) >= _LEAST_ROWS:
                    contrasts.append(values[inside])
                    numbers.append(rows[here[inside]])
            before.append(here)
    return (np.concatenate(contrasts), np.concatenate(numbers)) if contrasts else None


def _contrast(residual: FloatArray, torque: FloatArray, here: IntArray, before: list[IntArray]) -> FloatArray:
    """Residual of one branch minus the mean of others, interpolated at its torque; NaN where one does not reach it.

    The variance of a mean of two neighbours is taken as if rows were independent.
    """
    others, variance = np.zeros(here.size), np.zeros(here.size)
    for some in before:
        there = some[np.argsort(torque[some], kind="stable")]
        known = torque[there]
        if known.size < 2:
            return np.full(here.size, np.nan)
        above = np.clip(np.searchsorted(known, torque[here]), 1, known.size - 1)
        step = np.maximum(known[above] - known[above - 1], np.finfo(np.float64).tiny)
        share = (torque[here] - known[above - 1]) / step
        share[(share < 0.0) | (share > 1.0)] = np.nan
        others += (1.0 - share) * residual[there[above - 1]] + share * residual[there[above]]
        variance += (1.0 - share) ** 2 + share**2
    count = len(before)
    found: FloatArray = (residual[here] - others / count) / np.sqrt(1.0 + variance / count**2)
    return found
