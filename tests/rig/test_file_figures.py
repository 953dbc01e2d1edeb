"""Figures of files whose figures are known in closed form, read with noise, in either sense and over many cycles."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from cycloid_profile.effects import transmitted_torque
from cycloid_profile.measurement import HYSTERESIS, LOST_MOTION_MAP, TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import compared_figures, evaluate_loop, key_figures, measurement_residual
from cycloid_profile.rig.file_figures import LoopOfFile
from cycloid_profile.units import ARCMIN, NEWTON_METRE

# Spring STIFFNESS behind a play of ±PLAY, loaded beyond the rated torque; N·m and ′.
RATED, PEAK, STIFFNESS, PLAY, STEP = 400.0, 480.0, 100.0, 0.35, 1.0
LIGHT = 0.03 * RATED
PATHS = {
    "0 +T −T +T": (0.0, 1.0, -1.0, 1.0),
    "0 −T +T −T": (0.0, -1.0, 1.0, -1.0),
    "0 +T −T 0": (0.0, 1.0, -1.0, 0.0),
    "0 −T +T 0": (0.0, -1.0, 1.0, 0.0),
    "four cycles": (0.0, *(1.0, -1.0) * 4, 1.0),
    "four cycles the other way": (0.0, *(-1.0, 1.0) * 4, -1.0),
    "stops on the way": (1.0, -1.0, 1.0, -0.3),
}


def two_slope_loop(path: tuple[float, ...], friction: float) -> tuple[np.ndarray, np.ndarray]:
    """Torque [N·m] and angle [′] of play, spring and Coulomb friction along a path of shares of the peak."""
    legs = [np.linspace(a, b, round(abs(b - a) * PEAK / STEP) + 1)[1:] for a, b in pairwise(path)]
    torque = PEAK * np.concatenate([[path[0]], *legs])
    before = -math.copysign(1.0, torque[1] - torque[0])
    transmitted = transmitted_torque(torque, friction, 0.0, before)
    side = np.sign(transmitted)
    for row in np.flatnonzero(np.abs(transmitted) < 1e-9):
        side[row] = side[row - 1] if row else before
    return torque, transmitted / STIFFNESS + PLAY * side


def figures(torque: np.ndarray, angle: np.ndarray):
    return evaluate_loop(torque * NEWTON_METRE, angle * ARCMIN, RATED * NEWTON_METRE)


@pytest.mark.parametrize("noise", [0.0, 0.004], ids=["still", "noisy"])
@pytest.mark.parametrize("friction", [0.0, 7.0])
@pytest.mark.parametrize("path", PATHS.values(), ids=PATHS)
def test_a_loop_with_play_stiffness_and_friction(path, friction, noise) -> None:
    torque, angle = two_slope_loop(path, friction)
    rng = np.random.default_rng(1)
    of_angle, of_torque = noise * rng.standard_normal((2, torque.size))
    # The torque errs by as much, seen through the spring: it is not quite monotone then.
    found = figures(torque + STIFFNESS * of_torque, angle + of_angle)
    # Five standard deviations of a difference of two rows.
    within = 1e-9 + 5.0 * 2.0 * noise
    assert found.lost_motion / ARCMIN == pytest.approx(2.0 * (LIGHT / STIFFNESS + PLAY), abs=within)
    assert found.rigidity * ARCMIN / NEWTON_METRE == pytest.approx(
        np.full((2, 2), STIFFNESS), rel=1e-9 + within * STIFFNESS / (0.47 * RATED)
    )
    if friction:
        assert found.hysteresis_loss / ARCMIN == pytest.approx(2.0 * (friction / STIFFNESS + PLAY), abs=within)
        # The friction torque goes through twice the travel of the spring and the play; a jump of the play lies
        # between two rows, so that each branch errs by at most half a step of torque.
        travel = 2.0 * ((PEAK - friction) / STIFFNESS + PLAY)
        within_area = 2.0 * PLAY * STEP + 5.0 * 2.0 * noise * STEP * math.sqrt(4.0 * PEAK / STEP)
        assert found.loss_energy / NEWTON_METRE / ARCMIN == pytest.approx(2.0 * friction * travel, abs=within_area)
    assert not found.crossed


def test_many_cycles_leave_less_noise() -> None:
    spread = []
    for cycles in (1, 9):
        torque, angle = two_slope_loop((0.0, *(1.0, -1.0) * cycles, 1.0), 7.0)
        rng = np.random.default_rng(2)
        lost = [figures(torque, angle + 0.01 * rng.standard_normal(torque.size)).lost_motion for _ in range(60)]
        spread.append(np.std(lost) / ARCMIN)
    assert spread[1] == pytest.approx(spread[0] / 3.0, rel=0.35)


@pytest.mark.parametrize("reach", [(0.97, 0.98, 0.99), (0.99, 0.98, 0.97)], ids=["rising", "falling"])
def test_cycles_of_unequal_size_that_drift_keep_their_rigidity(reach) -> None:
    torque, angle = two_slope_loop((0.0, *(x for size in reach for x in (size, -size)), reach[0]), 7.0)
    drifted = angle + np.linspace(0.0, 0.5, torque.size)
    found = evaluate_loop(torque * NEWTON_METRE, drifted * ARCMIN, PEAK * NEWTON_METRE)
    # The drift within one sweep remains: a seventh of 0.5′ over twice the torque.
    assert found.rigidity * ARCMIN / NEWTON_METRE == pytest.approx(np.full((2, 2), STIFFNESS), rel=0.015)


def test_friction_that_holds_the_angle_leaves_no_figures() -> None:
    torque = PEAK * np.concatenate([np.linspace(a, b, 40)[1:] for a, b in ((0, 1), (1, -1), (-1, 1))])
    own = LoopOfFile(torque * NEWTON_METRE, RATED * NEWTON_METRE)
    assert np.all(np.isnan(own.of(np.zeros(torque.size))))
    (note,) = own.notes(np.zeros(torque.size))
    assert "does not change" in note


def test_friction_beyond_3_percent_hides_the_play() -> None:
    torque, angle = two_slope_loop((0.0, 1.0, -1.0, 1.0), 1.5 * LIGHT)
    found = figures(torque, angle)
    assert found.crossed
    assert found.lost_motion / ARCMIN == pytest.approx(2.0 * LIGHT / STIFFNESS, abs=1e-9)
    assert found.hysteresis_loss / ARCMIN == pytest.approx(2.0 * (1.5 * LIGHT / STIFFNESS + PLAY), abs=1e-9)


def test_rows_that_step_over_the_play_do_not_show_the_width() -> None:
    torque, angle = two_slope_loop((0.0, 1.0, -1.0, 1.0), 0.0)
    assert not figures(torque, angle).coarse
    apart = np.abs(np.mod(torque, 10.0) - 5.0) < 0.25
    assert figures(torque[apart], angle[apart]).coarse


def test_a_loop_below_the_rated_torque_has_no_rigidity_beyond() -> None:
    torque, angle = two_slope_loop((0.0, 1.0, -1.0, 1.0), 7.0)
    found = evaluate_loop(torque * NEWTON_METRE, angle * ARCMIN, 1.5 * PEAK * NEWTON_METRE)
    assert np.all(np.isfinite(found.rigidity[0]))
    assert np.all(np.isnan(found.rigidity[1]))
    assert math.isnan(found.torsional_rigidity)


def turn_file(amplitudes: dict[int, float], rows: int = 800, turn: float = 360.0) -> Measurement:
    angle = turn * np.arange(rows) / rows
    error = sum(size * np.cos(np.deg2rad(order * angle) + order) for order, size in amplitudes.items())
    columns = dict(zip(TRANSMISSION_ERROR.columns, (angle, error), strict=True))
    return Measurement(TRANSMISSION_ERROR, columns, {"torque_nm": "412"}, name="te.csv")


def test_orders_of_a_turn(drawn) -> None:
    sizes = {1: 0.8, 7: 3.0, 39: 0.5, 80: 2.0, 160: 0.9}
    found = compared_figures(measurement_residual(drawn, turn_file(sizes)))
    by_key = {one.name.key: one for one in found.figures}
    for order, size in sizes.items():
        figure = by_key[f"order_{order}_amplitude_arcsec"]
        assert figure.measured == pytest.approx(size, abs=1e-9)
        # Poses a pin pitch apart are identical: other orders than multiples of 40 cannot be predicted.
        assert figure.predicted == pytest.approx(0.0, abs=0.3 if order % 40 == 0 else 1e-9)
        assert figure.difference == figure.measured - figure.predicted
    titles = {key: one.name.title for key, one in by_key.items()}
    assert titles["order_1_amplitude_arcsec"].endswith("encoder")
    assert titles["order_121_amplitude_arcsec"].endswith("input")
    assert titles["order_160_amplitude_arcsec"].endswith("sun")
    assert titles["order_80_amplitude_arcsec"].startswith("order 80: 40·2")
    assert titles["order_7_amplitude_arcsec"] == "order 7"
    assert "peak_to_peak_arcsec" in by_key


def test_simulated_and_compared_figures_have_one_name_and_value(drawn) -> None:
    """``simulate --json`` and ``compare --json`` share their keys: a figure is the same number under both."""
    torque, angle = two_slope_loop((0.0, 1.0, -1.0, 1.0), 7.0)
    # Up to the rated torque: 3 % of the peak is then 3 % of that.
    torque *= drawn.case.torque / NEWTON_METRE / PEAK
    loop = Measurement(HYSTERESIS, {"torque_nm": torque, "angle_arcmin": angle}, {}, name="loop.csv")
    turn = turn_file({1: 0.8, 7: 3.0, 39: 0.5})
    for measured, shared in (
        (loop, {"lost_motion_arcmin", "hysteresis_loss_arcmin", "loss_energy_nm_arcmin"}),
        (turn, {"peak_to_peak_arcsec", *(f"order_{order}_amplitude_arcsec" for order in (1, 7, 39))}),
    ):
        simulated = key_figures(measured)
        compared = {
            one.name.key: one.measured for one in compared_figures(measurement_residual(drawn, measured)).figures
        }
        assert shared <= simulated.keys() & compared.keys()
        assert [compared[key] for key in shared] == pytest.approx([simulated[key] for key in shared], rel=1e-9)


def test_a_part_of_a_turn_has_no_orders(drawn) -> None:
    found = compared_figures(measurement_residual(drawn, turn_file({80: 1.0}, turn=200.0)))
    assert [one.name.key for one in found.figures] == ["peak_to_peak_arcsec"]
    assert "whole turn" in found.notes[0]


def test_noise_is_the_change_that_noise_makes(drawn) -> None:
    # The amplitude of an order of white noise has the mean square 4σ²/n.
    measured = turn_file({7: 3.0})
    noise = 0.2
    column = measured["error_arcsec"] + noise * np.random.default_rng(3).standard_normal(measured.rows)
    columns = dict(measured.columns) | {"error_arcsec": column}
    keys = dict(measured.keys) | {"noise_arcsec": str(noise)}
    residual = measurement_residual(drawn, Measurement(TRANSMISSION_ERROR, columns, keys))
    figure = next(one for one in compared_figures(residual).figures if one.name.key == "order_39_amplitude_arcsec")
    assert figure.noise == pytest.approx(2.0 * noise / math.sqrt(measured.rows), rel=0.3)


@pytest.mark.parametrize(
    ("share", "kind", "limited"),
    [
        (1.0, TRANSMISSION_ERROR, {"transmission_error_arcsec"}),
        (0.5, TRANSMISSION_ERROR, set()),
        (0.03, LOST_MOTION_MAP, {"lost_motion_arcmin"}),
        (0.5, LOST_MOTION_MAP, set()),
    ],
)
def test_a_limit_holds_at_its_torque(drawn, share, kind, limited) -> None:
    angle = 360.0 * np.arange(40) / 40
    columns = dict(zip(kind.columns, (angle, np.sin(angle)), strict=True))
    residual = measurement_residual(drawn, Measurement(kind, columns, {"torque_nm": str(share * 412.0)}))
    assert {one.name.limit for one in compared_figures(residual).figures if one.name.limit} == limited


def test_an_incomplete_loop_is_compared_without_figures(drawn) -> None:
    torque = np.linspace(0.0, 400.0, 30)
    columns = dict(zip(HYSTERESIS.columns, (torque, torque / 500.0), strict=True))
    found = compared_figures(measurement_residual(drawn, Measurement(HYSTERESIS, columns, {})))
    assert found.figures == ()
    assert "does not run from one end to the other and back" in found.notes[0]
