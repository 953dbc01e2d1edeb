"""Friction that loops of soft reducers with play show before any effect is fitted, and members that it hides."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import Recording, record
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.evidence import Library, estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search._determined import _whole_response, determined
from cycloid_profile.diagnosis.search._fits import empty_fit
from cycloid_profile.diagnosis.search._proposals import equations_about
from cycloid_profile.diagnosis.search._starts import of_finite_size
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import parse_measurement, read_measurement
from cycloid_profile.spec import read_spec
from tests.diagnosis.test_real_loops import FOLDER


@cache
def printed() -> AsBuiltReducer:
    return as_built_reducer(read_spec(FOLDER / "spec.toml"))


@cache
def library() -> Library:
    return Library(candidates(printed(), frozenset(), True), 2)


@cache
def measured() -> ExactModel:
    return ExactModel(printed(), [record(printed(), read_measurement(FOLDER / "play_initial.csv"))])


def response(optimum: Optimum) -> float:
    return _whole_response(measured(), optimum, measured().at(optimum), 0)


def one(name: str, **choice: float) -> Candidate:
    return next(c for c in library().candidates if c.name == name and choice.items() <= c.choice.items())


def loop_of_play(friction: float, play: float = 30.0) -> Recording:
    """A loop up to ±5 N·m: a slider of ``friction`` [N·m], a spring of 2′ per N·m behind it, and ``play`` [′]."""
    torque = np.concatenate([np.linspace(0.0, 5.0, 50), np.linspace(5.0, -5.0, 100), np.linspace(-5.0, 5.0, 100)])
    angle, now = [], -friction
    for applied in torque:
        now = min(max(now, applied - friction), applied + friction)
        angle.append(2.0 * now + np.sign(now) * play)
    rows = [f"{T:.6f},{a:.6f}" for T, a in zip(torque, angle, strict=True)]
    head = ["# format: cycloid-profile measurement 1", "# kind: hysteresis", "# output_angle_deg: 0", "# input: locked"]
    text = "\n".join([*head, "torque_nm,angle_arcmin", *rows]) + "\n"
    return record(printed(), parse_measurement(text, "loop.csv"))


def test_a_size_that_the_model_itself_errs_in_is_not_determined_by_its_response() -> None:
    pins = one("pin_support_compliance")
    found = measured().optimum(Attempt((pins,), np.array([0.3, 0.0]), steps=0), 0.0)
    assert found is not None
    assert response(found) < (0.3 / pins.size_error) ** 2
    assert determined(measured(), found) == []


@pytest.mark.parametrize("play", [0.0, 30.0])
def test_a_loop_shows_its_friction_however_much_play_it_has(play: float) -> None:
    assert loop_of_play(2.0, play).shown_friction_nm == pytest.approx(2.0, rel=0.03)
    # One reading error is not the end of the loop.
    wrong = loop_of_play(2.0, play).measurement
    angle = wrong["angle_arcmin"].copy()
    angle[130] = 400.0
    spoilt = record(printed(), replace(wrong, columns={**wrong.columns, "angle_arcmin": angle}))
    assert spoilt.shown_friction_nm == pytest.approx(2.0, rel=0.03)
    # Below a twentieth of the largest torque it is not clear.
    assert loop_of_play(0.1, play).shown_friction_nm == 0.0


def test_what_varies_slowly_along_a_printed_loop_is_not_its_noise() -> None:
    still = loop_of_play(2.0).measurement
    row = np.arange(still.rows)
    reading = 0.1 * np.random.default_rng(4).normal(size=row.size)
    wander = still["angle_arcmin"] + 3.0 * np.sin(0.15 * row) + reading
    noise = record(printed(), replace(still, columns={**still.columns, "angle_arcmin": wander})).noise
    assert noise.is_white
    assert noise.sigma == pytest.approx(0.1, rel=0.35)


def test_rows_in_the_play_are_not_compared() -> None:
    used = loop_of_play(2.0)
    angle = used.measurement["angle_arcmin"][used.rows]
    # |M| below 0.05 · 5 + 0.25 · 2 = 0.75 N·m, or 31.5′, may lie on either flank.
    assert np.min(np.abs(angle)) > 31.4


def test_friction_that_holds_a_stiff_stage_is_determined_by_its_whole_response() -> None:
    friction = one("coulomb_friction")
    # Correlated noise of this size hides the slope at the rows that do not move to the other flank.
    loop = ExactModel(printed(), [replace(measured().recordings[0], noise=Noise(4.0, 0.8))])
    found = loop.optimum(Attempt((friction,), np.array([0.66, 0.0])), 0.0)
    assert found is not None
    assert loop.baseline.misfit - found.misfit > 100.0
    assert found.linearly_determined == []
    assert determined(loop, found) == [0]


def test_two_effects_of_one_response_determine_neither() -> None:
    pair = (one("equidistant_error"), one("pin_radius_error"))
    both = measured().optimum(Attempt(pair, np.array([0.3, 0.0, 0.3, 0.0]), steps=0), 0.0)
    alone = measured().optimum(Attempt(pair[:1], np.array([0.3, 0.0]), steps=0), 0.0)
    assert both is not None
    assert alone is not None
    assert response(both) < 0.1 * response(alone)


def test_friction_starts_at_what_the_loop_shows() -> None:
    shown = measured().recordings[0].shown_friction_nm
    friction = one("coulomb_friction")
    known = Library((friction,), 2)
    equations = equations_about(measured(), known, empty_fit(measured()).optimum)
    (start,) = of_finite_size(measured(), known, equations, (0,))
    assert start.members == (friction,)
    assert start.start[0] * friction.width == pytest.approx(shown)


def test_equations_leave_the_members_of_an_optimum_where_they_are() -> None:
    friction, spring = one("coulomb_friction"), one("series_compliance")
    # Not an optimum of linear equations: a fit that a jump of the misfit ends is none either.
    there = measured().optimum(Attempt((friction,), np.array([0.5, 0.0]), steps=0), 0.0)
    assert there is not None
    equations = equations_about(measured(), Library((friction, spring), 2), there, rest=True)
    np.testing.assert_allclose(estimate(equations, [0])[0], there.u, atol=1e-9)


def test_the_misfit_has_one_minimum_along_friction() -> None:
    friction = one("coulomb_friction")
    soft = one("nonlinear_series_compliance", exponent=1.0)
    sizes = np.arange(0.4, 0.63, 0.005)
    states = [measured().state((friction, soft), np.array([size, 0.0, 1.95, 0.0])) for size in sizes]
    misfit = np.array([state.misfit for state in states if state is not None])
    assert misfit.size == sizes.size
    least = int(np.argmin(misfit))
    assert 0 < least < sizes.size - 1
    uphill = np.concatenate([np.diff(misfit[: least + 1]), -np.diff(misfit[least:])])
    # A rise of 3 is 1.7 standard deviations; chi² falls by a hundred here, so that no fit ends at it.
    assert np.max(uphill) < 3.0
