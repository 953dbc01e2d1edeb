"""A pair masked by one effect whose residual is within the scatter of chi²: a significant order reveals it."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.unscanned_waves import UnscannedWaves
from cycloid_profile.diagnosis.search.local_search import LocalSearch, leaves_residual
from cycloid_profile.diagnosis.search.masked_pairs import masked_pairs, may_mask_pair, residual_is_significant
from cycloid_profile.diagnosis.search.member_swaps import swap_members
from cycloid_profile.diagnosis.search.subsampling import subsample
from cycloid_profile.effects import AsBuiltReducer, EquidistantError, GeneratingEccentricityError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

ROWS = 1800  # of a turn: the mesh repeats 1,560 times

SOME = {
    "radial_moving_error",
    "generating_eccentricity_error",
    "pin_radius_error",
    "crank_bearing_compliance",
    "crank_bearing_clearance",
}


@pytest.fixture(scope="module")
def model() -> ExactModel:
    """A bench with excess equidistant removal on all flanks, and a wrong generating eccentricity of disc 2."""
    drawn = as_built_reducer(parse_spec(spec_text(Reducer())))
    machine = GeneratingEccentricityError(amount_um=1.56, disc=2).apply(EquidistantError(amount_um=0.48).apply(drawn))
    return bench(drawn, machine)


def bench(drawn: AsBuiltReducer, machine: AsBuiltReducer) -> ExactModel:
    """Transmission error at two torques and a lost motion map of a reducer."""
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=1, points=ROWS)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=2, points=ROWS, torque=12.36e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.004, seed=3, points=360)),
    ]
    return ExactModel(drawn, [record(drawn, one) for one in files])


@pytest.fixture(scope="module")
def library(model: ExactModel) -> Library:
    """Some of the effects: all of them take a minute."""
    return Library([c for c in candidates(model.reducer, frozenset(), True) if c.name in SOME], 2)


def fitted(model: ExactModel, library: Library, **sizes: float) -> Optimum:
    """Optimum of effects of disc 2, or without a disc, from a close start."""
    some = [c for c in library.candidates if c.choice.get("disc", 2) == 2]
    members = [next(c for c in some if c.name == name) for name in sizes]
    start = np.array([[size / m.width, 0.0] for m, size in zip(members, sizes.values(), strict=True)]).ravel()
    found = model.optimum(Attempt(tuple(members), start), library.prior(members))
    assert found is not None
    return found


@pytest.mark.slow
def test_residual_of_the_imitating_effect_is_significant_at_the_mesh_order(model, library):
    one = fitted(model, library, radial_moving_error=1.4)
    assert not leaves_residual(model, one)
    assert residual_is_significant(model, one)
    both = fitted(model, library, generating_eccentricity_error=1.4, pin_radius_error=-0.4)
    assert not residual_is_significant(model, both)


@pytest.mark.slow
def test_mesh_orders_are_not_chatter(model, library):
    """A wave of 1,362, three below 35 per lobe, was named where the mesh order of a pair remained."""
    one = fitted(model, library, radial_moving_error=1.4)
    blocks = model.at(one).blocks
    assert all(UnscannedWaves(blocks, one.members, disc).strongest()[0].p_value > 1e-3 for disc in (1, 2, None))


@pytest.mark.slow
@pytest.mark.parametrize("alike", [True, False], ids=["few poses for all rows", "a pose for each row"])
def test_the_pair_is_found_on_all_rows(model, library, alike, monkeypatch):
    assert model.solves_few_poses(library.candidates)
    if not alike:
        monkeypatch.setattr(ExactModel, "solves_few_poses", lambda *_: False)
    subsampled = model.with_recordings([subsample(r, 80) for r in model.recordings])
    one = fitted(model, library, radial_moving_error=1.4)
    assert may_mask_pair(model, one)
    starts = masked_pairs(
        model, subsampled, library, [fitted(subsampled, library, radial_moving_error=1.4)], lambda _: None
    )
    local_search = LocalSearch(model, library, 8, lambda _: None)
    found = swap_members(local_search, subsampled, local_search.best_of_starts(starts, one))
    assert found.log_evidence > one.log_evidence + 10.0
    assert {member.name for member in found.members} == {"generating_eccentricity_error", "pin_radius_error"}
