"""Dense scans are averaged, and short scans say how many lobes they cover."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis.data.recording import MOST_ROWS, record
from cycloid_profile.effects import DiscRunout, SingleToothError
from cycloid_profile.measurement import PROFILE_SCAN, parse_measurement
from cycloid_profile.rig import Settings, register_scan, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Noise, Reducer, scan, spec_text

REDUCER = as_built_reducer(parse_spec(spec_text(Reducer())))
PARTS = 4


@pytest.mark.parametrize(
    "stated",
    [
        pytest.param(REDUCER, id="equal lobes"),
        pytest.param(SingleToothError(4.0, 7, 1).apply(REDUCER), id="one lobe", marks=pytest.mark.slow),
    ],
)
def test_dense_scan_is_averaged_without_bias(stated):
    made = DiscRunout(3.0, 40.0).apply(stated)
    exact = simulate(made, PROFILE_SCAN, Settings(points=PARTS * MOST_ROWS))
    recording = record(stated, exact)
    assert MOST_ROWS <= recording.rows.size < 2 * MOST_ROWS
    assert any(f"averaged in groups of {PARTS} neighbours" in note for note in recording.notes)
    full = register_scan(stated.teeth[0], exact)
    assert recording.placed is not None
    assert recording.placed.turn == pytest.approx(full.turn, abs=1e-8)
    x, y = (np.mod(one.along + np.pi, 2.0 * np.pi * 39) for one in (full, recording.placed))
    order = np.argsort(x)
    expected = np.interp(y, x[order], full.removal[order])
    # 1 nm is far below the accuracy of the simulation, 8 nm.
    assert np.max(np.abs(recording.placed.removal - expected)) < 1e-6


def test_a_fifth_of_each_lobe_is_held_out_as_a_block():
    recording = record(REDUCER, simulate(REDUCER, PROFILE_SCAN, Settings(points=4000)))
    lobe = recording.placed.lobe[recording.rows]
    shares = [float(np.mean(recording.held_out[lobe == one])) for one in range(39)]
    assert np.mean(shares) == pytest.approx(0.2, abs=0.03)
    assert max(shares) < 0.4
    # Neighbours share their fate: two blocks a lobe at most, not points here and there.
    assert np.count_nonzero(np.diff(recording.held_out.astype(int)) == 1) < 2 * 39


def test_noise_of_averaged_points():
    noisy = simulate(REDUCER, PROFILE_SCAN, Settings(points=PARTS * MOST_ROWS, noise=0.3, seed=1))
    stated = record(REDUCER, noisy)
    estimated = record(REDUCER, replace(noisy, keys={k: v for k, v in noisy.keys.items() if k != "noise_um"}))
    for recording in (stated, estimated):
        assert recording.noise.sigma == pytest.approx(0.3 / np.sqrt(PARTS), rel=0.03)
        assert recording.noise.rho == pytest.approx(0.0, abs=0.03)


@pytest.mark.slow
def test_noise_of_averaged_points_that_are_correlated():
    # ρ = 0.6 over groups of four: the mean scatters by √(4 + 2·(3ρ + 2ρ² + ρ³))/4 of the stated deviation.
    noise = Noise(0.3, rho=0.6, outliers=0.001, declare=True)
    text = scan(Reducer(), (), points=PARTS * MOST_ROWS, noise=noise, seed=4)
    recording = record(REDUCER, parse_measurement(text, "dense.csv"))
    expected = 0.3 * np.sqrt(4.0 + 2.0 * (3.0 * 0.6 + 2.0 * 0.36 + 0.216)) / 4.0
    # ρ is estimated next to the effects of a scan; white noise would have 0.15.
    assert recording.noise.sigma == pytest.approx(expected, rel=0.1)


def test_short_scan_says_how_many_lobes_it_covers():
    text = scan(Reducer(), (), points=4000, noise=Noise(0.3), missing_lobes=range(6, 40), seed=1)
    recording = record(REDUCER, parse_measurement(text, "five.csv"))
    assert recording.lobes_covered == 5
    assert any("34 of 39 lobes were not scanned" in note and "do not tell" in note for note in recording.notes)
    assert record(REDUCER, parse_measurement(scan(Reducer(), (), points=1200, seed=1), "all.csv")).lobes_covered == 39
