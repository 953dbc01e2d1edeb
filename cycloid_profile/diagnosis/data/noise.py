"""Noise of measured rows: autoregressive up to order two, estimated from the data; tail probabilities of noise.

Effects appear as spectral lines, at low frequencies, or in few places. The rest of the spectrum contains noise only:
its level and shape give standard deviation and correlation (docs/diagnosis.md, "Noise").
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray, IntArray

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Values = TypeVar("Values", FloatArray, ComplexArray)

# Variance of the estimated variance, relative, times the number of rows; largest of the table in docs/diagnosis.md.
SCATTER_OF_ESTIMATE = 8.0
# Larger differences, in standard deviations, are steps, pits or slips.
_CLIPPED = 4.5
_LEAST_ROWS = 12  # third differences of fewer rows give no spread
_LOW_END = 0.15  # share of the spectrum that effects occupy
_LONG = 200  # rows of a run from which a tapered spectrum loses too little to matter
_SEGMENT = 4096  # rows of one tapered spectrum; half of them overlap
_LEAST_RUN = 8  # rows
_TREND = 3  # degree of the polynomial removed from a short run
# Prior probability of an effect in an ordinate of the spectrum, in its low end, and the range of its power, e^14 = 10⁶.
_SHARE, _SHARE_OF_LOW_END, _RANGE = 0.01, 0.5, 14.0
_SHARES = np.array([0.01, 0.02, 0.04, 0.08, 0.16, 0.3, 0.5, 0.8])  # chosen by the data
_BANDS = 96  # of the spectrum, in which ordinates are averaged
_COSINE = np.cos(np.pi * (np.arange(_BANDS) + 0.5) / _BANDS)
_BROAD_BANDS = 16
# Rows are filtered if a band lies this far below another; the floor that replaces it. Of AR(1), 1/300 takes ρ = 0.99.
_STOPPED, _FLOOR = 1.0 / 300.0, 1.0 / 30.0
_FIRST_ROWS = 0.5
_REPEATS = 2  # corrections for the polynomial removed from short runs
_LEAST_VARIANCE = 1e-24
_ROUNDS = 10  # of expectation maximisation
# Correlation of neighbours and partial correlation of the next but one that are tried; at 1 a row adds nothing.
_RHO, _PARTIAL = np.linspace(-0.5, 0.98, 75), np.linspace(-0.92, 0.92, 93)
_REFINED = 5  # times finer about the best


@dataclass(frozen=True, slots=True)
class Noise:
    """Autoregressive noise of order two: x_k = φ₁ x_{k−1} + φ₂ x_{k−2} + e_k.

    ``sigma``: standard deviation in the unit of the column. ``rho``: correlation of neighbours. ``partial``: partial
    correlation of rows two apart, φ₂; then φ₁ = ρ(1 − φ₂). Box, Jenkins, Reinsel (2008), Eq. (3.2.27). Stationary while
    both lie within ±1.
    """

    sigma: float
    rho: float = 0.0
    partial: float = 0.0

    @property
    def is_white(self) -> bool:
        """Whether rows are independent."""
        return self.rho == 0.0 and self.partial == 0.0

    @property
    def innovation(self) -> float:
        """Standard deviation of a row given all rows before it, in the unit of the column."""
        return self.sigma * math.sqrt((1.0 - self.rho**2) * (1.0 - self.partial**2))

    def correlation(self, count: int) -> FloatArray:
        """Correlation of rows 0 to ``count`` − 1 apart, shape (count,)."""
        found = np.ones(max(count, 2))
        found[1] = self.rho
        first = self.rho * (1.0 - self.partial)
        for k in range(2, found.size):
            found[k] = first * found[k - 1] + self.partial * found[k - 2]
        return found[:count]

    def mean_sigma(self, rows: int) -> float:
        """Standard deviation of the mean of ``rows`` neighbours, in the unit of the column."""
        return self.averaged(rows).sigma

    def averaged(self, rows: int) -> Noise:
        """Noise of means over ``rows`` neighbours each, one after the other, approximated by order two."""
        r = self.correlation(3 * rows)
        lag = np.arange(-rows + 1, rows)
        share = (rows - np.abs(lag)) / rows**2
        first, second, third = (float(share @ r[np.abs(lag + k * rows)]) for k in range(3))
        return _from_correlations(self.sigma * math.sqrt(max(first, 0.0)), second / first, third / first)

    def thinned(self, step: int) -> Noise:
        """Noise of every ``step``-th row, approximated by order two."""
        r = self.correlation(2 * step + 1)
        return _from_correlations(self.sigma, float(r[step]), float(r[2 * step]))

    def spectrum(self, omega: FloatArray) -> FloatArray:
        """Variance per row at angular frequencies ``omega`` [rad per row]; σ² everywhere for white noise."""
        return self.innovation**2 / _denominator(self.rho, self.partial, np.cos(omega))

    def whitening(self, starts: BoolArray) -> csr_array:
        """The matrix that turns rows into units of independent noise, shape (rows, rows).

        It combines a row and at most two before it; ``starts`` marks rows without a predecessor.
        """
        # Imported here: scipy.sparse takes longer to load than this module.
        from scipy.sparse import csr_array

        row = np.arange(starts.size)
        first = starts | (row == 0)
        second = np.append(True, first[:-1]) & ~first
        third = ~(first | second)
        of_second = 1.0 / (self.sigma * math.sqrt(1.0 - self.rho**2))
        own = np.select([first, second], [1.0 / self.sigma, of_second], 1.0 / self.innovation)
        before = np.where(second, -self.rho * of_second, -self.rho * (1.0 - self.partial) / self.innovation)
        two_before = np.full(int(np.sum(third)), -self.partial / self.innovation)
        values = np.concatenate([own, before[~first], two_before])
        rows = np.concatenate([row, row[~first], row[third]])
        columns = np.concatenate([row, row[~first] - 1, row[third] - 2])
        found = csr_array((values, (rows, columns)), shape=(row.size, row.size))
        found.eliminate_zeros()
        return found


def _from_correlations(sigma: float, first: float, second: float) -> Noise:
    """Noise with given correlations of rows one and two apart."""
    partial = (second - first**2) / (1.0 - first**2) if abs(first) < 1.0 else 0.0
    # A correlation of rounding size keeps the fast path of white noise.
    return Noise(sigma, first, partial) if max(abs(first), abs(partial)) > 1e-9 else Noise(sigma)


def _denominator(rho: FloatArray | float, partial: FloatArray | float, cosine: FloatArray) -> FloatArray:
    """|1 − φ₁ e^{−iω} − φ₂ e^{−2iω}|² at cos ω, Box, Jenkins, Reinsel (2008), Eq. (3.2.29)."""
    first = rho * (1.0 - partial)
    value: FloatArray = (
        1.0 + first**2 + partial**2 - 2.0 * first * (1.0 - partial) * cosine - 2.0 * partial * (2.0 * cosine**2 - 1.0)
    )
    return np.maximum(value, 1e-12)


def estimate_noise(
    residual: FloatArray, index: IntArray, stated: float | None = None, low_end: float = _LOW_END
) -> Noise:
    """Noise of rows in order, whatever effects the residual contains.

    Whittle likelihood of order 0, 1 and 2 on the spectrum of each run; the order has the least BIC. Each ordinate is
    noise only, or noise and an effect of any size. The shares of effects in the lowest ``low_end`` of the spectrum and
    above it follow the data.

    Parameters
    ----------
    residual : shape (rows,), in the unit of the column
    index : number of each row; equal steps connect neighbours, a longer step begins a new run
    stated : standard deviation that replaces the estimated one
    low_end : share of the spectrum that effects occupy; 0 if the rows contain noise only
    """
    runs = list(_runs(residual, index))
    ordinates = [_ordinates(run, low_end) for run in runs]
    if sum(one.power.size for one in ordinates) < _LEAST_ROWS:
        return _noise_of_few(residual, stated)
    spectrum = _Ordinates(
        *(np.concatenate([getattr(one, part.name) for one in ordinates]) for part in fields(_Ordinates))
    )
    spectrum = spectrum.without_stop_band()
    found = spectrum.best_noise()
    for _ in range(0 if found.is_white or all(run.size >= _LONG for run in runs) else _REPEATS):
        bias = np.concatenate([_bias_of_run(run.size, found) for run in runs])
        found = replace(spectrum, power=spectrum.power / bias).best_noise()
    return Noise(max(found.sigma if stated is None else stated, 1e-12), found.rho, found.partial)


def _runs(residual: FloatArray, index: IntArray) -> Iterator[FloatArray]:
    """Runs of neighbouring rows, cut into segments of which each overlaps half of the one before."""
    breaks = np.flatnonzero(run_starts(index))[1:]
    for run in np.split(residual, breaks):
        if run.size < _LEAST_RUN:
            continue
        count = max(math.ceil(2.0 * run.size / _SEGMENT) - 1, 1)
        length = min(_SEGMENT, run.size)
        for first in np.linspace(0, run.size - length, count).astype(int):
            yield run[first : first + length]


def run_starts(index: IntArray) -> BoolArray:
    """Mask of rows whose step from the row before is longer than usual, the first row included, shape (rows,)."""
    step = np.abs(np.diff(index))
    usual = float(np.median(step)) if step.size else 1.0
    return np.concatenate([[True], step > 1.5 * usual])


def _ordinates(run: FloatArray, low_end: float) -> _Ordinates:
    """Ordinates of one run; a tapered periodogram of a long run, the cosine transform of a short one.

    A taper keeps lines narrow and costs half the rows of a run, which overlapping segments give back.
    """
    from scipy.fft import dct

    n, run = run.size, _without_trend(run)
    long = n >= _LONG
    if long:
        taper = np.hanning(n + 2)[1:-1]
        power = np.abs(np.fft.rfft(run * taper))[:-1] ** 2 / np.sum(taper**2)
    else:
        power = dct(run, norm="ortho") ** 2
    omega = np.pi * np.arange(power.size) / power.size
    low = omega < low_end * np.pi
    effect = np.where(low, _SHARE_OF_LOW_END, _SHARE)
    # Neighbouring ordinates of a Hann taper share half their information.
    freedom, weight = (2.0, 0.5) if long else (1.0, 1.0)
    kept = slice(_TREND + 1, None)
    size = power[kept].size
    return _Ordinates(omega[kept], power[kept], np.full(size, freedom), np.full(size, weight), low[kept], effect[kept])


def _without_trend(run: FloatArray) -> FloatArray:
    t = np.linspace(-1.0, 1.0, run.size)
    found: FloatArray = run - np.polynomial.legendre.legval(t, np.polynomial.legendre.legfit(t, run, _TREND))
    return found


def scatter_about_cubics(residual: FloatArray, index: IntArray) -> tuple[float, int]:
    """Variance of rows in order about a cubic in each run, and its degrees of freedom.

    It is that of noise, and of effects with corners or waves.
    """
    left = [_without_trend(run) for run in _runs(residual, index)]
    freedom = sum(one.size - _TREND - 1 for one in left)
    return sum(float(one @ one) for one in left) / max(freedom, 1), freedom


def _bias_of_run(n: int, noise: Noise) -> FloatArray:
    """Expected ordinates of a run of ``n`` rows relative to the spectrum of its noise, shape (ordinates,).

    Correlated rows lose power at low frequencies to the removed polynomial.
    """
    from scipy.fft import dct
    from scipy.linalg import toeplitz

    kept = slice(_TREND + 1, None)
    if n >= _LONG:
        return np.ones(n // 2 - _TREND - 1)
    basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, n), _TREND))
    rows = dct(np.eye(n) - basis @ basis.T, axis=0, norm="ortho")[kept]
    expected = np.sum((rows @ toeplitz(noise.correlation(n))) * rows, axis=1) * noise.sigma**2
    return np.asarray(expected / noise.spectrum(np.pi * np.arange(n)[kept] / n))


@dataclass(frozen=True, slots=True, eq=False)
class _Ordinates:
    """Spectrum at ``omega`` [rad per row]: ``power``, a variance per row with ``freedom`` degrees of freedom.

    ``weight``: independent share of each. ``low``: whether it lies in the low end. ``effect``: prior probability of an
    effect in it. Arrays of shape (ordinates,).
    """

    omega: FloatArray
    power: FloatArray
    freedom: FloatArray
    weight: FloatArray
    low: BoolArray
    effect: FloatArray

    def without_stop_band(self) -> _Ordinates:
        """The spectrum of filtered rows with a white floor: no autoregression of order two follows a stop band."""
        band = (self.omega * (_BROAD_BANDS / np.pi)).astype(np.intp)
        own = self.power / _median_of_noise(self.freedom)
        levels = np.array([np.median(own[band == i]) for i in np.unique(band[~self.low])])
        if levels.size < 2 or np.min(levels) > _STOPPED * np.max(levels):
            return self
        return replace(self, power=self.power + _FLOOR * float(np.max(levels)))

    def best_noise(self) -> Noise:
        """Noise of the order with the least BIC."""
        above = ~self.low
        levels = (self.power / _median_of_noise(self.freedom))[above]
        rows = float(np.sum(self.freedom * self.weight))
        best, least = Noise(1.0), math.inf
        for order in range(3):
            # The likelihood has several maxima: noise with a stop band starts from the level of its pass band.
            for level in {_LEAST_VARIANCE + float(np.quantile(levels, q)) for q in (0.5, 0.9)}:
                for low_end in (0.0, 1.0):
                    noise, deviance = self._fitted(Noise(math.sqrt(level)), order, np.where(above, 1.0, low_end))
                    if deviance + order * math.log(rows) < least:
                        best, least = noise, deviance + order * math.log(rows)
        return best

    def _fitted(self, start: Noise, order: int, first: FloatArray) -> tuple[Noise, float]:
        """Noise of one order from ``first`` shares of the ordinates, and −2 ln L (expectation maximisation)."""
        noise, spectrum = start, self
        for i in range(_ROUNDS):
            pure, _ = spectrum._pure(noise)
            fresh = spectrum._banded(first * pure if i < 2 else pure, order)
            if fresh == noise and i > 2:
                break
            noise, spectrum = fresh, spectrum._with_share_of(pure)
        return noise, spectrum._pure(noise)[1]

    def _with_share_of(self, pure: FloatArray) -> _Ordinates:
        """The shares of effects, in the low end and above it, that follow from the probabilities ``pure``."""
        effect = np.empty(self.effect.size)
        for part in (self.low, ~self.low):
            if np.any(part):
                found = max(float(np.mean(1.0 - pure[part])), _SHARES[0])
                effect[part] = _SHARES[int(np.argmin(np.abs(np.log(_SHARES / found))))]
        return replace(self, effect=effect)

    def _pure(self, noise: Noise) -> tuple[FloatArray, float]:
        """Probability that each ordinate is noise only, and −2 ln L."""
        shown = noise.spectrum(self.omega)
        pure, total = _mixture(self.power / shown, self.freedom, self.effect)
        return pure, float(-2.0 * self.weight @ (np.log(total) - np.log(shown)))

    def _banded(self, pure: FloatArray, order: int) -> Noise:
        """Maximum of the likelihood of the ordinates with weights ``pure``, averaged in bands."""
        band = np.minimum((self.omega * (_BANDS / np.pi)).astype(np.intp), _BANDS - 1)
        own = self.freedom * self.weight * pure
        weight: FloatArray = np.bincount(band, own, _BANDS).astype(np.float64)
        sums = np.bincount(band, own * self.power / _mean_of_pure(self.freedom, self.effect), _BANDS)
        power: FloatArray = sums.astype(np.float64)
        rows = max(float(np.sum(weight)), 1e-9)
        rho = partial = 0.0
        if order > 0:
            rho, partial = _coarse_grid(order).minimum(weight, power)
            fine = np.arange(-_REFINED, _REFINED + 1) / _REFINED
            near = np.clip(rho + (_RHO[1] - _RHO[0]) * fine, -0.99, 0.99)
            beside = np.clip(partial + (_PARTIAL[1] - _PARTIAL[0]) * fine, -0.99, 0.99) if order == 2 else np.zeros(1)
            rho, partial = _Grid(near, beside).minimum(weight, power)
        level = float(power @ _denominator(rho, partial, _COSINE)) / rows
        return Noise(math.sqrt(level + _LEAST_VARIANCE) / Noise(1.0, rho, partial).innovation, rho, partial)


class _Grid:
    """Shapes of noise on a grid of ``rho`` and ``partial``."""

    def __init__(self, rho: FloatArray, partial: FloatArray) -> None:
        self.rho, self.partial = (x.ravel() for x in np.meshgrid(rho, partial, indexing="ij"))
        self.shape = _denominator(self.rho[:, np.newaxis], self.partial[:, np.newaxis], _COSINE)
        self.log = np.log(self.shape)
        # Determinant of the first two rows of a run, Box, Jenkins, Reinsel (2008), Eq. (A7.4.10): no unit roots.
        self.first_rows = -_FIRST_ROWS * np.log((1.0 - self.rho**2) * (1.0 - self.partial**2) ** 2)

    def minimum(self, weight: FloatArray, power: FloatArray) -> tuple[float, float]:
        """Shape with the largest Whittle likelihood, its level profiled out."""
        rows = max(float(np.sum(weight)), 1e-9)
        loss = np.log(self.shape @ power + 1e-300) + (self.first_rows - self.log @ weight) / rows
        best = int(np.argmin(loss))
        return float(self.rho[best]), float(self.partial[best])


@cache
def _coarse_grid(order: int) -> _Grid:
    return _Grid(_RHO, _PARTIAL if order == 2 else np.zeros(1))


def _mixture(ratio: FloatArray, freedom: FloatArray, effect: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Probability of noise only, and density, of ordinates ``ratio`` times the spectrum of the noise.

    Noise is χ²/``freedom``; an effect adds to it a power of log-uniform density over ``_RANGE``.
    """
    from scipy.special import erf

    u = np.maximum(ratio, 1e-12)
    two = freedom > 1.5
    noise = np.where(two, np.exp(-u), np.exp(-0.5 * u) / np.sqrt(2.0 * np.pi * u))
    other = np.where(two, -np.expm1(-u), erf(np.sqrt(0.5 * u))) / (u * _RANGE)
    total = (1.0 - effect) * noise + effect * other
    total = np.maximum(total, 1e-300)
    return (1.0 - effect) * noise / total, total


