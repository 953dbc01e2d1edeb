"""Drift of a curve from its first row to its last, separated from effects that repeat after a turn or on a branch.

A free drift would hide 61 % of the information on a sine of order one. So the width of its prior is zero unless the
rows show a drift themselves: a turn does not close, a branch of a loop does not return to itself.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.data.noise import Noise, run_starts

# Significance of a drift, in standard errors: one file in 80 without a drift gets the column.
_SIGNIFICANT = 2.5
_SIGNIFICANT_WAVE = 14.0  # of chi²: one in 1,000 for one order
_WIDTH = 2.0  # times the estimate
_ORDERS = 12  # round the turn, as in the detection
_LEAST_SPAN = 0.9  # of a turn
_APART = 0.01  # share of the drift that repeating effects must leave


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
    further = [_wave(angle, k) for k in range(3, _ORDERS + 1)]
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
    slow = np.abs(np.fft.rfft(left - amount * own))[_ORDERS + 1 : 5 * _ORDERS] ** 2 / residual.size
    level = float(np.median(slow)) / math.log(2.0) if slow.size else 1.0
    error = math.sqrt(max(level, 1.0) / energy)
    return _WIDTH * abs(amount) if abs(amount) > _SIGNIFICANT * error else 0.0


def _gain(left: FloatArray, columns: FloatArray) -> float:
    """Reduction of chi² by ``columns``."""
    fit, *_ = np.linalg.lstsq(columns, left, rcond=1e-9)
    return float(left @ (columns @ fit))
