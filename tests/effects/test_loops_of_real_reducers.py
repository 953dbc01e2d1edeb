"""Twist in series that bends, creeps or slips part by part: closed forms, energy, and the rig that shows them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import apply_effects, as_drawn, effect_from_table, transmitted_torque
from cycloid_profile.effects.series import CreepTwist, PowerTwist
from cycloid_profile.measurement import HYSTERESIS, Measurement
from cycloid_profile.rig import LinearisedCurve, hysteresis_loop, lost_motion_map, predict_curve
from cycloid_profile.rig.hysteresis import torque_path
from cycloid_profile.units import ARCMIN, NEWTON_METRE

RATED = 412e3
POWER = {"name": "nonlinear_series_compliance", "twist_arcmin": 2.0, "exponent": 0.6}
CREEP = {"name": "viscoelastic_creep", "twist_arcmin": 1.5, "relaxation_share": 0.4}
SLIP = {"name": "elastoslide_friction", "torque_nm": 20.0, "spread": 0.8}


def test_creep_of_a_ramp_has_its_closed_form() -> None:
    # λ c' = A M/T − c under M = τ: c = (A/T)(τ − λ(1 − e^{−τ/λ})).
    twist, relaxation = 3e-4, 0.3 * RATED
    torque = np.linspace(0.0, RATED, 57)
    expected = twist / RATED * (torque + relaxation * np.expm1(-torque / relaxation))
    assert CreepTwist(twist, relaxation, RATED).along(torque, torque) == pytest.approx(expected, abs=1e-16)


@given(st.floats(0.02, 5.0), st.integers(3, 60))
def test_creep_is_that_of_an_integrator_for_any_path(share: float, points: int) -> None:
    rng = np.random.default_rng(points)
    torque = RATED * np.cumsum(rng.normal(0.0, 0.3, points))
    clock = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(torque)))]) + abs(torque[0])
    law = CreepTwist(1e-3, share * RATED, RATED)
    at, path = np.append(0.0, clock), np.append(0.0, torque)

    def rate(t: float, c: np.ndarray) -> np.ndarray:
        return (1e-3 * np.interp(t, at, path) / RATED - c) / (share * RATED)

    found = law.along(torque, torque)
    now = np.zeros(1)
    for i in range(points):
        if at[i + 1] > at[i]:
            now = solve_ivp(rate, (at[i], at[i + 1]), now, rtol=1e-9, atol=1e-14).y[:, -1]
        assert found[i] == pytest.approx(now[0], abs=1e-8 * np.max(np.abs(torque)) / RATED)


def test_creep_does_not_depend_on_how_often_a_path_is_read() -> None:
    law = CreepTwist(1e-3, 0.3 * RATED, RATED)
    coarse = torque_path(RATED, 40)
    fine = np.interp(np.linspace(0.0, coarse.size - 1.0, 8 * (coarse.size - 1) + 1), np.arange(coarse.size), coarse)
    assert law.along(fine, fine)[::8] == pytest.approx(law.along(coarse, coarse), abs=1e-15)


def test_fast_relaxation_is_a_spring_and_slow_relaxation_is_rigid() -> None:
    torque = torque_path(RATED)
    settled = CreepTwist(1e-3, RATED, RATED).settled(torque)
    fast, slow = (CreepTwist(1e-3, share * RATED, RATED).along(torque, torque) for share in (1e-6, 1e5))
    assert fast == pytest.approx(settled, abs=2e-8)
    assert np.max(np.abs(slow)) < 2e-8


@given(st.floats(1e-5, 1e-2), st.floats(0.02, 5.0))
def test_creep_takes_energy_and_never_gives_any(twist: float, share: float) -> None:
    torque = RATED * np.sin(np.linspace(0.0, 16.0 * math.pi, 3201))
    angle = CreepTwist(twist, share * RATED, RATED).along(torque, torque)
    last = slice(-401, None)
    assert np.trapezoid(torque[last], angle[last]) > 0.0


@given(st.floats(0.2, 5.0), st.floats(-2.0, 2.0))
def test_power_of_the_torque_is_odd_and_has_its_twist_at_rated_torque(exponent: float, share: float) -> None:
    law = PowerTwist(1e-3, exponent, RATED)
    there, back = (law.settled(np.array([sign * share * RATED])) for sign in (1.0, -1.0))
    assert there == -back
    assert law.settled(np.array([RATED])) == pytest.approx(1e-3, rel=1e-15)


def test_slip_without_spread_is_coulomb_friction() -> None:
    torque = torque_path(RATED)
    narrow = transmitted_torque(torque, 2e4, 0.02, -1.0, 1e-9)
    assert narrow == pytest.approx(transmitted_torque(torque, 2e4, 0.02), abs=1e-6)


@given(st.floats(0.01, 1.0))
def test_slip_after_a_reversal_follows_masings_rule(spread: float) -> None:
    # After a full reversal the share of sliders that slip again at a change u is that of a first loading at u/2.
    mean = 3e4
    first = np.linspace(0.0, 3.0 * mean, 400)
    virgin = first - _from_rest(first, mean, spread * mean)
    falling = np.concatenate([np.linspace(0.0, 10.0 * mean, 200), 10.0 * mean - 2.0 * first])
    left = transmitted_torque(falling, mean, 0.0, 1.0, spread * mean)[200:]
    held_back = (left - left[0]) - (falling[200:] - falling[200])
    assert held_back == pytest.approx(2.0 * virgin, abs=0.03 * mean)


def _from_rest(torque: np.ndarray, mean: float, spread: float) -> np.ndarray:
    """Torque transmitted on a first loading, from the integral over evenly spread slip torques."""
    slip = mean + spread * np.linspace(-1.0, 1.0, 4001)
    return np.mean(np.maximum(torque[:, np.newaxis] - slip, 0.0), axis=1)


def test_rig_shows_them_in_loops_and_settled_over_a_turn(case: LoadCase) -> None:
    drawn, soft = as_drawn(case), apply_effects(case, [effect_from_table(POWER), effect_from_table(CREEP)])
    before, after = hysteresis_loop(drawn), hysteresis_loop(soft)
    T = case.torque
    top = int(np.argmax(after.torque))
    power = 2.0 * ARCMIN
    late = CreepTwist(1.5 * ARCMIN, 0.4 * T, T).along(after.torque, after.torque)
    assert (after.angle - before.angle)[top] == pytest.approx(power + late[top], rel=1e-12)
    lost = lost_motion_map(soft, poses=12).value - lost_motion_map(drawn, poses=12).value
    assert lost == pytest.approx(2.0 * (power * 0.03**0.6 + 1.5 * ARCMIN * 0.03), rel=1e-9)
    assert after.figures.loss_energy > before.figures.loss_energy


def test_coulomb_and_elastoslide_friction_have_one_width_at_full_reversal(case: LoadCase) -> None:
    sharp = hysteresis_loop(
        apply_effects(case, [effect_from_table({"name": "coulomb_friction", "torque_nm": 20.0})])
    ).figures
    smooth = hysteresis_loop(apply_effects(case, [effect_from_table(SLIP)])).figures
    assert smooth.torsional_rigidity == pytest.approx(sharp.torsional_rigidity, rel=1e-3)
    assert smooth.loss_energy == pytest.approx(sharp.loss_energy, rel=0.02)


@pytest.mark.parametrize("table", [POWER, CREEP, SLIP], ids=lambda table: str(table["name"]))
def test_change_of_a_loop_is_that_of_the_exact_model(case: LoadCase, table: dict[str, object]) -> None:
    torque = torque_path(case.torque, 60) / NEWTON_METRE
    loop = Measurement(HYSTERESIS, {"torque_nm": torque, "angle_arcmin": np.zeros_like(torque)}, {})
    base = apply_effects(case, [effect_from_table({"name": "coulomb_friction", "torque_nm": 5.0})])
    first_order = LinearisedCurve(predict_curve(base, loop))
    after = effect_from_table(table).apply(base)
    exact = predict_curve(after, loop).value - predict_curve(base, loop).value
    rows = np.isfinite(exact)
    # Friction acts through the tangent of the stage, which stiffens over its band.
    slack = 0.12 * np.max(np.abs(exact[rows])) if table is SLIP else 1e-9
    assert first_order.change(after)[rows] == pytest.approx(exact[rows], abs=slack)


def test_twists_of_several_effects_add(case: LoadCase) -> None:
    both = apply_effects(case, [effect_from_table(POWER), effect_from_table(POWER)])
    one = apply_effects(case, [effect_from_table(replace_size(POWER, 4.0))])
    torque = np.linspace(-1.0, 1.0, 9) * case.torque
    assert both.series_twist(torque) == pytest.approx(one.series_twist(torque), rel=1e-14)
    assert replace(both, further_twists=()).series_twist(torque) == pytest.approx(np.zeros(9))
    assert math.isclose(both.further_twists[0].settled(np.array([case.torque]))[0], 2.0 * ARCMIN)


def replace_size(table: dict[str, object], size: float) -> dict[str, object]:
    return {**table, "twist_arcmin": size}
