"""Limits a reducer must keep, and how far beyond them it is."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.errors import SpecError


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


NO_ANSWER = 10.0  # worst margin of a reducer without an answer
# An upper limit, or a lower and an upper one, None for neither.
Ends = float | tuple[float | None, float | None]


def limits_of(given: Mapping[str, Ends], names: Sequence[str]) -> tuple[Limit, ...]:
    """Limits from a mapping of quantity to its upper limit, or to a pair of lower and upper, None for neither.

    Raises
    ------
    SpecError
        If a quantity is none of ``names``, a limit is no number, a pair is the wrong way round, or there is no limit.
    """
    if not given:
        raise SpecError("limits", "none", "leave nothing to reach", f"limit one of {', '.join(names)}", ": ")
    return tuple(_limit(quantity, ends, names) for quantity, ends in given.items())


def _limit(quantity: str, ends: Ends, names: Sequence[str]) -> Limit:
    if quantity not in names:
        close = difflib.get_close_matches(quantity, names, n=1, cutoff=0.4)
        remedy = f"did you mean {close[0]}?" if close else f"choose from {', '.join(names)}"
        raise SpecError("limit of", f"'{quantity}'", "is of no quantity that is computed", remedy, " ")
    low, high = ends if isinstance(ends, tuple) else (None, ends)
    limit = Limit(quantity, -math.inf if low is None else float(low), math.inf if high is None else float(high))
    if math.isnan(limit.at_least) or math.isnan(limit.at_most) or (low is None and high is None):
        raise SpecError(
            f"limit of {quantity}", ends, "is no number", "give an upper limit, or a lower and an upper one"
        )
    if limit.at_least > limit.at_most:
        raise SpecError(f"lower limit of {quantity}", low, f"is above the upper one, {high:g}", "swap them")
    return limit


def within(values: FloatArray, names: Sequence[str], limits: Sequence[Limit]) -> BoolArray:
    """Which reducers keep all limits, shape (reducers,); one without an answer does not.

    ``values`` shape (reducers, quantities), in the order of ``names``.
    """
    kept: BoolArray = np.all([limit.beyond(values[:, names.index(limit.quantity)]) <= 0.0 for limit in limits], axis=0)
    return kept


@dataclass(frozen=True)
class WorstMargin:
    """The limits as one number a reducer: the farthest it is beyond any, in units of what that quantity scatters.

    ``scale`` of each limit. Zero is the limit whatever the scale; a lower limit of 0, which nothing can be divided by,
    is a limit as any other.
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

        A reducer without an answer has ``NO_ANSWER``: beyond, and no nearer or farther for any change.
        """
        beyond = [limit.beyond(values[:, self.names.index(limit.quantity)]) for limit in self.limits]
        worst: FloatArray = np.max(np.array(beyond) / self.scale[:, np.newaxis], axis=0)
        return np.where(np.isfinite(worst), worst, NO_ANSWER)


def _spread(values: FloatArray) -> float:
    """Half the width that holds the middle two thirds: a few that bind far beyond zero do not widen it."""
    some = values[np.isfinite(values)]
    if some.size == 0:
        return 1.0
    low, high = np.quantile(some, [1.0 / 6.0, 5.0 / 6.0])
    return float(0.5 * (high - low)) or 1.0
