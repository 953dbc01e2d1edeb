"""Reading errors: isolated rows that no feature of the part explains."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._smooth_forms import CORNER_MULTIPLES, distinct_waves, fitted_amounts, waves
from cycloid_profile.diagnosis.data.noise import local_noise
from cycloid_profile.geometry import Trochoid

_GROSS = 7.0  # standard deviations: noise alone exceeds them in no file
_LEAST_ERRORS = 3  # gross ones: fewer do not show how large errors are
_CHANCE = 0.003  # probability of mistaking a reading error for a feature, for a whole file
_SCATTERED = 1.5  # times the noise: upper limit of the spread of a few rows of pure noise
_DIGITS = 9  # of the largest value, beyond which values differ by rounding
_LEAST_ROWS = 24  # of a file in which a row can be seen to be isolated
_DIGITS_OF_WAVES = 6  # of cosines: rows at equal distances are written to a few digits
_ROUNDS = 8  # at most; most turns need one or two
_CHANCE_OF_WAVE = 0.01  # of a wave in a turn without one


def reading_step(values: FloatArray) -> float:
    """Smallest difference between two values that were read more than once, in their unit; 0 without two of them."""
    largest = float(np.max(np.abs(values), initial=0.0))
    if largest == 0.0:
        return 0.0
    # Values that were computed differ by rounding.
    value, count = np.unique(np.round(values / largest, _DIGITS), return_counts=True)
    between = np.diff(value[count > 1])
    return float(np.min(between)) * largest if between.size else 0.0


def gross_errors(residual: FloatArray, sigma: float, step: float = 0.0) -> BoolArray:
    """Reading errors: one or two rows far from their neighbourhood, whose neighbours are not displaced.

    Where some are gross others are small: of all that are omitted, noise makes up at most the share ``_CHANCE``.
    A coarse instrument reads in steps: one ``step`` away is no error, however seldom.
    """
    from scipy.special import ndtri

    n = residual.size
    if n < _LEAST_ROWS:
        return np.zeros(n, dtype=bool)
    reach = 5
    padded = np.concatenate([residual[reach:0:-1], residual, residual[-2 : -2 - reach : -1]])
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    # Effects vary within the window: subtract the median slope across the row.
    steps = np.arange(1, reach + 1)
    slope = np.median((windows[:, reach + steps] - windows[:, reach - steps]) / (2.0 * steps), axis=1)
    windows = windows - slope[:, np.newaxis] * np.arange(-reach, reach + 1)
    middle = np.median(windows, axis=1)
    spread = 1.4826 * np.median(np.abs(windows - middle[:, np.newaxis]), axis=1)
    # The spread of a few rows scatters: only a clear excess over the noise counts as variation.
    beyond = np.sqrt(np.maximum(spread**2 - (_SCATTERED * sigma) ** 2, 0.0))
    unit = np.hypot(sigma, beyond)
    off = windows[:, [reach - 1, reach, reach + 1]] - middle[:, np.newaxis]
    beyond_step = np.sign(off) * np.maximum(np.abs(off) - step, 0.0) / unit[:, np.newaxis]
    away = beyond_step[:, 1]
    neighbours = beyond_step[:, [0, 2]] * np.sign(off[:, 1:2])
    gross = _isolated(np.abs(away) > _GROSS, neighbours)
    if np.sum(gross) < _LEAST_ERRORS:
        return gross
    return _isolated(np.abs(away) > -ndtri(0.5 * _CHANCE * np.sum(gross) / n), neighbours)


def errors_of_turn(
    residual: FloatArray, angle: FloatArray, trochoid: Trochoid, step: float = 0.0
) -> tuple[BoolArray, FloatArray]:
    """Reading errors of a curve over a turn, and its rows with what is expected in place of the errors.

    ``angle`` of the output [rad], rising. Where a pin comes to bear the curve has a corner, which few rows show: what
    lobes and pins repeat is no reading error.
    """
    row, columns = np.arange(residual.size), _mesh_waves(angle, trochoid)

    def beyond(ripple: FloatArray) -> BoolArray:
        rest = residual - ripple
        return gross_errors(rest, local_noise(rest, row).sigma, step)

    ripple = np.zeros(residual.size)
    errors = beyond(ripple)
    # Errors hide a ripple, and a ripple hides errors.
    for _ in range(_ROUNDS):
        ripple, known = _ripple(residual, columns, ~errors), errors
        errors = beyond(ripple)
        if np.array_equal(errors, known):
            break
    filled = residual.copy()
    filled[errors] = ripple[errors] + np.interp(row[errors], row[~errors], (residual - ripple)[~errors])
    return errors, filled


def _mesh_waves(angle: FloatArray, trochoid: Trochoid) -> tuple[FloatArray, FloatArray]:
    """Slow waves, shape (rows, columns), and those at multiples of lobes, of pins and of both: cosine and sine of each.

    Rows at equal distances show some orders as others: each counts once.
    """
    counts = np.array([trochoid.lobes, trochoid.pins, trochoid.lobes * trochoid.pins])
    multiples = [np.arange(1, min(CORNER_MULTIPLES, angle.size // (2 * count)) + 1) * count for count in counts[:2]]
    slow = np.arange(tuned.LOW_ORDERS + 1)
    orders = np.concatenate([slow, *multiples, counts[2] * np.arange(1, tuned.PRODUCTS + 1)])
    kept = distinct_waves(np.exp(1j * np.outer(angle, orders)), _DIGITS_OF_WAVES)
    known = 2 * int(np.count_nonzero(kept < slow.size)) - 1
    columns = np.hstack([np.ones((angle.size, 1)), waves([*np.outer(orders[kept[1:]], angle)])])
    return columns[:, :known], columns[:, known:]


def _ripple(residual: FloatArray, columns: tuple[FloatArray, FloatArray], used: BoolArray) -> FloatArray:
    """Those waves of the mesh that clearly exceed the rest, at all rows, shape (rows,); fitted to the ``used`` rows."""
    slow, mesh = columns
    both = np.hstack(columns)
    rows, count = int(np.count_nonzero(used)), both.shape[1]
    if rows < 2 * count:
        return np.zeros(residual.size)
    fit = fitted_amounts(both[used], residual[used])
    level = float(np.sum((residual - both @ fit)[used] ** 2)) / (rows - count)
    power = 0.5 * rows * np.sum(fit[slow.shape[1] :].reshape(-1, 2) ** 2, axis=1)
    shown = mesh[:, np.repeat(power > 2.0 * level * math.log(max(power.size, 1) / _CHANCE_OF_WAVE), 2)]
    found: FloatArray = shown @ fitted_amounts(np.hstack([slow, shown])[used], residual[used])[slow.shape[1] :]
    return found


def _isolated(far: BoolArray, neighbours: FloatArray) -> BoolArray:
    """Those of ``far`` rows that are no part of a feature; ``neighbours`` as in ``_belongs_to_feature``."""
    # Three or more rows in a run are a feature.
    together = np.convolve(far.astype(int), np.ones(3), mode="same")
    longer = np.convolve((together >= 3).astype(int), np.ones(3), mode="same") > 0
    alone = far & ~longer
    return alone & ~_belongs_to_feature(alone, neighbours)


def _belongs_to_feature(alone: BoolArray, neighbours: FloatArray) -> BoolArray:
    """Which of the rows ``alone`` belong to a feature wider than the row spacing; ``neighbours`` of shape (rows, 2).

    ``neighbours``: deviations of the previous and the next row, in standard deviations, positive in the
    direction of the flagged row. A reading error is
    independent of its neighbours. A displaced neighbour marks a feature if neither scatter nor a second error explains
    it.
    """
    from scipy.special import ndtr

    errors = int(np.count_nonzero(alone & ~np.roll(alone, 1)))
    off = np.maximum(np.max(neighbours, axis=1), np.sum(neighbours, axis=1) / math.sqrt(2.0))
    by_scatter = 3.0 * ndtr(-off)  # minimum p-value of three tests
    by_another = 2.0 * errors / alone.size
    more = alone & (errors * (by_scatter + by_another) < _CHANCE)
    # Two adjacent rows belong together.
    found: BoolArray = alone & (more | np.roll(more, 1) | np.roll(more, -1))
    return found
