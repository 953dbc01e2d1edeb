"""The measurement proposed to separate rivals."""

from __future__ import annotations

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.planning import plan
from cycloid_profile.errors import SolveError
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Noise, Reducer, loop, spec_text


def test_a_bench_without_equilibrium_is_not_proposed(monkeypatch: pytest.MonkeyPatch) -> None:
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    recording = record(reducer, parse_measurement(loop(Reducer(), rows=60, noise=Noise(0.004)), "loop.csv"))
    library = candidates(reducer, frozenset(), True)
    oval, ring = (next(c for c in library if c.name == name) for name in ("disc_oval", "pin_ring_oval"))
    known = plan.information

    def binds(reducer, design, library):
        if design.kind.is_curve:
            raise SolveError("rows of the lost_motion_map", 40, "have no equilibrium", "make the effects smaller")
        return known(reducer, design, library)

    monkeypatch.setattr(plan, "information", binds)
    assert plan.separating_measurement(reducer, [Residuals(recording, reducer)], oval, [ring]) == "profile_scan"
