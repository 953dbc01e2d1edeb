"""Drift of a curve: found where a turn does not close, and no hindrance to effects of order one where it does."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.diagnosis.data._drift import loop_drift, turn_drift
from cycloid_profile.diagnosis.data.noise import Noise

ROWS = 3000
ANGLE = np.arange(ROWS) * 2.0 * np.pi / ROWS
EFFECTS = 5.0 * np.cos(ANGLE + 1.0) + 3.0 * np.cos(39 * ANGLE) + 2.0 * np.cos(5 * ANGLE) + 2.0 * np.cos(1404 * ANGLE)
RAMP = np.linspace(-1.0, 1.0, ROWS)


def turns(slope: float) -> list[float]:
    noise = [np.random.default_rng(seed).normal(size=ROWS) for seed in range(20)]
    return [turn_drift(one + slope * RAMP + EFFECTS, ANGLE, Noise(1.0), [39, 40]) for one in noise]


def test_a_turn_that_closes_has_no_drift():
    # So effects of order one keep all their information; a free line would take 61 % of a sine.
    assert sum(width > 0.0 for width in turns(0.0)) <= 1


def test_drift_of_half_a_standard_deviation_is_found():
    assert np.allclose(turns(0.5), 1.0, atol=0.5)


def test_part_of_a_turn_shows_no_drift():
    part = slice(0, ROWS // 2)
    assert turn_drift((3.0 * RAMP)[part], ANGLE[part], Noise(1.0)) == 0.0


@pytest.mark.parametrize(("slope", "found"), [(0.0, False), (2.0, True)])
def test_drift_of_a_loop(slope, found):
    torque = np.concatenate([np.linspace(0, 400, 48), np.linspace(400, -400, 96), np.linspace(-400, 400, 96)])
    rows = np.flatnonzero(np.abs(torque) > 20.0)
    residual = 0.05 * torque + 8.0 * np.sign(torque) + 3.0 * np.sign(np.gradient(torque))
    widths = []
    for seed in range(10):
        noisy = residual + np.random.default_rng(seed).normal(size=240) + slope * np.linspace(-1.0, 1.0, 240)
        widths.append(loop_drift(noisy[rows], torque[rows], rows, Noise(1.0)) > 0.0)
    assert sum(widths) >= 8 if found else sum(widths) <= 1
