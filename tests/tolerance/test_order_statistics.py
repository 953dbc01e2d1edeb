"""Moments, order statistics, intervals and yields of numbers in chunks, against numpy and scipy on all at once."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from cycloid_profile.tolerance.inputs import Limit
from cycloid_profile.tolerance.study import histogram, share_interval, summarise
from cycloid_profile.tolerance.study.statistics import CONFIDENCE, order_statistics, spread_of
from cycloid_profile.tolerance.study.summary import PERCENTS, percentile_ranks


def chunked(values: np.ndarray, sizes: list[int]) -> list[np.ndarray]:
    return np.split(values, np.cumsum(sizes)[np.cumsum(sizes) < values.size])


def numbers(seed: int, count: int, kind: str) -> np.ndarray:
    """Random numbers of a kind, some of them lost."""
    draw = np.random.default_rng(seed)
    made = {
        "normal": lambda: draw.normal(0.8, 1e-3, count),
        "far off": lambda: draw.normal(1e9, 1.0, count),
        "long tail": lambda: draw.standard_cauchy(count),
        "ties": lambda: draw.integers(0, 4, count).astype(float),
        "one value": lambda: np.full(count, 2.5),
    }[kind]()
    made[draw.random(count) < 0.1] = np.nan
    return made


kinds = st.sampled_from(["normal", "far off", "long tail", "ties", "one value"])


@given(st.integers(0, 10**6), st.integers(2, 400), kinds, st.lists(st.integers(1, 150), min_size=1, max_size=5))
def test_they_are_those_of_numpy(seed, count, kind, sizes):
    values = numbers(seed, count, kind)
    some = np.sort(values[np.isfinite(values)])
    chunks = chunked(values, sizes)
    spread = spread_of(lambda: chunks)
    assert (spread.count, spread.lost) == (some.size, count - some.size)
    if not some.size:
        assert math.isnan(spread.mean)
        return
    scale = np.max(np.abs(some))
    assert spread.mean == pytest.approx(np.mean(some), rel=1e-12, abs=1e-12 * scale)
    wanted = np.std(some, ddof=1) if some.size > 1 else 0.0
    assert spread.deviation == pytest.approx(wanted, rel=1e-9, abs=1e-15 * scale)
    assert (spread.low, spread.high) == (some[0], some[-1])
    assert int(np.sum(spread.counts)) == some.size
    np.testing.assert_array_equal(order_statistics(lambda: chunks, spread, range(some.size)), some)
    if kind != "one value" and some[-1] > some[0]:
        edges, share = histogram(spread, 16)
        assert edges.size == 17
        assert np.sum(share) == pytest.approx(1.0)
        np.testing.assert_allclose(edges[[0, -1]], some[[0, -1]])


def test_nothing_but_lost_numbers_is_no_fault():
    spread = spread_of(lambda: [np.array([np.nan, np.inf]), np.array([])])
    assert (spread.count, spread.lost) == (0, 2)
    assert math.isnan(spread.mean)
    edges, share = histogram(spread, 4)
    assert edges.size == share.size + 1
    assert np.sum(share) == 0.0


def test_no_more_than_a_chunk_is_held_at_once():
    # 64 chunks that are made when asked for; what is kept of them must stay far below all of them.
    import tracemalloc

    size, count = 20_000, 32

    def chunks() -> Iterable[np.ndarray]:
        for k in range(count):
            yield np.random.default_rng(k).standard_normal(size)

    tracemalloc.start()
    spread = spread_of(chunks)
    found = order_statistics(chunks, spread, [320_000])
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert abs(found[0]) < 0.01
    # A chunk and what is made of it is 8 arrays at most, and the histogram two of 65,536.
    assert peak < 8 * (8 * size + 3 * 65_536) < 0.7 * 8 * size * count


@pytest.mark.parametrize(("passed", "samples"), [(0, 50), (1, 50), (47, 50), (50, 50), (9731, 10_000)])
def test_interval_of_a_share_is_that_of_clopper_and_pearson(passed, samples):
    # By the quantiles of the beta distribution, their own formula.
    found = share_interval(passed, samples)
    off = 0.5 * (1.0 - CONFIDENCE)
    low = stats.beta.ppf(off, passed, samples - passed + 1) if passed else 0.0
    high = stats.beta.ppf(1.0 - off, passed + 1, samples - passed) if passed < samples else 1.0
    assert found.value == passed / samples
    assert found.low == pytest.approx(low, rel=1e-9, abs=1e-12)
    assert found.high == pytest.approx(high, rel=1e-9)


@given(st.floats(0.5, 99.73), st.integers(1, 5000))
def test_ranks_of_a_percentile_are_in_order_and_within(percent, count):
    value, low, high = percentile_ranks(percent, count)
    assert 0 <= low <= value <= high < count
    # The percentile of the sample: as many at or below it, none fewer.
    assert value + 1 >= percent / 100.0 * count
    assert value < percent / 100.0 * count or value == 0


@pytest.mark.parametrize("percent", [1.0, 50.0, 95.0, 99.0, 99.73])
def test_interval_of_a_percentile_holds_it_as_often_as_it_says(percent):
    # Whatever the distribution, the chance that ranks low and high enclose the percentile is a sum of binomial
    # probabilities: at least what is claimed, and not far more but where numbers are few.
    p = percent / 100.0
    for count in (4096, 20_000, 100_000):
        _, low, high = percentile_ranks(percent, count)
        # The numbers below the percentile are binomial; they must be more than low and at most high.
        chance = stats.binom.cdf(high, count, p) - stats.binom.cdf(low, count, p)
        assert chance >= CONFIDENCE - 1e-12
        assert chance < CONFIDENCE + 0.03


@pytest.mark.slow
@pytest.mark.parametrize("percent", [50.0, 95.0, 99.73])
def test_interval_of_a_percentile_covers_in_simulation(percent):
    draw = np.random.default_rng(12)
    count, times = 4096, 2000
    _, low, high = percentile_ranks(percent, count)
    true = stats.norm.ppf(percent / 100.0)
    held = 0
    for _ in range(times):
        ordered = np.sort(draw.standard_normal(count))
        held += bool(ordered[low] <= true <= ordered[high])
    assert held / times > CONFIDENCE - 4.0 * math.sqrt(CONFIDENCE * (1.0 - CONFIDENCE) / times)
    assert held / times < CONFIDENCE + 0.03


@dataclass
class Held:
    """A store in memory."""

    values: np.ndarray
    names: tuple[str, ...] = ("a", "b")
    chunk: int = 100
    read: list[int] = field(default_factory=list)

    @property
    def study(self) -> Any:
        @dataclass
        class Samples:
            samples: int

        return Samples(len(self.values))

    def columns(self, name: str) -> Iterable[np.ndarray]:
        for at in range(0, len(self.values), self.chunk):
            yield self.values[at : at + self.chunk, self.names.index(name)]

    def tables(self) -> Iterable[np.ndarray]:
        for at in range(0, len(self.values), self.chunk):
            yield self.values[at : at + self.chunk]


def test_summary_is_that_of_all_numbers_at_once():
    values = np.random.default_rng(3).normal([1.0, 20.0], [0.1, 3.0], (2010, 2))
    lost = np.arange(2010) % 200 == 7
    values[lost, 1] = np.nan
    summary = summarise(Held(values), [Limit("a", at_most=1.1), Limit("b", 15.0, 24.0), Limit("c", 3.0)])
    assert summary.samples == 2010
    assert [one.name for one in summary.quantities] == ["a", "b"]
    for one, column in zip(summary.quantities, values.T, strict=True):
        some = column[np.isfinite(column)]
        half = stats.norm.ppf(0.975) * np.std(some, ddof=1) / math.sqrt(some.size)
        assert one.mean.value == pytest.approx(np.mean(some), rel=1e-12)
        assert one.mean.high - one.mean.value == pytest.approx(half, rel=1e-9)
        assert one.spread.lost == column.size - some.size
        assert tuple(one.percentiles) == PERCENTS
        for percent, interval in one.percentiles.items():
            assert interval.value == np.percentile(some, percent, method="inverted_cdf")
            assert interval.low <= interval.value <= interval.high
    # A reducer without an answer is not within its limit.
    short, inside = values[:, 0] <= 1.1, (values[:, 1] >= 15.0) & (values[:, 1] <= 24.0)
    a, b, both = summary.yields
    assert (a.limit, both.limit) == (Limit("a", at_most=1.1), None)
    assert a.share.value == np.mean(short)
    assert b.share.value == np.mean(inside)
    assert both.share.value == np.mean(short & inside)


def test_one_limit_has_one_yield_and_none_has_none():
    values = np.random.default_rng(3).normal(1.0, 0.1, (30, 2))
    assert [one.limit for one in summarise(Held(values), [Limit("a", 1.0)]).yields] == [Limit("a", 1.0)]
    assert summarise(Held(values), []).yields == ()


def test_a_quantity_without_any_answer_says_so():
    values = np.full((30, 2), np.nan)
    values[:, 0] = 1.0
    summary = summarise(Held(values), [Limit("b", at_most=1.0)])
    assert summary.yields[0].share.value == 0.0
    assert summary.quantities[1].spread.lost == 30
    assert math.isnan(summary.quantities[1].percentiles[50.0].value)
    assert summary.quantities[0].percentiles[50.0].value == 1.0
