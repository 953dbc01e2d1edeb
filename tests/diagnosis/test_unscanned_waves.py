"""Chatter of a disc without a scan, from bench turns through the loaded pins."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import block_diag, cholesky, solve_triangular

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.diagnosis.data.noise import Noise as Coloured
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.model.candidate import candidates, chatter
from cycloid_profile.diagnosis.model.detection import detect
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.unscanned_waves import UnscannedWaves, _power, unscanned
from cycloid_profile.diagnosis.model.whitened import Whitened, normal_equations
from cycloid_profile.diagnosis.search._fits import empty_fit
from cycloid_profile.diagnosis.search._waves import waves_left
from cycloid_profile.effects import AsBuiltReducer, CumulativePitchError, Effect, GrindingChatter
from cycloid_profile.measurement import Measurement, parse_measurement
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Noise, Reducer, spec_text
from tests.diagnosis.blind.turn import lost_motion, transmission_error

WAVE = {"amplitude_um": 0.08, "waves_per_turn": 462.63, "phase_deg": 168.0}
DISC_1 = GrindingChatter(**WAVE, disc=1)


@pytest.fixture(scope="module")
def drawn() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


def bench(machine: AsBuiltReducer, seed: int) -> list[Measurement]:
    return [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed, points=1500)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed + 1, points=1500, torque=12.36e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.004, seed=seed + 2, points=300)),
    ]


def model_of(drawn: AsBuiltReducer, *hidden: Effect, seed: int = 1) -> ExactModel:
    machine = drawn
    for effect in hidden:
        machine = effect.apply(machine)
    return ExactModel(drawn, [record(drawn, one) for one in bench(machine, seed)])


@pytest.fixture(scope="module")
def chattering(drawn) -> ExactModel:
    return model_of(drawn, DISC_1)


def mesh_orders(block: Whitened) -> np.ndarray:
    """Order 39·40 of the output turn and its first two multiples, which are no chatter."""
    turned = [1560.0 * k * block.residuals.position for k in (1, 2, 3)]
    return block.white(np.stack([wave(angle) for angle in turned for wave in (np.cos, np.sin)], axis=1))


def fall(blocks: list[Whitened], known: list[np.ndarray], wave: list[np.ndarray]) -> float:
    """Fall of chi² by a wave given the known effects, by least squares over all rows and their whole covariance."""
    free = [np.hstack([block.nuisance[:, : block.known], mesh_orders(block)]) for block in blocks]
    error = block_diag(*(b.nuisance[:, b.known : b.known + b.residuals.model_error.shape[1]] for b in blocks))
    root = cholesky(np.eye(len(error)) + error @ error.T, lower=True)
    z, before, more = (
        solve_triangular(root, values, lower=True)
        for values in (
            np.concatenate([b.z for b in blocks]),
            np.hstack([block_diag(*free), np.concatenate(known)]),
            np.concatenate(wave),
        )
    )

    def left(A: np.ndarray) -> float:
        scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
        return float(np.sum((z - A @ (np.linalg.lstsq(A / scale, z, rcond=1e-9)[0] / scale)) ** 2))

    return left(before) - left(np.hstack([before, more]))


@pytest.mark.parametrize("rho", [0.0, 0.5], ids=["white", "coloured"])
@pytest.mark.parametrize(
    ("disc", "waves", "speed"),
    [(1, 462.6, "generating"), (2, 300.0, "generating"), (None, 215.3, "generating"), (1, 200.4, "c_axis")],
)
def test_power_is_the_fall_of_chi2_by_the_shape_of_the_effect(drawn, chattering, disc, waves, speed, rho):
    recordings = [replace(r, noise=Coloured(r.noise.sigma, rho)) for r in chattering.recordings]
    blocks = chattering.with_held_out(recordings).baseline.blocks
    ring = next(c for c in candidates(drawn, frozenset(), True) if c.name == "pin_ring_oval")
    wave = chatter(waves, disc, priors_of(drawn), speed)
    expected = fall(blocks, [b.columns([ring]) for b in blocks], [b.columns([wave]) for b in blocks])
    found = UnscannedWaves(blocks, [ring], disc).power(waves + np.array([0.0, 0.5]), speed)
    # Candidate columns are interpolated on a grid, to some thousandths.
    assert found[0] == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(("independence", "seen"), [(0.08, False), (0.12, True), (0.9, True)])
def test_waves_whose_cosine_and_sine_are_nearly_one_column_have_no_power(independence, seen):
    # Two rows in quadrature, so that cosine and sine span both: the fall is the whole χ². One row is lower than the
    # other by tan(½ asin(independence)): twice the product of both over the sum of their squares is the independence.
    z, C = np.array([1.3, -0.7]), np.array([1.0, 1j * np.tan(0.5 * np.arcsin(independence))])
    whole = np.sum(np.abs(C) ** 2)
    assert _power(z @ C, np.sum(C * C), whole, whole) == pytest.approx(z @ z if seen else 0.0)


def test_noise_alone_has_no_excess(drawn):
    found = UnscannedWaves(model_of(drawn).baseline.blocks, (), 1)
    # Two standard deviations of chi² below the number of rows, give or take two.
    assert -6.0 < found.excess / np.sqrt(found.z.size) < -0.5


def test_wave_and_disc_are_identified(chattering):
    peaks = {disc: UnscannedWaves(chattering.baseline.blocks, (), disc).strongest() for disc in (1, 2, None)}
    best = max(peaks, key=lambda disc: peaks[disc][0].power)
    assert best == 1
    assert peaks[1][0].waves == pytest.approx(462.63, abs=0.1)
    assert peaks[1][0].p_value < 1e-6
    assert [
        one.choice for one in waves_left(chattering, empty_fit(chattering).optimum) if one.choice.get("disc") == 1
    ] == [{"waves_per_turn": peaks[1][0].waves, "disc": 1, "constant_speed": "generating"}]


@pytest.mark.slow
@pytest.mark.parametrize("speed", ["c_axis", "surface"])
def test_waves_even_in_another_motion_are_proposed_in_that_motion(drawn, speed):
    model = model_of(drawn, GrindingChatter(**WAVE | {"amplitude_um": 0.3}, disc=1, constant_speed=speed))
    # Angle of the C axis and arc length hardly differ, so that both may explain as much.
    of_disc = [one.choice for one in waves_left(model, empty_fit(model).optimum) if one.choice["disc"] == 1]
    found = {one["constant_speed"]: one["waves_per_turn"] for one in of_disc}
    assert "generating" not in found
    assert found[speed] == pytest.approx(462.63, abs=0.1)


@pytest.mark.slow
def test_the_same_on_all_discs_is_another_hypothesis(drawn):
    blocks = model_of(drawn, GrindingChatter(**WAVE)).baseline.blocks
    peaks = {disc: UnscannedWaves(blocks, (), disc).strongest()[0] for disc in (1, 2, None)}
    assert max(peaks.values(), key=lambda peak: peak.power).disc is None
    assert peaks[None].waves == pytest.approx(462.63, abs=0.2)


def test_a_number_of_waves_is_kept_where_another_is_no_better(chattering):
    waves = UnscannedWaves(chattering.baseline.blocks, (), 1)
    best = waves.strongest()[0].waves
    assert waves.near(best + 0.02) == best + 0.02
    assert waves.near(best + 0.4) == pytest.approx(best, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [10, 20, 30])
def test_noise_makes_no_wave(drawn, seed):
    model = model_of(drawn, seed=seed)
    assert all(UnscannedWaves(model.baseline.blocks, (), disc).strongest()[0].p_value > 1e-3 for disc in (1, 2, None))
    assert waves_left(model, empty_fit(model).optimum) == []


@pytest.mark.slow
def test_waves_are_tested_without_excess_chi2(drawn):
    model = model_of(drawn, GrindingChatter(**WAVE | {"amplitude_um": 0.07}, disc=1))
    found = detect(model.baseline.blocks, normal_equations(model.baseline.blocks, candidates(drawn, frozenset(), True)))
    coordinates = {finding.coordinate for finding in found.significant_findings}
    assert "waves on disc 1" in coordinates
    assert "file" not in coordinates


def test_wide_row_spacing_gives_no_wave(drawn):
    subsampled = record(drawn, simulate(drawn, "transmission_error", Settings(noise=0.15, seed=1, points=24)))
    assert UnscannedWaves(ExactModel(drawn, [subsampled]).baseline.blocks, (), 1).strongest() == []


def test_a_scanned_disc_is_not_tested_on_turns(drawn, chattering):
    scanned = record(drawn, simulate(drawn, "profile_scan", Settings(noise=0.3, seed=1)))
    both = ExactModel(drawn, [scanned, *chattering.recordings])
    assert unscanned(both.baseline.blocks) == [2]
    assert unscanned(ExactModel(drawn, [scanned]).baseline.blocks) == []


@pytest.mark.slow
def test_an_unknown_effect_is_not_named_chatter(drawn):
    """An unknown runout fills the spectrum of turns with waves, none of which explains most of it."""
    model = model_of(drawn, CumulativePitchError(amplitude_um=2.0, phase_deg=30.0, disc=1))
    assert waves_left(model, empty_fit(model).optimum) == []


@pytest.mark.slow
def test_chatter_is_named_with_another_effect(drawn):
    """Without the wave a bore of 0.31 µm was named alone, and the wave counted as noise."""
    hidden = (
        Hidden("grinding_chatter", WAVE | {"amplitude_um": 0.12, "disc": 1}),
        Hidden("crank_hole_error", {"amplitude_um": 0.31, "direction_deg": 323.0, "crank": 2, "disc": 2}),
    )
    texts = {
        "te": transmission_error(Reducer(), hidden, torque_nm=412.0, rows=1500, noise=Noise(0.15), seed=1),
        "te_light": transmission_error(Reducer(), hidden, torque_nm=12.36, rows=1500, noise=Noise(0.15), seed=2),
        "lost_motion": lost_motion(Reducer(), hidden, rows=300, noise=Noise(0.004), seed=3),
    }
    found = diagnose(drawn, [parse_measurement(text, f"{name}.csv") for name, text in texts.items()])
    reported = {effect.candidate.name: effect for effect in found.effects}
    wave = reported.pop("grinding_chatter")
    assert wave.parameters["amplitude_um"] == pytest.approx(0.12, abs=3.0 * wave.uncertainty["amplitude_um"])
    waves = [place.candidate.choice["waves_per_turn"] for place in (wave, *wave.other_locations)]
    assert min(abs(n - 462.63) for n in waves) < 0.1
    assert "crank_hole_error" in {name for effect in reported.values() for name in effect.group}
    assert found.remainder is None
