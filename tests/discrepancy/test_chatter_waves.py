"""The spectrum of a scan: the fast way beside the readable one, and a wave that stands out of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import chatter
from cycloid_profile.discrepancy.chatter_candidates import standing_out
from cycloid_profile.discrepancy.chatter_waves import (
    chatter_peaks,
    chatter_spectrum,
    power_in_white_noise,
    power_one_by_one,
)
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Whitened
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Noise, Reducer, scan, spec_text, transmission_error

WAVE = Hidden("grinding_chatter", {"amplitude_um": 0.2, "waves_per_turn": 493.3, "phase_deg": 30.0})


@pytest.fixture(scope="module")
def block() -> Whitened:
    built = built_reducer(parse_spec(spec_text(Reducer())))
    text = scan(Reducer(), [WAVE], noise=Noise(0.3), seed=7)
    recording = record(built, parse_measurement(text, "scan.csv"))
    # Rows a long way from one another, too: some are held out.
    return Whitened(Laid(replace(recording, noise=replace(recording.noise, rho=0.0)), built))


@pytest.mark.parametrize(("first", "step", "count"), [(13.0, 0.5, 700), (492.3, 0.02, 51), (800.0, 0.5, 3)])
def test_waves_a_block_at_a_time_are_those_one_by_one(block, first, step, count):
    grid = first + step * np.arange(count)
    z = block.projected(block.z)
    slow, fast = power_one_by_one(block, grid, z), power_in_white_noise(block, grid, z)
    assert fast == pytest.approx(slow, rel=1e-7, abs=1e-7)


def test_a_wave_stands_out_of_the_spectrum(block):
    grid, power = chatter_spectrum(block)
    assert abs(grid[np.argmax(power)] - 493.3) < 0.5
    assert chatter_peaks(block)[0] == pytest.approx(493.3, abs=0.1)


def test_waves_of_all_discs_are_a_choice_like_any_other():
    """What a scan shows on one disc is looked up for all: left out, the share of the others went to a name of its
    own, after a search of a minute.
    """
    own, all_discs = chatter(500.0, 1), chatter(500.0, None)
    library = Library((own, all_discs), 2)
    assert library.where(own.name, {**own.choice, "disc": None}) is all_discs
    assert "disc" not in all_discs.parameters([1.0, 0.0])


@pytest.mark.slow
def test_waves_are_counted_anew_beside_a_larger_effect():
    """An eccentricity that fills the spectrum moves the peak by a tenth of a wave, of which a seventh is left over."""
    wave = Hidden("grinding_chatter", {"amplitude_um": 0.58, "waves_per_turn": 242.44, "phase_deg": 75.5})
    other = Hidden("generating_eccentricity_error", {"amount_um": 0.85})
    text = scan(Reducer(), [other, wave], noise=Noise(0.3), seed=3)
    found = diagnose(built_reducer(parse_spec(spec_text(Reducer()))), [parse_measurement(text, "scan.csv")])
    told = {effect.candidate.name: effect for effect in found.effects}
    assert set(told) == {"grinding_chatter", "generating_eccentricity_error"}
    assert told["grinding_chatter"].parameters["waves_per_turn"] == pytest.approx(242.44, abs=0.03)
    assert found.remainder is None


@pytest.mark.parametrize(("turns", "discs"), [(False, [1]), (True, [1, None])])
def test_where_turns_are_measured_too_all_discs_may_have_what_a_scan_shows(turns, discs):
    built = built_reducer(parse_spec(spec_text(Reducer())))
    files = [parse_measurement(scan(Reducer(), [WAVE], noise=Noise(0.3), seed=7), "scan.csv")]
    if turns:
        text = transmission_error(Reducer(), torque_nm=412.0, rows=400, noise=Noise(0.15), seed=6)
        files.append(parse_measurement(text, "turn.csv"))
    first = standing_out(ExactModel(built, [record(built, one) for one in files]))[: len(discs)]
    assert [one.choice.get("disc") for one in first] == discs
    assert all(one.choice["waves_per_turn"] == pytest.approx(493.3, abs=0.1) for one in first)
