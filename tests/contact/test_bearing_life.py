"""Rating life of roller bearings against ISO 281:2007 and the rule of Palmgren and Miner.

Source: ISO 281:2007, Table 7 (f_c of radial roller bearings, by D_we cos α/D_pw, printed with one decimal), 7.3 and
9.3.3. Tolerance of Table 7: half a unit of its last digit, and 0.001 for its own rounding to the nearest.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import (
    LoadCase,
    RollerSet,
    basic_rating_life,
    crank_bearing_life,
    equivalent_load,
    life_factor,
    life_of_all,
    reference_viscosity,
)
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.errors import LoadError
from cycloid_profile.modification import Equidistant, modify

TABLE_7 = {
    0.01: 52.1, 0.02: 60.8, 0.03: 66.5, 0.04: 70.7, 0.05: 74.1, 0.06: 76.9, 0.07: 79.2, 0.08: 81.2, 0.09: 82.8,
    0.10: 84.2, 0.11: 85.4, 0.12: 86.4, 0.13: 87.1, 0.14: 87.7, 0.15: 88.2, 0.16: 88.5, 0.17: 88.7, 0.18: 88.8,
    0.19: 88.8, 0.20: 88.7, 0.21: 88.5, 0.22: 88.2, 0.23: 87.9, 0.24: 87.5, 0.25: 87.0, 0.26: 86.4, 0.27: 85.8,
    0.28: 85.2, 0.29: 84.5, 0.30: 83.8,
}  # fmt: skip
OMEGA = 15.0 * 2.0 * math.pi / 60.0


@pytest.mark.parametrize(("ratio", "f_c"), TABLE_7.items())
def test_rating_factor_is_that_of_table_7(ratio, f_c):
    # Three rollers of 1 mm × 1 mm leave b_m f_c 3^(3/4) of the formula.
    rating = RollerSet(3, 1.0, 1.0, 1.0 / ratio).dynamic_load_rating
    assert rating / (1.1 * 3.0**0.75) == pytest.approx(f_c, abs=0.051)


def test_load_rating_goes_with_number_length_and_size():
    rating = RollerSet(10, 3.0, 9.0, 23.0).dynamic_load_rating
    assert RollerSet(20, 3.0, 9.0, 23.0).dynamic_load_rating == pytest.approx(2.0**0.75 * rating)
    assert RollerSet(10, 3.0, 18.0, 23.0).dynamic_load_rating == pytest.approx(2.0 ** (7.0 / 9.0) * rating)
    # All lengths doubled: 7/9 + 29/27 = 50/27.
    assert RollerSet(10, 6.0, 18.0, 46.0).dynamic_load_rating == pytest.approx(2.0 ** (50.0 / 27.0) * rating)


def test_static_rating_and_fatigue_limit():
    rollers = RollerSet(16, 3.0, 9.0, 23.0)
    assert rollers.static_load_rating == pytest.approx(44.0 * (20.0 / 23.0) * 16 * 27.0)
    assert rollers.fatigue_load_limit == pytest.approx(rollers.static_load_rating / 8.2)
    large = RollerSet(30, 30.0, 60.0, 400.0)
    assert large.fatigue_load_limit == pytest.approx(large.static_load_rating / 8.2 / 2.0)


spectra = st.lists(st.floats(1.0, 1e4), min_size=1, max_size=20).map(np.array)


@given(spectra, st.floats(1e3, 1e5))
def test_equivalent_load_uses_up_life_as_the_spectrum_does(force, rating):
    # Palmgren and Miner: every pose turns for an equal share of all revolutions.
    used = np.mean(1.0 / basic_rating_life(rating, force))
    assert float(basic_rating_life(rating, equivalent_load(force))) == pytest.approx(1.0 / used, rel=1e-9)
    assert np.mean(force) * (1.0 - 1e-12) <= equivalent_load(force) <= np.max(force) * (1.0 + 1e-12)


def test_rating_life_is_a_million_turns_at_the_load_rating():
    assert float(basic_rating_life(13e3, 13e3)) == pytest.approx(1e6)
    assert float(basic_rating_life(13e3, 6.5e3)) == pytest.approx(1e6 * 2.0 ** (10.0 / 3.0))
    assert basic_rating_life(13e3, [0.0, 1.0])[0] == math.inf


@given(st.lists(st.floats(10.0, 1e6), min_size=1, max_size=8))
def test_all_bearings_survive_their_common_life_in_nine_of_ten_sets(lives):
    # Weibull with the slope 9/8: each survives a life of L with the probability 0.9^((L/L10)^(9/8)).
    common = life_of_all(lives)
    assert math.prod(0.9 ** ((common / each) ** 1.125) for each in lives) == pytest.approx(0.9, rel=1e-9)
    assert common <= min(lives) * (1.0 + 1e-12)


def test_reference_viscosity():
    assert reference_viscosity(1000.0, 100.0) == pytest.approx(4500.0 / math.sqrt(1e5))
    assert reference_viscosity(600.0, 23.0) == pytest.approx(45_000.0 * 600.0**-0.83 / math.sqrt(23.0))
    # The two branches of the standard meet within 3 % at 1000 rpm.
    assert reference_viscosity(999.999, 23.0) == pytest.approx(reference_viscosity(1000.0, 23.0), rel=0.03)


@given(st.floats(0.1, 4.0), st.floats(0.0, 5.0))
def test_life_factor_rises_with_film_and_cleanliness(kappa, ratio):
    here = life_factor(kappa, ratio)
    # At κ = 0.1 the printed constants, which the standard rounds, leave 0.09990 to 0.09994.
    assert 0.09989 <= here <= 50.0 * (1.0 + 1e-12)
    assert life_factor(min(1.1 * kappa, 4.0), ratio) >= here * (1.0 - 1e-4)
    assert life_factor(kappa, 1.1 * ratio) >= here * (1.0 - 1e-4)


def test_life_factor_is_continuous_and_bounded():
    # The printed constants of neighbouring branches agree in three digits.
    for kappa in (0.4, 1.0):
        assert life_factor(kappa * (1.0 - 1e-12), 0.5) == pytest.approx(life_factor(kappa, 0.5), rel=2e-3)
    assert life_factor(1.0, 0.0) == pytest.approx(0.1)
    assert life_factor(4.0, 5.0) == pytest.approx(50.0)
    assert life_factor(9.0, 0.3) == life_factor(4.0, 0.3)
    assert math.isnan(life_factor(0.09, 0.3))
    # By hand at κ = 1: 0.1 (1 − (1.5859 − 1.2348)·0.3^0.4)^−9.185.
    assert life_factor(1.0, 0.3) == pytest.approx(0.1 * (1.0 - 0.3511 * 0.3**0.4) ** -9.185)


def test_life_of_the_crank_bearings_by_hand(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    turn = 2.0 * math.pi * np.arange(61) / 61
    stage = StageEquilibrium().at(case, turn)
    found = crank_bearing_life(stage, OMEGA, 13_000.0)
    assert found.speed_rpm == pytest.approx(600.0)
    assert found.equivalent_load.shape == found.life_h.shape == (2, 3)
    for disc, bearing in np.ndindex(2, 3):
        force = np.abs(stage.stage.bearing_force[:, disc, bearing])
        used = np.mean((force / 13_000.0) ** (10.0 / 3.0)) * 600.0 * 60.0 / 1e6
        assert found.life_h[disc, bearing] == pytest.approx(1.0 / used, rel=1e-12)
    assert found.life_of_all_h < found.least_life_h == pytest.approx(np.min(found.life_h))
    # Tangential force of the torque alone, 412 N·m over two discs and three cranks on 36 mm.
    assert np.all(found.equivalent_load > 412e3 / (2 * 3 * 36.0))
    assert np.all(np.isinf(crank_bearing_life(stage, 0.0, 13_000.0).life_h))


def test_one_turn_of_the_crank_holds_the_spectrum_of_a_turn_of_the_output(rv40e, rated_torque):
    # Over a turn of the output all bearings pass through the same loads; one turn of the crank has them spread over
    # the bearings, which differ by 2 % within it.
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    one = 2.0 * math.pi * np.arange(241) / 241
    whole = 39.0 * 2.0 * math.pi * np.arange(4001) / 4001
    spread = crank_bearing_life(StageEquilibrium().at(case, one), OMEGA, 13e3)
    equal = crank_bearing_life(StageEquilibrium().at(case, one), OMEGA, 13e3, equal_bearings=True)
    turn = crank_bearing_life(StageEquilibrium().at(case, whole), OMEGA, 13e3)
    assert 0.01 < np.ptp(spread.equivalent_load) / np.mean(spread.equivalent_load) < 0.03
    np.testing.assert_allclose(equal.equivalent_load, turn.equivalent_load, rtol=1e-5)


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"diameter": 0.0}, "diameter"),
        ({"length": math.nan}, "length"),
        ({"diameter": 8.0}, "diameter"),
        ({"diameter": 0.2}, "diameter"),
        ({"pitch_diameter": -4.0}, "diameter"),
        ({"count": 25}, "count"),
        ({"count": 0}, "count"),
    ],
)
def test_impossible_rollers_are_refused(change, what):
    with pytest.raises(LoadError) as caught:
        RollerSet(**{"count": 16, "diameter": 3.0, "length": 9.0, "pitch_diameter": 23.0, **change})
    assert caught.value.what == f"rollers: {what}"
    assert caught.value.exit_code == 2


def test_rollers_that_just_touch_are_possible():
    # 24 rollers of a chord of D_pw sin(π/24).
    room = 23.0 * math.sin(math.pi / 24)
    assert RollerSet(24, 0.9999 * room, 9.0, 23.0).count == 24
    with pytest.raises(LoadError):
        RollerSet(24, 1.0001 * room, 9.0, 23.0)


def test_life_without_bearing_forces_or_rating_is_refused(rv40e, rated_torque):
    case = LoadCase(rv40e, rv40e.theoretical_profile, rated_torque)
    with pytest.raises(LoadError, match="StageEquilibrium"):
        crank_bearing_life(Equilibrium(2).solve(case), OMEGA, 13e3)
    with pytest.raises(LoadError, match="load_rating"):
        crank_bearing_life(StageEquilibrium(2).solve(case), OMEGA, 0.0)
