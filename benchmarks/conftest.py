"""The load case of all benchmarks, and how two sides of a ratio are timed in one run."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import cycloid_profile as cp
from benchmarks.rv40e import loaded_rv40e


@pytest.fixture(scope="session")
def rv40e() -> cp.LoadCase:
    return loaded_rv40e()


@pytest.fixture
def side_by_side(benchmark: BenchmarkFixture) -> Callable[..., Any]:
    """Times ``ours`` with pytest-benchmark and ``plain`` right before each of its rounds.

    Both sides then see the same machine, whatever else runs on it; the table takes the least of each.
    ``row`` goes with the times into the JSON: what ``table.py`` needs for one line.
    """

    def run(ours: Callable[[], Any], plain: Callable[[], Any], rounds: int, **row: Any) -> Any:
        seconds = []

        def before() -> None:
            start = perf_counter()
            plain()
            seconds.append(perf_counter() - start)

        answer = benchmark.pedantic(ours, setup=before, rounds=rounds, warmup_rounds=1)
        benchmark.extra_info.update(row, plain_seconds=seconds)
        return answer

    return run
