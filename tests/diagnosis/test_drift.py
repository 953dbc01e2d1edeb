"""Drift: found where a turn does not close or an origin moves, and no hindrance to effects where they do not."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.diagnosis.data import record
from cycloid_profile.diagnosis.data._drift import loop_drift, origin_drift, turn_drift
from cycloid_profile.diagnosis.data.noise import Noise as RowNoise
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import REDUCERS, Hidden, Noise, loop, scan, spec_text

ROWS = 3000
ANGLE = np.arange(ROWS) * 2.0 * np.pi / ROWS
EFFECTS = 5.0 * np.cos(ANGLE + 1.0) + 3.0 * np.cos(39 * ANGLE) + 2.0 * np.cos(5 * ANGLE) + 2.0 * np.cos(1404 * ANGLE)
RAMP = np.linspace(-1.0, 1.0, ROWS)


def turns(slope: float, effects: np.ndarray = EFFECTS) -> list[float]:
    noise = [np.random.default_rng(seed).normal(size=ROWS) for seed in range(20)]
    return [turn_drift(one + slope * RAMP + effects, ANGLE, RowNoise(1.0), [39, 40]) for one in noise]


def test_a_turn_that_closes_has_no_drift():
    # So effects of order one keep all their information; a free line would take 61 % of a sine.
    assert sum(width > 0.0 for width in turns(0.0)) <= 1


def test_a_high_order_of_pins_is_no_drift():
    assert sum(width > 0.0 for width in turns(0.0, EFFECTS + 10.0 * np.sin(12 * ANGLE))) <= 1


def test_drift_of_half_a_standard_deviation_is_found():
    assert np.allclose(turns(0.5), 1.0, atol=0.5)


@pytest.mark.parametrize("slope", [0.0, 2.0])
def test_the_zero_of_the_angles_does_not_change_a_drift(slope):
    # On unevenly spaced rows a constant is no sum of waves.
    angle = 2.0 * np.pi * np.linspace(0.0, 1.0, 600) ** 1.5
    residual = np.random.default_rng(1).normal(size=600) + slope * np.linspace(-1.0, 1.0, 600)
    width = turn_drift(residual, angle, RowNoise(1.0))
    assert (width > 0.0) == (slope > 0.0)
    assert turn_drift(residual + 1000.0, angle, RowNoise(1.0)) == pytest.approx(width, abs=1e-6)


def test_a_texture_of_slow_waves_is_no_drift():
    # Part of each wave of 13 to 60 a turn looks like a ramp, which the scatter of the rows does not account for.
    angle, orders = np.arange(300) * 2.0 * np.pi / 300, np.arange(13, 61)
    found = []
    for seed in range(10):
        draws = np.random.default_rng(seed)
        waves = 3.0 * np.cos(angle[:, np.newaxis] * orders + draws.uniform(0.0, 2.0 * np.pi, orders.size))
        found.append(turn_drift(draws.normal(size=300) + np.sum(waves, axis=1), angle, RowNoise(1.0)))
    assert sum(width > 0.0 for width in found) <= 1


def test_part_of_a_turn_shows_no_drift():
    part = slice(0, ROWS // 2)
    assert turn_drift((3.0 * RAMP)[part], ANGLE[part], RowNoise(1.0)) == 0.0


TIME = np.linspace(-1.0, 1.0, 240)
PATHS = {"none": 0.0 * TIME, "line": 2.0 * TIME, "half a wave": 3.0 * np.cos(0.5 * np.pi * TIME)}


@pytest.mark.parametrize("path", PATHS)
def test_drift_of_a_loop(path):
    torque = np.concatenate([np.linspace(0, 400, 48), np.linspace(400, -400, 96), np.linspace(-400, 400, 96)])
    rows = np.flatnonzero(np.abs(torque) > 20.0)
    residual = 0.05 * torque + 8.0 * np.sign(torque) + 3.0 * np.sign(np.gradient(torque))
    widths = []
    for seed in range(10):
        noisy = residual + np.random.default_rng(seed).normal(size=240) + PATHS[path]
        widths.append(loop_drift(noisy[rows], torque[rows], rows, RowNoise(1.0)) > 0.0)
    assert sum(widths) <= 1 if path == "none" else sum(widths) >= 8


def test_a_loop_that_passes_each_branch_once_shows_no_drift():
    # On one pass the time is a function of the torque: a drift cannot be distinguished from an effect.
    torque = np.concatenate([np.linspace(-400, 400, 120), np.linspace(400, -400, 120)])
    assert loop_drift(50.0 * np.linspace(-1.0, 1.0, 240), torque, np.arange(240), RowNoise(1.0)) == 0.0


def test_errors_that_no_form_describes_are_no_drift_of_few_points():
    # 15 points less three fixed columns and four of the drift leave eight degrees of freedom: the limit of χ² for one
    # file in 80 is passed as often as F with four and eight degrees exceeds a quarter of it.
    towards, count = np.exp(2j * np.pi * np.arange(15) / 15), 400
    found = [
        origin_drift(
            5.0 * np.random.default_rng(seed).normal(size=15), towards, np.arange(15), np.ones((15, 1)), RowNoise(1.0)
        )
        for seed in range(count)
    ]
    expected = stats.f.sf(stats.chi2.isf(1.0 / 80.0, 4) / 4.0, 4, 8)
    assert np.mean(np.array(found) > 0.0) == pytest.approx(expected, abs=4.0 * np.sqrt(expected / count))


def test_waves_that_no_form_describes_do_not_change_the_width_of_a_drift():
    # Chatter, say, scatters by three standard deviations; the origin moves by two from the middle to either end.
    rng, rows, towards = np.random.default_rng(3), np.arange(ROWS), np.exp(1j * ANGLE)
    drift = 2.0 * RAMP * np.cos(ANGLE)
    widths = [
        origin_drift(drift + level * rng.normal(size=ROWS), towards, rows, np.ones((ROWS, 1)), RowNoise(1.0))
        for level in (1.0, 3.0)
    ]
    np.testing.assert_allclose(widths, widths[0], rtol=0.25)


def widths_of_scans(drift_um: float, *hidden: Hidden) -> list[float]:
    """Widths found on scans of small drives whose origin wanders by a slope and half a wave, in random directions."""
    reducer = REDUCERS["11 lobes"]
    built = as_built_reducer(parse_spec(spec_text(reducer)))
    noise = Noise(0.3, drift=drift_um / 0.3)
    texts = [scan(reducer, hidden, points=1600, noise=noise, turn_deg=40.0 * k, seed=k) for k in range(6)]
    return [record(built, parse_measurement(text, "scan.csv")).drift for text in texts]


@pytest.mark.parametrize(
    "hidden",
    [
        (),
        (Hidden("cumulative_pitch_error", {"amplitude_um": 3.0, "phase_deg": 80.0}),),
        (Hidden("wheel_wear_drift", {"amount_um": 3.0, "first_lobe": 4}),),
        (Hidden("grinding_chatter", {"amplitude_um": 0.8, "waves_per_turn": 131.4, "phase_deg": 10.0}),),
    ],
    ids=lambda hidden: hidden[0].name if hidden else "nothing",
)
def test_effects_of_a_scan_are_no_drift_of_its_origin(hidden):
    assert sum(width > 0.0 for width in widths_of_scans(0.0, *hidden)) <= 1


def test_drift_of_the_origin_of_a_scan_is_found_with_its_size():
    found = widths_of_scans(0.3)
    assert sum(width > 0.0 for width in found) >= 5
    # Twice the size: root mean square 0.3 µm in x and in y, from 1,600 points in noise of 0.3 µm.
    assert 0.4 < float(np.median(found)) < 1.6


def test_a_scan_of_a_perfect_disc_agrees_though_its_origin_drifts():
    reducer = REDUCERS["29 lobes"]
    text = scan(reducer, noise=Noise(0.3, drift=2.0), seed=5)
    built = as_built_reducer(parse_spec(spec_text(reducer)))
    found = diagnose(built, [parse_measurement(text, "scan.csv")])
    assert found.verdict == "agrees"
    assert any("origin drifts" in note for note in found.notes)


@pytest.mark.parametrize(
    ("creep", "verdict"), [(0.0, "agrees"), pytest.param(0.12, "unknown_effect", marks=pytest.mark.slow)]
)
def test_a_loop_that_creeps_does_not_agree_and_one_that_drifts_with_the_noise_does(creep: float, verdict: str) -> None:
    hidden = [Hidden("x_loop_creep", {"amount_arcmin": creep, "rows": 90.0})] if creep else []
    drawing = REDUCERS["11 lobes"]
    text = loop(drawing, hidden, noise=Noise(0.004, drift=0.0 if creep else 2.0), seed=3)
    found = diagnose(as_built_reducer(parse_spec(spec_text(drawing))), [parse_measurement(text, "loop.csv")])
    assert found.verdict == verdict
    assert any("rows drift" in note for note in found.notes)
    if creep:
        assert found.remainder is not None
        assert found.remainder.coordinate == "row"
        assert found.remainder.amplitude == pytest.approx(0.5 * creep, rel=0.5)
