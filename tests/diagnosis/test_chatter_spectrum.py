"""Chatter spectrum of a scan: fast and reference implementation, and a significant wave."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Residuals, diagnose
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import chatter
from cycloid_profile.diagnosis.model.chatter_spectrum import (
    chatter_peaks,
    chatter_spectrum,
    off_lobes,
    power_in_white_noise,
    power_one_by_one,
)
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.whitened import Whitened
from cycloid_profile.diagnosis.search._fits import empty_fit
from cycloid_profile.diagnosis.search._waves import waves_left
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Noise, Reducer, scan, spec_text, transmission_error

WAVE = Hidden("grinding_chatter", {"amplitude_um": 0.2, "waves_per_turn": 493.3, "phase_deg": 30.0})


@pytest.fixture(scope="module")
def block() -> Whitened:
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    text = scan(Reducer(), [WAVE], noise=Noise(0.3), seed=7)
    recording = record(reducer, parse_measurement(text, "scan.csv"))
    # Includes distant rows, because some are held out.
    return Whitened(Residuals(replace(recording, noise=replace(recording.noise, rho=0.0, partial=0.0)), reducer))


@pytest.mark.parametrize(("first", "step", "count"), [(13.0, 0.5, 700), (492.3, 0.02, 51), (800.0, 0.5, 3)])
def test_block_spectrum_equals_the_reference(block, first, step, count):
    grid = first + step * np.arange(count)
    z = block.projected(block.z)
    slow, fast = power_one_by_one(block, grid, z), power_in_white_noise(block, grid, z)
    assert fast == pytest.approx(slow, rel=1e-7, abs=1e-7)


def test_even_waves_far_shorter_than_a_tooth_form_are_chatter_at_any_number():
    # 594.58 waves on 11 lobes are 54.05 on each; a tooth form has at most 20.
    waves = np.array([22.4, 127.0, 132.0, 594.58])
    np.testing.assert_allclose(off_lobes(waves, 11, "generating"), [0.4, 5.0, 0.0, 374.58])
    # Modulated from lobe to lobe, the last has a part of half a wave a turn.
    np.testing.assert_allclose(off_lobes(waves, 11, "c_axis"), [0.4, 5.0, 0.0, 0.58])


def test_a_wave_is_significant_in_the_spectrum(block):
    grid, power = chatter_spectrum(block)
    assert abs(grid[np.argmax(power)] - 493.3) < 0.5
    speed, waves = chatter_peaks(block)
    assert speed == "generating"
    assert waves[0] == pytest.approx(493.3, abs=0.1)


def test_waves_on_all_discs_are_a_candidate():
    """Without a candidate on all discs, the share of the others received another name after a minute of search."""
    priors = priors_of(as_built_reducer(parse_spec(spec_text(Reducer()))))
    own, all_discs = chatter(500.0, 1, priors), chatter(500.0, None, priors)
    library = Library((own, all_discs), 2)
    assert library.where(own.name, {**own.choice, "disc": None}) is all_discs
    assert "disc" not in all_discs.parameters([1.0, 0.0])


@pytest.mark.slow
def test_number_of_waves_is_refitted_given_a_larger_effect():
    """A large eccentricity moves the peak by a tenth of a wave, which would leave a seventh of the amplitude."""
    wave = Hidden("grinding_chatter", {"amplitude_um": 0.58, "waves_per_turn": 242.44, "phase_deg": 75.5})
    other = Hidden("generating_eccentricity_error", {"amount_um": 0.85})
    text = scan(Reducer(), [other, wave], noise=Noise(0.3), seed=3)
    found = diagnose(as_built_reducer(parse_spec(spec_text(Reducer()))), [parse_measurement(text, "scan.csv")])
    reported = {effect.candidate.name: effect for effect in found.effects}
    assert set(reported) == {"grinding_chatter", "generating_eccentricity_error"}
    assert reported["grinding_chatter"].parameters["waves_per_turn"] == pytest.approx(242.44, abs=0.03)
    assert found.remainder is None


@pytest.mark.parametrize(("turns", "discs"), [(False, [1]), (True, [1, None])])
def test_with_turns_waves_of_a_scan_may_be_on_all_discs(turns, discs):
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    files = [parse_measurement(scan(Reducer(), [WAVE], noise=Noise(0.3), seed=7), "scan.csv")]
    if turns:
        text = transmission_error(Reducer(), torque_nm=412.0, rows=400, noise=Noise(0.15), seed=6)
        files.append(parse_measurement(text, "turn.csv"))
    model = ExactModel(reducer, [record(reducer, one) for one in files])
    found = waves_left(model, empty_fit(model).optimum)
    assert turns or {one.choice.get("disc") for one in found} == {1}
    first = found[: len(discs)]
    assert [one.choice.get("disc") for one in first] == discs
    assert all(one.choice["waves_per_turn"] == pytest.approx(493.3, abs=0.1) for one in first)
