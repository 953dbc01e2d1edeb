"""What the README and docs/exports.md claim is true of the committed files, and their code runs."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
EXPORTS = (ROOT / "docs" / "exports.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def files() -> dict[str, Any]:
    """The manifest of the reference set, by file name."""
    manifest = json.loads((ROOT / "exports" / "rv40e" / "manifest.json").read_text(encoding="utf-8"))
    return {entry["path"]: entry for entry in manifest["files"]}


def claimed_um(row: str) -> float:
    """The first length of a table row's last cells, in µm."""
    value, unit = re.findall(r"([\d.]+) (µm|pm)", row)[-1 if "chords" not in row else 0]
    return float(value) * {"µm": 1.0, "pm": 1e-6}[unit]


@pytest.mark.parametrize("page", [README, EXPORTS], ids=["README", "exports"])
def test_deviations_in_the_tables_are_those_measured(page: str, files: dict[str, Any]) -> None:
    rows = {m[1]: m[0] for m in re.finditer(r"^\| `([\w.]+)` \|.*$", page, re.MULTILINE)}
    rows = {name: row for name, row in rows.items() if name in files and re.search(r"\d (µm|pm)", row)}
    assert set(rows) == {"profile.csv", "profile.dxf", "disc.step", "grinding.nc", "cmm_nominal.csv"}
    for name, row in rows.items():
        text = row.replace("chords within 0.05 µm", "") if name == "profile.csv" else row
        text = text.replace(", chords included", "")
        assert claimed_um(text) == pytest.approx(files[name]["deviation_um"], rel=0.04), row


def test_counts_in_the_exports_page(files: dict[str, Any]) -> None:
    numbers = {int(n.replace(" ", "")) for n in re.findall(r"(\d+ \d{3}) (?:points|control vertices|arcs)", EXPORTS)}
    arcs = files["grinding.nc"]["entities"]
    assert numbers == {
        files["profile.csv"]["entities"]["points"],
        files["profile.dxf"]["entities"]["control_points"],
        arcs["G2"] + arcs["G3"] - 2,  # without lead-in and lead-out
        files["cmm_nominal.csv"]["entities"]["points"],
    }


def test_figures_in_the_readme_are_those_of_the_report() -> None:
    report = (ROOT / "exports" / "rv40e" / "report.html").read_text(encoding="utf-8")
    block = README.split("```text\n")[1].split("```")[0]
    figures = re.findall(r"\s(\d[\d.]*)\s+(\d[\d.]*)$", block, re.MULTILINE)
    assert len(figures) == 5
    for before, after in figures:
        assert f'<td class="n">{before}</td><td class="n">{after}</td>' in report


BLOCKS = re.findall(r"```python\n(.*?)```", README, re.DOTALL)


def test_the_readme_has_a_design_a_diagnosis_and_a_study() -> None:
    for word, block in zip(("design_disc", "diagnose", "tolerance_record"), BLOCKS, strict=True):
        assert word in block


def test_design_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    # Thirty poses and one format show that the code runs; tests/cli/test_commands.py builds the whole set.
    code = BLOCKS[0].replace('"exports/rv40e"', f'"{tmp_path}"').replace("3120)", "30)")
    code = code.replace('.toml")', '.toml").replace("export.formats", ["csv"])')
    exec(compile(code, "README.md", "exec"), {})
    assert "compensated 0.26" in capsys.readouterr().out
    assert (tmp_path / "report.html").is_file()


@pytest.mark.slow
def test_diagnosis_of_the_readme_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    exec(compile(BLOCKS[1], "README.md", "exec"), {})
    out = capsys.readouterr().out
    name, amplitude, error = re.findall(r"(\w+) +disc = 1, amplitude_um = ([\d.]+) ± ([\d.]+)", README)[0]
    found = re.search(r"^(\w+) \{.*?'amplitude_um': ([\d.]+).*?± \{'amplitude_um': ([\d.]+)", out)
    assert found is not None
    assert found[1] == name
    assert float(found[2]) == pytest.approx(float(amplitude), abs=1e-3)
    assert float(found[3]) == pytest.approx(float(error), rel=0.05)


@pytest.mark.slow
def test_study_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    exec(compile(BLOCKS[2].replace('"out/study"', f'"{tmp_path}"'), "README.md", "exec"), {})
    share = re.search(r"([\d.]+) % of the reducers", capsys.readouterr().out)
    assert share is not None
    # 20,000 reducers: two standard deviations of a share of 77 %.
    assert float(share[1]) == pytest.approx(76.9, abs=0.6)


def test_the_ci_runs_the_readmes_own_test_command() -> None:
    blocks = re.findall(r"```bash\n(.*?)\n```", README, re.DOTALL)
    (command,) = [block for block in blocks if "pytest" in block]
    assert "\n" not in command
    assert command in (ROOT / ".ci" / "run").read_text(encoding="utf-8")
