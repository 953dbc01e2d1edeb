"""Locations of an effect that the files do not separate, and the uncertainty of its size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose, effect_to_json
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.report.diagnosis import describe_effect
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Noise, Reducer, spec_text
from tests.diagnosis.blind.scan import scan
from tests.diagnosis.blind.turn import transmission_error


def reported(amplitude_um: float, **parts: int):
    oval = Hidden("disc_oval", {"amplitude_um": amplitude_um, "phase_deg": 60.0, **parts})
    text = transmission_error(Reducer(), [oval], torque_nm=412.0, rows=360, noise=Noise(0.15), seed=1)
    return diagnose(as_built_reducer(parse_spec(spec_text(Reducer()))), [parse_measurement(text, "te.csv")])


@pytest.mark.slow
def test_half_an_oval_on_both_discs_equals_a_whole_one_on_one():
    found = reported(0.3)
    (oval,) = found.effects
    assert oval.candidate.name == "disc_oval"
    places = {one.candidate.choice["disc"]: one for one in (oval, *oval.other_locations)}
    both = places[None]
    assert abs(both.parameters["amplitude_um"] - 0.3) < 3.0 * both.uncertainty["amplitude_um"]
    assert places[1].parameters["amplitude_um"] == pytest.approx(0.6, abs=0.05)
    notes = [note for note in found.notes if note.startswith("disc_oval of") and "fits as well" in note]
    assert len(notes) == len(oval.other_locations) > 0
    listed = effect_to_json(oval)["elsewhere"]
    assert len(listed) == len(oval.other_locations)
    assert all(one["uncertainty"].keys() == {"amplitude_um", "phase_deg"} for one in listed)
    assert ") or at another location, 0." in describe_effect(oval)


@pytest.mark.slow
def test_a_large_oval_of_one_disc_has_its_place_among_those_listed():
    """Its places differ by less than the error of the model: discs 1 and 2 by 0.01 of the logarithm of the evidence."""
    (oval,) = reported(1.0, disc=1).effects
    places = {one.parameters.get("disc"): one for one in (oval, *oval.other_locations)}
    assert places.keys() <= {None, 1, 2}
    assert places[1].parameters["amplitude_um"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("wrong", [0.5, 1.0, 2.0])
def test_uncertainties_follow_from_the_residual_noise(wrong):
    """The residual variance after the fit replaces the noise estimate made before it."""
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    text = scan(Reducer(), [Hidden("disc_runout", {"amplitude_um": 2.0, "phase_deg": 70.0})], noise=Noise(0.3), seed=4)
    recording = use_all_rows(record(reducer, parse_measurement(text, "scan.csv")))
    recording = replace(recording, noise=replace(recording.noise, sigma=wrong * 0.3))
    model = ExactModel(reducer, [recording])
    library = Library(candidates(reducer, frozenset({0}), False), 2)
    runout = next(c for c in library.candidates if c.name == "disc_runout")
    optimum = model.optimum(Attempt((runout,), np.array([0.1, 0.3])), 0.0)
    assert optimum is not None
    variance = model.with_residual_noise(optimum).covariance[0, 0]
    assert variance == pytest.approx(optimum.covariance[0, 0] / wrong**2, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("pin", [8, 28])
def test_a_thick_pin_has_its_place_among_those_listed(pin):
    """The pin across meets the second disc as this one meets the first."""
    hidden = [Hidden("single_pin_error", {"pin": pin, "amount_um": 3.3})]
    text = transmission_error(Reducer(), hidden, torque_nm=412.0, rows=360, noise=Noise(0.15), seed=pin)
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    found = diagnose(reducer, [parse_measurement(text, "te.csv")])
    (effect,) = found.effects
    assert effect.candidate.name == "single_pin_error"
    places = {one.candidate.choice["pin"] for one in (effect, *effect.other_locations)}
    assert places == {8, 28}
    assert [note for note in found.notes if note.startswith("single_pin_error of pin") and "fits as well" in note]
