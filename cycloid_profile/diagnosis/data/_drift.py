"""Drift of a measurement from its first row to its last, separated from effects that repeat.

A free drift would hide 61 % of the information on a sine of order one. So the width of its prior is zero unless the
rows show a drift, or those of another turn of the same kind: a turn does not close, a branch of a loop does not return
to itself, the origin of a scan moves between lobes whose forms agree.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial.legendre import legvander

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._smooth_forms import fitted_amounts
from cycloid_profile.diagnosis.data.noise import Noise, run_starts

_CHANCE = 1.0 / 80.0  # of a drift in a file without one
_SIGNIFICANT_LINE = 6.25  # of chi²: this chance for a line
_SIGNIFICANT_WAVE = 14.0  # of chi²: one in 1,000 for one order
DRIFT_WIDTH = 2.0  # times the estimate
_LEAST_SPAN = 0.9  # of a turn
# Share of the square of a drift that effects must leave: it is 0.02 where a loop passes each branch once, 0.05 in a
# turn with all its low orders, 0.7 where a loop passes a quarter again.
_APART = 0.03
_DEGREES = 4  # of the path of a drift in time: a drift is smooth
_SHOWN_DEGREES = 2  # of them that must be significant


def turn_drift(residual: FloatArray, angle: FloatArray, noise: Noise, orders: Sequence[int] = ()) -> float:
    """Prior width of the drift of a curve over a turn; 0 if the turn closes within the noise.

    Parameters
    ----------
    residual : shape (rows,), rising ``angle`` [rad]; the width has its unit, from the middle to either end
    noise : noise of the rows
    orders : per turn, fitted with 1 to 12, such as the multiples of lobes and pins
    """
    if not covers_a_turn(angle):
        return 0.0
    columns = [np.ones((residual.size, 1))]
    # Orders above half the rows alias to lower ones.
    columns += [_wave(angle, k) for k in dict.fromkeys([1, 2, *orders]) if k < residual.size / 4]
    further = [_wave(angle, k) for k in range(3, tuned.LOW_ORDERS + 1)]
    line = np.linspace(-1.0, 1.0, residual.size)[:, np.newaxis]
    starts = run_starts(np.arange(residual.size))
    columns += _significant_waves(residual, np.hstack(columns), further, line, noise, starts)
    return _path_width(residual, np.hstack(columns), line, noise, starts, _slow_variance)


def covers_a_turn(angle: FloatArray) -> bool:
    """Whether angles [rad] span enough of a turn to show whether it closes."""
    return float(np.ptp(angle)) >= _LEAST_SPAN * 2.0 * math.pi


def _wave(angle: FloatArray, order: int) -> FloatArray:
    return np.stack([np.cos(order * angle), np.sin(order * angle)], axis=1)


def loop_drift(residual: FloatArray, torque: FloatArray, rows: IntArray, noise: Noise) -> float:
    """Prior width of the drift of a loop; 0 if its branches repeat within the noise.

    ``torque`` of the ``rows`` in use, in any unit. A parabola in the torque stands for the effects on each branch.
    """
    x = torque / float(np.max(np.abs(torque)))
    rising = np.gradient(x, rows) > 0.0
    columns = []
    for up in (True, False):
        for positive in (True, False):
            branch = (rising == up) & ((x > 0.0) == positive)
            columns += [branch * x**k for k in range(3)]
    path = smooth_path(rows, _SHOWN_DEGREES)
    return _path_width(residual, np.stack(columns, axis=1), path, noise, run_starts(rows), _slow_variance)


def origin_drift(removal: FloatArray, normal: ComplexArray, rows: IntArray, forms: FloatArray, noise: Noise) -> float:
    """Prior width of the drift of the origin of a scan, in x and in y; 0 if it stays within the noise.

    Parameters
    ----------
    removal : shape (rows,), in order along the disc; the width has its unit, from the middle to either end
    normal : outward normal of each row in the frame of the machine, x + iy
    rows : number of each row in order of measurement
    forms : what effects look like: forms of all lobes that vary slowly round the disc, shape (rows, n)
    """
    path = origin_path(normal, rows, _SHOWN_DEGREES)
    fixed = np.column_stack([forms, normal.real, normal.imag])
    return _path_width(removal, fixed, path, noise, run_starts(np.arange(removal.size)), _variance)


def _path_width(
    residual: FloatArray,
    fixed: FloatArray,
    path: FloatArray,
    noise: Noise,
    starts: BoolArray,
    variance_of: Callable[[FloatArray], float],
) -> float:
    """Prior width of a drift along the columns of ``path``, given freely fitted ``fixed``; 0 if chance explains it.

    ``variance_of`` what is left, over that of the noise.
    """
    from scipy.special import gammaincc

    freedom = residual.size - fixed.shape[1] - path.shape[1]
    if freedom <= fixed.shape[1] + path.shape[1]:
        return 0.0
    if float(np.sum(_left(path, fixed) ** 2)) < _APART * float(np.sum(path**2)):
        return 0.0
    whitening = noise.whitening(starts)
    A, z, drift = (whitening @ values for values in (fixed, residual, path))
    left, seen = np.split(_left(np.column_stack([z, drift]), A), [1], axis=1)
    left = left[:, 0]
    amount, *_ = np.linalg.lstsq(seen, left, rcond=1e-9)
    rest = left - seen @ amount
    # Effects that the fixed columns do not describe raise the error above that of the noise.
    level = max(variance_of(rest) * rest.size / freedom, 1.0)
    gain = float(left @ left - rest @ rest) / level
    if gammaincc(0.5 * seen.shape[1], 0.5 * gain) > _CHANCE:
        return 0.0
    # By moments: columns that the fixed ones nearly contain have amounts that are all noise.
    return DRIFT_WIDTH * math.sqrt(max(gain - seen.shape[1], 0.0) * level / float(np.sum(seen**2)))


def _left(values: FloatArray, fixed: FloatArray) -> FloatArray:
    """What is left of columns after a fit of ``fixed``."""
    return np.asarray(values - fixed @ fitted_amounts(fixed, values))


def _variance(rest: FloatArray) -> float:
    return float(rest @ rest) / rest.size


def _slow_variance(rest: FloatArray) -> float:
    """Variance by slow waves but the slowest: lines elsewhere do not count."""
    slow = np.abs(np.fft.rfft(rest))[tuned.LOW_ORDERS + 1 : 5 * tuned.LOW_ORDERS] ** 2 / rest.size
    return float(np.median(slow)) / math.log(2.0) if slow.size else 1.0


def origin_path(normal: ComplexArray, rows: IntArray, degrees: int = _DEGREES) -> FloatArray:
    """Columns of a moving origin, seen along the ``normal`` of each row; shape (rows, 2·degrees).

    ``rows``: number of each row in order of measurement.
    """
    shapes = smooth_path(rows, degrees)
    return np.hstack([shapes * normal.real[:, np.newaxis], shapes * normal.imag[:, np.newaxis]])


def smooth_path(rows: IntArray, degrees: int = _DEGREES) -> FloatArray:
    """Columns of a drift, shape (rows, degrees): Legendre polynomials in time, each half as large as the one before."""
    time = 2.0 * (rows - np.min(rows)) / max(int(np.ptp(rows)), 1) - 1.0
    return np.asarray(legvander(time, degrees)[:, 1:] * 0.5 ** np.arange(degrees))


def _significant_waves(
    residual: FloatArray,
    fixed: FloatArray,
    waves: Sequence[FloatArray],
    line: FloatArray,
    noise: Noise,
    starts: BoolArray,
) -> list[FloatArray]:
    """Those of ``waves`` that are significant, given freely fitted ``fixed`` and the ``line`` if it is significant."""
    whitening = noise.whitening(starts)
    fitted, z, *columns = (whitening @ values for values in (fixed, residual, *waves, line))
    least = [_SIGNIFICANT_WAVE] * len(waves) + [_SIGNIFICANT_LINE]
    chosen: list[int] = []
    while True:
        basis, _ = np.linalg.qr(fitted)
        left = z - basis @ (basis.T @ z)
        gains = [_gain(left, one - basis @ (basis.T @ one)) for one in columns]
        shown = [i for i, gain in enumerate(gains) if gain > least[i] and i not in chosen]
        if not shown:
            return [waves[i] for i in chosen if i < len(waves)]
        # A drift has some of every order: the larger gain in chi² comes first.
        chosen.append(max(shown, key=lambda i: gains[i]))
        fitted = np.hstack([fitted, columns[chosen[-1]]])


def _gain(left: FloatArray, columns: FloatArray) -> float:
    """Reduction of chi² by ``columns``."""
    fit, *_ = np.linalg.lstsq(columns, left, rcond=1e-9)
    return float(left @ (columns @ fit))
