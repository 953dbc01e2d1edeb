"""Names that bend the curves alike are told apart where each is fitted, not where linear equations guess."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.climbing import Climb
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.exchange import exchanged
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.optimum import Attempt
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.effects.crank import CrankBearingClearance
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.process import MissingDeformationCompensation
from cycloid_profile.effects.ring import PinRadiusError
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text

ROWS = 100


@pytest.mark.slow
@pytest.mark.parametrize(
    ("hidden", "told"),
    [
        (CrankBearingClearance(radial_um=0.6), "series_compliance"),
        (PinRadiusError(amount_um=-0.6), "crank_bearing_compliance"),
        # One disc with twice as much shows the same to first order, and was all that was tried.
        (MissingDeformationCompensation(amount_um=-0.8), "pin_radius_error"),
    ],
)
def test_a_wrong_amount_is_exchanged_for_the_right_one(hidden: Effect, told: str):
    drawn = built_reducer(parse_spec(spec_text(Reducer())))
    machine = hidden.apply(drawn)
    files = [
        simulate(machine, "transmission_error", Settings(noise=0.02, seed=1, points=ROWS)),
        simulate(machine, "transmission_error", Settings(noise=0.02, seed=2, points=ROWS, torque=12.4e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.0005, seed=3, points=ROWS)),
    ]
    model = ExactModel(drawn, [record(drawn, one) for one in files])
    library = Library(candidates(drawn, frozenset(), True), 2)
    wrong = next(c for c in library.candidates if c.name == told)
    start = np.array([0.3, 0.0])
    best = model.optimum(Attempt((wrong,), start), library.prior([wrong]))
    climb = Climb(model, library, 8, lambda _: None)
    found = exchanged(climb, model, best)
    assert found.log_evidence > best.log_evidence + 5.0
    assert found.members[0].name == hidden.name
    assert found.members[0].choice.get("disc") is None
    # What was fitted on the way is kept: the group of a name is read from it.
    assert len(climb.found) > 1
