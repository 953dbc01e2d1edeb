"""``tolerance``: a table, pictures and a report; bad input ends with one sentence and status 2."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from cycloid_profile.cli.main import run

RV40E = Path(__file__).parents[2] / "examples" / "rv40e.toml"
PINS = '[[tolerance.effects]]\nname = "single_pin_error"\neach = "pin"\namount_um = { plus_minus = 1.0 }\n'


def spec_with(folder: Path, tables: str) -> Path:
    """A spec file of an RV-40E with more tables."""
    path = folder / "spec.toml"
    path.write_text(RV40E.read_text(encoding="utf-8") + "\n" + tables, encoding="utf-8")
    return path


@pytest.mark.slow
def test_backlash_alone_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = spec_with(tmp_path, f"[tolerance]\nloaded_samples = 0\n[tolerance.limits]\nbacklash_arcmin = 0.26\n{PINS}")
    assert run(["tolerance", str(spec), "--out", str(tmp_path / "out"), "--samples", "5000", "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["schema"] == 1
    assert not values["tolerances_assumed"]
    (limit,) = values["yields"]
    assert limit["low"] < limit["yield_percent"] < limit["high"]
    backlash = next(one for one in values["quantities"] if one["name"] == "backlash_arcmin")
    assert backlash["samples"] == 5000
    # Scatter of pins brings the first touch nearer: the mean is below the drawing.
    assert backlash["mean"]["high"] < backlash["drawn"]
    assert (tmp_path / "out" / "plots" / "distributions.png").stat().st_size > 5000
    assert "<svg" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    rows = list(csv.DictReader((tmp_path / "out" / "tolerance.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["quantity"] for row in rows] == ["backlash_arcmin", "least_backlash_arcmin"]
    assert float(rows[0]["mean"]) == pytest.approx(backlash["mean"]["value"])


@pytest.mark.slow
def test_same_seed_same_samples_and_a_second_run_reuses_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = spec_with(tmp_path, f"[tolerance]\nloaded_samples = 0\nsamples = 5000\n{PINS}")
    command = ["tolerance", str(spec), "--json", "--out"]
    found = []
    for name, threads in (("a", "1"), ("b", "2")):
        assert run([*command, str(tmp_path / name), "--threads", threads]) == 0
        found.append((tmp_path / name / "samples" / "backlash" / "part-00000.parquet").read_bytes())
    assert found[0] == found[1]
    capsys.readouterr()
    assert run([*command, str(tmp_path / "a")]) == 0
    assert "from a run before" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("tables", "options", "said"),
    [
        (PINS.replace("plus_minus", "sigma").replace("1.0", "-1.0"), [], "sigma"),
        (PINS.replace("single_pin_error", "single_pin_eror"), [], "did you mean single_pin_error?"),
        (
            PINS
            + PINS.replace("single_pin_error", "pin_position_error").replace("amount", "amplitude")
            + "[[tolerance.correlations]]\nvalue = 1.0\n"
            + 'between = ["single_pin_error.amount_um", "pin_position_error.amplitude_um"]\n',
            [],
            "positive definite",
        ),
        (PINS, ["--samples", "5"], "tolerance.samples = 5"),
        pytest.param(PINS, ["--scheduler", "tcp://127.0.0.1:9"], "cannot be reached", marks=pytest.mark.slow),
    ],
)
def test_bad_input_is_one_sentence(
    tables: str, options: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = spec_with(tmp_path, f"[tolerance]\nloaded_samples = 0\nsamples = 1000\n{tables}")
    assert run(["tolerance", str(spec), "--out", str(tmp_path / "out"), *options]) == 2
    printed = capsys.readouterr()
    last = printed.err.strip().splitlines()[-1]
    assert last.startswith("cycloid-profile: ")
    assert said in last
    assert not (tmp_path / "out" / "report.html").exists()


@pytest.mark.slow
def test_the_example_with_loads_and_the_published_claim(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    example = RV40E.with_name("rv40e_tolerances.toml")
    options = ["--samples", "4096", "--loaded-samples", "256"]
    assert run(["tolerance", str(example), "--out", str(tmp_path), *options]) == 0
    printed = capsys.readouterr().out
    assert "Sensitivity to tolerances with deformation compensation" in printed
    result = json.loads((tmp_path / "tolerance.json").read_text(encoding="utf-8"))
    # A rotation of the flanks moves every gap by as much lever: first order in the errors nothing changes.
    by_quantity = {one["quantity"]: one for one in result["compared"]}
    assert by_quantity["backlash_arcmin"]["ratio_of_deviations"] == pytest.approx(1.0, abs=0.01)
    assert {one["name"] for one in result["quantities"]} >= {"lost_motion_arcmin", "peak_pressure_mpa"}


@pytest.mark.slow
def test_reducers_that_cannot_be_assembled_end_the_study(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Before the ranking of the tolerances, which takes longest."""
    spec = spec_with(tmp_path, "[tolerance]\nsamples = 100\nloaded_samples = 8\n" + PINS.replace("1.0", "1000.0"))
    assert run(["tolerance", str(spec), "--out", str(tmp_path / "out")]) == 1
    errors = capsys.readouterr().err
    assert "of 8 are too many to omit: narrow the tolerances" in errors
    assert "halved" not in errors
    assert not (tmp_path / "out" / "report.html").exists()
