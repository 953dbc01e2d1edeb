"""Chatter of a disc that was not scanned, found by the turns of a bench: the wave under each pin, and what is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.discrepancy.candidates import Candidate, candidates, chatter
from cycloid_profile.discrepancy.chatter_candidates import standing_out, with_waves_beside_others
from cycloid_profile.discrepancy.detection import detect
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.noise import Noise as Coloured
from cycloid_profile.discrepancy.normal import Whitened, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.recording import record
from cycloid_profile.discrepancy.waves_under_pins import WavesUnderPins, unscanned
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.process import CumulativePitchError, GrindingChatter
from cycloid_profile.effects.ring import PinCircleRadiusError
from cycloid_profile.measurement.files import Measurement, parse_measurement
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.spec.read import parse_spec
from tests.discrepancy.blind import Hidden, Noise, Reducer, spec_text
from tests.discrepancy.blind.turn import lost_motion, transmission_error

WAVE = {"amplitude_um": 0.08, "waves_per_turn": 462.63, "phase_deg": 168.0}
DISC_1 = GrindingChatter(**WAVE, disc=1)


@pytest.fixture(scope="module")
def drawn() -> Built:
    return built_reducer(parse_spec(spec_text(Reducer())))


def bench(machine: Built, seed: int) -> list[Measurement]:
    return [
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed, points=1500)),
        simulate(machine, "transmission_error", Settings(noise=0.15, seed=seed + 1, points=1500, torque=12.36e3)),
        simulate(machine, "lost_motion_map", Settings(noise=0.004, seed=seed + 2, points=300)),
    ]


def model_of(drawn: Built, *hidden: Effect, seed: int = 1) -> ExactModel:
    machine = drawn
    for effect in hidden:
        machine = effect.apply(machine)
    return ExactModel(drawn, [record(drawn, one) for one in bench(machine, seed)])


@pytest.fixture(scope="module")
def chattering(drawn) -> ExactModel:
    return model_of(drawn, DISC_1)


def mesh_orders(block: Whitened) -> np.ndarray:
    """Order 39·40 of the output turn and its first two multiples, which are no wave."""
    turned = [1560.0 * k * block.laid.position for k in (1, 2, 3)]
    return block.white(np.stack([wave(angle) for angle in turned for wave in (np.cos, np.sin)], axis=1))


def fall(blocks: list[Whitened], known: list[np.ndarray], wave: list[np.ndarray]) -> float:
    """What a wave lowers chi² by beside what is known, by least squares of all rows together."""
    of_file = [np.hstack([block.nuisance, mesh_orders(block)]) for block in blocks]
    nuisance = np.zeros((sum(len(b.z) for b in blocks), sum(own.shape[1] for own in of_file)))
    row = column = 0
    for own in of_file:
        nuisance[row : row + len(own), column : column + own.shape[1]] = own
        row, column = row + len(own), column + own.shape[1]
    z, before = np.concatenate([b.z for b in blocks]), np.hstack([nuisance, np.concatenate(known)])

    def left(A: np.ndarray) -> float:
        scale = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
        return float(np.sum((z - A @ (np.linalg.lstsq(A / scale, z, rcond=1e-9)[0] / scale)) ** 2))

    return left(before) - left(np.hstack([before, np.concatenate(wave)]))


@pytest.mark.parametrize("rho", [0.0, 0.5], ids=["white", "coloured"])
@pytest.mark.parametrize(("disc", "waves"), [(1, 462.6), (2, 300.0), (None, 215.3)])
def test_power_is_the_fall_of_chi2_by_the_shape_of_the_effect(drawn, chattering, disc, waves, rho):
    recordings = [replace(r, noise=Coloured(r.noise.sigma, rho)) for r in chattering.recordings]
    blocks = chattering.with_rows(recordings).nothing.blocks
    ring = next(c for c in candidates(drawn, frozenset(), True) if c.name == "pin_ring_oval")
    expected = fall(blocks, [b.columns([ring]) for b in blocks], [b.columns([chatter(waves, disc)]) for b in blocks])
    found = WavesUnderPins(blocks, [ring], disc).power(waves + np.array([0.0, 0.5]))
    # The columns of a candidate go by way of a grid, which follows a wave to some thousandths.
    assert found[0] == pytest.approx(expected, rel=5e-3)


def test_the_wave_and_its_disc_stand_out(chattering):
    peaks = {disc: WavesUnderPins(chattering.nothing.blocks, (), disc).strongest() for disc in (1, 2, None)}
    best = max(peaks, key=lambda disc: peaks[disc][0].power)
    assert best == 1
    assert peaks[1][0].waves == pytest.approx(462.63, abs=0.1)
    assert peaks[1][0].p_value < 1e-9
    assert [one.choice for one in standing_out(chattering) if one.choice.get("disc") == 1] == [
        {"waves_per_turn": peaks[1][0].waves, "disc": 1}
    ]


@pytest.mark.slow
def test_the_same_on_all_discs_is_another_hypothesis(drawn):
    blocks = model_of(drawn, GrindingChatter(**WAVE)).nothing.blocks
    peaks = {disc: WavesUnderPins(blocks, (), disc).strongest()[0] for disc in (1, 2, None)}
    assert max(peaks.values(), key=lambda peak: peak.power).disc is None
    assert peaks[None].waves == pytest.approx(462.63, abs=0.2)


def test_a_number_of_waves_is_kept_where_another_is_no_better(chattering):
    waves = WavesUnderPins(chattering.nothing.blocks, (), 1)
    best = waves.strongest()[0].waves
    assert waves.near(best + 0.02) == best + 0.02
    assert waves.near(best + 0.4) == pytest.approx(best, abs=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [10, 20, 30])
def test_noise_makes_no_wave(drawn, seed):
    model = model_of(drawn, seed=seed)
    assert all(WavesUnderPins(model.nothing.blocks, (), disc).strongest()[0].p_value > 1e-3 for disc in (1, 2, None))
    assert standing_out(model) == []


@pytest.mark.slow
def test_it_is_looked_for_where_chi2_shows_nothing(drawn):
    model = model_of(drawn, GrindingChatter(**WAVE | {"amplitude_um": 0.07}, disc=1))
    found = detect(model.nothing.blocks, normal(model.nothing.blocks, candidates(drawn, frozenset(), True)))
    striking = {finding.coordinate for finding in found.striking}
    assert "waves on disc 1" in striking
    assert "file" not in striking


def test_rows_too_far_apart_for_any_wave_show_none(drawn):
    few = record(drawn, simulate(drawn, "transmission_error", Settings(noise=0.15, seed=1, points=24)))
    assert WavesUnderPins(ExactModel(drawn, [few]).nothing.blocks, (), 1).strongest() == []


def test_a_disc_that_was_scanned_is_left_to_its_scan(drawn, chattering):
    scanned = record(drawn, simulate(drawn, "profile_scan", Settings(noise=0.3, seed=1)))
    both = ExactModel(drawn, [scanned, *chattering.recordings])
    assert unscanned(both.nothing.blocks) == [2]
    assert unscanned(ExactModel(drawn, [scanned]).nothing.blocks) == []


@pytest.mark.slow
def test_what_every_effect_shows_as_waves_is_no_chatter(drawn):
    """A runout that is not known yet fills the turns with waves, none of which explains most of it."""
    model = model_of(drawn, CumulativePitchError(amplitude_um=2.0, phase_deg=30.0, disc=1))
    assert standing_out(model) == []


@pytest.mark.slow
def test_it_is_named_beside_another_effect(drawn):
    """Where it was not sought, a bore of 0.31 µm was told alone, and the wave was taken for noise."""
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
    told = {effect.candidate.name: effect for effect in found.effects}
    wave = told.pop("grinding_chatter")
    assert wave.parameters["amplitude_um"] == pytest.approx(0.12, abs=3.0 * wave.uncertainty["amplitude_um"])
    waves = [place.candidate.choice["waves_per_turn"] for place in (wave, *wave.elsewhere)]
    assert min(abs(n - 462.63) for n in waves) < 0.1
    assert "crank_hole_error" in {name for effect in told.values() for name in effect.group}
    assert found.remainder is None


@pytest.mark.slow
def test_another_effect_is_tried_beside_a_wave_of_its_own(drawn):
    """A wave that nobody knew of lets another effect lead; beside its own wave the right one does."""
    model = model_of(drawn, DISC_1, PinCircleRadiusError(amount_um=-1.0))
    library = Library(candidates(drawn, frozenset(), True), 2)

    def fitted(name: str, *more: Candidate) -> Optimum:
        members = (next(c for c in library.candidates if c.name == name), *more)
        found = model.optimum(Attempt(members, np.array([-0.3, 0.0] + [0.05, 0.0] * len(more))), 0.0)
        assert found is not None
        return found

    right, wrong = fitted("pin_circle_radius_error"), fitted("generating_eccentricity_error")
    assert with_waves_beside_others(model, library, wrong, [right]) == (library, [])
    with_wave = fitted("generating_eccentricity_error", chatter(480.0, 2))
    larger, starts = with_waves_beside_others(model, library, with_wave, [wrong, right])
    (beside,) = {tuple(larger.candidates[i].name for i in members) for members, _ in starts}
    assert beside == ("pin_circle_radius_error", "grinding_chatter")
    waves = [larger.candidates[members[1]].choice["waves_per_turn"] for members, _ in starts]
    # Up to whole numbers to a lobe, which turns hardly tell.
    assert min(abs((n - WAVE["waves_per_turn"] + 19.5) % 39.0 - 19.5) for n in waves) < 0.1
