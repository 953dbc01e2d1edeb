"""The command ``diagnose`` as a user meets it: tables, JSON, a folder with the new spec, and one-sentence refusals."""

from __future__ import annotations

import hashlib
import json
import math
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.effects import EFFECTS
from cycloid_profile.spec import read_spec
from tests.spec_texts import RV40E

# Short files: output does not depend on the number of rows.
SPEC = f"# kept as it is: comments, order, blanks\n{RV40E.rstrip()}   # removed\n"
OVAL = "[[effects]]\nname = 'disc_oval'\namplitude_um = 2.0\nphase_deg = 30.0\ndisc = 1\n"
KEYS = {"schema", "name", "verdict", "effects", "where", "remainder", "not_seen", "gap"}
EFFECT_KEYS = {"name", "parameters", "uncertainty", "group", "separate_by"}
GAP_KEYS = {"file", "unit", "noise", "fit_before", "fit_after", "held_out_before", "held_out_after"}
WRITTEN = {"report.html", "diagnosis.json", "mine_diagnosed.toml"}


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a spec, a scan of an oval disc, and one of a disc that is as drawn."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "mine.toml").write_text(SPEC, encoding="utf-8")
    (folder / "oval.toml").write_text(SPEC + OVAL, encoding="utf-8")
    for spec, file in (("oval", "scan"), ("mine", "clean")):
        words = ["simulate", str(folder / f"{spec}.toml"), "--kind", "profile_scan", "--points", "900"]
        words += ["--noise", "0.3", "--seed", "1"]
        assert run([*words, "--out", str(folder / f"{file}.csv")]) == 0
    return folder


@pytest.fixture(scope="module")
def diagnosed(bench: Path) -> Path:
    """The scan diagnosed once, into ``out`` and ``result.json``."""
    words = ["diagnose", str(bench / "mine.toml"), str(bench / "scan.csv"), "--out", str(bench / "out")]
    assert run([*words, "--json", str(bench / "result.json")]) == 0
    return bench


def _values(path: Path) -> dict[str, Any]:
    values = json.loads(path.read_text(encoding="utf-8"))
    assert isinstance(values, dict)
    return values


def test_json_keeps_its_contract(diagnosed: Path) -> None:
    values = _values(diagnosed / "result.json")
    assert set(values) >= KEYS
    assert values["schema"] == 1
    assert values["name"] == "RV-40E"
    assert values["verdict"] == "effects_found"
    (effect,) = values["effects"]
    assert set(effect) >= EFFECT_KEYS
    assert effect["name"] == "disc_oval"
    assert effect["group"] == ["disc_oval"]
    assert effect["separate_by"] is None
    assert set(effect["parameters"]) == {"amplitude_um", "phase_deg", "disc"}
    assert effect["parameters"]["disc"] == 1
    assert set(effect["uncertainty"]) == {"amplitude_um", "phase_deg"}
    # 0.3 µm √(2/900) and half of that over 2 µm in rad; the noise is drawn once.
    assert effect["uncertainty"]["amplitude_um"] == pytest.approx(0.014, rel=0.3)
    assert effect["uncertainty"]["phase_deg"] == pytest.approx(0.2, rel=0.3)
    for key, hidden in (("amplitude_um", 2.0), ("phase_deg", 30.0)):
        assert abs(effect["parameters"][key] - hidden) < 4.0 * effect["uncertainty"][key]
    assert values["where"]
    for place in values["where"]:
        assert set(place) >= {"file", "coordinate", "from", "to", "rms_um", "p_value"}
        assert place["file"] == "scan.csv"
        assert isinstance(place["coordinate"], str)
        assert all(math.isfinite(place[key]) for key in ("from", "to", "rms_um"))
        assert place["rms_um"] > 0.0
        assert 0.0 <= place["p_value"] < 0.005
    assert values["remainder"] is None
    assert {hidden["name"] for hidden in values["not_seen"]} <= set(EFFECTS)
    assert all(isinstance(hidden["smallest_detectable"], str) for hidden in values["not_seen"])
    (gap,) = values["gap"]
    assert set(gap) >= GAP_KEYS
    assert (gap["file"], gap["unit"]) == ("scan.csv", "um")
    assert gap["noise"] == pytest.approx(0.3, rel=0.1)
    for rows, scatter in (("fit", 0.1), ("held_out", 0.25)):
        assert gap[f"{rows}_before"] == pytest.approx(math.hypot(2.0 / math.sqrt(2.0), 0.3), rel=scatter)
        assert gap[f"{rows}_after"] == pytest.approx(0.3, rel=scatter)


