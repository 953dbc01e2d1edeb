"""Evaluation of scans from an independent generator, whose errors are known, and the command ``inspect``.

Cumulative pitch: lobes turned about the centre by A/S cos t with A along the normal at ψ0, hence F_p = 2 A R/S on the
pitch circle of radius R, and f_p = F_p sin(π/39). Runout: the teeth moved by e, hence F_r = 2 e, and each flank is
displaced along its normal by e at most, as an arc e R/S. Noise adds to the extremes, 0.3 µm a point.
"""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from independent_scans import LONGEST_LEVER, drawn_points

from cycloid_profile.cli.main import run
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.errors import MeasurementError
from cycloid_profile.export.inspection import CheckResult, inspect_scan
from cycloid_profile.measurement import PROFILE_SCAN, Measurement
from cycloid_profile.spec import parse_spec
from tests.spec_texts import RV40E, UNCOMPENSATED

SPEC = RV40E + UNCOMPENSATED
SIZE, NOISE = 1.0e-3, 0.3e-3  # mm


@pytest.fixture(scope="module")
def record() -> DesignRecord:
    return design_disc(parse_spec(SPEC))


def scan(points: np.ndarray, datum: str = "bore") -> Measurement:
    return Measurement(PROFILE_SCAN, {"x_mm": points.real, "y_mm": points.imag}, {"datum": datum}, "scan.csv")


def inspected(record: DesignRecord, points: np.ndarray, datum: str = "bore") -> dict[str, CheckResult]:
    result = inspect_scan(record, scan(points, datum))
    return {check.symbol: check for check in result.checks}


def within_noise(check: CheckResult, truth: float) -> bool:
    assert check.value is not None
    return truth - 2.0 * check.uncertainty <= check.value <= truth + check.noise_alone + 2.0 * check.uncertainty


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_pitch_and_runout_come_out_as_made(record: DesignRecord, seed: int) -> None:
    arc = 61.215 / LONGEST_LEVER
    ideal = inspected(record, drawn_points(seed, NOISE))
    assert all(within_noise(ideal[symbol], 0.0) for symbol in ("F_α", "f_p", "F_p", "F_r"))
    pitch = inspected(record, drawn_points(seed, NOISE, pitch=SIZE))
    assert within_noise(pitch["F_p"], 2.0 * SIZE * arc)
    assert within_noise(pitch["f_p"], 2.0 * SIZE * arc * math.sin(math.pi / 39))
    assert within_noise(pitch["F_r"], 0.0)
    runout = inspected(record, drawn_points(seed, NOISE, runout=SIZE))
    assert within_noise(runout["F_r"], 2.0 * SIZE)
    assert within_noise(runout["F_p"], 2.0 * SIZE * arc)


def test_without_noise_the_figures_are_exact(record: DesignRecord) -> None:
    pitch = inspected(record, drawn_points(0, 0.0, pitch=SIZE))
    assert pitch["F_p"].value == pytest.approx(2.0 * SIZE * 61.215 / LONGEST_LEVER, rel=5e-3)
    runout = inspected(record, drawn_points(0, 0.0, runout=SIZE))
    assert runout["F_r"].value == pytest.approx(2.0 * SIZE, rel=2e-2)
    # A shift of the teeth along x only: no other quantity is as large.
    assert runout["f_p"].value == pytest.approx(2.0 * SIZE * 61.215 / LONGEST_LEVER * math.sin(math.pi / 39), rel=0.15)


def test_a_free_scan_shows_no_runout_and_a_partial_one_is_refused(record: DesignRecord) -> None:
    points = drawn_points(4, NOISE, runout=SIZE)
    free = inspected(record, points + 0.7 - 0.2j, "free")
    assert free["F_r"].value is None
    assert free["F_r"].passed is None
    assert within_noise(free["F_p"], 0.0)
    with pytest.raises(MeasurementError, match=r"flanks.* of 39 have points enough: scan the whole disc"):
        inspected(record, points[: points.size // 2])


@pytest.mark.slow
def test_command_passes_fails_and_refuses(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec, file = tmp_path / "spec.toml", tmp_path / "scan.csv"
    points = drawn_points(5, NOISE, pitch=SIZE)
    rows = "\n".join(f"{z.real:.7f},{z.imag:.7f}" for z in points)
    head = "# format: cycloid-profile measurement 1\n# kind: profile_scan\n# datum: bore\nx_mm,y_mm\n"
    file.write_text(f"{head}{rows}\n", encoding="utf-8")
    spec.write_text(SPEC, encoding="utf-8")
    out = tmp_path / "out"
    assert run(["inspect", str(spec), str(file), "--out", str(out), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["pass"] is True
    assert {check["tolerance_from"] for check in printed["checks"]} == {"IT4, ground"}
    assert len(printed["flanks"]) == 78
    assert json.loads((out / "inspection.json").read_text(encoding="utf-8")) == printed
    assert {path.name for path in out.iterdir()} == {
        f"inspection.{ending}" for ending in ("csv", "html", "json", "png", "qif", "svg")
    }
    assert len((out / "inspection.csv").read_text(encoding="utf-8").splitlines()) == 79
    spec.write_text(SPEC + "[export.inspection]\ncumulative_pitch_tolerance_um = 1.5\n", encoding="utf-8")
    assert run(["inspect", str(spec), str(file), "--out", str(out)]) == 1
    assert "failed" in capsys.readouterr().out
    file.write_text(head + "1.0,2.0\n", encoding="utf-8")
    assert run(["inspect", str(spec), str(file), "--out", str(tmp_path / "none")]) == 2
    assert not (tmp_path / "none").exists()
