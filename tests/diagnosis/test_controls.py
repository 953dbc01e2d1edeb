"""Negative controls: files that no set of effects explains, and wrong names that must not fit."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Residuals, diagnose, nuisance_fitted
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import Measurement, parse_measurement
from cycloid_profile.rig import register_scan
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Noise, Reducer, loop, scan, spec_text

LOBES = 39
PITCH = Hidden("cumulative_pitch_error", {"amplitude_um": 2.4, "phase_deg": 70.0, "disc": 1})


@lru_cache(maxsize=1)
def reducer() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


def scanned(*effects: Hidden, seed: int = 1) -> Measurement:
    return parse_measurement(scan(Reducer(), effects, noise=Noise(0.3), seed=seed), "scan.csv")


def shuffled_lobes(measurement: Measurement, seed: int) -> Measurement:
    """The lobes in random order, each rotated to the position of another."""
    placed = register_scan(reducer().teeth[0], measurement)
    order = np.random.default_rng(seed).permutation(LOBES)
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    # A lobe is the sector about its middle; the trochoid numbers lobes clockwise, along the disc.
    turn = (order - np.arange(LOBES))[placed.lobe.astype(int)]
    z = z * np.exp(-2j * np.pi * turn / LOBES)
    return Measurement(measurement.kind, {"x_mm": z.real, "y_mm": z.imag}, measurement.keys, measurement.name)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lobes_in_another_order_have_no_name(seed):
    found = diagnose(reducer(), [shuffled_lobes(scanned(PITCH, seed=seed), seed)])
    assert found.verdict == "unknown_effect" or found.remainder is not None


@pytest.mark.slow
def test_wear_of_the_other_flank_is_another_effect():
    # The scan shows flank 1 worn, the bench flank 2, as if the disc had been turned over.
    files = [
        scanned(Hidden("flank_wear", {"amount_um": 3.0, "flank": 1, "disc": 1})),
        parse_measurement(
            loop(
                Reducer(),
                [Hidden("flank_wear", {"amount_um": 3.0, "flank": 2, "disc": 1})],
                rows=80,
                noise=Noise(0.004),
            ),
            "loop.csv",
        ),
    ]
    found = diagnose(reducer(), files)
    names = [e.candidate.name for e in found.effects]
    assert names != ["flank_wear"] or found.remainder is not None


@pytest.mark.parametrize(
    "wrong",
    [
        "disc_oval",
        "equidistant_error",
        "wheel_wear_drift",
        pytest.param("flank_wear", marks=pytest.mark.slow),
        "single_tooth_error",
    ],
)
def test_a_wrong_name_does_not_fit_held_out_rows(wrong):
    recording = record(reducer(), scanned(PITCH))
    model = ExactModel(reducer(), [recording])
    library = Library(candidates(reducer(), frozenset({0}), False), 2)
    best = []
    for candidate in [c for c in library.candidates if c.name == wrong][:8]:
        optimum = model.optimum(Attempt((candidate,), np.array([0.1, 0.1])), library.prior([candidate]))
        if optimum is not None:
            best.append(held_out_over_noise(model.at(optimum).residuals[0]))
    assert best
    assert min(best) > 1.1
    right = next(c for c in library.candidates if c.name == PITCH.name)
    optimum = model.optimum(Attempt((right,), np.array([0.1, 0.1])), library.prior([right]))
    assert held_out_over_noise(model.at(optimum).residuals[0]) < 1.1


def held_out_over_noise(residuals: Residuals) -> float:
    rows = residuals.recording.held_out
    return float(np.sqrt(np.mean(nuisance_fitted(residuals, True)[rows] ** 2)) / residuals.recording.noise.sigma)
