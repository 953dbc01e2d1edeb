"""Moments and exact order statistics of numbers too many to hold: three passes over the chunks."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray

_BINS = 65536


@dataclass(frozen=True, slots=True)
class Spread:
    """Numbers at a glance: ``count`` of those that are numbers, ``lost`` of the others; ``mean`` and standard
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
    """The numbers of these ranks, 0 for the least, exactly; a third pass, which keeps only the bins they lie in."""
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
