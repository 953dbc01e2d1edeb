"""An effect at places that the files do not tell apart, and how sure its size is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.optimum import Attempt
from cycloid_profile.discrepancy.recording import hold_nothing_out, record
from cycloid_profile.discrepancy.told import effect_told
from cycloid_profile.measurement.files import parse_measurement
from cycloid_profile.report.effect_in_words import effect_in_words
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Noise, Reducer, spec_text
from tests.discrepancy.blind.scan import scan
from tests.discrepancy.blind.turn import transmission_error


def told(amplitude_um: float, **parts: int):
    oval = Hidden("disc_oval", {"amplitude_um": amplitude_um, "phase_deg": 60.0, **parts})
    text = transmission_error(Reducer(), [oval], torque_nm=412.0, rows=360, noise=Noise(0.15), seed=1)
    return diagnose(built_reducer(parse_spec(spec_text(Reducer()))), [parse_measurement(text, "te.csv")])


@pytest.mark.slow
def test_half_an_oval_on_both_discs_turns_the_output_like_a_whole_one_on_one():
    found = told(0.3)
    (oval,) = found.effects
    assert oval.candidate.name == "disc_oval"
    places = {one.candidate.choice["disc"]: one for one in (oval, *oval.elsewhere)}
    both = places[None]
    assert abs(both.parameters["amplitude_um"] - 0.3) < 3.0 * both.uncertainty["amplitude_um"]
    assert places[1].parameters["amplitude_um"] == pytest.approx(0.6, abs=0.05)
    assert sum("disc_oval may as well be of" in note for note in found.notes) == len(oval.elsewhere) > 0
    listed = effect_told(oval)["elsewhere"]
    assert len(listed) == len(oval.elsewhere)
    assert all(one["uncertainty"].keys() == {"amplitude_um", "phase_deg"} for one in listed)
    assert ") or elsewhere, 0." in effect_in_words(oval)


@pytest.mark.slow
def test_a_large_oval_of_one_disc_is_of_that_disc():
    (oval,) = told(1.0, disc=1).effects
    assert oval.parameters["disc"] == 1
    assert oval.elsewhere == ()


@pytest.mark.parametrize("wrong", [0.5, 1.0, 2.0])
def test_sizes_are_as_sure_as_the_noise_that_is_left_allows(wrong):
    """Whatever is thought of the noise beforehand, what is left once the effect is known tells it."""
    built = built_reducer(parse_spec(spec_text(Reducer())))
    text = scan(Reducer(), [Hidden("disc_runout", {"amplitude_um": 2.0, "phase_deg": 70.0})], noise=Noise(0.3), seed=4)
    recording = hold_nothing_out(record(built, parse_measurement(text, "scan.csv")))
    recording = replace(recording, noise=replace(recording.noise, sigma=wrong * 0.3))
    model = ExactModel(built, [recording])
    library = Library(candidates(built, frozenset({0}), False), 2)
    runout = next(c for c in library.candidates if c.name == "disc_runout")
    optimum = model.optimum(Attempt((runout,), np.array([0.1, 0.3])), 0.0)
    assert optimum is not None
    variance = model.with_noise_left(optimum).covariance[0, 0]
    assert variance == pytest.approx(optimum.covariance[0, 0] / wrong**2, rel=0.05)
