"""Fits of the empirical effects to the residual that named effects leave."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.empirical.deviations import FormDeviation, TorqueTwistResidual
from cycloid_profile.errors import MeasurementError
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.spec.model import DataFileSpec
from cycloid_profile.units import UM

_CHANCE = 1e-3  # probability that noise alone adds a knot anywhere
_GAIN_ANY = 4.0  # standard deviations of chi² that a curve must gain, as for the remainder of scans
_GROUPS = 400  # means of neighbouring rows: the time does not grow with their number
_LEAST_GROUPS = 3  # on either side of a new knot
_LEVELS = (1, 3, 7)  # knots tried at once within an interval: one alone may miss a wave
_MOST_KNOTS = 40
_DIGITS_UM = 6  # digits after the point, a picometre
_DIGITS_TWIST = 10


def form_deviation_of(
    curve: NormalDeviation, uncertainty: float, disc: int | None = None, data: Iterable[DataFileSpec] = ()
) -> FormDeviation:
    """The smooth remainder of scans as an empirical effect.

    Parameters
    ----------
    curve : removal at even phases from 0 on, as ``smooth_remainder`` gives it
    uncertainty : root mean square standard error [mm]
    disc : disc counted from 1, None for all
    data : the scans, see ``data_file``
    """
    removal, lobes = curve.removal, curve.lobes
    if removal.size % lobes == 0:
        by_lobe = removal.reshape(lobes, -1)
        # A form common to all lobes is kept once.
        if np.ptp(by_lobe, axis=0).max() <= 10.0**-_DIGITS_UM * UM:
            removal, lobes = by_lobe[0], 1
    values = np.round(removal / UM, _DIGITS_UM) + 0.0
    return FormDeviation(
        tuple(values.tolist()), lobes, disc, round(uncertainty / UM, _DIGITS_UM), data=tuple(data)
    )  # fmt: skip


def fit_torque_twist(
    torque_nm: FloatArray,
    branch: FloatArray,
    residual_arcmin: FloatArray,
    sigma_arcmin: FloatArray | float,
    *,
    correlation: float = 0.0,
    data: Iterable[DataFileSpec] = (),
) -> TorqueTwistResidual | None:
    """Smooth twist against torque on the two branches of loops; None if neither is significant.

    Natural cubic splines by weighted least squares. A knot is added only where chi² falls by more than noise explains.
    An insignificant branch is zero. The mean of both is zero at zero torque, where a loop has no angle of its own.

    Parameters
    ----------
    torque_nm : torque applied, shape (rows,) [N·m]; rows of several loops may follow each other
    branch : +1 while the torque rises, −1 while it falls (``loop_branches``), shape (rows,)
    residual_arcmin : measured minus predicted angle, shape (rows,) [arc minutes]
    sigma_arcmin : standard deviation of the noise, of each row or of all [arc minutes]
    correlation : of the noise of neighbouring rows
    data : the loops, see ``data_file``

    Raises ``MeasurementError`` if the arrays differ in shape, the noise is not above zero, or a branch has fewer than
    8 rows.
    """
    T, y = np.asarray(torque_nm, dtype=np.float64), np.asarray(residual_arcmin, dtype=np.float64)
    sigma = np.broadcast_to(np.asarray(sigma_arcmin, dtype=np.float64), y.shape)
    if not T.shape == y.shape == np.shape(branch):
        shapes = f"{T.shape}, {np.shape(branch)}, {y.shape}"
        raise MeasurementError("shapes of torque, branch, residual", shapes, "differ", "give one number for each row")
    if not np.all(sigma > 0.0):
        raise MeasurementError("noise of the loop", float(sigma.min()), "is not above zero", "give its noise in arcmin")
    widened = math.sqrt((1.0 + correlation) / (1.0 - correlation))
    finite = np.isfinite(T) & np.isfinite(y)
    curves = [_branch(T[own], y[own], sigma[own] * widened)
              for own in (finite & (np.asarray(branch) > 0.0), finite & (np.asarray(branch) <= 0.0))]  # fmt: skip
    if not any(curve.significant for curve in curves):
        return None
    rising, falling = (curve if curve.significant else curve.zero() for curve in curves)
    middle = 0.5 * (rising.at(0.0) + falling.at(0.0))
    columns = [column for curve in (rising, falling)
               for column in (curve.knots, curve.values - middle, curve.error)]  # fmt: skip
    lists = [tuple((np.round(column, _DIGITS_TWIST) + 0.0).tolist()) for column in columns]
    return TorqueTwistResidual(*lists, data=tuple(data))


class _Curve(NamedTuple):
    """Natural spline of one branch: ``knots`` [N·m], ``values`` and standard ``error`` there [arc minutes]."""

    knots: FloatArray
    values: FloatArray
    error: FloatArray
    significant: bool

    def at(self, torque: float) -> float:
        inside = np.clip([torque], self.knots[0], self.knots[-1])
        return float((_design(self.knots, inside) @ self.values)[0])

    def zero(self) -> _Curve:
        """The curve that is zero, over the same range."""
        ends, nothing = self.knots[[0, -1]], np.zeros(2)
        return _Curve(ends, nothing, self.error[[0, -1]], False)


class _Groups(NamedTuple):
    """Weighted means of rows of nearly the same torque: ``x``, ``y`` and the square root ``w`` of the weight."""

    x: FloatArray
    y: FloatArray
    w: FloatArray

    def fitted(self, knots: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Values at the knots, their covariance, and chi² of the groups."""
        A = _design(knots, self.x) * self.w[:, np.newaxis]
        covariance = np.asarray(np.linalg.pinv(A.T @ A, hermitian=True), dtype=np.float64)
        values: FloatArray = covariance @ (A.T @ (self.w * self.y))
        return values, covariance, float(np.sum((self.w * self.y - A @ values) ** 2))


