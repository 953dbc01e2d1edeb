"""Shapes of effects: defaults, limits and formulas of each family, written out here from the formulas of the tooth."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad, solve_ivp

from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.effects import (
    EFFECTS,
    apply_effects,
    as_drawn,
    chatter_angle,
    effect_from_table,
    parameters,
    shape_choices,
    transmitted_torque,
)
from cycloid_profile.effects.process import archard_depth
from cycloid_profile.errors import SpecError
from cycloid_profile.measurement import HYSTERESIS, Measurement
from cycloid_profile.rig import LinearisedCurve, hysteresis_loop, predict_curve
from cycloid_profile.rig.hysteresis import torque_path
from cycloid_profile.units import NEWTON_METRE

PINS, LOBES = 40, 39
R_P, R_RP, ECCENTRICITY, CLEARANCE = 64.0, 3.0, 1.3, 0.006
K1 = ECCENTRICITY * PINS / R_P
RADIUS = R_RP + CLEARANCE  # of the wheel that ground the tooth
PERIOD = 2.0 * math.pi * LOBES
PHASE = np.linspace(-3.0, PERIOD + 3.0, 4001)
UM = 1e-3
shaped = pytest.mark.parametrize("name", sorted(name for name, kind in EFFECTS.items() if kind.shapes))


def removed(reducer, phase=PHASE, disc: int = 0):
    """Removal beyond the parallel curve [mm]."""
    return reducer.teeth[disc].removal(phase).value


def tooth_point(phase):
    """Point of the ground tooth, x + iy, from the published formulas."""
    S = 1.0 / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(phase))
    i = PINS / LOBES
    outer, inner = np.exp(1j * (1.0 - i) * phase), np.exp(-1j * i * phase)
    return (R_P - RADIUS * S) * outer - (ECCENTRICITY - K1 * RADIUS * S) * inner


def speed(phase: float) -> float:
    """Length of the tooth curve per phase, from neighbouring points to sixth order."""
    step = 1e-3
    z = tooth_point(phase + step * np.arange(-3, 4))
    return float(abs(np.dot([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0], z)) / (60.0 * step))


def lever(phase):
    return np.sin(phase) / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(phase))


def smooth_step(x):
    u = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u * u)


def wrapped(x, period):
    return np.mod(x + 0.5 * period, period) - 0.5 * period


@shaped
def test_shapes_are_parameters_with_their_default_first(name, case) -> None:
    kind = EFFECTS[name]
    known = {p.name: p for p in parameters(kind)}
    size = next(p for p in known.values() if p.required)
    sizes: dict[str, Any] = {p.name: p.tolerance for p in known.values() if p.required}
    for key, values in kind.shapes.items():
        assert values[0] == getattr(kind, key)
        assert len(set(values)) == len(values) > 1
        assert known[key].tolerance is None
        assert not known[key].whole
    choices = shape_choices(kind)
    assert len(choices) == math.prod(len(values) for values in kind.shapes.values())
    assert kind(**sizes, **choices[0]) == kind(**sizes)
    for choice in choices:
        made = apply_effects(case, [kind(**sizes, **choice)])
        assert getattr(kind(**sizes, **choice), size.name) == size.tolerance
        assert len(made.teeth) == 2


def test_effects_without_shapes_have_one_empty_choice() -> None:
    assert shape_choices(EFFECTS["equidistant_error"]) == ({},)


def test_defaults_are_the_shapes_of_before(built_with) -> None:
    size = 2.0 * UM
    drift = built_with({"name": "wheel_wear_drift", "amount_um": 2.0, "first_lobe": 8})
    x = wrapped(PHASE - (2.0 * 7.0 - 1.0) * math.pi, PERIOD)
    assert removed(drift) == pytest.approx(-size * (x / PERIOD + 1.0 - smooth_step(x / 0.5)), abs=1e-15)
    chatter = built_with({"name": "grinding_chatter", "amplitude_um": 2.0, "waves_per_turn": 393, "phase_deg": 20.0})
    assert removed(chatter) == pytest.approx(size * np.cos(393 / 39 * PHASE - math.radians(20.0)), abs=1e-14)
    low = built_with({"name": "single_tooth_error", "amount_um": 2.0, "lobe": 3})
    from_tip = math.pi - np.abs(wrapped(PHASE - 4.0 * math.pi, PERIOD))
    assert removed(low) == pytest.approx(size * smooth_step(from_tip / 0.5), abs=1e-15)
    even = built_with({"name": "equidistant_error", "amount_um": 2.0})
    assert even.teeth[0].pin_radius == pytest.approx(RADIUS + size, abs=1e-15)
    assert not even.teeth[0].removals


def test_default_wear_is_pressure_times_sliding(built_with, case) -> None:
    worn = built_with({"name": "flank_wear", "amount_um": 2.0})
    shared = Equilibrium(poses=24).solve(case)
    psi = shared.phase.ravel()
    w = np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(psi))
    load = shared.pressure.ravel() * np.abs(R_P * w - R_RP)
    order = np.argsort(psi)
    grid = -math.pi + 2.0 * math.pi * np.arange(121) / 121
    depth = np.interp(grid, psi[order], load[order])
    assert removed(worn, grid) == pytest.approx(2.0 * UM * depth / np.max(depth), abs=1e-15)


@given(st.floats(0.0, 1.0), st.integers(1, LOBES))
def test_a_worn_wheel_can_begin_anywhere(share: float, lobe: int) -> None:
    made = effect_from_table(
        {"name": "wheel_wear_drift", "amount_um": 1.0, "first_lobe": lobe, "start_in_lobe": share, "blend_rad": 0.1}
    )
    (ramp,) = made._modified_tooth(_blank()).removals  # type: ignore[attr-defined]
    start = 2.0 * math.pi * (lobe - 1.5 + share)
    further = np.linspace(0.1, PERIOD - 0.1, 501)
    path = _blank().tooth.trochoid
    found = ramp.derivatives(start + further, np.ones_like(further), path).value
    # Even from nothing to the whole amount, but for the jump itself.
    assert found == pytest.approx(-UM * further / PERIOD, abs=1e-14)
    at = ramp.derivatives(np.array([start]), np.ones(1), path).value
    assert at == pytest.approx(-0.5 * UM, abs=1e-14)


def _blank():
    from cycloid_profile.effects.process import _Disc
    from cycloid_profile.geometry import ToothProfile, Trochoid

    tooth = ToothProfile(Trochoid(PINS, R_P, ECCENTRICITY), R_RP)
    return _Disc(tooth, 0.0, None)  # type: ignore[arg-type]


def test_the_end_of_one_lobe_is_the_start_of_the_next(built_with) -> None:
    table = {"name": "wheel_wear_drift", "amount_um": 2.0}
    end, start = built_with({**table, "start_in_lobe": 1.0}), built_with({**table, "first_lobe": 2})
    assert removed(end) == pytest.approx(removed(start), abs=1e-15)


@pytest.mark.parametrize("blend", [0.05, 0.2, 1.0, 1.5])
def test_a_lobe_ends_over_its_blend(built_with, blend: float) -> None:
    low = built_with({"name": "single_tooth_error", "amount_um": 2.0, "lobe": 5, "blend_rad": blend})
    from_tip = math.pi - np.abs(wrapped(PHASE - 8.0 * math.pi, PERIOD))
    assert removed(low) == pytest.approx(2.0 * UM * smooth_step(from_tip / blend), abs=1e-15)


def test_waves_of_a_steady_c_axis_are_even_in_the_polar_angle(built_with) -> None:
    table = {"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 393, "phase_deg": 20.0}
    made = built_with({**table, "constant_speed": "c_axis"})
    clockwise = -np.angle(tooth_point(PHASE))
    expected = 0.5 * UM * np.cos(393 * clockwise - math.radians(20.0))
    assert removed(made) == pytest.approx(expected, abs=1e-13)


def test_waves_of_a_steady_surface_are_even_in_the_arc_length(built_with) -> None:
    table = {"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 87, "phase_deg": 20.0}
    made = built_with({**table, "constant_speed": "surface"})
    lobe = quad(speed, 0.0, 2.0 * math.pi, epsabs=1e-10, limit=200)[0]
    phase = np.array([-2.0, 0.3, 1.0, 3.0, 4.0, 100.0])
    whole = np.floor(phase / (2.0 * math.pi))
    rest = phase - 2.0 * math.pi * whole
    length = whole * lobe + np.array([quad(speed, 0.0, x, epsabs=1e-10, limit=200)[0] for x in rest])
    expected = 0.5 * UM * np.cos(87 * 2.0 * math.pi * length / (LOBES * lobe) - math.radians(20.0))
    assert removed(made, phase) == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("speed_of", ["generating", "c_axis", "surface"])
def test_waves_pass_root_and_tip_of_every_lobe_equally(built_with, speed_of: str) -> None:
    # A wave for each lobe, crest at root and trough at tip: symmetry fixes these angles for each motion.
    made = built_with(
        {"name": "grinding_chatter", "amplitude_um": 1.0, "waves_per_turn": LOBES, "constant_speed": speed_of}
    )
    roots = 2.0 * math.pi * np.arange(LOBES)
    assert removed(made, roots) == pytest.approx(UM, abs=1e-14)
    assert removed(made, roots + math.pi) == pytest.approx(-UM, abs=1e-14)


def test_the_angle_of_chatter_is_known_by_its_motion(case) -> None:
    phase = np.linspace(-3.0, 3.0, 61)
    assert chatter_angle("generating", case.profile, phase) == pytest.approx(phase / LOBES, abs=1e-15)
    assert chatter_angle("c_axis", case.profile, phase) == pytest.approx(-np.angle(tooth_point(phase)), abs=1e-14)
    turn = np.array([PERIOD, 2.0 * PERIOD])
    assert chatter_angle("surface", case.profile, turn) == pytest.approx([2.0 * math.pi, 4.0 * math.pi], rel=1e-14)
    with pytest.raises(SpecError, match="is not a choice"):
        chatter_angle("clock", case.profile, phase)


def test_discs_ground_together_have_waves_in_one_frame(built_with) -> None:
    made = built_with(
        {"name": "grinding_chatter", "amplitude_um": 1.0, "waves_per_turn": 7, "constant_speed": "c_axis"}
    )
    # Disc 2 is mounted half a pitch on: its polar angles are larger by π/z_c in the frame of the carrier.
    clockwise = -np.angle(tooth_point(PHASE))
    expected = UM * np.cos(7 * (clockwise + math.pi / LOBES))
    assert removed(made, disc=1) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("flank", [1, 2])
@pytest.mark.parametrize("exponent", [0.5, 1.0, 1.5, 2.0])
def test_wear_by_the_lever(built_with, exponent: float, flank: int) -> None:
    table = {"name": "flank_wear", "amount_um": 2.0, "by": "lever", "exponent": exponent, "flank": flank}
    found = removed(built_with(table), phase := np.linspace(-math.pi, math.pi, 2001))
    side = 3 - 2 * flank
    expected = 2.0 * UM * np.maximum(side * lever(phase), 0.0) ** exponent
    # The spline rounds the edges of the flank, where no pin carries: by a point of it at least.
    inside = np.minimum(np.abs(phase), math.pi - np.abs(phase)) > 0.15
    assert found[inside] == pytest.approx(expected[inside], abs=2.0 * UM * 1e-4)
    assert found == pytest.approx(expected, abs=2.0 * UM * (0.12 if exponent < 1.0 else 0.02))


@pytest.mark.parametrize("exponent", [0.5, 1.5, 2.0])
def test_wear_follows_a_power_of_pressure_times_sliding(built_with, case, exponent: float) -> None:
    grid, depth = archard_depth(as_drawn(case))
    found = removed(built_with({"name": "flank_wear", "amount_um": 2.0, "exponent": exponent}), grid)
    assert found == pytest.approx(2.0 * UM * depth**exponent, abs=1e-15)


def test_more_load_wears_more_of_the_flank(case) -> None:
    shares = [0.1, 0.5, 1.0, 2.0, 5.0]
    widths = [np.mean(archard_depth(as_drawn(case), load_share=share)[1] > 0.0) for share in shares]
    assert np.all(np.diff(widths) > 0.0)
    heavier = replace(case, torque=2.0 * case.torque)
    assert archard_depth(as_drawn(heavier))[1] == pytest.approx(archard_depth(as_drawn(case), load_share=2.0)[1])


@pytest.mark.parametrize("flank", [1, 2])
def test_an_equidistant_error_of_one_flank_leaves_the_other(built_with, flank: int) -> None:
    made = built_with({"name": "equidistant_error", "amount_um": 2.0, "flank": flank})
    side = 3 - 2 * flank
    inside = np.linspace(0.3, math.pi - 0.3, 101)
    assert removed(made, side * inside) == pytest.approx(2.0 * UM, abs=1e-15)
    assert removed(made, -side * inside) == pytest.approx(0.0, abs=1e-15)
    # The loop opens on that side alone, by the gap over the lever a z_c at the first contact.
    drawn, opened = (hysteresis_loop(one).figures for one in (built_with(), made))
    moved = np.array(opened.centreline) - np.array(drawn.centreline)
    (of_flank, of_other) = (moved[1], moved[0]) if flank == 1 else (moved[0], moved[1])
    assert side * of_flank == pytest.approx(2.0 * UM / (ECCENTRICITY * LOBES), rel=0.05)
    assert abs(of_other) < 1e-3 * abs(of_flank)


RATED = 412e3


@given(st.floats(0.0, 0.3), st.floats(0.01, 10.0))
def test_break_away_of_one_is_coulomb_friction(share: float, travel: float) -> None:
    torque = torque_path(RATED, 100)
    slip = share * RATED
    assert transmitted_torque(torque, slip, 0.02, -1.0, 0.0, (0.0, travel)) == pytest.approx(
        transmitted_torque(torque, slip, 0.02), abs=1e-9
    )


@given(st.floats(0.0, 5.0), st.floats(0.05, 10.0))
def test_friction_after_a_reversal_is_that_of_its_formula(ratio: float, travel: float) -> None:
    slip = 0.1 * RATED
    torque = np.concatenate([np.linspace(0.0, 4.0 * RATED, 30), np.linspace(4.0 * RATED, -4.0 * RATED, 160)])
    stage = transmitted_torque(torque, slip, 0.0, -1.0, 0.0, ((ratio - 1.0) * slip, travel * slip))
    back, held = stage[29:], stage[29]
    assert held == pytest.approx(4.0 * RATED - slip, rel=1e-12)
    gap, slid = back - torque[29:], held - back
    moving = slid > 0.0
    expected = slip * (1.0 + (ratio - 1.0) * np.exp(-slid / (travel * slip)))
    assert gap[moving] == pytest.approx(expected[moving], rel=1e-9)
    # It sticks as long as the torque has not fallen by what held it and what breaks it away.
    sticks = torque[29:] > 4.0 * RATED - slip * (1.0 + ratio) * (1.0 + 1e-12)
    assert np.all(back[sticks] == held)
    assert np.all(gap <= np.max(expected) + 1e-6)


@given(st.floats(0.2, 3.0))
def test_slow_fall_does_not_depend_on_how_often_a_path_is_read(ratio: float) -> None:
    # Where friction falls less than the torque rises nothing snaps, and the path alone decides.
    slip = 0.05 * RATED
    coarse = torque_path(RATED, 40)
    fine = np.interp(np.linspace(0.0, coarse.size - 1.0, 8 * (coarse.size - 1) + 1), np.arange(coarse.size), coarse)
    added = ((ratio - 1.0) * slip, 4.0 * slip)
    few, many = (transmitted_torque(path, slip, 0.0, -1.0, 0.0, added) for path in (coarse, fine))
    assert many[::8] == pytest.approx(few, abs=1e-6 * RATED)


@given(st.floats(0.2, 1.8), st.floats(1.0, 10.0))
def test_the_path_is_that_of_an_integrator(ratio: float, travel: float) -> None:
    # While it slips, T − M = slip + added e^{−s/λ} with ds = dM: dM/dT = 1/(1 − added/λ e^{−s/λ}).
    slip = 0.1 * RATED
    added, length = (ratio - 1.0) * slip, travel * slip
    path = np.concatenate([[-RATED, 0.0], np.linspace(0.5, 1.0, 9) * RATED])
    start = slip * (1.0 + ratio)  # torque beyond −RATED where it breaks away
    found = transmitted_torque(path, slip, 0.0, 1.0, 0.0, (added, length))[2:]

    def rate(_: float, moved: np.ndarray) -> np.ndarray:
        return 1.0 / (1.0 - added / length * np.exp(-moved / length))

    held = -RATED + slip
    begin = -RATED + start
    solved = solve_ivp(rate, (begin, RATED), [0.0], t_eval=path[2:], rtol=1e-10, atol=1e-6).y[0]
    assert found == pytest.approx(held + solved, abs=1e-5 * RATED)


def test_break_away_opens_the_loop_after_reversals(case) -> None:
    table = {"name": "stribeck_friction", "torque_nm": 20.0}
    plain = hysteresis_loop(apply_effects(case, [effect_from_table({**table, "breakaway_ratio": 1.0})]))
    stuck = hysteresis_loop(apply_effects(case, [effect_from_table({**table, "breakaway_ratio": 2.0})]))
    coulomb = hysteresis_loop(apply_effects(case, [effect_from_table({"name": "coulomb_friction", "torque_nm": 20.0})]))
    assert plain.angle == pytest.approx(coulomb.angle, abs=1e-12)
    assert stuck.figures.loss_energy > plain.figures.loss_energy


def test_two_frictions_of_one_kind_are_one_of_their_sum(built_with) -> None:
    table = {"name": "stribeck_friction", "torque_nm": 2.0, "breakaway_ratio": 2.0, "travel_share": 3.0}
    twice, whole = built_with(table, table), built_with({**table, "torque_nm": 4.0})
    for name in ("coulomb_torque", "breakaway_torque", "breakaway_travel"):
        assert getattr(twice, name) == pytest.approx(getattr(whole, name), rel=1e-15)


def test_change_of_a_loop_by_break_away_is_that_of_the_exact_model(case) -> None:
    torque = torque_path(case.torque, 60) / NEWTON_METRE
    loop = Measurement(HYSTERESIS, {"torque_nm": torque, "angle_arcmin": np.zeros_like(torque)}, {})
    base = apply_effects(case, [effect_from_table({"name": "coulomb_friction", "torque_nm": 20.0})])
    after = effect_from_table({"name": "stribeck_friction", "torque_nm": 0.5}).apply(base)
    exact = predict_curve(after, loop).value - predict_curve(base, loop).value
    rows = np.isfinite(exact)
    change = LinearisedCurve(predict_curve(base, loop)).change(after)
    assert change[rows] == pytest.approx(exact[rows], abs=0.12 * np.max(np.abs(exact[rows])))
