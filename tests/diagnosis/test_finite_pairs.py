"""Starting pairs at a finite size find effects whose linear response about zero is wrong."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.evidence import estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.finite_pairs import LINEAR_LIMIT, pairs_of_finite_size
from cycloid_profile.diagnosis.search.identical_effects import always_identical
from cycloid_profile.diagnosis.search.local_search import LocalSearch, equations_about
from cycloid_profile.effects import PinSupportCompliance, RadialMovingError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

SOME = {"radial_moving_error", "equidistant_error", "pin_radius_error", "thermal_growth", "pin_support_compliance"}


@pytest.fixture(scope="module")
def model() -> ExactModel:
    """Turns at two torques with softer pins, and an infeed of 2.7 µm on disc 2."""
    drawn = as_built_reducer(parse_spec(spec_text(Reducer())))
    machine = PinSupportCompliance(added_um_per_kn=3.0).apply(RadialMovingError(amount_um=-2.7, disc=2).apply(drawn))
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=1, points=1800)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=1800, torque=12.36e3)),
    ]
    return ExactModel(drawn, [record(drawn, one) for one in files])


@pytest.fixture(scope="module")
def library(model: ExactModel) -> Library:
    """Some effects without direction."""
    return Library([c for c in candidates(model.reducer, frozenset(), True) if c.name in SOME], 2)


@pytest.fixture(scope="module")
def ranked_singles(model: ExactModel, library: Library) -> Optimum:
    """The infeed alone."""
    infeed = next(c for c in library.candidates if c.name == "radial_moving_error" and c.choice.get("disc") == 2)
    found = model.optimum(Attempt((infeed,), np.array([-2.6 / infeed.width, 0.0])), library.prior([infeed]))
    assert found is not None
    return found


def softer(library: Library) -> Candidate:
    """The compliance of the pin supports."""
    return next(c for c in library.candidates if c.name == "pin_support_compliance")


def test_linear_equations_about_zero_have_the_wrong_sign(model, library, ranked_singles):
    u = estimate(
        equations_about(model, library, ranked_singles), library.places([*ranked_singles.members, softer(library)])
    )[0]
    assert u[2] < 0.0


@pytest.mark.slow
def test_compliance_is_found_from_a_finite_start(model, library, ranked_singles):
    starts = pairs_of_finite_size(model, library, [ranked_singles])
    found = LocalSearch(model, library, 8, lambda _: None).best_of_starts(starts, ranked_singles, LINEAR_LIMIT)
    assert [member.name for member in found.members] == ["radial_moving_error", "pin_support_compliance"]
    assert found.coordinates(1)[0] == pytest.approx(3.0, abs=0.3)


def test_every_shape_is_tried_once(model, library, ranked_singles):
    starts = pairs_of_finite_size(model, library, [ranked_singles, ranked_singles])
    partners = [library.members(members)[1] for members, _ in starts]
    assert len({id(one) for one in partners}) == len(partners)
    assert not any(always_identical(model.reducer, one, ranked_singles.members[0]) for one in partners)
    assert all(abs(u[2]) >= 0.3 for _, u in starts)


def test_a_fit_below_the_least_size_stops(model, library, ranked_singles):
    start = np.array([*ranked_singles.u, 0.04, 0.0])
    attempt = Attempt((*ranked_singles.members, softer(library)), start, steps=1)
    assert model.optimum(attempt, 0.0) is not None
    assert model.optimum(replace(attempt, least=2.0), 0.0) is None
