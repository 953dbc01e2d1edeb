"""Families of tests of the residual: each finds a planted deviation, with the probability of its statistic."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2, norm

from cycloid_profile.diagnosis import Residuals
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.recording import use_all_rows
from cycloid_profile.diagnosis.model import detection as tests_of
from cycloid_profile.diagnosis.model.detection import Finding, detect, detect_given, largest_finding, largest_gain
from cycloid_profile.diagnosis.model.whitened import Whitened, normal_equations
from tests.diagnosis.test_likelihood import equations, library, residuals
from tests.diagnosis.test_moves import scanned, some

SIGMA, ACCURACY = 0.3, 0.008
LOBES = 39


def planted(form, kind: str = "scan", noise: float = 1.0) -> Whitened:
    """Rows of a file, all fitted, that hold a form and white noise of a known size."""
    one = scanned(0) if kind == "scan" else residuals(kind)
    one = one.under(replace(use_all_rows(one.recording), noise=Noise(SIGMA)))
    draw = np.random.default_rng(12).normal(size=one.residual.size)
    one.residual = noise * SIGMA * draw + form(one)
    return Whitened(one)


def found_by(block: Whitened, coordinate: str) -> Finding:
    """The last of a coordinate: windows of rows come before whole lobes."""
    return [f for f in tests_of._block_findings(block, block.projected(block.z)) if f.coordinate == coordinate][-1]


def two_sided(score: float, looks: int) -> float:
    return 1.0 - (1.0 - 2.0 * norm.sf(abs(score))) ** looks


def test_the_noise_alone_is_within_the_probabilities():
    found = detect([planted(lambda one: 0.0 * one.residual)], None)
    assert not found.significant
    assert found.p_value == pytest.approx(1.0 - (1.0 - min(f.p_value for f in found.findings)) ** found.families)
    assert [f.p_value for f in found.findings] == sorted(f.p_value for f in found.findings)


def test_a_deviating_lobe_is_found_with_its_mean():
    block = planted(lambda one: 0.5 * (one.lobe == 10))
    found, z = found_by(block, "lobe"), block.projected(block.z)
    own = z[block.residuals.lobe == 10]
    assert (found.start, found.end) == (11.0, 12.0)
    assert found.amplitude == pytest.approx(np.mean(own) * SIGMA)
    assert found.p_value == pytest.approx(two_sided(np.sum(own) / math.sqrt(own.size), LOBES), rel=1e-6)
    assert found.over_accuracy == pytest.approx(abs(found.amplitude) / (5.0 * ACCURACY))


def test_a_deviating_phase_is_found_in_degrees_about_the_root():
    # 15° of phase, −30° to −15°, on every lobe.
    block = planted(lambda one: 0.4 * ((one.phase > np.radians(-30.0)) & (one.phase < np.radians(-15.0))))
    found, z = found_by(block, "psi_deg"), block.projected(block.z)
    degrees = np.degrees(np.mod(block.residuals.phase + math.pi, 2.0 * math.pi) - math.pi)
    own = z[(degrees >= -30.0) & (degrees < -15.0)]
    assert (found.start, found.end) == (-30.0, -15.0)
    assert found.amplitude == pytest.approx(np.mean(own) * SIGMA)
    assert found.p_value == pytest.approx(two_sided(np.sum(own) / math.sqrt(own.size), 24), rel=1e-6)
    assert found.over_accuracy == pytest.approx(abs(found.amplitude) / (2.0 * ACCURACY))


def test_a_short_deviation_is_found_in_a_window_of_its_rows():
    rows = slice(200, 240)
    block = planted(lambda one: np.where((np.arange(one.residual.size) // 40) == 5, 0.6, 0.0))
    z, position = block.projected(block.z), block.residuals.position
    base = Finding("", "um", "lobe", 0.0, 0.0, 0.0, 1.0)
    found = tests_of._windows(base, z, position, 40, SIGMA)
    # The largest row counts as much as the second largest.
    *_, second, largest = np.sort(np.abs(z[rows]))
    assert second > 3.0
    score = (np.sum(z[rows]) - (largest - second)) / math.sqrt(40.0)
    # Windows overlap by a half: 2·600/40 − 1 of them.
    assert found.p_value == pytest.approx(two_sided(score, 2 * (z.size // 40) - 1), rel=1e-6)
    assert found.amplitude == pytest.approx(np.mean(z[rows]) * SIGMA)
    # Lobe 1 has its root in the middle, where the position along the disc is π.
    assert found.start == pytest.approx(position[200] / (2.0 * math.pi) + 1.0)
    assert found.end == pytest.approx(position[240] / (2.0 * math.pi) + 1.0)
    windows = [one for one in tests_of._block_findings(block, z) if one.coordinate == "lobe"]
    assert len(windows) == 5  # of 4, 12, 40 and 120 rows, and the lobes
    assert found.amplitude in [one.amplitude for one in windows]
    of_angle = tests_of._windows(replace(base, coordinate="output_angle_deg"), z, position, 40, SIGMA)
    assert of_angle.start == pytest.approx(math.degrees(position[200]))
    of_row = tests_of._windows(replace(base, coordinate="row"), z, position, 40, SIGMA)
    assert of_row.end == pytest.approx(position[240])


def test_a_deviation_is_as_improbable_inwards_as_outwards():
    def form(one: Residuals) -> np.ndarray:
        return 0.5 * (one.lobe == 10) + 0.2 * np.cos(one.phase)

    blocks = planted(form), planted(lambda one: -form(one), noise=-1.0)
    outwards, inwards = ([f for f in detect([block], None).findings if f.coordinate != "file"] for block in blocks)
    assert [(f.coordinate, f.start) for f in inwards] == [(f.coordinate, f.start) for f in outwards]
    np.testing.assert_allclose([f.p_value for f in inwards], [f.p_value for f in outwards], rtol=1e-9)
    np.testing.assert_allclose([abs(f.amplitude) for f in inwards], [abs(f.amplitude) for f in outwards], rtol=1e-9)
    assert {f.coordinate for f in outwards if f.amplitude > 0.0} >= {"lobe", "psi_deg"}
    assert {f.coordinate for f in inwards if f.amplitude < 0.0} == {"lobe", "psi_deg"}


def test_one_reading_error_is_no_deviation_but_two_neighbours_are():
    draw = np.random.default_rng(3)
    z = draw.standard_normal(400)
    base, position = Finding("", "um", "row", 0.0, 0.0, 0.0, 1.0), np.arange(400.0)
    z[[101, 102]] = 0.0, 10.0
    assert tests_of._windows(base, z, position, 4, SIGMA).p_value > 0.05
    z[101] = 10.0
    assert tests_of._windows(base, z, position, 4, SIGMA).p_value < 1e-9


@pytest.mark.parametrize("kind", ["scan", "turn"])
def test_a_wave_is_found_by_its_order_and_amplitude(kind):
    def wave(one: Residuals) -> np.ndarray:
        turn = (one.position - math.pi) / LOBES if kind == "scan" else one.position
        return 0.5 * np.cos(5.0 * turn + 1.0)

    block = planted(wave, kind, noise=0.2)
    found = found_by(block, "waves per turn" if kind == "scan" else "order")
    assert (found.start, found.end) == (5.0, 5.0)
    assert found.amplitude == pytest.approx(0.5, rel=0.1)
    accuracy = block.residuals.recording.accuracy
    assert found.over_accuracy == pytest.approx(found.amplitude / (math.sqrt(2.0) * accuracy))
    # The statistic is the fall of χ² by cosine and sine together, of two degrees of freedom.
    angle = 5.0 * ((block.residuals.position - math.pi) / LOBES if kind == "scan" else block.residuals.position)
    G = block.white(np.stack([np.cos(angle), np.sin(angle)], axis=1))
    R, b = block.product(G, G), block.product(G, block.z)
    p = chi2.sf(float(b @ np.linalg.solve(R, b)), 2)
    # Low orders; of a turn also six multiples of lobes and pins, and their product.
    looks = 12 if kind == "scan" else 12 + 6 + 6 + 1
    assert found.p_value == pytest.approx(1.0 - (1.0 - p) ** looks, rel=1e-6, abs=1e-15)


def test_a_file_with_more_variance_than_noise_says_how_much():
    block = planted(lambda one: 0.0 * one.residual, noise=2.0)
    found, z = found_by(block, "file"), block.projected(block.z)
    excess = float(z @ z) / z.size - 1.0
    assert found.amplitude == pytest.approx(SIGMA * math.sqrt(excess))
    # The variance of χ²/n is 2/n; that of the estimated noise up to 8/n.
    assert found.p_value == pytest.approx(norm.sf(excess / math.sqrt(10.0 / z.size)), rel=1e-9)
    assert found.over_accuracy == pytest.approx(found.amplitude / ACCURACY)


def test_waves_of_chatter_are_found_in_the_spectrum():
    block = planted(lambda one: 0.4 * np.real(one.waves(200.5)))
    (found,) = tests_of._chatter_findings(block, block.projected(block.z))
    assert found.coordinate == "waves per turn"
    assert found.start == found.end == pytest.approx(200.5, abs=0.5)
    assert found.amplitude == pytest.approx(0.4, rel=0.15)
    assert found.over_accuracy == pytest.approx(found.amplitude / (math.sqrt(2.0) * ACCURACY))
    assert found in detect([block], None).significant_findings
    # A turn shows waves of the disc through many pins at a time: it has orders, but no waves of its own.
    assert {one.coordinate for one in detect([planted(lambda one: 0.0 * one.residual, "turn")], None).findings} == {
        "file", "output_angle_deg", "order",
    }  # fmt: skip


def test_each_effect_is_tested_at_its_best_place():
    teeth = [one for one in library(False) if one.name == "single_tooth_error"][:2]
    members = [*some("disc_oval", "flank_wear", disc=1), *teeth]
    R, u = np.diag([30.0, 20.0, 25.0, 0.0, 9.0, 0.0, 16.0, 0.0]), np.array([0.3, -0.4, 1.0, 0.0, 0.5, 0.0, 1.0, 0.0])
    linear = equations(R @ u, R, members)
    found = {one.coordinate.removeprefix("shape of "): one for one in tests_of._library_findings(linear)}
    assert set(found) == {"disc_oval", "flank_wear", "single_tooth_error"}
    for name, fall, degrees, looks, size, width in (
        ("disc_oval", 30.0 * 0.09 + 20.0 * 0.16, 2, 1, 0.5, members[0].width),
        ("flank_wear", 25.0, 1, 1, 1.0, members[1].width),
        ("single_tooth_error", 16.0, 1, 2, 1.0, members[3].width),
    ):
        assert found[name].p_value == pytest.approx(1.0 - (1.0 - chi2.sf(fall, degrees)) ** looks)
        assert found[name].amplitude == pytest.approx(size * width)
        # 1000 rows with a standard deviation of 0.3.
        assert found[name].over_accuracy == pytest.approx(math.sqrt(fall / 1000.0) * 0.3 / 0.008)
    assert largest_gain(linear) == pytest.approx(25.0)
    assert largest_gain(equations(np.zeros(8), R, members)) == 0.0


def test_fitted_effects_leave_no_findings():
    members = list(some("disc_oval", disc=1))

    def oval(one: Residuals) -> np.ndarray:
        return one.columns(members)[:, 0] @ np.array([1.0, -0.5])

    block = planted(oval)
    assert detect([block], normal_equations([block], members)).significant
    columns = [block.columns(members)]
    with_oval, without = (detect([one], None, columns) for one in (block, planted(lambda one: 0.0 * one.residual)))
    # Whatever its size: these families know nothing of what the oval fits.
    for coordinate in ("file", "lobe", "psi_deg"):
        both = [sorted(f.p_value for f in one.findings if f.coordinate == coordinate) for one in (with_oval, without)]
        assert both[0] == pytest.approx(both[1], rel=1e-6)
    plain = detect([block], None)
    assert detect_given([block], []).p_value == plain.p_value
    assert detect_given([block], members).p_value == with_oval.p_value


def test_the_largest_place_comes_before_a_whole_file():
    one = Finding("scan.csv", "um", "lobe", 3.0, 4.0, -0.5, 1e-9, 9.0)
    other, file = replace(one, amplitude=0.3), replace(one, coordinate="file", amplitude=2.0)
    within = replace(one, amplitude=5.0, over_accuracy=0.9)
    by_chance = replace(one, amplitude=5.0, p_value=0.01)
    found = tests_of.Detection(1e-8, 5, (one, other, file, within, by_chance))
    assert found.significant_findings == (one, other, file)
    assert largest_finding(found) is one
    assert largest_finding(replace(found, findings=(file,))) is file
    assert tests_of.Detection(0.0049, 1, ()).significant
    assert not tests_of.Detection(0.0051, 1, ()).significant