def test_folder_holds_report_pictures_result_and_spec(diagnosed: Path) -> None:
    out = diagnosed / "out"
    assert {f.name for f in out.iterdir()} == WRITTEN | {"plots"}
    pictures = sorted(f.name for f in (out / "plots").iterdir())
    stems = {Path(name).stem for name in pictures}
    assert stems
    assert pictures == sorted(f"{stem}{ending}" for stem in stems for ending in (".png", ".svg"))
    for stem in stems:
        assert (out / "plots" / f"{stem}.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
        assert (out / "plots" / f"{stem}.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "disc oval" in page.replace("_", " ")
    assert "src=" not in page
    assert _values(out / "diagnosis.json") == _values(diagnosed / "result.json")


def test_old_spec_is_unchanged_and_begins_the_new_one(diagnosed: Path) -> None:
    assert (diagnosed / "mine.toml").read_bytes() == SPEC.encode()
    new = diagnosed / "out" / "mine_diagnosed.toml"
    text = new.read_text(encoding="utf-8")
    assert text.startswith(SPEC)
    (effect,) = read_spec(new).effects
    assert effect["name"] == "disc_oval"
    assert "amplitude_um" in effect["uncertainty"]
    assert hashlib.sha256((diagnosed / "scan.csv").read_bytes()).hexdigest()[:16] in effect["origin"]


def test_with_the_new_spec_they_agree(diagnosed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new = str(diagnosed / "out" / "mine_diagnosed.toml")
    scan = str(diagnosed / "scan.csv")
    assert run(["diagnose", new, scan, "--out", str(tmp_path / "again"), "--json", "-"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["verdict"] == "agrees"
    assert values["effects"] == []
    assert not list((tmp_path / "again").glob("*.toml"))
    assert run(["compare", new, scan, "--out", str(tmp_path / "compared"), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["gap"]
    assert row["rms"] == pytest.approx(0.3, rel=0.1)
    words = ["simulate", new, "--kind", "profile_scan", "--points", "400", "--out", str(tmp_path / "new.csv")]
    assert run(words) == 0
    assert (tmp_path / "new.csv").is_file()


def test_text_names_the_effect_and_the_gap(diagnosed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diagnose", str(diagnosed / "mine.toml"), str(diagnosed / "scan.csv"), "--out", str(tmp_path / "out")]
    assert run(words) == 0
    out, err = capsys.readouterr()
    assert out.startswith("RV-40E: the missing effect has been found\n")
    for word in ("disc_oval", "amplitude_um = ", " ± ", "scan.csv", "µm", "mine_diagnosed.toml", "report.html"):
        assert word in out
    assert "…" not in out
    assert err
    assert all(line.startswith("…") for line in err.splitlines())
    # The same data and the same spec: the same bytes.
    for file in sorted(f for f in (diagnosed / "out").rglob("*") if f.is_file()):
        assert (tmp_path / "out" / file.relative_to(diagnosed / "out")).read_bytes() == file.read_bytes(), file.name


def test_agreement_lists_the_smallest_detectable_sizes(
    bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["diagnose", str(bench / "mine.toml"), str(bench / "clean.csv"), "--out", str(tmp_path / "out")]
    assert run(words) == 0
    out = capsys.readouterr().out
    assert "measurement and simulation agree" in out
    assert "smallest detectable size" in out
    assert "disc_oval" in out
    assert {f.name for f in (tmp_path / "out").iterdir()} == {"report.html", "diagnosis.json", "plots"}


def test_json_is_printed_alone(bench: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diagnose", str(bench / "mine.toml"), str(bench / "clean.csv"), "--out", str(tmp_path / "out")]
    assert run([*words, "--json", "-"]) == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["verdict"] == "agrees"
    assert all(line.startswith("…") for line in err.splitlines())
    assert not Path("-").exists()


def test_folder_that_nobody_gave(bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["diagnose", str(bench / "mine.toml"), str(bench / "clean.csv")]) == 0
    assert (tmp_path / "exports" / "mine" / "diagnosis" / "report.html").is_file()
    assert [f.name for f in tmp_path.iterdir()] == ["exports"]


@pytest.mark.slow
def test_files_to_check_with_are_not_fitted(
    diagnosed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["diagnose", str(diagnosed / "mine.toml"), str(diagnosed / "scan.csv"), "--out", str(tmp_path / "out")]
    assert run([*words, "--held-out", str(diagnosed / "clean.csv"), "--json", "-"]) == 0
    fitted, checked = json.loads(capsys.readouterr().out)["gap"]
    assert checked["file"] == "clean.csv"
    assert checked["fit_before"] is None
    assert checked["fit_after"] is None
    # A disc without the oval: with it in the spec the check must fail, and by as much.
    assert checked["held_out_before"] == pytest.approx(0.3, rel=0.1)
    assert checked["held_out_after"] == pytest.approx(fitted["fit_before"], rel=0.1)


@pytest.mark.slow
def test_plan_prints_the_effect_sizes_each_measurement_detects(
    bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(["diagnose", str(bench / "mine.toml"), "--plan"]) == 0
    out, err = capsys.readouterr()
    for kind in ("profile_scan", "transmission_error", "lost_motion_map", "hysteresis"):
        assert kind in out
    for name in ("disc_oval", "series_compliance", "coulomb_friction", "encoder_eccentricity"):
        assert name in out
    # No ordinary measurement separates a colder disc from a changed infeed.
    assert "as thermal_growth" in out
    assert err
    assert [p.name for p in tmp_path.rglob("*") if p.is_file()] == ["plan.png"]


FAULTS = {
    "no data": ((), "at least one CSV file"),
    "a file that is not there": (("nothing.csv",), "nothing.csv"),
    "no measured file": (("mine.toml",), "kind"),
    "an unknown kind": (("curve.csv",), "te_curve"),
    "a disc that is not there": (("scan.csv", "--disc", "3"), "disc = 3"),
    "disc 0": (("scan.csv", "--disc", "0"), "disc = 0"),
    "a bad file after a good one": (("clean.csv", "curve.csv"), "te_curve"),
    "a bad file to check with": (("clean.csv", "--held-out", "curve.csv"), "te_curve"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_refusal_is_one_sentence_and_nothing_is_written(
    fault: str, bench: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    words, named = FAULTS[fault]
    for file in ("mine.toml", "scan.csv", "clean.csv"):
        (tmp_path / file).write_bytes((bench / file).read_bytes())
    (tmp_path / "curve.csv").write_text("# kind: te_curve\na,b\n1.0,2.0\n2.0,3.0\n", encoding="utf-8")
    before = sorted(tmp_path.rglob("*"))
    monkeypatch.chdir(tmp_path)
    assert run(["diagnose", "mine.toml", *words, "--out", "out", "--json", "result.json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (sentence,) = [line for line in err.splitlines() if not line.startswith("…")]
    assert sentence.startswith("cycloid-profile: ")
    assert named in sentence
    assert sorted(tmp_path.rglob("*")) == before


def test_help_has_an_example(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnose", "--help"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "Example: cycloid-profile diagnose examples/rv40e.toml" in out


@pytest.mark.slow
def test_against_names_what_became_oval(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["diagnose", str(bench / "mine.toml"), str(bench / "scan.csv"), "--out", str(bench / "changed")]
    assert run([*words, "--against", str(bench / "clean.csv")]) == 0
    assert "what changed" in capsys.readouterr().out
    values = _values(bench / "changed" / "diagnosis.json")
    assert set(values) >= KEYS
    rows = {one["parameter"]: one for one in values["against"]["changes"] if one["name"] == "disc_oval"}
    assert rows["amplitude_um"]["change"] == pytest.approx(2.0, abs=4.0 * rows["amplitude_um"]["uncertainty"])
    assert values["against"]["files"][0]["before"] == "clean.csv"
    assert (bench / "changed" / "plots" / "change_scan.png").is_file()
