"""(b) Nonlinear load sharing with one unknown against a plain loop over poses with a bracketing root finder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import cycloid_profile as cp
from benchmarks.touched import TouchedDisc
from cycloid_profile.contact.disc.equilibrium import balance_moments, balance_moments_numpy

POSES = 10_000
LOOPED = 200  # poses of the plain loop, spread over all
SOME = range(0, POSES, POSES // LOOPED)


@pytest.fixture(scope="module")
def disc(rv40e: cp.LoadCase) -> TouchedDisc:
    return TouchedDisc(rv40e, POSES)


@pytest.mark.parametrize("threads", ["all cores", "one thread"])
def test_compiled(side_by_side: Callable[..., Any], disc: TouchedDisc, threads: str) -> None:
    numba = pytest.importorskip("numba")
    before = numba.get_num_threads()
    if threads == "one thread":
        numba.set_num_threads(1)
    answer = side_by_side(
        ours=lambda: balance_moments(disc.law, disc.contact, disc.gap, disc.lever, disc.torque),
        plain=lambda: disc.looped(SOME),
        rounds=25,
        row=f"(b) load sharing, 1 unknown, 10,000 poses × 40 pins, gaps given: `balance_moments`, numba on {threads}",
        against="`brentq` pose by pose, same law",
        figure="loop / ours",
        poses=POSES,
        looped=LOOPED,
        least=300.0,
    )
    numba.set_num_threads(before)

    np.testing.assert_allclose(answer.rotation[SOME], disc.looped(SOME), rtol=1e-8)


def test_in_numpy(side_by_side: Callable[..., Any], disc: TouchedDisc) -> None:
    answer = side_by_side(
        ours=lambda: balance_moments_numpy(disc.law, disc.contact, disc.gap, disc.lever, disc.torque),
        plain=lambda: disc.looped(SOME),
        rounds=15,
        row="(b) the numpy reference of the tests: `balance_moments_plainly`",
        against="that loop",
        figure="loop / ours",
        poses=POSES,
        looped=LOOPED,
        least=300.0,
    )

    np.testing.assert_allclose(answer.rotation[SOME], disc.looped(SOME), rtol=1e-8)


def test_with_exact_gaps(side_by_side: Callable[..., Any], disc: TouchedDisc, rv40e: cp.LoadCase) -> None:
    answer = side_by_side(
        ours=lambda: cp.Equilibrium().at(rv40e, disc.crank_angle),
        plain=lambda: disc.looped(SOME),
        rounds=7,
        row="(b) first touch, exact gaps, balance, pressures: `Equilibrium().at`",
        against="that loop, still with the gaps given",
        figure="loop / ours",
        poses=POSES,
        looped=LOOPED,
    )

    np.testing.assert_allclose(answer.twist[SOME], disc.looped(SOME), rtol=1e-8)
