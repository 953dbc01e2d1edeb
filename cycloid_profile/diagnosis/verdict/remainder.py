"""Smooth curve fitted to the residual of scans after subtraction of the named effects; it has no physical model.

Periodic cubic splines with adaptive knots: first a form common to all lobes, then the rest along the disc. A knot is
added only where the improvement is significant. Waves below a cut-off length and lobes without points are not fitted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.units import UM

if TYPE_CHECKING:
    from scipy.sparse import csr_array

LABEL = "fitted, not physics"
SHORTEST_WAVE = 1.0 / 12.0  # of a lobe
_DEGREE = 3  # continuous curvature: a wheel can follow
_FIRST_PER_LOBE = 9  # knots before the first split: three waves a lobe
_INTERVALS_PER_WAVE = 3.0  # a cubic spline resolves a wave with three intervals
_LOBES_PER_FIRST = 3  # lobes per first interval round the disc
_SAMPLES_PER_LOBE = 48  # four of the shortest wave
_LEAST_POINTS = 3  # on either half of an interval that is split
_CHANCE = 1e-3  # probability that noise alone splits an interval
_GAIN_ANY = 4.0  # standard deviations of chi² that a curve must gain
_FADE = 0.5  # rad over which the curve fades out towards a lobe without points
_RIDGE = 1e-6  # of the largest diagonal element, far below the weight of one point
_DEEPEST = 8  # halvings tried at once


@dataclass(frozen=True, eq=False)
class ScanResidual:
    """Residual of one scan: phase ``along`` the disc, phase + 2π·lobe [rad], and ``removal`` [mm], both shape
    (points,).

    ``sigma``: standard deviation of the noise [mm]; ``rho``: correlation of neighbouring points.
    """

    along: FloatArray
    removal: FloatArray
    sigma: float
    rho: float = 0.0


@dataclass(frozen=True, eq=False)
class Remainder:
    """Smooth periodic curve along the disc; ``curve`` is material missing along the normal.

    ``rms`` and ``largest`` value [mm]; ``uncertainty``: root mean square error from the noise of the scan [mm];
    ``lobes_without``: lobes without points, counted from 1.
    """

    curve: NormalDeviation
    rms: float
    largest: float
    uncertainty: float
    lobes_without: tuple[int, ...]
    label: str = LABEL


@dataclass(frozen=True, eq=False)
class _Spline:
    """Periodic cubic spline: ``knots`` of one period, shape (n + 1,), with ``coefficients``, shape (n,)."""

    knots: FloatArray
    coefficients: FloatArray

    def __call__(self, x: FloatArray) -> FloatArray:
        value: FloatArray = _design(self.knots, x) @ self.coefficients
        return value


def smooth_remainder(
    residuals: Sequence[ScanResidual], lobes: int, shortest: float = SHORTEST_WAVE
) -> Remainder | None:
    """Smooth part of the residual of scans of one disc; None if it is not significant.

    Parameters
    ----------
    residuals : residuals of all scans of the disc
    lobes : number of lobes z_c
    shortest : length of the shortest fitted wave, in lobes
    """
    period = 2.0 * math.pi * lobes
    x = np.mod(np.concatenate([r.along for r in residuals]), period)
    y = np.concatenate([r.removal for r in residuals])
    # Correlated neighbours carry less information.
    sigma = np.concatenate([np.full(r.along.size, r.sigma * math.sqrt((1 + r.rho) / (1 - r.rho))) for r in residuals])
    least = 2.0 * math.pi * shortest / _INTERVALS_PER_WAVE
    common_form = _fitted(
        np.mod(x, 2.0 * math.pi), y, sigma, np.linspace(0.0, 2.0 * math.pi, _FIRST_PER_LOBE + 1), least
    )
    rest = y if common_form is None else y - common_form(np.mod(x, 2.0 * math.pi))
    coarse = max(8, round(lobes / _LOBES_PER_FIRST))
    disc = _fitted(x, rest, sigma, np.linspace(0.0, period, coarse + 1), least)
    if common_form is None and disc is None:
        return None
    count = lobes * _SAMPLES_PER_LOBE
    at = np.arange(count) * period / count
    value = np.zeros(count)
    freedom = 0
    if common_form is not None:
        value, freedom = value + common_form(np.mod(at, 2.0 * math.pi)), freedom + common_form.coefficients.size
    if disc is not None:
        value, freedom = value + disc(at), freedom + disc.coefficients.size
    scanned = np.bincount(_lobe(x, lobes), minlength=lobes) >= _LEAST_POINTS
    value = value * _scanned_weight(at, scanned)
    return Remainder(
        NormalDeviation(at, value, lobes),
        rms=float(np.sqrt(np.mean(value**2))),
        largest=float(np.max(np.abs(value))),
        uncertainty=float(np.sqrt(freedom / np.sum(sigma**-2.0))),
        lobes_without=tuple(int(m) + 1 for m in np.flatnonzero(~scanned)),
    )


def remainder_text(remainder: Remainder) -> str:
    """One sentence about the remainder."""
    return (
        f"the remainder, {remainder.rms / UM:.2f} µm rms and {remainder.largest / UM:.2f} µm at most, "
        f"is {remainder.label}: it describes this scan only"
    )


def _fitted(x: FloatArray, y: FloatArray, sigma: FloatArray, knots: FloatArray, least: float) -> _Spline | None:
    """Least-squares spline with adaptive knots; None if it is not significant against the noise."""
    if _mean_counts(x, knots) < _LEAST_POINTS:
        return None
    fit = _least_squares(knots, x, y, sigma)
    while True:
        split = _intervals_to_split(knots, fit, x, y, sigma, least)
        if not np.any(split):
            break
        knots = _halved(knots, split)
        fit = _least_squares(knots, x, y, sigma)
    freedom = knots.size - 1
    fall = float(np.sum((y / sigma) ** 2) - np.sum(((y - fit(x)) / sigma) ** 2))
    return fit if fall > freedom + _GAIN_ANY * math.sqrt(2.0 * freedom) else None


def _intervals_to_split(
    knots: FloatArray, fit: _Spline, x: FloatArray, y: FloatArray, sigma: FloatArray, least: float
) -> BoolArray:
    """Intervals with a significant improvement by inner knots at any finer level: one level alone may miss a wave."""
    from scipy.special import chdtri

    now = _per_interval(knots, x, ((y - fit(x)) / sigma) ** 2)
    room = np.diff(knots) >= 2.0 * least * (1.0 - 1e-9)
    split = np.zeros(room.size, dtype=bool)
    finer, may = knots, room
    for level in range(1, _DEEPEST):
        finer = _halved(finer, np.diff(finer) >= 2.0 * least * (1.0 - 1e-9))
        counts = _per_interval(finer, x, np.ones_like(x))
        inside = np.searchsorted(knots, 0.5 * (finer[1:] + finer[:-1]), side="right") - 1
        scarce = np.bincount(inside, weights=counts < _LEAST_POINTS, minlength=room.size) > 0
        may = may & ~scarce
        if not np.any(may & ~split):
            break
        gain = now - _per_interval(knots, x, ((y - _least_squares(finer, x, y, sigma)(x)) / sigma) ** 2)
        split |= may & (gain > chdtri(2.0**level - 1.0, _CHANCE))
    return split


def _least_squares(knots: FloatArray, x: FloatArray, y: FloatArray, sigma: FloatArray) -> _Spline:
    """Weighted least squares; a small ridge keeps the spline at zero where there are no points."""
    from scipy.sparse import csr_array, eye_array
    from scipy.sparse.linalg import spsolve

    A = _design(knots, x)
    weighted = csr_array(A.multiply(sigma[:, np.newaxis] ** -2.0))
    gram = A.T @ weighted
    ridge = _RIDGE * float(gram.diagonal().max()) * eye_array(knots.size - 1)
    return _Spline(knots, np.atleast_1d(spsolve((gram + ridge).tocsc(), weighted.T @ y)))


def _design(knots: FloatArray, x: FloatArray) -> csr_array:
    """Values of the periodic basis at ``x`` within the period, shape (points, intervals)."""
    from scipy.interpolate import BSpline
    from scipy.sparse import csr_array

    n, period = knots.size - 1, knots[-1] - knots[0]
    before, after = knots[-1 - _DEGREE : -1] - period, knots[1 : 1 + _DEGREE] + period
    open_knots = np.concatenate([before, knots, after])
    full = csr_array(BSpline.design_matrix(np.clip(x, knots[0], knots[-1]), open_knots, _DEGREE))
    fold = csr_array((np.ones(n + _DEGREE), (np.arange(n + _DEGREE), np.arange(n + _DEGREE) % n)))
    return csr_array(full @ fold)


def _halved(knots: FloatArray, which: BoolArray) -> FloatArray:
    """The knots with a further knot in the middle of each interval of ``which``."""
    middle = 0.5 * (knots[1:] + knots[:-1])
    return np.sort(np.concatenate([knots, middle[which]]))


def _per_interval(knots: FloatArray, x: FloatArray, value: FloatArray) -> FloatArray:
    """Sum of ``value`` over the points of each interval."""
    where = np.clip(np.searchsorted(knots, x, side="right") - 1, 0, knots.size - 2)
    total: FloatArray = np.bincount(where, weights=value, minlength=knots.size - 1).astype(np.float64)
    return total


def _mean_counts(x: FloatArray, knots: FloatArray) -> float:
    return x.size / (knots.size - 1)


def _lobe(along: FloatArray, lobes: int) -> IntArray:
    """Lobe index of a phase along the disc; the root is in the middle."""
    return np.mod(np.round(along / (2.0 * math.pi)), lobes).astype(np.intp)


def _scanned_weight(along: FloatArray, scanned: BoolArray) -> FloatArray:
    """Weight of each place: 1 on scanned lobes, 0 on the others, with a smooth transition within scanned lobes."""
    lobes = scanned.size
    if np.all(scanned):
        return np.ones_like(along)
    lobe = _lobe(along, lobes)
    from_root = along - 2.0 * math.pi * np.round(along / (2.0 * math.pi))
    neighbour = np.where(from_root < 0.0, lobe - 1, lobe + 1) % lobes
    u = np.clip((math.pi - np.abs(from_root)) / _FADE, 0.0, 1.0)
    end = np.where(scanned[neighbour], 1.0, u * u * (3.0 - 2.0 * u))
    return np.where(scanned[lobe], end, 0.0)
