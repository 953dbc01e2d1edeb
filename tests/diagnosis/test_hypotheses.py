"""A hypothesis by itself: size, angle, their uncertainty, other lobe indices; and the error of the model."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cycloid_profile.diagnosis.data._loops import torque_since_reversal
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model._model_error import form_error_of_loop, hat_functions, mesh_orders
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates, chatter
from cycloid_profile.diagnosis.model.chatter_spectrum import SPEEDS
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.effects import CoulombFriction, removal_between
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.units import UM
from tests.diagnosis import blind
from tests.diagnosis.test_explanations import best_of
from tests.diagnosis.test_likelihood import library, reducer, residuals
from tests.diagnosis.test_moves import some

LOBES = 39


def polar(candidate: Candidate, x: np.ndarray) -> tuple[float, float]:
    values = candidate.parameters(x)
    return values[candidate.size], values[candidate.angle]


@pytest.mark.parametrize(("name", "waves"), [("disc_oval", 2), ("cumulative_pitch_error", 1)])
def test_two_coordinates_are_an_amplitude_and_an_angle(name, waves):
    (one,) = some(name, disc=1)
    x = 3.0 * np.array([math.cos(math.radians(250.0)), math.sin(math.radians(250.0))])
    assert polar(one, x) == pytest.approx((3.0, 250.0 / waves))
    # The same waves by coordinates: x·cos(wt) + y·sin(wt) is a cos(w(t − angle)).
    amplitude, angle = polar(one, x)
    t = np.linspace(0.0, 6.0, 50)
    wave = x[0] * np.cos(waves * t) + x[1] * np.sin(waves * t)
    np.testing.assert_allclose(amplitude * np.cos(waves * (t - math.radians(angle))), wave, atol=1e-12)


def test_uncertainty_is_that_of_many_draws():
    (oval,) = some("disc_oval", disc=1)
    spread, x = np.array([[0.004, 0.0015], [0.0015, 0.002]]), np.array([-1.2, 2.0])
    stated = oval.uncertainty(x, spread)
    draws = np.random.default_rng(4).multivariate_normal(x, spread, 20_000)
    sizes, angles = np.array([polar(oval, one) for one in draws]).T
    assert stated["amplitude_um"] == pytest.approx(np.std(sizes), rel=0.02)
    assert stated["phase_deg"] == pytest.approx(np.std(angles), rel=0.02)
    # A size of one coordinate, and the reciprocal of another.
    wear, series = some("flank_wear")[0], some("series_compliance")[0]
    assert series.inverse
    draws = np.random.default_rng(5).normal(0.02, 2e-4, 20_000)
    inverse = [series.parameters([one, 0.0])[series.size] for one in draws]
    assert series.uncertainty(np.array([0.02, 0.0]), np.diag([4e-8, 1.0])) == {
        series.size: pytest.approx(np.std(inverse), rel=0.02)
    }
    assert wear.uncertainty(np.array([1.0, 0.0]), np.diag([0.04, 1.0])) == {wear.size: pytest.approx(0.2)}
    # No angle is less certain than ±180°.
    assert oval.uncertainty(np.array([1e-6, 0.0]), np.eye(2))["phase_deg"] == pytest.approx(90.0)


@pytest.mark.parametrize("name", ["disc_oval", "cumulative_pitch_error", "wheel_wear_drift", "single_tooth_error"])
def test_the_form_of_a_disc_is_that_of_the_reindexed_effect(name):
    (one,) = some(name, disc=1)
    lobes, size = 5, np.array([1.2, 0.5 if one.angle else 0.0])
    choice, angle = one.reindexed(lobes, LOBES)
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ size
    tooth, other = reducer().teeth[0], replace(one, choice=choice)
    phase, lobe = np.full(LOBES, 0.4), np.arange(float(LOBES))
    here, there = (
        removal_between(tooth, of.effect(x).apply(reducer()).teeth[0], phase, lobe)
        for of, x in ((one, size), (other, turned if one.angle else size))
    )
    # The same error on lobes whose numbers are five higher, or five lower: some turn of the disc it must be.
    assert np.max(np.abs(here)) > 0.1 * UM
    np.testing.assert_allclose(np.roll(here, lobes), there, atol=1e-3 * np.max(np.abs(here)))


def test_waves_of_chatter_turn_with_every_wave():
    wave = chatter(100.25, 1, priors_of(reducer()))
    choice, angle = wave.reindexed(3, LOBES)
    assert choice == dict(wave.choice)
    assert abs(angle) == pytest.approx(100.25 * 2.0 * math.pi * 3 / LOBES)


def test_hats_are_a_partition_of_unity():
    x = np.array([0.0, 0.25, 1.0, 2.9, 3.0, 4.0])
    found = hat_functions(x, 5)
    np.testing.assert_allclose(found.sum(axis=1), 1.0)
    np.testing.assert_allclose(found @ np.arange(5.0), x)
    assert np.count_nonzero(found) == 2 + 2 + 4
    around = hat_functions(np.array([3.75, 0.5]), 4, periodic=True)
    np.testing.assert_allclose(around, [[0.75, 0.0, 0.0, 0.25], [0.5, 0.5, 0.0, 0.0]])


def test_torque_since_the_last_reversal():
    torque = np.array([0.0, 50.0, 100.0, 60.0, -20.0, -100.0, -70.0])
    direction = np.sign(np.diff(torque, prepend=-1.0))
    # From 100 N·m back by 40, 120 and 200, from −100 N·m by 30.
    np.testing.assert_array_equal(
        torque_since_reversal(torque, direction), [np.inf, np.inf, np.inf, 40.0, 120.0, 200.0, 30.0]
    )


def test_rows_of_a_loop_near_zero_and_after_a_reversal_are_omitted():
    text = blind.loop(blind.Reducer(), [], rows=501, noise=blind.Noise(0.001), seed=2)
    one = record(reducer(), parse_measurement(text, "loop.csv"))
    torque = one.measurement["torque_nm"] / 412.0
    # Up to the largest torque, down to its opposite and up again, in steps of a hundredth.
    since = np.full(torque.size, np.inf)
    for turn in (int(np.argmax(torque)), int(np.argmin(torque))):
        since[turn + 1 :] = np.abs(torque[turn + 1 :] - torque[turn])
    kept = np.zeros(torque.size, dtype=bool)
    kept[one.rows] = True
    clear = np.abs(np.abs(torque) - 0.05) > 0.006
    np.testing.assert_array_equal(kept[clear], ((np.abs(torque) > 0.05) & (since > 0.0499))[clear])


def test_orders_of_mesh_are_those_of_lobes_pins_and_both():
    found = mesh_orders(reducer().case.drive.trochoid)
    np.testing.assert_array_equal(found, sorted([*(39 * np.arange(1, 7)), *(40 * np.arange(1, 7)), 1560]))


@pytest.mark.parametrize("name", ["equidistant_error", "disc_oval", "wheel_wear_drift", "single_tooth_error"])
def test_tabulated_columns_of_a_scan_are_differences_of_the_removal(name):
    (one,), scan = some(name, disc=1), residuals("scan")
    fresh = Residuals(scan.recording, reducer(), FlankGrid(reducer()))
    column = fresh.columns([one])[:, 0]
    tooth = reducer().teeth[0]
    for c in range(one.coordinates):
        x = np.zeros(2)
        x[c] = 1e-3 * one.width
        after = one.effect(x).apply(reducer()).teeth[0]
        wanted = removal_between(tooth, after, fresh.phase, fresh.lobe) / UM * 1e3
        np.testing.assert_allclose(column[:, c], wanted, atol=5e-3 * np.max(np.abs(wanted)))
    assert one.coordinates == 2 or not np.any(column[:, 1])


def test_optimum_names_what_is_certain_and_what_is_implausible():
    oval, pitch = some("disc_oval", "cumulative_pitch_error", disc=1)
    best = replace(best_of([oval, pitch], [1.0, 0.0, 0.1, 0.2]), covariance=np.diag([0.04, 0.04, 0.09, 0.01]))
    # 5 standard deviations, and along (1, 2)/√5 a standard deviation of √(0.09 + 4·0.01)/√5 = 0.161: 1.39 of them.
    assert best.linearly_determined == [0]
    members, u = best.part([0])
    assert members == (oval,)
    np.testing.assert_array_equal(u, [1.0, 0.0])
    assert best.part([])[1].shape == (0,)
    assert not best.implausible
    assert replace(best, u=np.array([0.0, 0.0, 2.5, 2.5])).implausible
    assert best.remaining_member([pitch]) is oval
    assert best.remaining_member([oval, pitch]) is None
    assert best.remaining_member([some("flank_wear")[0]]) is None
    np.testing.assert_allclose(best.coordinates(1), pitch.width * np.array([0.1, 0.2]))
    np.testing.assert_allclose(best.covariance_of(-1), pitch.width**2 * np.diag([0.09, 0.01]))


def test_errors_of_all_discs_may_be_turned_by_half_a_turn():
    (ring, oval) = some("pin_ring_runout", "disc_oval", disc=1)
    everywhere = next(one for one in library(True) if one.name == "disc_runout" and one.choice.get("disc") is None)
    best = best_of([ring, oval, everywhere], [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    found = {tuple(m.name for m in members): other.u for members, other in best.rotated_by_180()}
    # The oval is of one disc, and the same after half a turn.
    assert set(found) == {("pin_ring_runout",), ("disc_runout",), ("pin_ring_runout", "disc_runout")}
    np.testing.assert_allclose(found[("disc_runout",)], [0.1, 0.2, 0.3, 0.4, -0.5, -0.6])
    np.testing.assert_allclose(found[("pin_ring_runout", "disc_runout")], [-0.1, -0.2, 0.3, 0.4, -0.5, -0.6])


def test_removals_of_an_effect_are_tabulated_once_for_all_files_and_states():
    class Counted(FlankGrid):
        times = 0

        def after(self, *of):
            self.times += 1
            return super().after(*of)

    oval, wear = *some("disc_oval", disc=1), *some("flank_wear", disc=1)
    shared, scan = Counted(reducer()), residuals("scan").recording
    model = ExactModel(reducer(), [scan, replace(scan, noise=replace(scan.noise, sigma=0.5))], shared)
    for state in (model.baseline, model.state([wear], np.array([0.5, 0.0]))):
        found = [one.columns([oval]) for one in state.residuals]
        np.testing.assert_array_equal(*found)
        assert np.any(found[0])
    assert shared.times == oval.coordinates
    # A model without a table of its own makes one.
    assert ExactModel(reducer(), [scan]).flank_grid.touches(oval, 0)


@pytest.mark.parametrize("waves", [100.0, 600.0, 1400.0])
@pytest.mark.parametrize("speed", SPEEDS)
def test_columns_of_short_waves_are_those_of_the_effect(waves, speed):
    # Tabulated where the grid resolves them, else one by one.
    scan, wave = residuals("scan"), chatter(waves, 1, priors_of(reducer()), speed)
    column = Residuals(scan.recording, reducer(), FlankGrid(reducer())).columns([wave])[:, 0]
    tooth = reducer().teeth[0]
    for c in (0, 1):
        x = 1e-3 * wave.width * np.eye(2)[c]
        after = wave.effect(x).apply(reducer()).teeth[0]
        wanted = removal_between(tooth, after, scan.phase, scan.lobe) / UM * 1e3
        np.testing.assert_allclose(column[:, c], wanted, atol=0.02 * np.max(np.abs(wanted)))


def test_effects_have_their_places_on_two_discs_three_cranks_forty_pins():
    curves, scan = (Counter(one.name for one in library(with_curves)) for with_curves in (True, False))
    both = Counter(one.name for one in candidates(reducer(), frozenset({0, 1}), False))
    # Disc 1, disc 2 or both; a scan shows its own disc, two scans also what the discs share.
    assert (curves["disc_oval"], scan["disc_oval"], both["disc_oval"]) == (3, 1, 3)
    # What is of one lobe is of one disc; the form of a runout has two kinds.
    assert (curves["single_tooth_error"], scan["single_tooth_error"]) == (2 * LOBES, LOBES)
    assert curves["disc_runout"] == 3 * 2
    # All cranks together or one of three; a hole is that of one crank in one disc.
    assert curves["crank_eccentricity_error"] == curves["crank_phase_error"] == 4 * 3
    assert (curves["crank_hole_error"], curves["planet_runout"]) == (3 * 2, 3)
    assert (curves["single_pin_error"], curves["pin_ring_oval"]) == (40, 1)
    for one in library(True):
        if one.name in ("crank_hole_error", "planet_runout", "single_pin_error", "single_tooth_error"):
            assert None not in one.choice.values()


def test_a_fit_is_given_up_only_if_it_cannot_reach_the_best():
    model = ExactModel(reducer(), [residuals("scan").recording])
    (one,) = some("equidistant_error", disc=1)
    best = model.optimum(Attempt((one,), np.array([0.1, 0.0])), 0.0)
    assert best.converged
    # Two whole steps and a short one away; steps are one prior width at most.
    start = best.u + np.array([2.04, 0.0])
    assert 20.0 < best.R[0, 0] * 0.04**2 < 180.0
    for ahead, reached in ((0.0, True), (40.0, True), (500.0, False)):
        again = model.optimum(Attempt((one,), start, beat=best.misfit - ahead), 0.0)
        assert (again is not None) == reached
        if again is not None:
            np.testing.assert_allclose(again.u, best.u, atol=0.2 / math.sqrt(best.R[0, 0]))
            assert again.misfit == pytest.approx(best.misfit, abs=0.05)
    # A gain of less than 40 in chi² is no reason for another step.
    early = model.optimum(Attempt((one,), best.u + np.array([0.01, 0.0]), least_gain=40.0), 0.0)
    assert early.converged
    assert best.misfit + 1.0 < early.misfit < best.misfit + 40.0
    # Cut short, it is no optimum.
    assert not model.optimum(Attempt((one,), start, steps=1), 0.0).converged


def test_friction_errs_after_a_reversal_until_it_pulls_the_other_way():
    # Friction of 10 N·m on a loop up to ±100 N·m without the rows within 5 N·m of its ends.
    torque = np.concatenate([np.arange(-100.0, 100.0), np.arange(100.0, -100.0, -1.0), np.arange(-100.0, 101.0)])
    branch = np.where(np.arange(torque.size) // 200 == 1, -1.0, 1.0)
    rows = np.flatnonzero(np.abs(torque) <= 95.0)
    rows = rows[rows > 200]
    loop = residuals("loop").recording
    measurement = replace(loop.measurement, columns={"torque_nm": torque, "angle_arcmin": torque})
    recording = replace(loop, measurement=measurement, rows=rows)
    passed = 100.0 + branch[rows] * torque[rows]
    for friction in (10.0, 0.0):
        through = 1e3 * (torque[rows] - friction * branch[rows])
        curve = SimpleNamespace(prediction=SimpleNamespace(terms=[SimpleNamespace(through=through)]))
        found = form_error_of_loop(10.0 * branch[rows], curve, recording)
        # While it sticks friction passes linearly from one side to the other: over 20 N·m, in other forms 10 or 30.
        for column, over in zip(found[:, -2:].T, (friction, 3.0 * friction), strict=True):
            triangle = 0.5 * 10.0 * branch[rows] * np.maximum(1.0 - passed / max(over, 1e-6), 0.0)
            # 5 N·m at either end have no rows.
            assert np.count_nonzero(triangle) == 2 * max(over - 5.0, 0.0)
            np.testing.assert_allclose(column, triangle, atol=1e-9)


def test_rows_of_a_loop_near_zero_on_the_stage_may_touch_either_flank():
    # Friction takes a part of the torque: rows that were away from zero come close to it on the stage.
    loop = residuals("loop")
    one = Residuals(loop.recording, CoulombFriction(torque_nm=60.0).apply(reducer()))
    torque = one.first_order.prediction.terms[0].through / 1e3
    margin = 0.05 * 412.0 + 0.25 * 60.0
    near = np.flatnonzero(np.abs(torque) < margin)
    assert 0 < near.size < torque.size
    angle = one.first_order.prediction.on_last_flank
    forwards, backwards = (np.median(angle[near[sign * torque[near] > 0.0]]) for sign in (1.0, -1.0))
    assert 0.0 < forwards - backwards < 0.5 * np.ptp(angle)
    wanted = np.zeros((torque.size, near.size))
    wanted[near, np.arange(near.size)] = (forwards - backwards) * (1.0 - np.abs(torque[near]) / margin)
    np.testing.assert_allclose(one.row_error, wanted, rtol=1e-9)
    assert loop.row_error.shape == (loop.residual.size, 0)


def test_the_path_of_a_printed_loop_errs_by_a_share_of_its_twist():
    # Hats along the path, or over the torque of either branch: constant and linear errors are among their sums.
    loop = residuals("loop")
    one = Residuals(loop.recording, replace(reducer(), quality="printed"))
    torque, size = loop.recording.measurement["torque_nm"], 0.04 * np.ptp(one.first_order.prediction.on_last_flank)
    path = np.cumsum(np.abs(np.diff(torque, prepend=torque[0])))[one.recording.rows]
    np.testing.assert_allclose(one.path_error.sum(axis=1), size)
    knots = 0.05 * np.max(np.abs(torque)) * np.arange(one.path_error.shape[1])
    np.testing.assert_allclose(one.path_error @ knots, size * path, rtol=1e-9)
    # A loop up to twice the torque: its knots are twice as far apart.
    for peak in (412.0, 824.0):
        found, knots = one.branch_error(peak), np.linspace(-peak, peak, 41)
        assert found.shape == (torque[one.recording.rows].size, 2 * knots.size)
        up, down = found[:, :41], found[:, 41:]
        assert not np.any(up.any(axis=1) & down.any(axis=1))
        np.testing.assert_allclose(found.sum(axis=1), size)
        np.testing.assert_allclose(found @ np.tile(knots, 2), size * torque[one.recording.rows], atol=1e-9 * peak)
    rising = np.gradient(torque)[one.recording.rows] > 0.0
    turning = np.abs(np.abs(torque[one.recording.rows]) - 412.0) < 1.0
    np.testing.assert_array_equal(up.any(axis=1)[~turning], rising[~turning])
    # Of a change the share of its own largest response; metal has no such error.
    later = one.under(replace(one.recording, later=True))
    (series,) = some("series_compliance")
    response = np.max(np.abs(later.columns([series.change])[:, 0, 0])) * 0.5
    grown = later.branch_error(412.0, [series.change], np.array([0.5, 0.0]))
    np.testing.assert_allclose(grown.sum(axis=1), 0.04 * response)
    assert loop.path_error.shape[1] == loop.branch_error(412.0).shape[1] == 0