def _mean_of_pure(freedom: FloatArray, effect: FloatArray) -> FloatArray:
    """Mean of ordinates of noise 1 that counts as noise; below 1, as the largest count as effects."""
    found = np.ones(freedom.size)
    for d in np.unique(freedom):
        for share in np.unique(effect):
            found[(freedom == d) & (effect == share)] = _one_mean_of_pure(float(d), float(share))
    return found


@cache
def _one_mean_of_pure(freedom: float, effect: float) -> float:
    root = np.linspace(1e-4, 8.0, 20000)
    u = root**2
    pure, _ = _mixture(u, np.full(u.size, freedom), np.full(u.size, effect))
    own = (np.exp(-u) if freedom > 1.5 else np.exp(-0.5 * u) / np.sqrt(2.0 * np.pi * u)) * root * pure
    return float(np.sum(own * u) / np.sum(own))


def _median_of_noise(freedom: FloatArray) -> FloatArray:
    """Median of χ²/f for f of one or two."""
    return np.where(freedom > 1.5, math.log(2.0), 0.4549)


def local_noise(residual: FloatArray, index: IntArray, stated: float | None = None) -> Noise:
    """White noise from third differences of rows in order; ``index`` differs by 1 between neighbours."""
    d = residual[3:] - 3.0 * residual[2:-1] + 3.0 * residual[1:-2] - residual[:-3]
    d = d[(index[3:] - index[:-3]) == 3]
    if d.size < _LEAST_ROWS:
        return _noise_of_few(residual, stated)
    spread = 1.4826 * float(np.median(np.abs(d)))
    kept = d[np.abs(d) <= _CLIPPED * spread]
    # The squared coefficients 1, −3, 3, −1 sum to 20.
    sigma = stated if stated is not None else float(np.sqrt(np.mean(kept**2) / 20.0))
    return Noise(max(sigma, 1e-12))


def _noise_of_few(residual: FloatArray, stated: float | None) -> Noise:
    """White noise of rows that are too few for a spectrum: all that they scatter."""
    return Noise(stated if stated is not None else max(float(np.std(residual)), 1e-12))


def upper_tail(score: float) -> float:
    """Upper tail probability of the standard normal distribution."""
    return 0.5 * math.erfc(score / math.sqrt(2.0))


def sidak(p: float, looks: int) -> float:
    """Šidák correction: probability that the smallest of ``looks`` p-values is ``p`` or less."""
    return float(-math.expm1(looks * math.log1p(-min(p, 1.0 - 1e-16))))