def _branch(T: FloatArray, y: FloatArray, sigma: FloatArray) -> _Curve:
    """Adaptive spline of one branch."""
    groups = _grouped(T, y, sigma)
    knots = groups.x[[0, -1]]
    values, covariance, chi2 = groups.fitted(knots)
    while (more := _best_split(groups, knots, chi2)) is not None:
        knots = more
        values, covariance, chi2 = groups.fitted(knots)
    gain = float(np.sum((groups.w * groups.y) ** 2)) - chi2
    freedom = knots.size
    spread = chi2 / max(groups.x.size - freedom, 1)
    error = np.sqrt(np.diag(covariance) * max(spread, 1.0))
    return _Curve(knots, values, error, gain > freedom + _GAIN_ANY * math.sqrt(2.0 * freedom))


def _best_split(groups: _Groups, knots: FloatArray, chi2: float) -> FloatArray | None:
    """The knots with further ones in the interval where chi² falls most, None where it falls no more than by noise."""
    from scipy.special import chdtrc, chdtri

    best, least = None, 1.0
    intervals = knots.size - 1
    for i in range(intervals):
        for count in _LEVELS:
            inner = np.linspace(knots[i], knots[i + 1], count + 2)
            if np.min(np.histogram(groups.x, inner)[0]) < _LEAST_GROUPS or knots.size + count > _MOST_KNOTS:
                continue
            more = np.sort(np.concatenate([knots, inner[1:-1]]))
            gain = chi2 - groups.fitted(more)[2]
            if gain > chdtri(float(count), _CHANCE / (intervals * len(_LEVELS))):
                # Probabilities of large gains are all zero: the gain itself decides between them.
                rank = float(chdtrc(float(count), gain)) or -gain / count
                if rank < least:
                    best, least = more, rank
    return best


def _grouped(T: FloatArray, y: FloatArray, sigma: FloatArray) -> _Groups:
    least = 2 * (_LEAST_GROUPS + 1)
    if T.size < least or np.ptp(T) == 0.0:
        limit = f"has {T.size} rows" if T.size < least else "has one torque"
        raise MeasurementError("branch of the loop", "given", limit, f"give at least {least} rows of it", " ")
    order = np.argsort(T, kind="stable")
    T, y, weight = T[order], y[order], sigma[order] ** -2.0
    group = np.arange(T.size) * min(_GROUPS, T.size) // T.size
    total = np.bincount(group, weight)
    x, mean = np.bincount(group, weight * T) / total, np.bincount(group, weight * y) / total
    # Rows of the same torque in neighbouring groups would make knots coincide.
    kept = np.concatenate([[True], np.diff(x) > 1e-9 * (x[-1] - x[0])])
    if not np.all(kept):
        again = np.cumsum(kept) - 1
        sums = np.bincount(again, total)
        x, mean = np.bincount(again, total * x) / sums, np.bincount(again, total * mean) / sums
        total = sums
    return _Groups(x, mean, np.sqrt(total))


def _design(knots: FloatArray, x: FloatArray) -> FloatArray:
    """Natural cubic cardinal splines at ``x``, shape (points, knots)."""
    from scipy.interpolate import CubicSpline

    found: FloatArray = CubicSpline(knots, np.eye(knots.size), bc_type="natural")(x)
    return found
