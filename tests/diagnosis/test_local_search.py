"""Local search: known starts are reused, and every search has its own limit of exact fits."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.search.local_search import LocalSearch
from cycloid_profile.effects import CumulativePitchError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text


@pytest.fixture(scope="module")
def model() -> ExactModel:
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    machine = CumulativePitchError(amplitude_um=2.0, phase_deg=70.0, disc=1).apply(reducer)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=1, points=1560))
    return ExactModel(reducer, [use_all_rows(record(reducer, scan))])


@pytest.fixture(scope="module")
def library(model: ExactModel) -> Library:
    return Library(candidates(model.reducer, frozenset({0}), False), 2)


def start(library: Library) -> tuple[list[int], np.ndarray]:
    pitch = next(i for i, c in enumerate(library.candidates) if c.name == "cumulative_pitch_error")
    return [pitch], np.array([0.1, 0.3])


def test_a_fitted_start_is_reused_by_the_next_search(model, library):
    first = LocalSearch(model, library, 1, lambda _: None)
    best = first.run([start(library)], 0)
    assert [m.name for m in best.members] == ["cumulative_pitch_error"]
    # No exact fit is permitted, and none is necessary.
    again = LocalSearch(model, library, 0, lambda _: None, first.found).run([start(library)], 1)
    assert again is best


def test_a_search_without_exact_fits_finds_nothing_new(model, library):
    assert LocalSearch(model, library, 0, lambda _: None).run([start(library)], 1).members == ()


def test_a_second_search_has_its_own_limit_of_fits(model, library):
    spent = LocalSearch(model, library, 1, lambda _: None)
    spent.run([start(library)], 0)
    waves = next(i for i, c in enumerate(library.candidates) if c.name == "disc_oval")
    other = ([waves], np.array([0.1, 0.0]))
    spent.run([other], 0)
    assert (waves,) not in spent.found
    fresh = LocalSearch(model, library, 1, lambda _: None, spent.found)
    fresh.run([other], 0)
    assert (waves,) in fresh.found


def test_states_are_shared_between_models_with_different_rows(model, library):
    pitch = library.candidates[start(library)[0][0]]
    u = np.array([0.1, 0.3])
    state = model.state([pitch], u)
    twin = model.with_held_out(model.recordings)
    assert twin.state([pitch], u).residuals[0].residual is state.residuals[0].residual
