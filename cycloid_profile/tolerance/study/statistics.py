"""Moments, exact order statistics and confidence intervals of numbers that exceed the memory, by passes over chunks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray

CONFIDENCE = 0.95
_BINS = 65536


@dataclass(frozen=True, slots=True)
class Interval:
    """A ``value`` and the limits of its confidence interval, ``low`` to ``high``."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False, slots=True)
class Spread:
    """Distribution of numbers: ``count`` of those that are finite, ``lost`` of the others; ``mean`` and standard
    ``deviation``; ``low`` and ``high``; ``edges`` and ``counts`` of their histogram.
    """

    count: int
    lost: int
    mean: float
    deviation: float
    low: float
    high: float
    edges: FloatArray
    counts: IntArray


Chunks = Callable[[], Iterable[FloatArray]]


def spread_of(chunks: Chunks) -> Spread:
    """Two passes over ``chunks()``, which must give the same arrays each time, shape (any,)."""
    count = lost = 0
    mean = square = 0.0
    low, high = math.inf, -math.inf
    for chunk in chunks():
        some = chunk[np.isfinite(chunk)]
        lost += chunk.size - some.size
        if not some.size:
            continue
        # Chan's update: a sum of squares of large numbers would lose the digits of a small spread.
        own = float(np.mean(some))
        off = own - mean
        square += float(np.sum((some - own) ** 2)) + off * off * count * some.size / (count + some.size)
        mean += off * some.size / (count + some.size)
        count += some.size
        low, high = min(low, float(np.min(some))), max(high, float(np.max(some)))
    if not count:
        return Spread(0, lost, math.nan, math.nan, math.nan, math.nan, np.array([0.0, 1.0]), np.zeros(1, dtype=np.intp))
    edges = np.linspace(low, high, _BINS + 1) if high > low else np.array([low, low])
    counts = np.zeros(edges.size - 1, dtype=np.intp)
    for chunk in chunks():
        counts += np.bincount(_bins(chunk[np.isfinite(chunk)], edges), minlength=counts.size)
    return Spread(count, lost, mean, math.sqrt(square / max(count - 1, 1)), low, high, edges, counts)


def order_statistics(chunks: Chunks, spread: Spread, ranks: Sequence[int]) -> FloatArray:
    """Exact numbers of the given ranks, 0 for the smallest; a third pass keeps only the bins that contain them."""
    ends = np.cumsum(spread.counts)
    wanted = np.searchsorted(ends, np.asarray(ranks), side="right")
    kept: dict[int, list[FloatArray]] = {int(bin_): [] for bin_ in wanted}
    for chunk in chunks():
        some = chunk[np.isfinite(chunk)]
        at = _bins(some, spread.edges)
        for bin_, found in kept.items():
            found.append(some[at == bin_])
    held = {bin_: np.sort(np.concatenate(found)) for bin_, found in kept.items()}
    before = np.concatenate([[0], ends])
    return np.array([held[int(b)][rank - before[b]] for b, rank in zip(wanted, ranks, strict=True)])


def _bins(values: FloatArray, edges: FloatArray) -> IntArray:
    """Bin of each number, the last one closed on both sides."""
    return np.clip(np.searchsorted(edges, values, side="right") - 1, 0, edges.size - 2)


def histogram(spread: Spread, bins: int) -> tuple[FloatArray, FloatArray]:
    """Edges of ``bins`` bins, shape (bins + 1,), and the share of reducers in each, shape (bins,)."""
    if spread.counts.size < bins:
        return spread.edges, spread.counts / max(spread.count, 1)
    fine = np.concatenate([[0], np.cumsum(spread.counts)])
    at = np.linspace(0, spread.counts.size, bins + 1).astype(np.intp)
    return spread.edges[at], np.diff(fine[at]) / max(spread.count, 1)


def share_interval(passed: int, samples: int) -> Interval:
    """Share with its interval by Clopper and Pearson, Biometrika 26 (1934) 404."""
    from scipy.stats import binomtest

    found = binomtest(passed, samples).proportion_ci(CONFIDENCE, "exact")
    return Interval(passed / samples, float(found.low), float(found.high))


def percent(share: Interval) -> str:
    """A yield with its 95 % interval as text."""
    return f"{100.0 * share.value:.2f} % ({100.0 * share.low:.2f} to {100.0 * share.high:.2f} %)"
