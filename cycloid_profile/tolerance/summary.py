"""What a study says: distribution, percentiles and yield, each with what it can be off by."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.limits import Limit, within
from cycloid_profile.tolerance.order_statistics import Spread, order_statistics, spread_of
from cycloid_profile.tolerance.store import Store

CONFIDENCE = 0.95
PERCENTS = (1.0, 5.0, 50.0, 95.0, 99.0, 99.73)


@dataclass(frozen=True, slots=True)
class Interval:
    """A ``value`` and the limits of its confidence interval, ``low`` to ``high``."""

    value: float
    low: float
    high: float


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


@dataclass(frozen=True)
class StudySummary:
    """All quantities of a study, and its yield against each limit and all of them together."""

    store: Store
    quantities: tuple[QuantitySummary, ...]
    yields: tuple[Yield, ...]

    @property
    def samples(self) -> int:
        """Number of reducers."""
        return self.store.study.samples


def summarise(store: Store, limits: Sequence[Limit]) -> StudySummary:
    """Summary of a finished study; ``limits`` of quantities it does not hold are left out."""
    known = [limit for limit in limits if limit.quantity in store.names]
    return StudySummary(store, tuple(_quantity(store, name) for name in store.names), _yields(store, known))


def _quantity(store: Store, name: str) -> QuantitySummary:
    chunks = partial(store.columns, name)
    spread = spread_of(chunks)
    off = _z() * spread.deviation / math.sqrt(max(spread.count, 1))
    mean = Interval(spread.mean, spread.mean - off, spread.mean + off)
    if not spread.count:
        return QuantitySummary(
            name, spread, mean, {percent: Interval(math.nan, math.nan, math.nan) for percent in PERCENTS}
        )
    ranks = {percent: percentile_ranks(percent, spread.count) for percent in PERCENTS}
    found = order_statistics(chunks, spread, [rank for three in ranks.values() for rank in three])
    values = found.reshape(-1, 3).tolist()
    return QuantitySummary(
        name, spread, mean, {percent: Interval(*three) for percent, three in zip(PERCENTS, values, strict=True)}
    )


def percentile_ranks(percent: float, count: int) -> tuple[int, int, int]:
    """Ranks of a percentile and of the ends of its interval: binomial, whatever the distribution.

    The interval is the widest there is where the percentile lies too far out for the number of samples.
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


def share_interval(passed: int, samples: int) -> Interval:
    """Share with its interval by Clopper and Pearson, Biometrika 26 (1934) 404."""
    from scipy.stats import binomtest

    found = binomtest(passed, samples).proportion_ci(CONFIDENCE, "exact")
    return Interval(passed / samples, float(found.low), float(found.high))


def _z() -> float:
    from scipy.special import ndtri

    return float(ndtri(0.5 * (1.0 + CONFIDENCE)))


def histogram(spread: Spread, bins: int) -> tuple[FloatArray, FloatArray]:
    """Edges of ``bins`` bins, shape (bins + 1,), and the share of reducers in each, shape (bins,)."""
    if spread.counts.size < bins:
        return spread.edges, spread.counts / max(spread.count, 1)
    fine = np.concatenate([[0], np.cumsum(spread.counts)])
    at = np.linspace(0, spread.counts.size, bins + 1).astype(np.intp)
    return spread.edges[at], np.diff(fine[at]) / max(spread.count, 1)
