"""Noise of measured rows, white or correlated, estimated from the data; tail probabilities of noise.

Effects appear as spectral lines or at low frequencies. The median of the spectrum in bands above them contains noise
only; the slope of the bands gives the correlation of neighbouring rows.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeVar, cast

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray

Values = TypeVar("Values", FloatArray, ComplexArray)

# Variance of the estimated variance, relative, times the number of rows.
SCATTER_OF_ESTIMATE = 6.0
# Larger differences, in standard deviations, are steps, pits or slips.
_CLIPPED = 4.5
_LEAST_ROWS = 12  # third differences of fewer rows give no spread
_RHO = np.linspace(-0.3, 0.95, 251)  # correlations of neighbours tried, 0.005 apart; at 1 rows tell nothing
# Least correlation in standard errors; smaller values count as zero.
_BELIEVED = 3.0
_LOW_END = 0.15  # share of the spectrum that effects occupy
_BAND = 25  # ordinates: the median of a band scatters by 0.3 of itself
_LINE = 6.0  # ordinates this many times above the mean are spectral lines
_GROSS = 7.0  # standard deviations: noise alone exceeds them in no file
_CHANCE = 0.003  # probability of mistaking a reading error for a feature, for a whole file
_SCATTERED = 1.5  # times the noise: upper limit of the spread of a few rows of pure noise


@dataclass(frozen=True, slots=True)
class Noise:
    """First-order autoregressive noise: standard deviation ``sigma`` in the unit of the column, correlation ``rho``."""

    sigma: float
    rho: float = 0.0

    def whiten(self, values: Values, starts: BoolArray) -> Values:
        """Rows in units of independent noise, in their shape; ``starts`` marks rows without a predecessor."""
        if self.rho == 0.0:
            return values / self.sigma
        before = np.roll(values, 1, axis=0)
        fresh = (values - self.rho * before) / (self.sigma * np.sqrt(1.0 - self.rho**2))
        first = starts if values.ndim == 1 else starts[:, np.newaxis]
        return cast("Values", np.where(first, values / self.sigma, fresh))


def spectral_noise(residual: FloatArray, stated: float | None = None) -> Noise:
    """Noise of evenly spaced rows in order; ``stated`` fixes sigma."""
    n = residual.size
    if n < 8 * _BAND:
        return local_noise(residual, np.arange(n), stated)
    taper = np.hanning(n + 2)[1:-1]
    power = np.abs(np.fft.rfft((residual - np.mean(residual)) * taper)) ** 2 / np.sum(taper**2)
    first = int(_LOW_END * power.size)
    bands = (power.size - 1 - first) // _BAND
    kept = power[first : first + bands * _BAND].reshape(bands, _BAND)
    omega = np.pi * np.arange(first, first + bands * _BAND).reshape(bands, _BAND).mean(axis=1) / (power.size - 1)
    # Ordinates of a periodogram are exponential: their median is ln 2 times the mean.
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
    # Lines are omitted. Truncation at t means removes the share e^-t (1 + t) from the mean of an exponential.
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
    # The squared coefficients 1, −3, 3, −1 sum to 20.
    sigma = stated if stated is not None else float(np.sqrt(np.mean(kept**2) / 20.0))
    return Noise(max(sigma, 1e-12))


def gross_errors(residual: FloatArray, sigma: float) -> BoolArray:
    """Reading errors: one or two rows far from their neighbourhood, whose neighbours are not displaced."""
    n = residual.size
    if n < 2 * _LEAST_ROWS:
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
    far: BoolArray = np.abs(residual - middle) > _GROSS * unit
    # Three or more rows in a run are a feature.
    together = np.convolve(far.astype(int), np.ones(3), mode="same")
    longer = np.convolve((together >= 3).astype(int), np.ones(3), mode="same") > 0
    alone = far & ~longer
    neighbours = (windows[:, [reach - 1, reach + 1]] - middle[:, np.newaxis]) / unit[:, np.newaxis]
    return alone & ~_belongs_to_feature(alone, neighbours * np.sign(residual - middle)[:, np.newaxis])


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


def upper_tail(score: float) -> float:
    """Upper tail probability of the standard normal distribution."""
    return 0.5 * math.erfc(score / math.sqrt(2.0))


def sidak(p: float, looks: int) -> float:
    """Šidák correction: probability that the smallest of ``looks`` p-values is ``p`` or less."""
    return float(-math.expm1(looks * math.log1p(-min(p, 1.0 - 1e-16))))
