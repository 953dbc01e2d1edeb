"""An implausibly large effect is not named; the result reports it as nearest effect with the reason."""

from __future__ import annotations

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose, diagnosis_to_json
from cycloid_profile.effects import CumulativePitchError
from cycloid_profile.report.diagnosis import headline
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text

# Half of IT4 at the pin circle of 128 mm is 4.77 µm, the limit is 3.5 of these.
LARGEST = 16.7


@pytest.mark.slow
def test_an_implausible_pitch_error_is_reported_but_not_named():
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    amount = 1.6 * LARGEST
    machine = CumulativePitchError(amplitude_um=amount, phase_deg=70.0, disc=1).apply(reducer)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=4, points=1500))
    found = diagnose(reducer, [scan])
    assert found.verdict == "unknown_effect"
    assert not found.effects
    assert "library" in headline(found)
    near = found.nearest[0]
    assert near.name == "cumulative_pitch_error"
    assert near.too_large
    assert near.share > 0.99
    assert abs(near.parameters["amplitude_um"] - amount) < 0.5
    values = diagnosis_to_json(found, "drive")
    first = values["nearest"][0]
    assert f"than a ground drive of this size plausibly has ({LARGEST:.3g})" in first["why_not"]
    assert abs(first["parameters"]["amplitude_um"] - near.parameters["amplitude_um"]) < 1e-3
    assert any(note.startswith("resembles cumulative_pitch_error, but amplitude_um = ") for note in values["notes"])
    # The others state the share of the gap that they leave.
    assert all(one["why_not"].endswith("% of the gap") for one in values["nearest"][1:])
