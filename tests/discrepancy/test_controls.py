"""Files that no set of effects may explain: the name must be withheld, and a wrong name must not fit."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid, settled
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.optimum import Attempt
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import Measurement, parse_measurement
from cycloid_profile.rig.registration import place_scan
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Noise, Reducer, loop, scan, spec_text

LOBES = 39
PITCH = Hidden("cumulative_pitch_error", {"amplitude_um": 2.4, "phase_deg": 70.0, "disc": 1})


@lru_cache(maxsize=1)
def built() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


def scanned(*effects: Hidden, seed: int = 1) -> Measurement:
    return parse_measurement(scan(Reducer(), effects, noise=Noise(0.3), seed=seed), "scan.csv")


def shuffled_lobes(measurement: Measurement, seed: int) -> Measurement:
    """The same lobes in another order: each turned into the place of another."""
    placed = place_scan(built().teeth[0], measurement)
    order = np.random.default_rng(seed).permutation(LOBES)
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    # A lobe is the sector about its own middle; the trochoid's lobes are counted along the disc, clockwise.
    turn = (order - np.arange(LOBES))[placed.lobe.astype(int)]
    z = z * np.exp(-2j * np.pi * turn / LOBES)
    return Measurement(measurement.kind, {"x_mm": z.real, "y_mm": z.imag}, measurement.keys, measurement.name)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lobes_in_another_order_have_no_name(seed):
    found = diagnose(built(), [shuffled_lobes(scanned(PITCH, seed=seed), seed)])
    assert found.verdict == "unknown_effect" or found.remainder is not None


@pytest.mark.slow
def test_a_wear_of_the_other_flank_is_not_the_same_wear():
    # The scan shows flank 1 worn, the bench flank 2: as if somebody had turned the disc over between the two.
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
    found = diagnose(built(), files)
    names = [e.candidate.name for e in found.effects]
    assert names != ["flank_wear"] or found.remainder is not None


@pytest.mark.parametrize(
    "wrong", ["disc_oval", "equidistant_error", "wheel_wear_drift", "flank_wear", "single_tooth_error"]
)
def test_a_wrong_name_does_not_fit_what_was_held_out(wrong):
    recording = record(built(), scanned(PITCH))
    model = ExactModel(built(), [recording])
    library = Library(candidates(built(), frozenset({0}), False), 2)
    best = []
    for candidate in [c for c in library.candidates if c.name == wrong][:8]:
        optimum = model.optimum(Attempt((candidate,), np.array([0.1, 0.1])), library.prior([candidate]))
        if optimum is not None:
            best.append(held_out_over_noise(model.at(optimum).laid[0]))
    assert best
    assert min(best) > 1.1
    right = next(c for c in library.candidates if c.name == PITCH.name)
    optimum = model.optimum(Attempt((right,), np.array([0.1, 0.1])), library.prior([right]))
    assert held_out_over_noise(model.at(optimum).laid[0]) < 1.1


def held_out_over_noise(laid: Laid) -> float:
    rows = laid.recording.held_out
    return float(np.sqrt(np.mean(settled(laid, True)[rows] ** 2)) / laid.recording.noise.sigma)
