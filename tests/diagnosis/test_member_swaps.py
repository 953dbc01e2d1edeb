"""Effects with nearly identical curves are separated by exact fits, not by linear equations."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.diagnosis.search.local_search import LocalSearch
from cycloid_profile.diagnosis.search.member_swaps import swap_members
from cycloid_profile.effects import CrankBearingClearance, Effect, MissingDeformationCompensation, PinRadiusError
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

ROWS = 100


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "reported"),
    [
        (CrankBearingClearance(radial_um=0.6), "series_compliance"),
        (PinRadiusError(amount_um=-0.6), "crank_bearing_compliance"),
        # One disc with twice the size is identical to first order, and was the only alternative tried.
        (MissingDeformationCompensation(amount_um=-0.8), "pin_radius_error"),
    ],
)
def test_a_wrong_effect_is_replaced_by_the_right_one(hidden: Effect, reported: str):
    drawn = as_built_reducer(parse_spec(spec_text(Reducer())))
    machine = hidden.apply(drawn)
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.02, seed=1, points=ROWS)),
        simulate(machine, "transmission_error", Settings(noise=0.02, seed=2, points=ROWS, torque=12.4e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.0005, seed=3, points=ROWS)),
    ]
    model = ExactModel(drawn, [record(drawn, one) for one in files])
    library = Library(candidates(drawn, frozenset(), True), 2)
    wrong = next(c for c in library.candidates if c.name == reported)
    start = np.array([0.3, 0.0])
    best = model.optimum(Attempt((wrong,), start), library.prior([wrong]))
    local_search = LocalSearch(model, library, 8, lambda _: None)
    found = swap_members(local_search, model, best)
    assert found.log_evidence > best.log_evidence + 5.0
    assert found.members[0].name == hidden.name
    assert found.members[0].choice.get("disc") is None
    # The fits are kept: the ambiguity group is read from them.
    assert len(local_search.found) > 1
