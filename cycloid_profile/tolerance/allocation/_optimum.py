"""The cheapest tolerances that reach a yield on one fixed sample of reducers (docs/allocation.md, Eqs. 70 to 75).

The yield is a step function of one sample; a smooth quantile of the worst margin takes its place. The value of the
quantile needs only the reducer at that rank, but the gradient of one random reducer is noisy. A weighted mean over the
neighbouring ranks has a smooth gradient (Eqs. 72 and 73).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.tolerance.inputs import NO_SOLUTION_MARGIN, Cost, Limit, Tolerances, WorstMargin
from cycloid_profile.tolerance.model import Quantities
from cycloid_profile.tolerance.study import Draws

# Of a tolerance. Coordinates are linear in tolerances, so that one side is as good as both: slopes of backlash are
# exact but at a change of contact, those of lost motion within 2e-4 of the largest (1e-3: 9e-3).
_STEP = 1e-4
FINE, ROUGH = 1e-5, 1e-3  # share of the cost a step must change for the search to go on
_MOST_STEPS = 40
_KEPT = 1e-3  # of the scatter, by which the limit may be missed on the sample
_AT_BOUND = 1e-6
# Weights are those of a sample with so many failures. More of them follow the quantile closer, with fewer reducers to
# take a gradient from: 25 shift the yield of a normal answer by 0.0008 at 95 %, which verification takes out again.
_FAILURES = 25.0
_NEGLIGIBLE = 1e-4


@dataclass(frozen=True, eq=False)
class SmoothQuantile:
    """Mean of the ordered sample about rank ``share``, beta weights of Harrell and Davis, Biometrika 69 (1982) 635.

    ``ranks`` with weights that count, and their ``weights``, which add to 1.
    """

    share: float
    ranks: IntArray
    weights: FloatArray

    @classmethod
    def of(cls, share: float, count: int) -> SmoothQuantile:
        """The quantile ``share`` of samples of ``count``."""
        from scipy.special import betainc

        as_if = min(float(count), _FAILURES / min(share, 1.0 - share))
        ends = betainc((as_if + 1.0) * share, (as_if + 1.0) * (1.0 - share), np.arange(count + 1) / count)
        weights = np.diff(ends)
        (ranks,) = np.nonzero(weights > _NEGLIGIBLE * np.max(weights))
        return cls(share, ranks, weights[ranks] / np.sum(weights[ranks]))

    def members(self, values: FloatArray) -> IntArray:
        """Indices of the ``values`` whose ranks have a weight, in the order of ``weights``."""
        return np.argsort(values, kind="stable")[self.ranks]

    def at(self, values: FloatArray) -> float:
        """The quantile of ``values``, shape (count,)."""
        return float(self.weights @ np.sort(values)[self.ranks])


@dataclass(frozen=True, eq=False)
class CostCurves:
    """Costs of the tolerances ``where``, indices of scatters, against the logarithms u of their ratios."""

    where: IntArray
    costs: tuple[Cost, ...]

    @classmethod
    def of(cls, tolerances: Tolerances) -> CostCurves:
        """Cost curves of all scatters whose cost depends on their tolerance."""
        found = [(i, one.cost) for i, one in enumerate(tolerances.scatters) if one.cost and one.cost.at_drawing > 0.0]
        return cls(np.array([i for i, _ in found], dtype=np.intp), tuple(cost for _, cost in found))

    @cached_property
    def low(self) -> FloatArray:
        """Least u of each."""
        return np.log([cost.finest for cost in self.costs])

    @cached_property
    def high(self) -> FloatArray:
        """Greatest u of each."""
        return np.log([cost.coarsest for cost in self.costs])

    def each(self, u: FloatArray) -> FloatArray:
        """Cost of each (Eq. 70)."""
        return np.array([cost.value(ratio) for cost, ratio in zip(self.costs, np.exp(u), strict=True)])

    def slope(self, u: FloatArray) -> FloatArray:
        """Derivative of the cost of each by its u."""
        ratios = np.exp(u)
        return np.array([ratio * cost.slope(ratio) for cost, ratio in zip(self.costs, ratios, strict=True)])

    def curvature(self, u: FloatArray) -> FloatArray:
        """Second derivative of the cost of each by its u."""
        return -np.array([cost.exponent for cost in self.costs]) * self.slope(u)

    def applied(self, tolerances: Tolerances, u: FloatArray) -> Tolerances:
        """The tolerances at u; those without a cost stay as on the drawing."""
        factors = np.ones(len(tolerances.scatters))
        factors[self.where] = np.exp(u)
        return tolerances.scaled([float(factor) for factor in factors])


@dataclass(frozen=True, eq=False)
class Sample:
    """Reducers with the same normal numbers ``z``, shape (reducers, dimensions), whatever their tolerances."""

    draws: Draws
    answers: Quantities
    curves: CostCurves
    z: FloatArray
    margin: WorstMargin

    @classmethod
    def drawn(cls, draws: Draws, answers: Quantities, limits: tuple[Limit, ...], count: int) -> Sample:
        """The first ``count`` reducers of ``draws``."""
        z = draws.normals(0, count, 0)
        margin = WorstMargin.scaled_by(answers.of(draws.from_normals(z)), answers.names, limits)
        return cls(draws, answers, CostCurves.of(draws.tolerances), z, margin)

    def beginning(self, count: int) -> Sample:
        """The sample of its first reducers."""
        return replace(self, z=self.z[:count])

    def worst(self, u: FloatArray, rows: IntArray | slice = slice(None)) -> FloatArray:
        """Worst margin of the reducers ``rows`` at u."""
        draws = replace(self.draws, tolerances=self.curves.applied(self.draws.tolerances, u))
        return self.margin.of(self.answers.of(draws.from_normals(self.z[rows])))

    def share_within(self, u: FloatArray) -> float:
        """Share of the sample within all limits."""
        return float(np.mean(self.worst(u) <= 0.0))

    def gradient(self, u: FloatArray, worst: FloatArray, quantile: SmoothQuantile) -> FloatArray:
        """Derivative of the quantile of ``worst``, the margins at u, by every u (Eq. 73).

        Only reducers whose rank has a nonzero weight in the quantile are computed again.
        """
        rows = quantile.members(worst)
        found = np.empty(len(u))
        for i in range(len(u)):
            moved = u.copy()
            moved[i] += np.log1p(_STEP)
            other = self.worst(moved, rows)
            answered = (other != NO_SOLUTION_MARGIN) & (worst[rows] != NO_SOLUTION_MARGIN)
            found[i] = quantile.weights @ np.where(answered, other - worst[rows], 0.0) / _STEP
        return found


@dataclass(frozen=True, eq=False)
class Cheapest:
    """Where a search ended.

    ``u`` logarithms of the ratios; ``beyond`` the quantile of the worst margin there, which is to be 0 or less;
    ``cost_per_yield`` of one more unit of yield (Eq. 75), 0 where all are at their coarsest; ``saving_left`` share of
    the cost that a better search might still save at most (Eq. 74); ``steps`` of the search.
    """

    u: FloatArray
    beyond: float
    cost: float
    cost_per_yield: float
    saving_left: float
    steps: int

    @property
    def kept(self) -> bool:
        """Whether the sample reaches the yield."""
        return self.beyond <= _KEPT


def cheapest(sample: Sample, share: float, start: FloatArray, change: float = FINE) -> Cheapest:
    """Least cost at which the ``share`` of the sample keeps its limits, searched from u = ``start``.

    The search ends where a step changes the cost by less than the share ``change``.
    """
    from scipy.optimize import minimize

    curves, quantile = sample.curves, SmoothQuantile.of(share, len(sample.z))
    unit = float(-np.sum(curves.slope(np.clip(np.zeros(len(start)), curves.low, curves.high))))
    worst = _cached_margins(sample)
    found = minimize(
        lambda u: float(np.sum(curves.each(u))) / unit,
        np.clip(start, curves.low, curves.high),
        jac=lambda u: curves.slope(u) / unit,
        bounds=list(zip(curves.low, curves.high, strict=True)),
        constraints={
            "type": "ineq",
            "fun": lambda u: -quantile.at(worst(u)),
            "jac": lambda u: -sample.gradient(u, worst(u), quantile),
        },
        method="SLSQP",
        options={"ftol": change, "maxiter": _MOST_STEPS},
    )
    u = np.clip(found.x, curves.low, curves.high)
    return _evaluated(sample, quantile, u, int(found.nit))


def highest_yield_tolerances(sample: Sample, share: float, start: FloatArray) -> tuple[FloatArray, float]:
    """Tolerances of the highest yield at any cost, as u, and their share within limits."""
    from scipy.optimize import minimize

    curves, quantile = sample.curves, SmoothQuantile.of(share, len(sample.z))
    worst = _cached_margins(sample)
    found = minimize(
        lambda u: quantile.at(worst(u)),
        np.clip(start, curves.low, curves.high),
        jac=lambda u: sample.gradient(u, worst(u), quantile),
        bounds=list(zip(curves.low, curves.high, strict=True)),
        method="L-BFGS-B",
        options={"maxiter": _MOST_STEPS},
    )
    u = np.clip(found.x, curves.low, curves.high)
    return u, sample.share_within(u)


def _cached_margins(sample: Sample) -> Callable[[FloatArray], FloatArray]:
    """Worst margins with the last few u cached, because value and gradient are evaluated at the same u."""
    worst = lru_cache(maxsize=4)(lambda key: sample.worst(np.frombuffer(key)))
    return lambda u: worst(u.tobytes())


def _evaluated(sample: Sample, quantile: SmoothQuantile, u: FloatArray, steps: int) -> Cheapest:
    """The result with its Lagrange multiplier and the largest saving that may remain."""
    curves, worst = sample.curves, sample.worst(u)
    cost = float(np.sum(curves.each(u)))
    beyond = quantile.at(worst)
    free = active_bounds(curves, u) == 0
    if not np.any(free):
        return Cheapest(u, beyond, cost, 0.0, 0.0, steps)
    slope, curvature = curves.slope(u)[free], curves.curvature(u)[free]
    rise = sample.gradient(u, worst, quantile)[free]
    multiplier = max(0.0, -float(np.sum(slope * rise / curvature)) / float(np.sum(rise**2 / curvature)))
    left = float(np.sum((slope + multiplier * rise) ** 2 / curvature)) / 2.0
    return Cheapest(u, beyond, cost, multiplier * _rise_with_yield(worst, quantile.share), left / cost, steps)


def active_bounds(curves: CostCurves, u: FloatArray) -> IntArray:
    """−1 for each tolerance at its finest, 1 at its coarsest, 0 between."""
    return np.where(u <= curves.low + _AT_BOUND, -1, np.where(u >= curves.high - _AT_BOUND, 1, 0)).astype(np.intp)


def _rise_with_yield(worst: FloatArray, share: float) -> float:
    """Derivative of the quantile by the yield, from quantiles half a failing share apart."""
    apart = 0.25 * min(share, 1.0 - share)
    above, below = (SmoothQuantile.of(share + sign * apart, len(worst)).at(worst) for sign in (1.0, -1.0))
    return (above - below) / (2.0 * apart)
