"""Backlash of many reducers: closed forms, the exact contact of random reducers, and scatter that lowers the mean.

What is left of exact contact when gaps are linear: tooth and pin slide past each other by s while the gap changes, so
that a foot on a curve of relative radius R has moved s²/2R off its tangent. With every error in sight at most E, the
disc turns by E/l to meet it, which carries its flanks r_p/l·E along at the lever l; s ≤ (1 + r_p/l)·E.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.mesh import gaps, mesh, output_turn
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import tolerances_of, typical_tolerances
from cycloid_profile.tolerance.model import unit_changes
from cycloid_profile.tolerance.model._crank_locked import (
    CrankLockedBacklash,
    crank_locked_backlash,
    pose_count,
    sparse_columns,
)
from cycloid_profile.tolerance.study import Draws
from cycloid_profile.units import ARCMIN, UM

POSES = 13
COUNT = 4096
FLANKS = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 6.0}},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 6.0}},
    {"name": "equidistant_error", "each": "disc", "amount_um": {"plus_minus": 6.0}},
    {"name": "disc_runout", "each": "disc", "amplitude_um": {"plus_minus": 6.0}},
    {"name": "cumulative_pitch_error", "each": "disc", "amplitude_um": {"plus_minus": 6.0}},
)
BODIES = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 6.0}},
    {"name": "crank_hole_error", "each": ["disc", "crank"], "amplitude_um": {"plus_minus": 6.0}},
    {"name": "crank_eccentricity_error", "each": ["disc", "crank"], "amount_um": {"plus_minus": 6.0}},
)


def of(reducer: AsBuiltReducer, tolerances, poses: int = POSES) -> CrankLockedBacklash:
    return crank_locked_backlash(reducer, unit_changes(reducer, tolerances), poses)


# Closed forms.


def test_one_normal_error_of_all_discs_makes_normal_backlash(small, scattered):
    tolerances = scattered({"name": "equidistant_error", "amount_um": {"sigma": 2.0}})
    stage = of(small, tolerances)
    drawn = np.max(stage.by_pose(np.zeros((1, 1))), axis=1)[0]
    backlash = np.max(stage.by_pose(Draws(tolerances).coordinates(0, COUNT, 0)), axis=1)
    # Eq. 32: 2/(a z_c) a unit; the pin that touches first stands next to ψ0, where the lever is a little less.
    longest = small.case.drive.trochoid.longest_lever
    slope = (np.max(stage.by_pose(np.ones((1, 1))), axis=1)[0] - drawn) / UM
    assert 2.0 / longest <= slope < 1.02 * 2.0 / longest
    assert stats.kstest(backlash, stats.norm(drawn, slope * 2.0 * UM).cdf).statistic < 1.63 / math.sqrt(COUNT)
    assert np.mean(backlash) == pytest.approx(drawn, abs=4.0 * slope * 2.0 * UM / math.sqrt(COUNT))


def ideal(reducer: AsBuiltReducer, contacts: int) -> CrankLockedBacklash:
    """Every contact of both flanks as near as all others, each with an error of its own: 1 rad a unit."""
    return CrankLockedBacklash(
        reducer, np.zeros((contacts, 2)), sparse_columns(list(np.eye(2 * contacts)), 2 * contacts),
        np.tile(np.arange(contacts)[:, np.newaxis], 2), np.ones((1, 2, contacts)),
    )  # fmt: skip


# Mean range of n standard normal numbers d2 (Tippett 1925; ISO 7870-2), three decimals.
D2 = {2: 1.128, 5: 2.326, 10: 3.078, 25: 3.931}


@pytest.mark.parametrize("contacts", D2)
def test_backlash_of_equal_contacts_is_that_of_the_least_of_them(small, contacts):
    # The least of n on either flank: on average d2/2 below the drawing, each distributed as 1 − (1 − Φ)^n.
    stage = ideal(small, contacts)
    x = np.random.default_rng(contacts).standard_normal((20_000, 2 * contacts))
    backlash = np.max(stage.by_pose(x), axis=1)
    assert np.mean(backlash) == pytest.approx(-D2[contacts], abs=0.0005 + 4.0 * np.std(backlash) / math.sqrt(len(x)))
    x[:, 1::2] = 0.0
    least = np.max(stage.by_pose(x), axis=1)
    found = stats.kstest(least, lambda v: 1.0 - stats.norm.sf(v) ** contacts)
    assert found.statistic < 1.63 / math.sqrt(len(x))


drives = st.builds(
    lambda pins, share, thickness, discs, gap: as_drawn(_case(pins, share, thickness, discs, gap)),
    st.integers(8, 16), st.floats(0.3, 0.75), st.floats(0.2, 0.4), st.integers(1, 2), st.floats(0.01, 0.03),
)  # fmt: skip


def _case(pins: int, share: float, thickness: float, discs: int, gap: float) -> LoadCase:
    trochoid = Trochoid(pins, 2.0 * pins, share * 2.0)
    drive = Drive(trochoid, thickness * 2.0 * math.pi, 8.0, discs, CentralEccentric(2e4))
    return LoadCase(drive, modify(drive.theoretical_profile, Equidistant(gap)), 5e3)


@settings(max_examples=4)
@given(drives, st.floats(2.0, 6.0), st.integers(0, 10**6))
def test_pins_out_of_place_lower_the_mean_backlash(reducer, sigma, seed):
    given = {"name": "pin_position_error", "each": "pin", "amplitude_um": {"sigma": sigma}}
    tolerances = tolerances_of([given], [], reducer)
    stage = of(reducer, tolerances, 5)
    x = Draws(tolerances, seed).coordinates(0, 200, 0)
    drawn = stage.by_pose(np.zeros((1, x.shape[1])))
    there, back = stage.by_pose(x), stage.by_pose(-x)
    # A least of straight lines is concave: an error and its opposite together never gain, whatever they are.
    assert np.all(there + back <= 2.0 * drawn + 1e-15)
    assert np.mean(there) + np.mean(back) < 2.0 * np.mean(drawn)


# Exact contact.


def exact_backlash(reducer: AsBuiltReducer, crank: np.ndarray, moved: np.ndarray | None = None) -> np.ndarray:
    """Turn of all discs together between first touches of either flank, by the exact gaps, shape (poses,) [rad].

    NaN where a pin near root or tip, with hardly any lever, keeps the discs from ever touching with the others.
    ``moved``: displacement of each disc as complex and its rotation, shape (poses, discs, 2).
    """
    drive = reducer.case.drive
    meshing = mesh(drive.trochoid, crank, drive.discs)
    off = np.zeros((len(crank), drive.discs, 2), dtype=complex) if moved is None else moved
    radius = drive.pin_radius + reducer.pin_oversize
    touches = []
    for way in (1.0, -1.0):
        turn = np.zeros(len(crank))
        for _ in range(30):
            step = np.full(len(crank), np.inf)
            for j, tooth in enumerate(reducer.teeth):
                rotation = (turn + off[:, j, 1].real)[:, np.newaxis]
                seen = gaps(tooth, radius, meshing.disc(j), off[:, j : j + 1, 0], rotation, reducer.pin_shift)
                arm = way * seen.lever
                stops = arm > 0.05 * drive.trochoid.longest_lever
                closing = np.where(stops, seen.gap, np.inf) / np.where(stops, arm, 1.0)
                step = np.minimum(step, np.min(closing, axis=(1, 2)))
            turn += way * step
            if np.max(np.abs(step)) < 1e-14:
                break
        touches.append(np.where(np.abs(step) < 1e-14, way * turn, np.nan))
    return touches[0] + touches[1]


def seated(reducer: AsBuiltReducer, crank: np.ndarray) -> np.ndarray:
    """Where bores on eccentrics that are off put each disc, equal bearings, no load: shape (poses, discs, 2).

    The rigid motion that leaves the least squares between bores and eccentrics, written out for bores evenly round.
    """
    drive = reducer.case.drive
    count, discs = reducer.cranks, drive.discs
    carrier = np.exp(-1j * crank / drive.trochoid.lobes)[:, np.newaxis]
    place = drive.support.circle_radius * np.exp(2j * np.pi * np.arange(count) / count) * carrier
    moved = np.zeros((len(crank), discs, 2), dtype=complex)
    for j in range(discs):
        eccentric = reducer.eccentric_shift[j] * np.exp(1j * (crank + 2.0 * np.pi * j / discs))[:, np.newaxis]
        wish = eccentric - reducer.bore_shift[j] * carrier
        moved[:, j, 0] = np.mean(wish, axis=1)
        moved[:, j, 1] = np.mean((np.conj(1j * place) * wish).real, axis=1) / drive.support.circle_radius**2
    return moved


@pytest.mark.parametrize(
    ("tables", "seed"),
    [(FLANKS, 1), (BODIES, 3), *(pytest.param(*more, marks=pytest.mark.slow) for more in ((FLANKS, 2), (BODIES, 4)))],
)
def test_linear_gaps_are_exact_to_the_square_of_the_errors(small, scattered, made_with, tables, seed):
    tolerances = scattered(*tables)
    stage = of(small, tolerances)
    trochoid = small.case.drive.trochoid
    crank = output_turn(trochoid, stage.poses)
    x = Draws(tolerances, seed).coordinates(0, 1, 0)
    factors, errors = np.array([1.0, 0.25, 0.125, 0.0625]), []
    for factor in factors:
        reducer = made_with(small, tolerances, factor * x[0])
        wanted = exact_backlash(reducer, crank, seated(reducer, crank))
        errors.append(np.abs(stage.by_pose(factor * x)[0] - wanted))
    size = 4.0 * 6.0 * UM  # four errors of ±6 µm meet at a contact
    slides = (1.0 + trochoid.pin_circle_radius / trochoid.longest_lever) * size
    radius = 1.0 / np.max(np.abs(1.0 / small.case.drive.pin_radius + 1.0 / 3.0))
    assert np.max(errors[0]) < 2.0 * slides**2 / (2.0 * radius) / trochoid.longest_lever
    # Half the errors leave a quarter of it, and less while another pin is still the first in the larger of both.
    mean = [np.sqrt(np.mean(error**2)) for error in errors]
    assert np.polyfit(np.log(factors[1:]), np.log(mean[1:]), 1)[0] > 1.8


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_largest_backlash_of_an_rv40e_is_exact_to_a_fiftieth_of_an_arcminute(large, made_with, seed):
    # All the errors of a good workshop that teeth, pins and cranks have, at 47 poses.
    tolerances = typical_tolerances(large)
    stage = of(large, tolerances, 47)
    crank = output_turn(large.case.drive.trochoid, stage.poses)
    x = Draws(tolerances, seed).coordinates(0, 2, 0)
    drawn = np.max(stage.by_pose(np.zeros_like(x[:1])), axis=1)[0]
    for one, worst in zip(x, np.max(stage.by_pose(x), axis=1), strict=True):
        reducer = made_with(large, tolerances, one)
        wanted = exact_backlash(reducer, crank, seated(reducer, crank))
        assert np.sum(np.isfinite(wanted)) >= 44
        # Five of six are within 0.0015′; where so much scatters that pins next to the root stop the disc, it is more.
        assert worst == pytest.approx(np.nanmax(wanted), abs=0.02 * ARCMIN)
        assert abs(worst - drawn) > 0.03 * ARCMIN


def test_drawing_alone_is_its_exact_backlash(small, scattered):
    stage = of(small, scattered(FLANKS[0]))
    crank = output_turn(small.case.drive.trochoid, stage.poses)
    np.testing.assert_allclose(stage.by_pose(np.zeros((1, 11)))[0], exact_backlash(small, crank), rtol=0.0, atol=1e-13)


# How it is computed.


def by_pose_plainly(stage: CrankLockedBacklash, x: np.ndarray) -> np.ndarray:
    """Backlash at each pose in plain numpy, shape (reducers, poses) [rad]."""
    matrix = stage.by_unit.toarray().reshape(*stage.base.shape, -1)
    turn = np.min(stage.base + np.einsum("cfx,rx->rcf", matrix, x), axis=1)
    return turn[:, : stage.poses] + turn[:, stage.poses :]


def test_compiled_is_the_plain_reference(small):
    tolerances = typical_tolerances(small)
    stage = of(small, tolerances)
    x = Draws(tolerances).coordinates(0, 45, 0)
    whole = stage.by_pose(x)
    np.testing.assert_allclose(whole, by_pose_plainly(stage, x), rtol=0.0, atol=1e-16)
    # A reducer has the same answer to the last bit, whatever others are computed next to it.
    np.testing.assert_array_equal(stage.by_pose(x[7:20]), whole[7:20])
    np.testing.assert_array_equal(stage.by_pose(x[3:4]), whole[3:4])


@pytest.mark.parametrize(
    "tables",
    [FLANKS, (*FLANKS, {"name": "single_tooth_error", "each": ["disc", "lobe"], "amount_um": {"plus_minus": 3.0}})],
)
def test_extremes_are_those_of_very_many_poses(small, scattered, tables):
    # 24 poses a turn of the crank, and interpolation between them, against 600 of them.
    tolerances = scattered(*tables)
    lobes = small.case.drive.trochoid.lobes
    x = Draws(tolerances, 5).coordinates(0, 40, 0)
    found = of(small, tolerances, 24 * lobes).extremes(x) / ARCMIN
    every = of(small, tolerances, 600 * lobes).by_pose(x) / ARCMIN
    wanted = np.stack([np.max(every, axis=1), np.min(every, axis=1)], axis=1)
    coarse = of(small, tolerances, 47).by_pose(x) / ARCMIN
    missed = wanted - np.stack([np.max(coarse, axis=1), np.min(coarse, axis=1)], axis=1)
    off = found - wanted
    # A tenth of what 47 poses miss, on average and for each reducer.
    assert np.all(np.abs(np.mean(off, axis=0)) < 0.1 * np.abs(np.mean(missed, axis=0)))
    assert np.all(np.sqrt(np.mean(off**2, axis=0)) < 0.2 * np.sqrt(np.mean(missed**2, axis=0)))


def test_extremes_of_a_reducer_do_not_depend_on_the_others(small):
    tolerances = typical_tolerances(small)
    stage = of(small, tolerances, 120)
    x = Draws(tolerances).coordinates(0, 140, 0)
    whole = stage.extremes(x)
    np.testing.assert_array_equal(stage.extremes(x[7:20]), whole[7:20])
    np.testing.assert_array_equal(stage.extremes(x[135:136]), whole[135:136])


def test_gradient_is_the_difference_of_backlash(small, backlash_gradient):
    tolerances = typical_tolerances(small)
    stage = of(small, tolerances)
    x = Draws(tolerances).coordinates(0, 3, 0)
    gradient = backlash_gradient(stage, x)
    ways = np.random.default_rng(1).standard_normal((5, x.shape[1]))
    for one, own in zip(x, gradient, strict=True):
        for way in ways:
            step = 1e-7
            found = (
                np.max(stage.by_pose((one + step * way)[np.newaxis]), axis=1)
                - np.max(stage.by_pose((one - step * way)[np.newaxis]), axis=1)
            ) / 2.0
            assert found[0] / step == pytest.approx(own @ way, rel=1e-5, abs=1e-10)


def test_a_central_eccentric_has_no_misfits_and_still_an_answer():
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    reducer = as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 5e3))
    tolerances = typical_tolerances(reducer)
    assert not {"crank_hole_error", "crank_eccentricity_error"} & {one.kind.name for one in tolerances.scatters}
    stage = of(reducer, tolerances)
    assert np.all(np.max(stage.by_pose(Draws(tolerances).coordinates(0, 9, 0)), axis=1) > 0.0)


@given(st.integers(2, 60), st.integers(20, 2000))
def test_poses_are_no_multiple_of_an_order(about, orders):
    number = pose_count(about, orders)
    assert number >= about
    assert math.gcd(number, orders) == 1 or orders % number != 0
    assert all(number % d for d in range(2, int(math.sqrt(number)) + 1))
