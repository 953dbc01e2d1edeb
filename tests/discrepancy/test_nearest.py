"""An effect larger than any workshop makes is not named, but the answer says what it looks like and why not."""

from __future__ import annotations

import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.told import told
from cycloid_profile.effects.process import CumulativePitchError
from cycloid_profile.report.verdict_in_words import headline
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Reducer, spec_text

# The tolerance is 3 µm, a width twice that, and 3.5 widths are the largest that is named.
LARGEST = 21.0


@pytest.mark.slow
def test_a_pitch_error_of_no_workshop_is_told_with_its_size_and_not_named():
    built = built_reducer(parse_spec(spec_text(Reducer())))
    amount = 1.6 * LARGEST
    machine = CumulativePitchError(amplitude_um=amount, phase_deg=70.0, disc=1).apply(built)
    scan = simulate(machine, "profile_scan", Settings(noise=0.3, seed=4, points=1500))
    found = diagnose(built, [scan])
    assert found.verdict == "unknown_effect"
    assert not found.effects
    assert "library" in headline(found)
    near = found.nearest[0]
    assert near.name == "cumulative_pitch_error"
    assert near.too_large
    assert near.share > 0.99
    assert abs(near.parameters["amplitude_um"] - amount) < 0.5
    values = told(found, "drive")
    first = values["nearest"][0]
    assert f"larger than any workshop makes ({LARGEST:.3g})" in first["why_not"]
    assert abs(first["parameters"]["amplitude_um"] - near.parameters["amplitude_um"]) < 1e-3
    assert any(note.startswith("looks like cumulative_pitch_error, but amplitude_um = ") for note in values["notes"])
    # The others fail by what they leave, and say so.
    assert all(one["why_not"].endswith("% of the gap") for one in values["nearest"][1:])
