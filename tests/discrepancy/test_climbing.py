"""A climb begins with what is known of its starts, and every climb has rescorings of its own."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.climbing import Climb
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.recording import hold_nothing_out, record
from cycloid_profile.effects.process import CumulativePitchError
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text


@pytest.fixture(scope="module")
def model() -> ExactModel:
    built = built_reducer(parse_spec(spec_text(Reducer())))
    machine = CumulativePitchError(amplitude_um=2.0, phase_deg=70.0, disc=1).apply(built)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560))
    return ExactModel(built, [hold_nothing_out(record(built, scan))])


@pytest.fixture(scope="module")
def library(model: ExactModel) -> Library:
    return Library(candidates(model.built, frozenset({0}), False), 2)


def start(library: Library) -> tuple[list[int], np.ndarray]:
    pitch = next(i for i, c in enumerate(library.candidates) if c.name == "cumulative_pitch_error")
    return [pitch], np.array([0.1, 0.3])


def test_a_start_that_was_rescored_before_is_where_the_next_climb_begins(model, library):
    first = Climb(model, library, 1, lambda _: None)
    best = first.up([start(library)], 0)
    assert [m.name for m in best.members] == ["cumulative_pitch_error"]
    # Nothing may be rescored any more, and nothing needs to be.
    again = Climb(model, library, 0, lambda _: None, first.found).up([start(library)], 1)
    assert again is best


def test_a_climb_without_rescorings_finds_nothing_new(model, library):
    assert Climb(model, library, 0, lambda _: None).up([start(library)], 1).members == ()


def test_a_second_climb_has_rescorings_of_its_own(model, library):
    spent = Climb(model, library, 1, lambda _: None)
    spent.up([start(library)], 0)
    waves = next(i for i, c in enumerate(library.candidates) if c.name == "disc_oval")
    other = ([waves], np.array([0.1, 0.0]))
    spent.up([other], 0)
    assert (waves,) not in spent.found
    fresh = Climb(model, library, 1, lambda _: None, spent.found)
    fresh.up([other], 0)
    assert (waves,) in fresh.found


def test_states_are_shared_between_models_of_other_rows(model, library):
    pitch = library.candidates[start(library)[0][0]]
    u = np.array([0.1, 0.3])
    state = model.state([pitch], u)
    twin = model.with_rows(model.recordings)
    assert twin.state([pitch], u).laid[0].residual is state.laid[0].residual
