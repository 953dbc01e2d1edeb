"""The command ``correct`` as a user meets it: the folder, JSON, and one-sentence refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.diagnosis.verdict.remainder import LABEL
from cycloid_profile.effects import AsBuiltReducer, Effect, apply_effects, effect_from_table
from cycloid_profile.measurement import HYSTERESIS, Measurement, format_measurement, read_measurement
from cycloid_profile.rig import measurement_residual
from tests.diagnosis.correcting import CLOSED, HIDDEN, NOISE, drawn, found, named, of_table, scan_of
from tests.spec_texts import RV40E


@pytest.fixture
def files(tmp_path: Path) -> Callable[..., tuple[str, str]]:
    """Writes spec and scan; gives their names."""

    def write(scan: Measurement, more: str = "") -> tuple[str, str]:
        (tmp_path / "mine.toml").write_text(RV40E + more, encoding="utf-8")
        (tmp_path / "scan.csv").write_text(format_measurement(scan), encoding="utf-8")
        return str(tmp_path / "mine.toml"), str(tmp_path / "scan.csv")

    return write


@pytest.fixture
def diagnosed_as(monkeypatch: pytest.MonkeyPatch) -> Callable[..., None]:
    """Replaces the search for effects by its result; other tests cover the search."""

    def replace_diagnosis(verdict: str, *effects: Effect) -> None:
        def answer(reducer: AsBuiltReducer, scans: list[Measurement], *_: Any) -> Any:
            result = found(reducer, [named(one) for one in effects], *scans)
            result.verdict = verdict
            return result

        monkeypatch.setattr("cycloid_profile.report.diagnosis.correction_package.diagnose", answer)

    return replace_diagnosis


Files = Callable[..., tuple[str, str]]
WRITTEN = {
    "profile_corrected.csv",
    "grinding_corrected.nc",
    "predicted_scan.csv",
    "correction.html",
    "correction.png",
    "correction.svg",
    "correction.json",
}


def test_correct_writes_the_path_and_what_to_expect(
    files: Files, diagnosed_as: Callable[..., None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    error, known = of_table(HIDDEN[7]), of_table(HIDDEN[6])
    diagnosed_as("effects_found", error)
    more = '[[effects]]\nname = "disc_oval"\namplitude_um = 3.0\nphase_deg = 20.0\ndisc = 1\n'
    spec, scan = files(scan_of(apply_effects(drawn().case, [error, known]), 3), more)
    assert run(["correct", spec, scan, "--out", str(tmp_path / "out"), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert {path.name for path in (tmp_path / "out").iterdir()} == WRITTEN == {f["path"] for f in values["files"]}
    assert values == json.loads((tmp_path / "out" / "correction.json").read_text(encoding="utf-8"))
    assert values["schema"] == 1
    assert values["verdict"] == "effects_found"
    assert values["effects"][0]["parameters"]["amplitude_um"] == pytest.approx(2.0)
    assert values["known_effects"][0]["name"] == "disc_oval"
    assert values["largest_um"] <= values["limit_um"] == 10.0
    (one,) = values["scans"]
    assert one["rms_after_um"] == pytest.approx(NOISE, rel=0.03)
    assert one["rms_before_um"] > 3.0 * NOISE
    assert values["rms_expected_um"] == pytest.approx(NOISE, rel=0.05)
    # The machine's errors are in the expected scan, and it is the drawing all the same.
    expected = read_measurement(tmp_path / "out" / "predicted_scan.csv")
    assert measurement_residual(drawn(), expected, 0).rms < 1e-3
    nc = (tmp_path / "out" / "grinding_corrected.nc").read_text(encoding="ascii")
    assert "(LOBES DIFFER" in nc


def test_correct_says_so_where_all_agrees(files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec, scan = files(scan_of(drawn(), 2))
    assert run(["correct", spec, scan, "--out", str(tmp_path / "out")]) == 0
    assert "nothing to correct" in capsys.readouterr().out
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_what_has_no_name_is_not_cancelled_unless_asked(
    files: Files, diagnosed_as: Callable[..., None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    diagnosed_as("unknown_effect")
    spec, scan = files(scan_of(of_table(HIDDEN[12]).apply(drawn()), 4))
    out = tmp_path / "out"
    assert run(["correct", spec, scan, "--out", str(out)]) == 1
    assert "--remainder" in capsys.readouterr().err
    assert not out.exists()
    assert run(["correct", spec, scan, "--out", str(out), "--remainder"]) == 0
    printed = capsys.readouterr().out
    assert LABEL in printed
    values = json.loads((out / "correction.json").read_text(encoding="utf-8"))
    assert values["effects"] == []
    assert values["remainder"]["largest_um"] == pytest.approx(3.0, abs=0.5)
    assert values["rms_expected_um"] < CLOSED * NOISE


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (("--limit-um", "1"), "is more than the limit of 1 µm"),
        (("--limit-um", "-1"), "is not above zero"),
        (("--wheel-radius-mm", "4"), "is below the wheel radius"),
        (("--wheel-radius-mm", "nan"), "is not above zero"),
    ],
)
def test_bad_input_is_one_sentence_and_no_file(
    more: tuple[str, ...],
    sentence: str,
    files: Files,
    diagnosed_as: Callable[..., None],
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    error = of_table(HIDDEN[7])
    diagnosed_as("effects_found", error)
    spec, scan = files(scan_of(error.apply(drawn()), 3))
    assert run(["correct", spec, scan, "--out", str(tmp_path / "out"), *more]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (line,) = [line for line in err.splitlines() if not line.startswith("…")]
    assert sentence in line
    assert not (tmp_path / "out").exists()


def test_only_scans_are_taken(files: Files, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    loop = Measurement(HYSTERESIS, {"torque_nm": np.arange(4.0), "angle_arcmin": np.arange(4.0)})
    spec, name = files(loop)
    assert run(["correct", spec, name, "--out", str(tmp_path / "out")]) == 2
    assert "is no scan of a disc" in capsys.readouterr().err
    assert run(["correct", spec]) == 2
    assert "none were given" in capsys.readouterr().err


def test_errors_of_the_ring_alone_leave_nothing_to_grind(
    files: Files, diagnosed_as: Callable[..., None], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    diagnosed_as("effects_found", effect_from_table({"name": "pin_radius_error", "amount_um": 2.0}))
    spec, scan = files(scan_of(drawn(), 2))
    assert run(["correct", spec, scan, "--out", str(tmp_path / "out")]) == 1
    assert "grinding the disc does not remove it" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
