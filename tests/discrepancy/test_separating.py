"""The measurement that is proposed to tell rivals apart."""

from __future__ import annotations

import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy import plan
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.errors import SolveError
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Noise, Reducer, loop, spec_text


def test_a_bench_that_would_bind_is_not_proposed_and_does_not_stop_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    reducer = built_reducer(parse_spec(spec_text(Reducer())))
    recording = record(reducer, parse_measurement(loop(Reducer(), rows=60, noise=Noise(0.004)), "loop.csv"))
    library = candidates(reducer, frozenset(), True)
    oval, ring = (next(c for c in library if c.name == name) for name in ("disc_oval", "pin_ring_oval"))
    known = plan.information

    def binds(built, design, library):
        if design.kind != "profile_scan":
            raise SolveError("rows of the lost_motion_map", 40, "have no equilibrium", "make the effects smaller")
        return known(built, design, library)

    monkeypatch.setattr(plan, "information", binds)
    assert plan.separating_measurement(reducer, [recording], oval, [ring]) == "profile_scan"
