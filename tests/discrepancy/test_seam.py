"""Waves that do not come out even: a scan shows the lobe that they begin at, whichever the file counts first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.normal import Whitened
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.discrepancy.scans_first import counted_as_scans_show
from cycloid_profile.discrepancy.seam import seam
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Noise, Reducer, scan, spec_text, transmission_error

BUILT = built_reducer(parse_spec(spec_text(Reducer())))
LOBES = 39
UNEVEN = Hidden("grinding_chatter", {"amplitude_um": 0.6, "waves_per_turn": 612.45, "phase_deg": 278.0, "disc": 1})
EVEN = replace(UNEVEN, parameters={**UNEVEN.parameters, "waves_per_turn": 612.0})


def scanned(effects, lobes_on, seed=5):
    """A scan whose machine counts ``lobes_on`` further than the disc does."""
    turn = 1.0 - 360.0 / LOBES * lobes_on
    text = scan(Reducer(), effects, points=4000, noise=Noise(0.3), turn_deg=turn, seed=seed)
    return parse_measurement(text, "scan.csv")


def begins(effects, lobes_on, waves):
    block = Whitened(Laid(record(BUILT, scanned(effects, lobes_on)), BUILT))
    return seam(block, block.projected(block.z), waves)


@pytest.mark.parametrize("lobes_on", [0, 1, 13, 38])
def test_the_lobe_is_found_that_waves_begin_at(lobes_on):
    assert begins([UNEVEN], lobes_on, 612.0) == lobes_on


def test_waves_that_come_out_even_begin_nowhere():
    assert begins([EVEN], 13, 612.0) is None


def test_noise_begins_nowhere():
    assert begins([], 13, 612.0) is None


@pytest.mark.parametrize("lobes_on", [0, 20])
def test_waves_are_told_from_the_lobe_they_begin_at(lobes_on):
    """Without it the jump parts the peak in two: a second chatter was named beside the first, or none at all."""
    found = diagnose(BUILT, [scanned([UNEVEN], lobes_on)])
    (effect,) = found.effects
    assert effect.candidate.name == "grinding_chatter"
    assert effect.parameters["waves_per_turn"] == pytest.approx(612.45, abs=0.06)
    assert effect.parameters["amplitude_um"] == pytest.approx(0.6, abs=0.04)
    told = [note for note in found.notes if "lobes are counted from where the waves begin" in note]
    assert [f"lobe {lobes_on + 1} as the file counts" in note for note in told] == ([True] if lobes_on else [])


@pytest.mark.slow
def test_what_else_a_scan_shows_is_counted_from_there_too():
    low = Hidden("single_tooth_error", {"amount_um": 2.0, "lobe": 9, "disc": 1})
    found = {e.candidate.name: e.parameters for e in diagnose(BUILT, [scanned([UNEVEN, low], 25)]).effects}
    assert set(found) == {"grinding_chatter", "single_tooth_error"}
    assert found["single_tooth_error"]["lobe"] == 9


@pytest.mark.parametrize(
    "effect",
    [
        Hidden("wheel_wear_drift", {"amount_um": 3.0, "first_lobe": 8, "disc": 1}),
        Hidden("disc_oval", {"amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}),
        Hidden("single_tooth_error", {"amount_um": 3.0, "lobe": 30, "disc": 1}),
    ],
    ids=lambda one: one.name,
)
def test_nothing_else_makes_a_scan_count_otherwise(effect):
    """A saw-tooth over the lobes jumps, too, and names the lobe it does so at itself."""
    model = ExactModel(BUILT, [record(BUILT, scanned([effect], 5))])
    assert counted_as_scans_show(model, candidates(BUILT, frozenset({0}), False)) is model


@pytest.mark.slow
def test_one_turn_beside_a_scan_tells_waves_of_all_discs():
    """The lobes counted by the scan, the turn need only say which discs have them."""
    wave = Hidden("grinding_chatter", {"amplitude_um": 0.5, "waves_per_turn": 1043.9, "phase_deg": 278.0})
    turn = transmission_error(Reducer(), [wave], torque_nm=412.0, rows=1200, noise=Noise(0.15), seed=6)
    found = diagnose(BUILT, [scanned([wave], 7), parse_measurement(turn, "turn.csv")])
    (effect,) = found.effects
    assert effect.candidate.name == "grinding_chatter"
    assert "disc" not in effect.parameters
    assert effect.parameters["waves_per_turn"] == pytest.approx(1043.9, abs=0.06)
    assert np.cos(np.deg2rad(effect.parameters["phase_deg"] - 278.0)) > 0.99
