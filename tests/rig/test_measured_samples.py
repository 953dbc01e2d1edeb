"""Samples of an independent generator with a known answer: the right effects leave their noise and nothing else.

The generator's white noise is 0.3 µm on scans, 0.004′ on loops and maps, 0.15″ on transmission error. A residual of N
rows says that to 1/√(2N): 1 % for scans and transmission error, 3 % for maps, 5 % for loops.
"""

from __future__ import annotations

import json

import numpy as np
import pytest

from cycloid_profile.measurement import read_measurement
from cycloid_profile.rig import measurement_residual
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM

NOISE = {"um": 0.3, "arcmin": 0.004, "arcsec": 0.15}
# One and a half per cent of the rated torque and more apart: within the backlash the angle is anywhere.
PRESSED = 0.05


def truth(folder):
    return json.loads((folder / "truth.json").read_text(encoding="utf-8"))["size_mm_rad"]


@pytest.mark.parametrize(
    ("file", "within"),
    [
        ("scan_none/scan.csv", 0.03),
        ("te_none/te_rated.csv", 0.03),
        ("te_none/te_light.csv", 0.03),
        ("te_none/lost_motion.csv", 0.06),
    ],
)
def test_the_drive_as_drawn_leaves_the_noise(drawn, measured, file, within):
    found = measurement_residual(drawn, read_measurement(measured / file))
    assert found.rms == pytest.approx(NOISE[found.unit], rel=within)
    # The noise read from neighbouring rows, without a stated value.
    assert found.noise == pytest.approx(NOISE[found.unit], rel=0.06)
    assert np.all(np.isfinite(found.residual))


def test_lost_motion_of_the_drive_as_drawn(drawn, measured):
    # 0.8507′ was measured; nothing is taken off a lost motion.
    sample = read_measurement(measured / "te_none" / "lost_motion.csv")
    assert np.mean(sample["lost_motion_arcmin"]) == pytest.approx(0.8507, abs=5e-5)
    assert abs(np.mean(measurement_residual(drawn, sample).residual)) < 3.0 * 0.004 / np.sqrt(600.0)


def loop_residual(reducer, sample):
    """Residual where the torque presses the stage well, its mean off; and how many rows that are."""
    found = measurement_residual(reducer, sample).residual
    pressed = np.abs(sample["torque_nm"]) > PRESSED * reducer.case.torque / NEWTON_METRE
    left = found[pressed]
    assert np.all(np.isfinite(left))
    return left - np.mean(left), left.size


def test_a_loop_with_soft_shafts_and_friction(built_with, measured):
    size = truth(measured / "hyst_two")
    known = (
        {"name": "series_compliance", "stiffness_nm_per_arcmin": size["ks"] * ARCMIN / NEWTON_METRE},
        {"name": "coulomb_friction", "torque_nm": size["friction"]},
    )
    sample = read_measurement(measured / "hyst_two" / "hysteresis.csv")
    left, rows = loop_residual(built_with(*known), sample)
    assert rows > 0.9 * sample["torque_nm"].size
    # The generator's friction is not quite a play operator: half as much again as the noise.
    assert np.sqrt(np.mean(left**2)) < 0.007
    # Either alone leaves twenty times as much and more.
    for one in known:
        left, _ = loop_residual(built_with(one), sample)
        assert np.sqrt(np.mean(left**2)) > 0.014


def test_a_loop_with_play_in_the_bearings(built_with, drawn, measured):
    size = truth(measured / "hyst_play")["cb"]
    sample = read_measurement(measured / "hyst_play" / "hysteresis.csv")
    loose = built_with({"name": "crank_bearing_clearance", "radial_um": size / UM})
    left, _ = loop_residual(loose, sample)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(NOISE["arcmin"], rel=0.1)
    without, _ = loop_residual(drawn, sample)
    assert np.sqrt(np.mean(without**2)) > 20.0 * NOISE["arcmin"]


# Amplitude and direction fit te_rated.csv best, by the angle alone (form 2); the truth does not say them.
RUNOUT = {"name": "disc_runout", "amplitude_um": 3.2636, "phase_deg": 106.842, "disc": 1}


@pytest.mark.parametrize(("file", "within"), [("te_light", 0.04), ("lost_motion", 0.08)])
def test_runout_of_one_disc_read_at_rated_torque_foretells_the_other_files(built_with, measured, file, within):
    sample = read_measurement(measured / "te_disc_runout" / f"{file}.csv")
    found = measurement_residual(built_with({**RUNOUT, "form": 2}), sample)
    assert found.rms == pytest.approx(NOISE[found.unit], rel=within)


@pytest.mark.slow
@pytest.mark.parametrize("file", ["te_rated", "te_light", "lost_motion"])
def test_another_effect_does_not_foretell_them(built_with, drawn, measured, file):
    sample = read_measurement(measured / "te_disc_runout" / f"{file}.csv")
    found = measurement_residual(built_with({**RUNOUT, "form": 2}), sample)
    assert found.rms < 1.1 * NOISE[found.unit]
    assert measurement_residual(drawn, sample).rms > 25.0 * NOISE[found.unit]
    # The same amplitude, but of a tooth moved as a whole.
    assert measurement_residual(built_with(RUNOUT), sample).rms > 10.0 * NOISE[found.unit]
