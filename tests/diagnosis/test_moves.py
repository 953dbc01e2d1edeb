"""Steps of the search by themselves: the lobe index, seams, fewer rows, other parts, other sets, starts."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from cycloid_profile.diagnosis import Residuals
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library, linear_evidence, log_priors
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.whitened import Whitened, normal_equations
from cycloid_profile.diagnosis.search import _second_order as second
from cycloid_profile.diagnosis.search import on_other_parts
from cycloid_profile.diagnosis.search._fits import Fit, Fits, empty_fit
from cycloid_profile.diagnosis.search._proposals import Proposal, equations_about, linear_proposals
from cycloid_profile.diagnosis.search._starts import (
    _around,
    _best_of_each_variety,
    _directed,
    _symmetric,
    of_finite_size,
)
from cycloid_profile.diagnosis.search._subsampling import screening_subsample, smallest_subsample, subsample
from cycloid_profile.diagnosis.search.lobe_index import index_lobes, offsets_about, with_offsets
from cycloid_profile.diagnosis.search.seam import _power_from_each_lobe
from cycloid_profile.diagnosis.search.search import _Stage
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.rig import Settings, simulate
from tests.diagnosis import blind
from tests.diagnosis.test_likelihood import equations, library, reducer, residuals

LOBES = 39
PITCH = blind.Hidden("cumulative_pitch_error", {"amplitude_um": 3.0, "phase_deg": 70.0, "disc": 1})


@cache
def scanned(lobes: int) -> Residuals:
    """A scan of the pitch error, turned by some lobes on the machine."""
    text = blind.scan(
        blind.Reducer(), [PITCH], points=600, noise=blind.Noise(0.3), turn_deg=360.0 / LOBES * lobes, seed=lobes
    )
    return Residuals(record(reducer(), parse_measurement(text, f"scan {lobes}.csv")), reducer())


def test_a_second_scan_gets_the_lobe_index_of_the_first():
    lobes, flank_grid = 17, FlankGrid(reducer())
    files = [scanned(0), scanned(lobes)]
    first, other = index_lobes(reducer(), files, library(False), flank_grid)
    # Registration alone turns each scan by less than half a lobe.
    turned = (other.placed.turn - first.placed.turn) / (2.0 * math.pi) * LOBES
    assert turned % LOBES == pytest.approx(lobes, abs=0.02)
    assert first is files[0]
    # A single file has no other to agree with.
    assert index_lobes(reducer(), files[1:], library(False), flank_grid)[0] is files[1]
    # The same about an optimum with the effect.
    model = ExactModel(reducer(), [one.recording for one in files], flank_grid, files)
    known = Library(library(False), 2)
    pitch = next(one for one in known.candidates if one.name == PITCH.name)
    angle = math.radians(70.0)
    start = 3.0 / pitch.width * np.array([math.cos(angle), math.sin(angle)])
    best = ExactModel(reducer(), [files[0].recording], flank_grid, files[:1]).optimum(Attempt((pitch,), start), 0.0)
    offsets = offsets_about(model, known, best)
    again = with_offsets(model, offsets)
    assert offsets[0] == 0
    assert again.recordings[1].placed.turn == pytest.approx(other.placed.turn, abs=1e-4)
    assert with_offsets(model, (0, 0)) is model


def test_waves_may_begin_at_any_lobe():
    # Fall of χ² by cosine and sine of waves that run on through lobe 1 and break where they begin, one by one.
    one, waves = scanned(0), 100.4
    white = replace(one.recording, noise=Noise(0.3))
    block = Whitened(one.under(white))
    z, rows = block.projected(block.z), block.chosen
    of = (one.position[rows] // (2.0 * math.pi)).astype(int) % LOBES
    found = _power_from_each_lobe(block, z, waves, "generating", of, LOBES)
    for first in (0, 1, 20, 38):
        turn = one.position[rows] / LOBES - math.pi / LOBES
        angle = waves * (turn + 2.0 * math.pi * (of < first))
        columns = np.stack([np.cos(angle), np.sin(angle)], axis=1) / 0.3
        fall = z @ columns @ np.linalg.solve(columns.T @ columns, columns.T @ z)
        assert found[first] == pytest.approx(fall, rel=1e-6)


def test_fewer_rows_of_a_curve_are_uneven_and_know_their_noise():
    turn = residuals("turn").recording
    recording = replace(turn, noise=Noise(0.1, 0.6))
    few = subsample(recording, 25)
    fit = recording.rows[~recording.held_out]
    step = fit.size // 25
    assert set(few.rows) <= set(fit)
    assert few.rows.size == fit.size // step
    assert not np.any(few.held_out)
    assert few.noise.rho == pytest.approx(0.6**step)
    place = np.searchsorted(fit, few.rows)
    np.testing.assert_array_equal(place // step, np.arange(few.rows.size))  # one of every step
    assert len(set(place % step)) == step
    assert subsample(recording, fit.size) is recording
    scan = residuals("scan").recording
    assert subsample(scan, 10) is scan
    model = ExactModel(reducer(), [recording])
    assert smallest_subsample(model, 1e6) is model  # up to 1000 rows are cheap


def test_sets_are_tried_on_a_quarter_of_the_rows_of_each_file_and_on_none_less_than_before():
    turn, scan = residuals("turn").recording, residuals("scan").recording

    def model(*recordings, only_loops=False):
        return SimpleNamespace(recordings=recordings, only_loops=only_loops, with_recordings=lambda some: model(*some))

    count = np.count_nonzero(~turn.held_out)
    every, few = model(turn, turn), model(subsample(turn, count // 2), subsample(turn, count // 8))
    first, second = screening_subsample(every, few).recordings
    assert (first.rows.size, second.rows.size) == (few.recordings[0].rows.size, count // 4)
    # It must save half of the rows, and a file without rows to fit stays as it is.
    assert screening_subsample(every, every) is None
    assert screening_subsample(model(scan), model(scan)) is None
    held_out = replace(turn, rows=turn.rows[:3], held_out=np.ones(3, dtype=bool))
    found = screening_subsample(model(turn, held_out), model(few.recordings[1], held_out))
    assert found.recordings[1] is held_out
    # On a loop each row may decide which pins bear.
    assert screening_subsample(model(turn, only_loops=True), model(few.recordings[1])) is None


@pytest.mark.parametrize(("misfit", "ended", "kept"), [(149.0, True, True), (151.0, True, False), (151.0, False, True)])
def test_a_set_is_given_up_where_its_fit_to_fewer_rows_ends_clearly_worse(misfit, ended, kept):
    (oval,), (pitch,) = some("disc_oval", disc=1), some("cumulative_pitch_error", disc=1)
    best = Fit(optimum_of((oval,), [3.0, 4.0]), (0,))
    asked = []

    def optimum(attempt, _):
        asked.append(attempt)
        return replace(optimum_of((pitch,), [0.7, 0.1]), misfit=misfit, converged=ended)

    class There(State):
        misfit = 75.0

    fewer = SimpleNamespace(state=lambda members, u: There(reducer(), (), members, u), optimum=optimum)
    stage = SimpleNamespace(
        _screening_models=SimpleNamespace(model=lambda _: fewer),
        _to_beat=None,
        fits=SimpleNamespace(best=best),
        library=Library((oval, pitch), 2),
    )
    found = _Stage._screened(stage, Proposal((pitch,), np.array([0.5, 0.0]), (0,)))
    # The misfit of the best set there, 75 + 3² + 4², and 50 more.
    assert asked[0].beat == 100.0
    assert (found is not None) == kept
    if kept:
        np.testing.assert_allclose(found, [0.7, 0.1])


def some(*names: str, **choice: object) -> tuple[Candidate, ...]:
    return tuple(
        next(
            one
            for one in library(True)
            if one.name == name and all(one.choice.get(k, v) == v for k, v in choice.items() if k in one.choice)
        )
        for name in names
    )


def optimum_of(members: tuple[Candidate, ...], u: list[float]) -> Optimum:
    n = 2 * len(members)
    return Optimum(members, np.array(u), np.eye(n), np.zeros((n, n)), 0.0, 0.0, 100, 7.0, True)


def test_equivalent_parts_are_half_a_turn_and_a_third_apart():
    (oval,), (pitch,) = some("disc_oval", disc=1), some("cumulative_pitch_error", disc=1)
    known = Library(library(True), 2)
    # The second disc is mounted 180° further: an oval looks the same, a pitch error is turned round.
    for member, sign in ((oval, 1.0), (pitch, -1.0)):
        ((members, u),) = on_other_parts(known, optimum_of((member,), [0.6, 0.2]), reducer())
        (moved,) = known.members(members)
        assert (moved.name, moved.choice["disc"]) == (member.name, 2)
        np.testing.assert_allclose(u, sign * np.array([0.6, 0.2]), atol=1e-12)
    # A crank error of one disc: three cranks on each disc, without the one that it is.
    (crank,) = some("crank_eccentricity_error", disc=1, crank=2)
    found = on_other_parts(known, optimum_of((crank,), [0.6, 0.0]), reducer())
    places = {(known.candidates[i].choice["disc"], known.candidates[i].choice["crank"]) for (i,), _ in found}
    assert places == {(1, 1), (1, 3), (2, 1), (2, 2), (2, 3)}
    assert all(np.array_equal(u, [0.6, 0.0]) for _, u in found)
    # A pin of 40 meets the second disc as the one across from it meets the first.
    (pin,) = some("single_pin_error", pin=28)
    (((place,), _),) = on_other_parts(known, optimum_of((pin,), [0.6, 0.0]), reducer())
    assert known.candidates[place].choice["pin"] == 8


def test_proposals_are_the_best_sets_of_every_move():
    # Five effects with patterns of their own; the truth has two of them.
    members = list(some("disc_oval", "cumulative_pitch_error", "disc_runout", disc=1))
    members += [next(one for one in library(True) if one.name == name) for name in ("pin_ring_oval", "pin_ring_runout")]
    R, truth = np.kron(np.diag([50.0, 40.0, 60.0, 30.0, 20.0]), np.eye(2)), np.zeros(10)
    R[0, 2] = R[2, 0] = 20.0
    truth[[0, 1, 6]] = 1.0, 0.5, -0.8
    linear, known = equations(R @ truth, R, members), Library(tuple(members), 2)
    for base in ((), (0,), (2,), (0, 2), (1, 2)):
        best = optimum_of(known.members(base), [0.1] * (2 * len(base)))
        found = linear_proposals(linear, known, best, (0,))
        # Relative to the evidence of the exact fit, 7, of the base.
        shift = 7.0 - linear_evidence(linear, known.priors, list(base))
        proposed = {frozenset(known.places(one.members)) for one in found}
        # From any set of these, two moves at most lead to the truth.
        distance = len({0, 3} ^ set(base))
        assert ({0, 3} in proposed) == (distance <= 2)
        assert all(len(one ^ set(base)) <= 3 for one in proposed)
        if len(base) == 2:
            assert {frozenset([i]) for i in base} <= proposed
        promised = [one.promised for one in found]
        assert promised == sorted(promised, reverse=True)
        for one in found:
            places = known.places(one.members)
            assert one.promised == pytest.approx(shift + linear_evidence(linear, known.priors, places))
            where = [2 * i + c for i in places for c in (0, 1)]
            A = np.eye(len(where)) + R[np.ix_(where, where)]
            np.testing.assert_allclose(one.start, np.linalg.solve(A, (R @ truth)[where]), rtol=1e-9, atol=1e-12)
        # Or with the base where it is, and no slope along the others.
        for one in linear_proposals(linear, known, best, (0,), keep=True):
            places = known.places(one.members)
            where = [2 * i + c for i in places for c in (0, 1)]
            slope = (R @ truth)[where] - (np.eye(len(where)) + R[np.ix_(where, where)]) @ one.start
            kept = np.repeat(np.isin(places, base), 2)
            np.testing.assert_allclose(one.start[kept], 0.1)
            np.testing.assert_allclose(slope[~kept], 0.0, atol=1e-9)
    np.testing.assert_allclose(known.priors, log_priors(members, 2))


def test_a_response_of_second_order_gives_size_and_half_the_angle():
    for size, angle in ((1.0, 0.4), (1.0, 3.5), (0.2, -1.0)):
        found = second._coordinates(size * np.array([math.cos(angle), math.sin(angle)]))
        assert math.hypot(*found) == pytest.approx(0.5 * size**0.7)
        # Twice the angle of the coordinates is that of the response.
        assert math.cos(2.0 * math.atan2(found[1], found[0]) - angle) == pytest.approx(1.0)
    assert math.hypot(*second._coordinates(np.array([1e3, 0.0]))) == pytest.approx(2.0)
    assert math.hypot(*second._coordinates(np.array([1e-9, 0.0]))) == pytest.approx(0.5 * 0.05**0.7)


def test_free_amounts_are_those_of_least_squares():
    block = Whitened(residuals("turn"))
    draw = np.random.default_rng(4)
    columns = draw.normal(size=(block.chosen.size, 2))
    fall, amounts = second.chi2_reduction([block], columns)
    G = block.white(columns)
    before = block.product(block.z, block.z)
    left = block.z - G @ amounts
    assert fall == pytest.approx(float(before - block.product(left, left)), rel=1e-6)
    # No other amounts leave less.
    for change in ([0.1, 0.0], [0.0, -0.1]):
        other = block.z - G @ (amounts + change)
        assert block.product(other, other) > block.product(left, left)


@cache
def turned(name: str, *parts: tuple[str, int], size: float) -> ExactModel:
    """A turn of 60 rows of one effect, its size in prior widths."""
    (one,) = some(name, **dict(parts))
    machine = one.effect(np.array([size, 0.0]) * one.width).apply(reducer())
    file = simulate(machine, "lost_motion_map", Settings(noise=1e-4, seed=1, points=60))
    return ExactModel(reducer(), [record(reducer(), file)])


def test_single_effects_start_at_a_finite_size_of_the_right_sign():
    model = turned("pin_circle_radius_error", size=-0.8)
    (right,), others = some("pin_circle_radius_error"), some("coulomb_friction", "crank_bearing_clearance")
    known = Library((*others, right), 2)
    linear = normal_equations(model.baseline.blocks, known.candidates)
    found = of_finite_size(model, known, linear, (0,))
    assert found[0].members == (right,)
    assert found[0].start[0] == pytest.approx(-0.8, rel=0.3)
    assert found[0].start[1] == 0.0
    # Each at most once in either direction, and one-sided effects in one.
    tried = [(one.members[0].name, bool(one.start[0] > 0.0)) for one in found]
    assert len(set(tried)) == len(tried)
    assert all(up for name, up in tried if name != right.name)
    # Best first: the fall of χ² by a multiple of the response at half a width.
    (u,), state = found[0].start[:1], model.state([right], np.array([-0.5, 0.0]))
    column = second.change_of_predictions(model.baseline, state)[:, np.newaxis]
    fall, (amount,) = second.chi2_reduction(model.baseline.blocks, column)
    assert u == pytest.approx(-0.5 * amount)
    assert fall > 0.5 * model.baseline.chi2


def test_half_a_turn_is_tried_where_a_rotation_by_180_degrees_changes_nothing():
    (ring,), (oval,) = some("pin_ring_runout"), some("pin_ring_oval")
    model = ExactModel(reducer(), [record(reducer(), simulate(reducer(), "hysteresis", Settings(noise=1e-3, seed=1)))])
    ((half,),) = _around(model, [ring])
    u = np.array([direction for _, direction in half])
    assert np.allclose(np.arctan2(u[:, 1], u[:, 0]), np.pi * np.arange(8) / 8)
    opposite = [model.state([ring], -one).chi2 for one in u[::3]]
    assert [model.state([ring], one).chi2 for one in u[::3]] == pytest.approx(opposite, rel=1e-3)
    # The ring is not the same 90° on, nor are pins where pins were if their number is odd.
    ((whole,),) = _around(model, [oval])
    assert len(whole) == 16
    drive = SimpleNamespace(trochoid=SimpleNamespace(pins=11))
    assert not _symmetric(SimpleNamespace(reducer=SimpleNamespace(discs=2, case=SimpleNamespace(drive=drive))))


def test_wear_is_tried_from_every_second_lobe_on_with_either_sign():
    model = ExactModel(reducer(), [record(reducer(), simulate(reducer(), "hysteresis", Settings(noise=1e-3, seed=1)))])
    both, first = _around(model, [one for one in library(True) if one.name == "wheel_wear_drift"])
    for (more, less), disc in ((both, None), (first, 1)):
        places = [member for member, _ in more]
        assert [member for member, _ in less] == places
        assert {member.choice["disc"] for member in places} == {disc}
        assert [member.along for member in places] == list(range(1, reducer().case.drive.trochoid.lobes + 1, 2))
        assert {tuple(direction) for _, direction in more} == {(1.0, 0.0)}
        assert {tuple(direction) for _, direction in less} == {(-1.0, 0.0)}


def test_what_all_discs_share_acts_by_its_square_and_twice_its_angle():
    model = turned("cumulative_pitch_error", ("disc", None), size=0.5)
    (pitch,), (own,) = some("cumulative_pitch_error", disc=None), some("cumulative_pitch_error", disc=1)
    known, none = Library((own, pitch), 2), empty_fit(model).optimum
    linear = normal_equations(model.baseline.blocks, known.candidates)
    assert list(second._cancelling(known, linear, none)) == [pitch]
    columns = second._second_order_responses(model, model.baseline, pitch)
    # A new solve at any angle of that size, from the three patterns.
    for angle in (0.3, 1.9):
        u = 0.5 * np.array([math.cos(angle), math.sin(angle)])
        exact = second.change_of_predictions(model.baseline, model.state([pitch], u))
        predicted = columns @ [math.cos(2.0 * angle), math.sin(2.0 * angle), 1.0]
        np.testing.assert_allclose(predicted, exact, atol=0.1 * np.max(np.abs(exact)))
    # The start that explains most is near the machine's, or half a turn further.
    (found,) = second.second_order(model, known, linear, none, (0,))
    assert found.members == (pitch,)
    assert 0.25 < math.hypot(*found.start) < 1.0
    assert abs(math.sin(math.atan2(found.start[1], found.start[0]))) < 0.3


def test_what_cancels_to_first_order_is_proposed_next_to_another_effect():
    (pitch,), (oval,) = some("cumulative_pitch_error", disc=None), some("pin_ring_oval")
    machine, size = reducer(), np.array([0.5, 0.0])
    for one in (oval, pitch):
        machine = one.effect(size * one.width).apply(machine)
    file = simulate(machine, "lost_motion_map", Settings(noise=1e-4, seed=1, points=60))
    model, known = ExactModel(reducer(), [record(reducer(), file)]), Library((oval, pitch), 2)
    first = model.optimum(Attempt((oval,), size), 0.0)
    linear = equations_about(model, known, first)
    (found,) = second.second_order(model, known, linear, first, (0,))
    assert found.members == (oval, pitch)
    # Twice its angle is seen, so half a turn is free.
    assert 0.25 < math.hypot(*found.start[2:]) < 1.0
    assert abs(math.sin(math.atan2(found.start[3], found.start[2]))) < 0.3


def test_each_variety_starts_at_the_place_and_angle_that_explain_most():
    ovals = [one for one in library(True) if one.name == "disc_oval"]
    (wear, everywhere) = some("flank_wear", "pin_ring_oval")
    members = [*(one for one in ovals if one.choice["disc"]), wear, everywhere]
    u = np.array([1.2, 1.6, 0.3, 0.1, -0.5, 0.0, 0.0, 0.0])
    R = np.diag([10.0, 10.0, 20.0, 20.0, 30.0, 0.0, 10.0, 10.0])
    directed = _directed(Library(tuple(members), 2), equations(R @ u, R, members))
    found = {one.candidate: one.direction for one in _best_of_each_variety(directed)}
    assert set(found) == {members[0], wear, everywhere}
    np.testing.assert_allclose(found[members[0]], [0.6, 0.8])
    # One-sided, or without any pattern: straight on.
    np.testing.assert_array_equal(found[wear], [1.0, 0.0])
    np.testing.assert_array_equal(found[everywhere], [1.0, 0.0])


@cache
def one_thick_pin() -> ExactModel:
    """A turn of a reducer with one pin 3 µm off, read by an encoder 1″ off its axis."""
    hidden = [
        blind.Hidden("single_pin_error", {"amount_um": 3.0, "pin": 7}),
        blind.Hidden("encoder_eccentricity", {"amplitude_arcsec": 1.0, "phase_deg": 40.0}),
    ]
    text = blind.transmission_error(blind.Reducer(), hidden, torque_nm=412.0, rows=400, noise=blind.Noise(0.1), seed=5)
    return ExactModel(reducer(), [record(reducer(), parse_measurement(text, "turn.csv"))])


def fitted(model: ExactModel, *names: str, **choice: object) -> Optimum:
    members = some(*names, **choice)
    found = model.optimum(Attempt(members, np.full(2 * len(members), 0.1)), 0.0)
    assert found is not None
    return found


def test_a_smaller_error_of_the_model_alone_makes_no_set_better():
    model = one_thick_pin()
    part = fitted(model, "single_pin_error", "encoder_eccentricity", pin=7)
    whole = fitted(model, "single_pin_error", "encoder_eccentricity", "pin_ring_runout", pin=7)
    # The residual of the whole, its nuisances those of the part, fitted against their priors.
    (of_part,), (of_whole,) = model.at(part).blocks, model.at(whole).blocks
    A, n = of_part.nuisance, of_part.nuisance.shape[1]
    _, (chi2,), *_ = np.linalg.lstsq(np.vstack([A, np.eye(n)]), np.concatenate([of_whole.z, np.zeros(n)]))
    common = 0.5 * (part.chi2 - chi2 + float(part.u @ part.u - whole.u @ whole.u))
    # Were the error of the whole smaller, it would be better by that alone.
    smaller = replace(whole, misfit=part.misfit - 2.0 * abs(common) - 50.0)
    assert model.deficit(part, smaller) == pytest.approx(common, abs=1e-4)
    assert model.deficit(part, replace(whole, misfit=part.misfit + 2.0)) == -1.0


def test_members_without_which_a_set_is_not_worse_are_left_out():
    model = one_thick_pin()
    fits = Fits(model)
    # There is no runout, and the pin and the encoder without it were never fitted.
    whole = Fit(fitted(model, "single_pin_error", "encoder_eccentricity", "pin_ring_runout", pin=7), (0,))
    fits.keep(whole)
    best, ranked = fits.simplest(Library(library(True), 2), lambda _: None)
    assert {one.name for one in best.optimum.members} == {"single_pin_error", "encoder_eccentricity"}
    assert whole.key in {one.key for one in ranked}
