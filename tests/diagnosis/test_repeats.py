"""Noise from repeats of one specimen: a texture common to both files is not noise, whatever its spectrum."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Recording
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.data.repeats import with_drift_of_instrument, with_noise_of_repeats
from cycloid_profile.measurement import HYSTERESIS, TRANSMISSION_ERROR, Measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Reducer, spec_text
from tests.diagnosis.test_likelihood import residuals

NOISE, TEXTURE, ROWS = 0.15, 0.4, 3000


def turn(seed: int, rho: float = 0.0, shift: float = 0.0, **keys: str) -> Recording:
    """A transmission error of noise and a texture identical in all files."""
    fresh = np.random.default_rng(seed).normal(size=ROWS)
    noise = fresh.copy()
    for i in range(1, ROWS):
        noise[i] = rho * noise[i - 1] + np.sqrt(1.0 - rho**2) * fresh[i]
    error = TEXTURE * np.random.default_rng(0).normal(size=ROWS) + NOISE * noise
    angle = (np.arange(ROWS) + shift) * 360.0 / ROWS
    known = {"torque_nm": "412"} | keys
    measurement = Measurement(TRANSMISSION_ERROR, {"output_angle_deg": angle, "error_arcsec": error}, known)
    return Recording(measurement, 0, np.arange(ROWS), np.zeros(ROWS, dtype=bool), Noise(0.43))


@pytest.mark.parametrize("rho", [0.0, 0.6])
def test_common_texture_of_repeats_is_not_noise(rho):
    files = [turn(seed, rho, specimen="A") for seed in (1, 2, 3)]
    for one in with_noise_of_repeats(files):
        # Three files of 3,000 rows give a standard deviation to about 2 %, less with correlated rows.
        assert one.noise.sigma == pytest.approx(NOISE, rel=0.08)
        assert one.noise.rho == pytest.approx(rho, abs=0.1)
        assert "3 repeats of A" in one.notes[-1]


def test_other_files_keep_their_noise():
    alone = turn(1, specimen="A")
    for other in (
        turn(2, specimen="B"),
        turn(2),
        turn(2, specimen="A", torque_nm="12"),
        turn(2, specimen="A", noise_arcsec="0.2"),
        turn(2, shift=0.5, specimen="A"),
    ):
        kept = with_noise_of_repeats([alone, other])
        assert [one.noise for one in kept] == [alone.noise, other.noise]
        assert kept[0] is alone


def test_eight_rows_at_the_same_places_are_enough():
    error = np.random.default_rng(3).normal(size=(2, 8))
    files = []
    for one in error:
        columns = {"output_angle_deg": 45.0 * np.arange(8), "error_arcsec": one}
        measurement = Measurement(TRANSMISSION_ERROR, columns, {"specimen": "A", "torque_nm": "412"})
        files.append(Recording(measurement, 0, np.arange(8), np.zeros(8, dtype=bool), Noise(0.43)))
    # The difference of two files scatters by √2 as much as one.
    expected = np.std(error[0] - error[1]) / np.sqrt(2.0)
    assert [one.noise.sigma for one in with_noise_of_repeats(files)] == pytest.approx([expected, expected])


def test_omitted_rows_of_one_file_are_omitted_in_the_difference():
    one, other = turn(1, specimen="A"), turn(2, specimen="A")
    some = np.delete(np.arange(ROWS), [10, 500, 501])
    other = replace(other, rows=some, held_out=np.zeros(some.size, dtype=bool))
    found = with_noise_of_repeats([one, other])
    assert found[0].noise.sigma == pytest.approx(NOISE, rel=0.08)
    assert found[0].noise == found[1].noise


def test_repeats_of_a_loop_are_matched_by_row():
    torque = np.concatenate([np.linspace(-400, 400, 120), np.linspace(400, -400, 120)])
    shared = 0.02 * np.random.default_rng(0).normal(size=torque.size)

    def loop(seed: int, off: float = 0.0) -> Recording:
        angle = torque / 400 + shared + 0.004 * np.random.default_rng(seed).normal(size=torque.size)
        columns = {"torque_nm": torque + off, "angle_arcmin": angle}
        measurement = Measurement(HYSTERESIS, columns, {"specimen": "A", "output_angle_deg": "20"})
        rows = np.flatnonzero(np.abs(torque) > 20)
        return Recording(measurement, 0, rows, np.zeros(rows.size, dtype=bool), Noise(0.02))

    # Torques of equal rows may differ by a tenth of their step, 6.7 N·m.
    for off, matched in ((0.0, True), (0.6, True), (-0.6, True), (0.8, False)):
        for one in with_noise_of_repeats([loop(1), loop(2, off)]):
            assert one.noise.sigma == pytest.approx(0.004 if matched else 0.02, rel=0.25)


def test_diagnosis_uses_the_noise_of_repeats():
    from cycloid_profile.diagnosis import diagnose
    from cycloid_profile.rig import Settings, simulate

    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    scans = [simulate(reducer, "profile_scan", Settings(noise=0.3, seed=seed, points=780)) for seed in (1, 2)]
    unstated = [
        replace(s, name=f"{i}.csv", keys={k: v for k, v in s.keys.items() if k != "noise_um"} | {"specimen": "disc 1"})
        for i, s in enumerate(scans)
    ]
    found = diagnose(reducer, unstated)
    assert found.verdict == "agrees"
    assert found.gaps[0].noise == found.gaps[1].noise
    assert any("2 repeats of disc 1" in note for note in found.notes)


def test_an_instrument_that_drifts_in_one_turn_may_drift_in_all():
    drifting, closed, own = replace(turn(1), drift=0.4), turn(2), replace(turn(3), drift=0.1)
    half = replace(turn(4), rows=np.arange(ROWS // 2), held_out=np.zeros(ROWS // 2, dtype=bool))
    first, second, third, fourth, scan = with_drift_of_instrument(
        [drifting, closed, own, half, residuals("scan").recording]
    )
    assert (first, third, fourth) == (drifting, own, half)
    assert second.drift == drifting.drift
    assert not second.shown_drift
    assert "drifts" in second.notes[-1]
    assert not scan.drift
    # Without a drift, and with one of parts that creep, each file stays alone.
    for other in (turn(3), replace(turn(3), drift=20.0)):
        assert with_drift_of_instrument([closed, other])[0] is closed
