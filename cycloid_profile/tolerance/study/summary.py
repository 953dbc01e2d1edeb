"""Summary of a study: distribution, percentiles and yield, each with its confidence interval."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.inputs import Limit, within
from cycloid_profile.tolerance.study.statistics import (
    CONFIDENCE,
    Interval,
    Spread,
    order_statistics,
    percent,
    share_interval,
    spread_of,
)
from cycloid_profile.tolerance.study.store import Store

_LOST_SHARE = 0.01  # of the reducers, without equilibrium, that may be omitted
PERCENTS = (1.0, 5.0, 50.0, 95.0, 99.0, 99.73)


@dataclass(frozen=True, slots=True)
class QuantitySummary:
    """One quantity of all reducers: its ``spread``, ``mean``, and ``percentiles`` by percent."""

    name: str
    spread: Spread
    mean: Interval
    percentiles: Mapping[float, Interval]


@dataclass(frozen=True, slots=True)
class Yield:
    """Share of reducers within a ``limit``, None for all limits together; one without an answer fails."""

    limit: Limit | None
    share: Interval


@dataclass(frozen=True, repr=False)
class StudySummary(Described):
    """All quantities of a study, and its yield against each limit and all of them together."""

    store: Store
    quantities: tuple[QuantitySummary, ...]
    yields: tuple[Yield, ...]

    @property
    def samples(self) -> int:
        """Number of reducers."""
        return self.store.study.samples

    def to_frame(self) -> Any:
        """A ``pandas.DataFrame``, one row per quantity: mean, standard deviation and percentiles, in its unit."""
        columns: dict[str, list[float] | list[str]] = {
            "quantity": [one.name for one in self.quantities],
            "mean": [one.mean.value for one in self.quantities],
            "deviation": [one.spread.deviation for one in self.quantities],
        }
        return frame(columns | {f"p{p:g}": [one.percentiles[p].value for one in self.quantities] for p in PERCENTS})

    def _key_figures(self) -> Mapping[str, str]:
        figures = {"reducers": f"{self.samples:,}"}
        for one in self.quantities:
            high = one.percentiles[99.0].value
            figures[one.name] = f"{one.mean.value:.4g} ± {one.spread.deviation:.2g}, 99 % below {high:.4g}"
        return figures | {f"yield, {one.limit or 'all limits'}": percent(one.share) for one in self.yields}


def require_equilibria(lost: int, reducers: int) -> None:
    """Raise ``SolveError`` if more than 1 % of the drawn reducers have no equilibrium: they cannot be assembled."""
    if lost > _LOST_SHARE * reducers:
        raise SolveError(
            "reducers without equilibrium",
            f"{lost:,} of {reducers:,}",
            "are too many to omit",
            "narrow the tolerances until the discs can be assembled",
        )


def summarise(store: Store, limits: Sequence[Limit]) -> StudySummary:
    """Summary of a finished study; ``limits`` of quantities it does not hold are left out."""
    known = [limit for limit in limits if limit.quantity in store.names]
    return StudySummary(store, tuple(_quantity(store, name) for name in store.names), _yields(store, known))


def _quantity(store: Store, name: str) -> QuantitySummary:
    from scipy.special import ndtri

    chunks = partial(store.columns, name)
    spread = spread_of(chunks)
    off = float(ndtri(0.5 * (1.0 + CONFIDENCE))) * spread.deviation / math.sqrt(max(spread.count, 1))
    mean = Interval(spread.mean, spread.mean - off, spread.mean + off)
    values = [[math.nan] * 3] * len(PERCENTS)
    if spread.count:
        ranks = [rank for one in PERCENTS for rank in percentile_ranks(one, spread.count)]
        values = order_statistics(chunks, spread, ranks).reshape(-1, 3).tolist()
    percentiles = {one: Interval(*three) for one, three in zip(PERCENTS, values, strict=True)}
    return QuantitySummary(name, spread, mean, percentiles)


def percentile_ranks(percent: float, count: int) -> tuple[int, int, int]:
    """Ranks of a percentile and of the ends of its interval: binomial, for any distribution.

    With too few samples for the percentile, the interval ends at the first or last rank.
    """
    from scipy.stats import binom

    p = percent / 100.0
    value = min(max(math.ceil(p * count) - 1, 0), count - 1)
    low = int(binom.ppf(0.5 * (1.0 - CONFIDENCE), count, p)) - 1
    high = int(binom.ppf(0.5 * (1.0 + CONFIDENCE), count, p))
    return value, max(min(low, value), 0), min(max(high, value), count - 1)


def _yields(store: Store, limits: Sequence[Limit]) -> tuple[Yield, ...]:
    if not limits:
        return ()
    asked: list[Limit | None] = [*limits, None] if len(limits) > 1 else list(limits)
    passed = np.zeros(len(asked), dtype=np.intp)
    for table in store.tables():
        for i, limit in enumerate(asked):
            passed[i] += np.count_nonzero(within(table, store.names, limits if limit is None else [limit]))
    samples = store.study.samples
    return tuple(Yield(limit, share_interval(int(count), samples)) for limit, count in zip(asked, passed, strict=True))
