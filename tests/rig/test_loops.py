"""Physics of the hysteresis loop: friction as a play operator, and loops whose numbers are known beforehand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cycloid_profile.effects import transmitted_torque
from cycloid_profile.errors import MeasurementError
from cycloid_profile.rig import backlash_map, evaluate_loop, hysteresis_loop
from cycloid_profile.rig.hysteresis import torque_path
from cycloid_profile.units import ARCMIN, NEWTON_METRE

torques = arrays(np.float64, st.integers(1, 40), elements=st.floats(-1e6, 1e6))
coulombs = st.floats(0.0, 2e5)
shares = st.floats(0.0, 0.9)
sides = st.sampled_from([-1.0, 1.0])


@given(torques, coulombs, shares, sides)
def test_friction_holds_back_no_more_than_it_can(torque, coulomb, share, before):
    left = transmitted_torque(torque, coulomb, share, before)
    band = coulomb + share * np.abs(torque)
    assert np.all(np.abs(torque - left) <= band * (1.0 + 1e-12) + 1e-9)


@given(torques, coulombs, sides)
def test_the_stage_moves_only_when_it_is_pushed(torque, coulomb, before):
    left = transmitted_torque(torque, coulomb, 0.0, before)
    moved = np.diff(left, prepend=math.copysign(coulomb, before))
    going = moved != 0.0
    # It then hangs behind by the whole friction, on the side it comes from.
    np.testing.assert_allclose((torque - left)[going], np.sign(moved[going]) * coulomb, atol=1e-9)


@given(torques, coulombs, shares, sides)
def test_friction_is_symmetric_in_direction(torque, coulomb, share, before):
    there, back = (
        transmitted_torque(torque, coulomb, share, before),
        transmitted_torque(-torque, coulomb, share, -before),
    )
    np.testing.assert_array_equal(there, -back)


@given(torques, coulombs, shares, sides)
def test_speed_and_stops_do_not_matter(torque, coulomb, share, before):
    # Points in between and rests change nothing of what is reached.
    between = np.interp(np.arange(0.0, torque.size - 0.75, 0.25), np.arange(torque.size), torque)
    found = transmitted_torque(np.repeat(between, 2), coulomb, share, before)[1::8]
    np.testing.assert_allclose(found, transmitted_torque(torque, coulomb, share, before), atol=1e-6)


@given(torques, sides)
def test_without_friction_the_stage_feels_it_all(torque, before):
    np.testing.assert_array_equal(transmitted_torque(torque, 0.0, 0.0, before), torque)


@given(st.integers(1, 9), st.sampled_from([10, 20, 50]))
def test_the_loop_of_a_play_operator_has_its_area(tenths, per_side):
    # Peak 1, friction c: from 1 − c down to −(1 − c), after a rest of 2c: ∮T dleft = 2c · 2(1 − c). The steps are whole
    # parts of c, so that the corners are points.
    c = 0.5 * tenths / 10.0
    steps = np.arange(10 * per_side + 1) / (10.0 * per_side)
    path = np.concatenate([2.0 * steps - 1.0, (1.0 - 2.0 * steps)[1:], (2.0 * steps - 1.0)[1:]])[10 * per_side :]
    left = transmitted_torque(path, c, 0.0, 1.0)
    area = abs(np.trapezoid(path, left))
    assert area == pytest.approx(4.0 * c * (1.0 - c), rel=1e-9)


def test_friction_in_proportion_opens_the_loop_towards_its_ends():
    path = torque_path(1.0, 400)
    top, bottom = int(np.argmax(path)), int(np.argmin(path))
    left = transmitted_torque(path, 0.0, 0.1)
    width = left[top:bottom][::10] - np.interp(path[top:bottom][::10], path[bottom:], left[bottom:])
    # Falling it feels T + 0.1|T|, rising T − 0.1|T|: apart by 0.2|T|, until the end of the path holds it.
    torque = path[top:bottom][::10]
    free = np.abs(torque) < 0.8
    np.testing.assert_allclose(width[free], 0.2 * np.abs(torque[free]), atol=1e-3)


PEAK, STIFFNESS, STEP, WIDTH = 400.0, 50.0, 0.7, 0.2


def centre(torque):
    """A spring with a step of STEP between ∓3 %."""
    return torque / STIFFNESS + 0.5 * STEP * np.clip(torque / (0.03 * PEAK), -1.0, 1.0)


def branch(torque, side):
    """Rising (−1) or falling (+1): apart by WIDTH at zero and closed at both ends."""
    return centre(torque) + 0.5 * side * WIDTH * (1.0 - np.abs(torque) / PEAK)


def synthetic(shares_of_peak, sides_of_branch):
    torque = PEAK * np.asarray(shares_of_peak)
    return torque, branch(torque, np.asarray(sides_of_branch))


UP = np.array([-1.0, -0.8, -0.5, -0.2, -0.03, 0.0, 0.03, 0.2, 0.5, 0.8, 1.0])
DOWN = UP[::-1]
VIRGIN = np.array([0.0, 0.03, 0.5])


def path_of(*pieces):
    """Shares of the peak and side of the branch of pieces of a loop put together."""
    share = np.concatenate(pieces)
    side = np.concatenate([np.full(piece.size, 1.0 if piece[-1] < piece[0] else -1.0) for piece in pieces])
    return share, side


@pytest.mark.parametrize(
    "pieces",
    [
        pytest.param((VIRGIN, DOWN, UP), id="from zero"),
        pytest.param((DOWN, UP), id="from the top"),
        pytest.param((UP, DOWN, UP), id="from the bottom, a turn and a half"),
        pytest.param((VIRGIN, DOWN, UP, DOWN), id="one branch more"),
        pytest.param((VIRGIN, DOWN, UP, DOWN, UP), id="two turns"),
        pytest.param((DOWN, UP, DOWN[:6]), id="stops on the way"),
        pytest.param((UP, DOWN), id="from the bottom and back"),
        pytest.param((-VIRGIN, UP, DOWN), id="the other way round"),
        pytest.param((UP[5:], DOWN, UP[:6]), id="from zero to zero"),
        pytest.param((DOWN[5:], UP, DOWN[:6]), id="from zero to zero, the other way round"),
    ],
)
def test_figures_of_a_loop_that_is_known(pieces):
    found = evaluate_loop(*synthetic(*path_of(*pieces)))
    assert found.lost_motion == pytest.approx(STEP + 2.0 * 0.03 * PEAK / STIFFNESS, abs=1e-9)
    assert found.hysteresis_loss == pytest.approx(WIDTH, abs=1e-9)
    # From half to full torque the branch runs T/k and closes by half of what it is open there, a quarter of WIDTH.
    rise = 0.5 * PEAK / STIFFNESS + 0.25 * WIDTH
    assert found.torsional_rigidity == pytest.approx(0.5 * PEAK / rise, abs=1e-9)
    # ∮ θ dT: the width falls to nothing at both ends.
    assert found.loss_energy == pytest.approx(PEAK * WIDTH, abs=1e-9)
    low, high = found.centreline
    assert (low, high) == pytest.approx((centre(-0.03 * PEAK), centre(0.03 * PEAK)), abs=1e-9)
    assert found.zero == pytest.approx((-0.5 * WIDTH, 0.5 * WIDTH), abs=1e-9)


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3), st.floats(-10.0, 10.0))
def test_figures_go_with_their_units_and_know_no_zero(torque_unit, angle_unit, zero):
    torque, angle = synthetic(*path_of(VIRGIN, DOWN, UP))
    plain = evaluate_loop(torque, angle)
    found = evaluate_loop(torque_unit * torque, angle_unit * (angle + zero))
    assert found.lost_motion == pytest.approx(angle_unit * plain.lost_motion, rel=1e-9)
    assert found.hysteresis_loss == pytest.approx(angle_unit * plain.hysteresis_loss, rel=1e-9)
    assert found.torsional_rigidity == pytest.approx(plain.torsional_rigidity * torque_unit / angle_unit, rel=1e-9)


@pytest.mark.parametrize(
    "pieces",
    [
        pytest.param((VIRGIN, DOWN), id="never back"),
        pytest.param((UP,), id="one branch"),
        pytest.param((DOWN,), id="one branch down"),
        pytest.param((UP[5:], DOWN[:6]), id="one side"),
        pytest.param((0.4 * UP, DOWN, 0.4 * UP), id="back not halfway"),
    ],
)
def test_an_incomplete_loop_is_refused(pieces):
    with pytest.raises(MeasurementError, match="does not run from one end to the other and back") as refused:
        evaluate_loop(*synthetic(*path_of(*pieces)))
    assert "0 → +T → −T → +T" in refused.value.remedy


def test_a_still_bench_is_refused():
    with pytest.raises(MeasurementError):
        evaluate_loop(np.zeros(10), np.zeros(10))


def test_torque_path_goes_both_ways_and_closes_up_about_zero():
    path = torque_path(412.0, 400)
    assert path[0] == 0.0
    assert (np.max(path), np.min(path), path[-1]) == (412.0, -412.0, 412.0)
    assert 380 <= path.size <= 420
    steps = np.abs(np.diff(path))
    assert steps[0] < 0.15 * np.max(steps)
    # Three branches, each in one direction.
    assert np.count_nonzero(np.diff(np.sign(np.diff(path)))) == 2


def test_loop_without_friction_is_one_line_but_for_the_backlash(drawn):
    loop = hysteresis_loop(drawn)
    np.testing.assert_array_equal(loop.torque, loop.stage_torque)
    found = evaluate_loop(loop.torque, loop.angle)
    # Afloat it rests where it was pushed last: the branches part by the backlash at zero torque, and nowhere else.
    touch = backlash_map(drawn, 1).value[0]
    assert found.hysteresis_loss == pytest.approx(touch, rel=2e-3)
    pressed = np.abs(loop.torque) > 0.01 * drawn.case.torque
    top, bottom = int(np.argmax(loop.torque)), int(np.argmin(loop.torque))
    down = np.interp(loop.torque[bottom:], loop.torque[top : bottom + 1][::-1], loop.angle[top : bottom + 1][::-1])
    np.testing.assert_allclose(loop.angle[bottom:][pressed[bottom:]], down[pressed[bottom:]], atol=1e-12)
    # Published for this drive without series compliance: 0.851′ and 558 N·m/′ between half and full torque.
    assert found.lost_motion / ARCMIN == pytest.approx(0.851, abs=2e-3)
    assert found.torsional_rigidity * ARCMIN / NEWTON_METRE == pytest.approx(558.0, rel=0.01)


def test_friction_opens_the_loop_by_its_torque_over_the_stiffness(built_with, drawn):
    # Where the stage is loaded each branch lags by the friction over the tangent stiffness.
    rubbing = hysteresis_loop(built_with({"name": "coulomb_friction", "torque_nm": 7.0}))
    plain = hysteresis_loop(drawn)
    top, bottom = int(np.argmax(plain.torque)), int(np.argmin(plain.torque))
    at = 0.5 * drawn.case.torque
    down = np.interp(at, rubbing.torque[top:bottom][::-1], rubbing.angle[top:bottom][::-1])
    up = np.interp(at, rubbing.torque[bottom:], rubbing.angle[bottom:])
    width = np.interp([at + 7e3, at - 7e3], plain.torque[bottom:], plain.angle[bottom:])
    assert down - up == pytest.approx(width[0] - width[1], rel=1e-3)
    # Both branches move equally: the centreline, and with it lost motion, hardly does.
    lost = [evaluate_loop(loop.torque, loop.angle).lost_motion for loop in (rubbing, plain)]
    assert lost[0] == pytest.approx(lost[1], rel=0.05)


def test_the_loop_starts_on_the_side_of_the_preceding_load(drawn):
    up, down = (hysteresis_loop(drawn, before=before).angle for before in (-1.0, 1.0))
    assert down[0] - up[0] == pytest.approx(backlash_map(drawn, 1).value[0], rel=2e-3)
    np.testing.assert_array_equal(up[1:], down[1:])


def test_series_compliance_softens_the_loop(built_with, drawn):
    soft = hysteresis_loop(built_with({"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0}))
    stiff = hysteresis_loop(drawn)
    k = [evaluate_loop(loop.torque, loop.angle).torsional_rigidity * ARCMIN / NEWTON_METRE for loop in (soft, stiff)]
    assert 1.0 / k[0] == pytest.approx(1.0 / k[1] + 1.0 / 134.0, rel=1e-6)
