"""Limits a reducer must keep, and its exceedance of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.errors import SpecError, did_you_mean


@dataclass(frozen=True, slots=True)
class Limit:
    """``quantity`` is to lie from ``at_least`` to ``at_most``, in the unit it has in its name."""

    quantity: str
    at_least: float = -math.inf
    at_most: float = math.inf

    def beyond(self, values: FloatArray) -> FloatArray:
        """How far values lie beyond the nearer limit, negative within, in their shape and unit."""
        return np.maximum(values - self.at_most, self.at_least - values)

    def __str__(self) -> str:
        ends = [f"{word} {end:g}" for word, end in (("≥", self.at_least), ("≤", self.at_most)) if math.isfinite(end)]
        return f"{self.quantity} {' and '.join(ends)}"


NO_SOLUTION_MARGIN = 10.0  # worst margin of a reducer without a converged solution
# An upper limit, or a lower and an upper one, None for neither.
Ends = float | tuple[float | None, float | None]


def limits_of(given: Mapping[str, Ends] | Sequence[Limit], names: Sequence[str]) -> tuple[Limit, ...]:
    """Given limits unchanged, or limits from a mapping. It maps a quantity to its upper limit, or to a pair of limits
    with None for a missing one.

    Raises
    ------
    SpecError
        If a quantity is none of ``names``, a limit is no number, a pair is reversed, or there is no limit.
    """
    if not given:
        raise SpecError("limits", "none", "leave nothing to reach", f"limit one of {', '.join(names)}", ": ")
    for quantity in given if isinstance(given, Mapping) else [one.quantity for one in given]:
        if quantity not in names:
            remedy = did_you_mean(quantity, names, f"choose from {', '.join(names)}")
            raise SpecError("limit of", f"'{quantity}'", "is of no quantity that is computed", remedy, " ")
    if isinstance(given, Mapping):
        return tuple(_limit(quantity, ends) for quantity, ends in given.items())
    return tuple(given)


def _limit(quantity: str, ends: Ends) -> Limit:
    low, high = ends if isinstance(ends, tuple) else (None, ends)
    limit = Limit(quantity, -math.inf if low is None else float(low), math.inf if high is None else float(high))
    if math.isnan(limit.at_least) or math.isnan(limit.at_most) or (low is None and high is None):
        remedy = "give an upper limit, or a lower and an upper one"
        raise SpecError(f"limit of {quantity}", ends, "is no number", remedy)
    if limit.at_least > limit.at_most:
        raise SpecError(f"lower limit of {quantity}", low, f"is above the upper one, {high:g}", "swap them")
    return limit


def within(values: FloatArray, names: Sequence[str], limits: Sequence[Limit]) -> BoolArray:
    """Which reducers keep all limits, shape (reducers,); one without a converged solution does not.

    ``values`` shape (reducers, quantities), in the order of ``names``.
    """
    return np.asarray(np.all([limit.beyond(values[:, names.index(limit.quantity)]) <= 0.0 for limit in limits], axis=0))


@dataclass(frozen=True, eq=False)
class WorstMargin:
    """The limits as one number per reducer: the largest exceedance of any limit over its ``scale``, the scatter of
    that quantity. A margin of zero is the limit for any scale, so a lower limit of 0 is possible.
    """

    names: tuple[str, ...]
    limits: tuple[Limit, ...]
    scale: FloatArray

    @classmethod
    def scaled_by(cls, values: FloatArray, names: tuple[str, ...], limits: tuple[Limit, ...]) -> WorstMargin:
        """With the scatter of ``values``, shape (reducers, quantities), as scale."""
        spread = np.array([_spread(values[:, names.index(limit.quantity)]) for limit in limits])
        return cls(names, limits, spread)

    def of(self, values: FloatArray) -> FloatArray:
        """Worst margin of each reducer, negative where all limits are kept, shape (reducers,).

        A reducer without a converged solution gets the constant ``NO_SOLUTION_MARGIN``: it fails, with zero gradient.
        """
        beyond = [limit.beyond(values[:, self.names.index(limit.quantity)]) for limit in self.limits]
        worst: FloatArray = np.max(np.array(beyond) / self.scale[:, np.newaxis], axis=0)
        return np.where(np.isfinite(worst), worst, NO_SOLUTION_MARGIN)


def _spread(values: FloatArray) -> float:
    """Half-width of the central two thirds; robust against binding outliers."""
    some = values[np.isfinite(values)]
    if some.size == 0:
        return 1.0
    low, high = np.quantile(some, [1.0 / 6.0, 5.0 / 6.0])
    return float(0.5 * (high - low)) or 1.0
