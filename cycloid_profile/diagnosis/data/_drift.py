"""Drift of a measurement from its first row to its last, separated from effects that repeat.

A free drift would hide 61 % of the information on a sine of order one. So the width of its prior is zero unless the
rows show a drift themselves: a turn does not close, a branch of a loop does not return to itself, the origin of a scan
moves between lobes whose forms agree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.polynomial.legendre import legvander

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data.noise import Noise, run_starts

# Significance of a drift, in standard errors: one file in 80 without a drift gets the column.
_SIGNIFICANT = 2.5
_SIGNIFICANT_WAVE = 14.0  # of chi²: one in 1,000 for one order
_WIDTH = 2.0  # times the estimate
_LEAST_SPAN = 0.9  # of a turn
_APART = 0.01  # share of the drift that repeating effects must leave
_DEGREES = 4  # of the path of a drift in time: a drift is smooth
_SHOWN_DEGREES = 2  # of them that must be significant
_CHANCE = 1.0 / 80.0  # of a path where there is none, as for curves


def turn_drift(residual: FloatArray, angle: FloatArray, noise: Noise, orders: Sequence[int] = ()) -> float:
    """Prior width of the drift of a curve over a turn; 0 if the turn closes within the noise.

    Parameters
    ----------
    residual : shape (rows,), rising ``angle`` [rad]; the width has its unit, from the middle to either end
    noise : noise of the rows
    orders : per turn, fitted with 1 to 12, such as the multiples of lobes and pins
    """
    if np.ptp(angle) < _LEAST_SPAN * 2.0 * math.pi:
        return 0.0
    columns = [np.ones((residual.size, 1))]
    # Orders above half the rows alias to lower ones.
    columns += [_wave(angle, k) for k in dict.fromkeys([1, 2, *orders]) if k < residual.size / 4]
    further = [_wave(angle, k) for k in range(3, tuned.LOW_ORDERS + 1)]
    return _width(residual, np.hstack(columns), further, noise, np.arange(residual.size))


def _wave(angle: FloatArray, order: int) -> FloatArray:
    return np.stack([np.cos(order * angle), np.sin(order * angle)], axis=1)


def loop_drift(residual: FloatArray, torque: FloatArray, rows: np.ndarray, noise: Noise) -> float:
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
    return _width(residual, np.stack(columns, axis=1), [], noise, rows)


def origin_drift(removal: FloatArray, normal: ComplexArray, rows: IntArray, forms: FloatArray, noise: Noise) -> float:
    """Prior width of the drift of the origin of a scan, in x and in y; 0 if it stays within the noise.

    Parameters
    ----------
    removal : shape (rows,), in order along the disc; the width has its unit, from the middle to either end
    normal : outward normal of each row in the frame of the machine, x + iy
    rows : number of each row in order of measurement
    forms : what effects look like: forms of all lobes that vary slowly round the disc, shape (rows, n)
    """
    from scipy.special import gammaincc

    path = origin_path(normal, rows, _SHOWN_DEGREES)
    fixed = np.column_stack([forms, normal.real, normal.imag])
    if removal.size <= 2 * (fixed.shape[1] + path.shape[1]):
        return 0.0
    starts = run_starts(np.arange(removal.size))
    A, z, drift = (noise.whiten(values, starts) for values in (fixed, removal, path))
    wanted = np.column_stack([z, drift])
    # Of many rows and few columns, normal equations take a tenth of the time.
    fit, *_ = np.linalg.lstsq(A.T @ A, A.T @ wanted, rcond=1e-9)
    left, seen = np.split(wanted - A @ fit, [1], axis=1)
    left = left[:, 0]
    if float(np.sum(seen**2)) < _APART * float(np.sum(drift**2)):
        return 0.0
    amount, *_ = np.linalg.lstsq(seen, left, rcond=1e-9)
    rest = left - seen @ amount
    # Effects that the forms do not describe, such as chatter, raise the error above that of the noise.
    level = max(float(rest @ rest) / (rest.size - A.shape[1] - seen.shape[1]), 1.0)
    gain = float(left @ left - rest @ rest) / level
    if gammaincc(0.5 * seen.shape[1], 0.5 * gain) > _CHANCE:
        return 0.0
    # By moments: columns that the forms nearly contain have amounts that are all noise.
    return _WIDTH * math.sqrt(max(gain - seen.shape[1], 0.0) * level / float(np.sum(seen**2)))


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


def _width(
    residual: FloatArray, columns: FloatArray, further: Sequence[FloatArray], noise: Noise, rows: np.ndarray
) -> float:
    """Prior width of a ramp given freely fitted ``columns``, shape (rows, n), and those of ``further`` that are
    significant given it."""
    starts = run_starts(rows)
    ramp = np.linspace(-1.0, 1.0, residual.size)[:, np.newaxis]
    A, z, drift, *waves = (noise.whiten(values, starts) for values in (columns, residual, ramp, *further))
    if residual.size <= 2 * A.shape[1]:
        return 0.0
    # A drift has some of every order: the larger gain in chi² comes first.
    waves, drifts = list(waves), False
    while waves:
        basis, _ = np.linalg.qr(np.hstack([A, drift]) if drifts else A)
        left = z - basis @ (basis.T @ z)
        gains = [_gain(left, wave - basis @ (basis.T @ wave)) for wave in waves]
        best = int(np.argmax(gains))
        if not drifts and _gain(left, drift - basis @ (basis.T @ drift)) > max(gains[best], _SIGNIFICANT**2):
            drifts = True
        elif gains[best] > _SIGNIFICANT_WAVE:
            A = np.hstack([A, waves.pop(best)])
        else:
            break
    fit, *_ = np.linalg.lstsq(A, np.column_stack([z, drift]), rcond=1e-9)
    left, own = (np.column_stack([z, drift]) - A @ fit).T
    energy = float(own @ own)
    if energy < _APART * float(np.sum(drift**2)):
        return 0.0
    amount = float(own @ left) / energy
    # Slow effects that the columns do not describe raise the error above that of the noise; lines elsewhere do not.
    slow = np.abs(np.fft.rfft(left - amount * own))[tuned.LOW_ORDERS + 1 : 5 * tuned.LOW_ORDERS] ** 2 / residual.size
    level = float(np.median(slow)) / math.log(2.0) if slow.size else 1.0
    error = math.sqrt(max(level, 1.0) / energy)
    return _WIDTH * abs(amount) if abs(amount) > _SIGNIFICANT * error else 0.0


def _gain(left: FloatArray, columns: FloatArray) -> float:
    """Reduction of chi² by ``columns``."""
    fit, *_ = np.linalg.lstsq(columns, left, rcond=1e-9)
    return float(left @ (columns @ fit))
