"""Noise of single files: every class is estimated on short files too, whatever effects the residual contains.

Tolerances are about four standard errors of the simulated means; docs/diagnosis.md has the scatter of one file.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.signal import lfilter

from cycloid_profile.diagnosis.data._branches import contrasts_of_branches
from cycloid_profile.diagnosis.data._reading_errors import gross_errors
from cycloid_profile.diagnosis.data.noise import Noise, estimate_noise, local_noise

CLASSES = {"white": (0.0, 0.0), "AR(1) 0.5": (0.5, 0.0), "AR(1) 0.7": (0.7, 0.0), "AR(2)": (0.64, -0.4)}
SEEDS = range(8)


def draw(rows: int, rho: float, partial: float, seed: int) -> np.ndarray:
    """Stationary noise of standard deviation 1."""
    white = np.random.default_rng(seed).normal(size=rows + 300)
    noise = Noise(1.0, rho, partial)
    return noise.innovation * lfilter([1.0], [1.0, -rho * (1.0 - partial), -partial], white)[300:]


TORQUE = np.concatenate([np.linspace(0, 1, 48), np.linspace(1, -1, 96), np.linspace(-1, 1, 96)])


def branches() -> np.ndarray:
    """Rows of a loop of 240 rows away from zero torque: five runs."""
    return np.flatnonzero((np.abs(TORQUE) > 0.05) & (np.abs(TORQUE) < 0.98))


def shape_of(kind: str, rows: int) -> np.ndarray:
    """A typical large effect, in standard deviations of the noise."""
    x = np.arange(rows) * 2.0 * np.pi / rows
    if kind == "loop":
        torque = np.interp(np.arange(rows), [0, 48, 144, 239], [0, 1, -1, 1])
        return 20.0 * torque + 8.0 * np.tanh(6.0 * torque) + 5.0 * np.sign(np.gradient(torque))
    return 8.0 * np.cos(x + 1.0) + 5.0 * np.cos(39 * x) + 4.0 * np.cos(40 * x)


# Without an effect, the easier case, the most correlated class alone.
CASES = [("AR(1) 0.7", False), *((name, True) for name in ("AR(1) 0.7", "AR(2)"))]
CASES += [pytest.param(name, True, marks=pytest.mark.slow) for name in ("white", "AR(1) 0.5")]


@pytest.mark.parametrize(("kind", "rows", "tolerance"), [("loop", 240, 0.14), ("map", 600, 0.12), ("turn", 3000, 0.05)])
@pytest.mark.parametrize(("name", "with_effect"), CASES)
def test_standard_deviation_and_mean_of_forty_rows(kind, rows, tolerance, name, with_effect):
    index = branches() if kind == "loop" else np.arange(rows)
    true = Noise(1.0, *CLASSES[name])
    found = []
    for seed in SEEDS:
        residual = draw(rows, true.rho, true.partial, seed) + with_effect * shape_of(kind, rows)
        found.append(estimate_noise(residual[index], index))
    assert np.mean([noise.sigma for noise in found]) == pytest.approx(1.0, abs=tolerance)
    ratio = np.median([noise.mean_sigma(40) for noise in found]) / true.mean_sigma(40)
    assert ratio == pytest.approx(1.0, abs=2.5 * tolerance)


def test_white_noise_is_found_white():
    found = [estimate_noise(draw(3000, 0.0, 0.0, seed), np.arange(3000)) for seed in SEEDS]
    assert sum(noise.is_white for noise in found) >= 7


def test_filtered_rows_are_correlated():
    for seed in SEEDS:
        white = np.random.default_rng(seed).normal(size=3012)
        weights = np.exp(-0.5 * (np.arange(-6, 7) / 1.5) ** 2)
        smoothed = np.convolve(white, weights / np.linalg.norm(weights), "valid")
        noise = estimate_noise(smoothed, np.arange(smoothed.size))
        true = np.std(smoothed[:3000].reshape(-1, 40).mean(axis=1))
        # 75 means scatter by 8 %; an autoregression of order two approximates a filter.
        assert 0.7 < noise.mean_sigma(40) / true < 2.0


def test_quantised_rows_and_outliers():
    for seed in SEEDS:
        draws = np.random.default_rng(seed)
        noise, effect = draws.normal(size=3000), shape_of("turn", 3000)
        rounded = 2.0 * np.round((noise + effect) / 2.0) - effect
        # Rounding to steps q adds q²/12.
        assert estimate_noise(rounded, np.arange(3000)).sigma == pytest.approx(math.sqrt(1.0 + 4.0 / 12.0), rel=0.06)
        hit = draws.random(3000) < 0.005
        noise[hit] += 10.0 * draws.choice([-1.0, 1.0], size=int(np.count_nonzero(hit)))
        kept = ~gross_errors(noise, local_noise(noise, np.arange(3000)).sigma)
        assert estimate_noise(noise[kept], np.flatnonzero(kept)).sigma == pytest.approx(1.0, rel=0.08)


def test_stated_standard_deviation_keeps_the_correlation_of_the_rows():
    noise = estimate_noise(draw(3000, 0.6, 0.0, 1), np.arange(3000), stated=2.5)
    assert noise.sigma == 2.5
    assert noise.rho == pytest.approx(0.6, abs=0.06)


@pytest.mark.parametrize("name", CLASSES)
def test_whitened_rows_are_independent(name):
    rho, partial = CLASSES[name]
    starts = np.zeros(60_000, dtype=bool)
    starts[::60] = True
    noise = Noise(0.3, rho, partial)
    runs = np.concatenate([0.3 * draw(60, rho, partial, seed) for seed in range(1000)])
    white = noise.whitening(starts) @ runs
    assert np.std(white) == pytest.approx(1.0, abs=0.015)
    for lag in (1, 2, 3):
        assert np.mean(white[lag:] * white[:-lag]) == pytest.approx(0.0, abs=0.015)
    columns = noise.whitening(starts) @ np.stack([runs, 2.0 * runs], axis=1)
    assert np.allclose(columns, np.stack([white, 2.0 * white], axis=1))


@pytest.mark.parametrize("name", CLASSES)
def test_means_and_thinned_rows(name):
    rho, partial = CLASSES[name]
    noise, x = Noise(1.0, rho, partial), draw(400_000, rho, partial, 3)
    means, fewer = x.reshape(-1, 8).mean(axis=1), x[::3]
    for fewer_rows, rows in ((noise.averaged(8), means), (noise.thinned(3), fewer)):
        assert fewer_rows.sigma == pytest.approx(np.std(rows), rel=0.01)
        lags = [np.mean(rows[k:] * rows[: rows.size - k]) / np.var(rows) for k in (1, 2)]
        assert np.allclose(fewer_rows.correlation(3)[1:], lags, atol=0.015)
    assert noise.mean_sigma(8) == noise.averaged(8).sigma


def test_spectrum_has_the_variance_of_the_rows():
    noise, omega = Noise(2.0, 0.64, -0.4), np.pi * (np.arange(4000) + 0.5) / 4000
    assert np.mean(noise.spectrum(omega)) == pytest.approx(4.0, rel=1e-6)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[] if name == "AR(2)" else pytest.mark.slow) for name in CLASSES]
)
def test_corners_of_an_elastic_effect_do_not_pass_for_noise(name):
    true, index = Noise(1.0, *CLASSES[name]), branches()
    # Pins that come into contact at 0.3 of the torque, and friction.
    effect = 200.0 * np.sign(TORQUE) * np.maximum(np.abs(TORQUE) - 0.3, 0.0) + 5.0 * np.sign(np.gradient(TORQUE))
    found = []
    for seed in range(24):
        residual = (draw(TORQUE.size, true.rho, true.partial, seed) + effect)[index]
        contrasts = contrasts_of_branches(residual, index, TORQUE)
        assert contrasts is not None
        found.append(estimate_noise(*contrasts))
    assert np.mean([noise.sigma for noise in found]) == pytest.approx(1.0, abs=0.12)
    ratio = np.median([noise.mean_sigma(40) for noise in found]) / true.mean_sigma(40)
    assert ratio == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize("step", [1.0, 0.7])
def test_contrasts_of_branches_have_the_variance_of_single_rows(step):
    """At equal torques, and at others, where neighbours are interpolated."""
    down = np.arange(90.0, 0.0, -step)
    torque = np.concatenate([np.arange(1.0, 91.0), down, np.arange(1.0, 91.0)])
    rows = np.arange(torque.size)
    values = [
        contrasts_of_branches(np.random.default_rng(seed).normal(size=rows.size), rows, torque) for seed in range(40)
    ]
    found = np.concatenate([one[0] for one in values if one is not None])
    # Neighbouring means share rows, which leaves the variance of each as it is.
    assert np.var(found) == pytest.approx(1.0, abs=0.05)


def test_elastic_effects_cancel_in_contrasts_of_branches():
    torque = np.concatenate([np.arange(1.0, 31.0), np.arange(29.0, -31.0, -1.0), np.arange(-29.0, 31.0)])
    rows = np.flatnonzero(torque)
    contrasts, number = contrasts_of_branches(np.tanh(torque[rows]) + torque[rows] ** 2, rows, torque)
    assert contrasts.size == 3 * 29  # down, and up on both sides; the peak has one row
    np.testing.assert_allclose(contrasts, 0.0, atol=1e-9)
    assert set(number) < set(rows)


def test_one_branch_has_no_contrast():
    torque = np.arange(1.0, 40.0)
    assert contrasts_of_branches(torque, np.arange(torque.size), torque) is None
