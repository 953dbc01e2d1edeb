"""Noise of a measured row: white or correlated from row to row, told from the data themselves.

Effects show as lines in the spectrum or at its low end. The median of the spectrum in bands above that sees only
noise, and its slope tells how much of the noise neighbouring rows share.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np
from scipy.special import ndtr

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray

Values = TypeVar("Values", FloatArray, ComplexArray)

# The square of an estimated standard deviation scatters by this over the number of rows.
SCATTER_OF_ESTIMATE = 6.0
# Beyond so many standard deviations a difference is no noise: a step, a pit, a slip.
_CLIPPED = 4.5
_LEAST_ROWS = 12
_RHO = np.linspace(-0.3, 0.95, 251)
# Correlation is believed above so many standard errors.
_BELIEVED = 3.0
_LOW_END = 0.15  # share of the spectrum where effects live
_BAND = 25
_LINE = 6.0  # an ordinate so far above the mean is a line
_GROSS = 7.0
_CHANCE = 0.003  # that a reading error of a file is taken for something that is there
_SCATTERED = 1.5  # times the noise: what the spread of a few rows of noise alone may be


@dataclass(frozen=True, slots=True)
class Noise:
    """First-order autoregressive noise: standard deviation ``sigma`` in the unit of the column, correlation ``rho``."""

    sigma: float
    rho: float = 0.0

    def whiten(self, values: Values, starts: BoolArray) -> Values:
        """Rows in units of independent noise; ``starts`` marks rows without a neighbour before. Shape kept."""
        if self.rho == 0.0:
            return values / self.sigma
        before = np.roll(values, 1, axis=0)
        fresh = (values - self.rho * before) / (self.sigma * np.sqrt(1.0 - self.rho**2))
        first = starts if values.ndim == 1 else starts[:, np.newaxis]
        return cast("Values", np.where(first, values / self.sigma, fresh))


def spectral_noise(residual: FloatArray, stated: float | None = None) -> Noise:
    """Noise of many evenly spaced rows in order; ``stated`` fixes sigma."""
    n = residual.size
    if n < 8 * _BAND:
        return local_noise(residual, np.arange(n), stated)
    taper = np.hanning(n + 2)[1:-1]
    power = np.abs(np.fft.rfft((residual - np.mean(residual)) * taper)) ** 2 / np.sum(taper**2)
    first = int(_LOW_END * power.size)
    bands = (power.size - 1 - first) // _BAND
    kept = power[first : first + bands * _BAND].reshape(bands, _BAND)
    omega = np.pi * np.arange(first, first + bands * _BAND).reshape(bands, _BAND).mean(axis=1) / (power.size - 1)
    # Ordinates of a periodogram are exponential: their median is ln 2 of the mean.
    level = np.log(np.median(kept, axis=1) / np.log(2.0))
    rho_ = _RHO[:, np.newaxis]
    shape = np.log((1.0 - rho_**2) / (1.0 - 2.0 * rho_ * np.cos(omega) + rho_**2))
    left = level - shape
    spread = np.mean(np.abs(left - np.median(left, axis=1, keepdims=True)), axis=1)
    best = int(np.argmin(spread))
    rho = float(_RHO[best])
    if rho < _BELIEVED * 1.5 / np.sqrt(n):
        rho, best = 0.0, int(np.argmin(np.abs(_RHO)))
    if stated is not None:
        return Noise(stated, rho)
    omega = np.pi * np.arange(first, power.size - 1) / (power.size - 1)
    white = power[first:-1] * (1.0 - 2.0 * rho * np.cos(omega) + rho**2) / (1.0 - rho**2)
    # Lines are left out; an exponential loses a share e^-t (1 + t) of its mean beyond t times it.
    limit = _LINE * float(np.median(white)) / np.log(2.0)
    lost = np.exp(-_LINE) * _LINE / (1.0 - np.exp(-_LINE))
    sigma = float(np.sqrt(np.mean(white[white <= limit]) / (1.0 - lost)))
    return Noise(max(sigma, 1e-12), rho)


def local_noise(residual: FloatArray, index: IntArray, stated: float | None = None) -> Noise:
    """White noise from third differences of rows in order; ``index`` differs by 1 between neighbours."""
    d = residual[3:] - 3.0 * residual[2:-1] + 3.0 * residual[1:-2] - residual[:-3]
    d = d[(index[3:] - index[:-3]) == 3]
    if d.size < _LEAST_ROWS:
        spread = float(np.std(residual)) if residual.size > 1 else 1.0
        return Noise(stated if stated is not None else max(spread, 1e-12))
    spread = 1.4826 * float(np.median(np.abs(d)))
    kept = d[np.abs(d) <= _CLIPPED * spread]
    # The coefficients 1, −3, 3, −1 have the square sum 20.
    sigma = stated if stated is not None else float(np.sqrt(np.mean(kept**2) / 20.0))
    return Noise(max(sigma, 1e-12))


def gross_errors(residual: FloatArray, sigma: float) -> BoolArray:
    """Single rows, or two together, that stand out of both their neighbourhoods by far more than the noise, and whose
    neighbours know nothing of it.
    """
    n = residual.size
    if n < 2 * _LEAST_ROWS:
        return np.zeros(n, dtype=bool)
    reach = 5
    padded = np.concatenate([residual[reach:0:-1], residual, residual[-2 : -2 - reach : -1]])
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1)
    # Effects rise and fall within the reach: their slope is taken off, by the middle one of those across the row.
    steps = np.arange(1, reach + 1)
    slope = np.median((windows[:, reach + steps] - windows[:, reach - steps]) / (2.0 * steps), axis=1)
    windows = windows - slope[:, np.newaxis] * np.arange(-reach, reach + 1)
    middle = np.median(windows, axis=1)
    spread = 1.4826 * np.median(np.abs(windows - middle[:, np.newaxis]), axis=1)
    # The spread of a few rows scatters: only what is clearly more than the noise is something that varies there.
    beyond = np.sqrt(np.maximum(spread**2 - (_SCATTERED * sigma) ** 2, 0.0))
    unit = np.hypot(sigma, beyond)
    far: BoolArray = np.abs(residual - middle) > _GROSS * unit
    # Three rows and more in a run are something that is there.
    together = np.convolve(far.astype(int), np.ones(3), mode="same")
    longer = np.convolve((together >= 3).astype(int), np.ones(3), mode="same") > 0
    alone = far & ~longer
    beside = (windows[:, [reach - 1, reach + 1]] - middle[:, np.newaxis]) / unit[:, np.newaxis]
    return alone & ~_part_of_more(alone, beside * np.sign(residual - middle)[:, np.newaxis])


def _part_of_more(alone: BoolArray, beside: FloatArray) -> BoolArray:
    """Which of the rows that stand out ``alone`` have rows ``beside`` them, before and after, shape (rows, 2), in
    standard deviations to the same side, that are off as well.

    A reading error says nothing of the next reading; what is wider than the rows are apart does. That neither is the
    scatter of the rows beside nor another reading error must be more than chance for all that stand out together.
    """
    errors = int(np.count_nonzero(alone & ~np.roll(alone, 1)))
    off = np.maximum(np.max(beside, axis=1), np.sum(beside, axis=1) / math.sqrt(2.0))
    by_scatter = 3.0 * ndtr(-off)  # the best of three looks
    by_another = 2.0 * errors / alone.size
    more = alone & (errors * (by_scatter + by_another) < _CHANCE)
    # Of two rows together both are.
    found: BoolArray = alone & (more | np.roll(more, 1) | np.roll(more, -1))
    return found
