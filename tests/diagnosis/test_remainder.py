"""Smooth remainder of a scan: fitted where it is significant, and corrected."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.correction import correction
from cycloid_profile.diagnosis import ScanResidual, smooth_remainder
from cycloid_profile.diagnosis.verdict.remainder import LABEL
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.rig import measurement_residual
from cycloid_profile.units import UM
from tests.diagnosis.correcting import CLOSED, LOBES, NOISE, drawn, found, scan_of

ALONG = np.sort(np.random.default_rng(5).uniform(0.0, 2.0 * math.pi * LOBES, 4680))
FORMS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "pit": lambda x: 4.0 * np.exp(-(((x - 200.0) / 0.25) ** 2)),
    "every lobe equal": lambda x: np.cos(3.0 * x) + 0.5 * np.sin(x),
    "once round the disc": lambda x: np.cos(3.0 * x / LOBES),
    "waves that swell": lambda x: np.cos(4.0 * x) * np.cos(2.0 * x / LOBES),
    "eleven waves a lobe": lambda x: np.cos(11.0 * x),
}


@pytest.mark.parametrize("form", FORMS.values(), ids=FORMS.keys())
def test_a_remainder_is_fitted_to_a_fraction_of_the_noise(form: Callable[[np.ndarray], np.ndarray]) -> None:
    noise = NOISE * np.random.default_rng(6).normal(size=ALONG.size)
    smooth = smooth_remainder([ScanResidual(ALONG, (form(ALONG) + noise) * UM, NOISE * UM)], LOBES)
    assert smooth is not None
    assert smooth.label == LABEL
    error = value_of(smooth.curve, ALONG) / UM - form(ALONG)
    assert math.sqrt(NOISE**2 + float(np.mean(error**2))) < CLOSED * NOISE
    assert smooth.curve.whole_disc


def value_of(curve: NormalDeviation, along: np.ndarray) -> np.ndarray:
    """The curve at phases along the disc [mm]."""
    return curve.derivatives(along, np.ones_like(along), drawn().teeth[0].trochoid).value


@pytest.mark.slow
def test_noise_leaves_no_remainder() -> None:
    for seed in range(20):
        noise = NOISE * UM * np.random.default_rng(seed).normal(size=ALONG.size)
        assert smooth_remainder([ScanResidual(ALONG, noise, NOISE * UM)], LOBES) is None


def test_lobes_without_points_are_unchanged() -> None:
    lobe = np.mod(np.round(ALONG / (2.0 * math.pi)), LOBES)
    there = ALONG[(lobe < 10) | (lobe > 14)]
    noise = NOISE * np.random.default_rng(7).normal(size=there.size)
    smooth = smooth_remainder([ScanResidual(there, (1.0 + np.cos(2.0 * there) + noise) * UM, NOISE * UM)], LOBES)
    assert smooth is not None
    assert smooth.lobes_without == (11, 12, 13, 14, 15)
    inside = np.linspace(2.0 * math.pi * 10, 2.0 * math.pi * 14, 999)
    assert np.max(np.abs(value_of(smooth.curve, inside))) < 0.01 * UM
    far = np.linspace(2.0 * math.pi * 20, 2.0 * math.pi * 30, 999)
    assert np.allclose(value_of(smooth.curve, far) / UM, 1.0 + np.cos(2.0 * far), atol=0.2)


def test_the_remainder_corrects_an_unknown_form() -> None:
    at = np.arange(0.0, 2.0 * math.pi * LOBES, 0.1)
    pit = NormalDeviation(at, 4.0 * UM * np.exp(-((at - 201.0) ** 2)), LOBES)
    tooth = drawn().teeth[0]
    bad = drawn().with_tooth(0, replace(tooth, removals=(pit,)))
    result = correction(found(drawn(), [], scan_of(bad, 8)), with_remainder=True)
    assert result.remainder is not None
    program = result.program
    again = drawn().with_tooth(0, replace(program, removals=(*program.removals, pit)))
    assert measurement_residual(drawn(), scan_of(again, 9), 0).rms < CLOSED * NOISE
    assert measurement_residual(drawn(), scan_of(bad, 9), 0).rms > 1.5 * NOISE
    assert result.rms_expected == pytest.approx(NOISE, rel=0.1)
