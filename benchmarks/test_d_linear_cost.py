"""(d) Cost is linear in the poses: times for the slope in log-log that the table fits, results kept whole."""

from __future__ import annotations

import pytest
from pytest_benchmark.fixture import BenchmarkFixture

import cycloid_profile as cp

POSES = (1_000, 3_000, 10_000, 30_000, 100_000)
SOLVERS: dict[str, cp.Equilibrium | cp.StageEquilibrium] = {
    "1 unknown": cp.Equilibrium(),
    "whole stage": cp.StageEquilibrium(),
}


@pytest.mark.parametrize("poses", POSES)
@pytest.mark.parametrize("name", SOLVERS)
def test_linear_cost(benchmark: BenchmarkFixture, rv40e: cp.LoadCase, name: str, poses: int) -> None:
    crank_angle = cp.output_turn(rv40e.drive.trochoid, poses)

    # The small ones last milliseconds and are easily disturbed.
    rounds = 2 if poses > 30_000 else 5
    answer = benchmark.pedantic(lambda: SOLVERS[name].at(rv40e, crank_angle), rounds=rounds, warmup_rounds=1)

    benchmark.extra_info.update(linear_cost=name, poses=poses)
    assert answer.converged
