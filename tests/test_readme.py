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


def test_python_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    code = README.split("```python\n")[1].split("```")[0]
    monkeypatch.chdir(ROOT)
    exec(compile(code.replace('"exports/rv40e"', f'"{tmp_path}"'), "README.md", "exec"), {})
    assert "→" in capsys.readouterr().out
    assert (tmp_path / "report.html").is_file()


def test_the_ci_runs_the_readmes_own_test_command() -> None:
    blocks = re.findall(r"```bash\n(.*?)\n```", README, re.DOTALL)
    (command,) = [block for block in blocks if "pytest" in block]
    assert "\n" not in command
    assert command in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_links_lead_somewhere() -> None:
    for page in [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]:
        for target in re.findall(r"\]\((?!http|#)([^)#]+)", page.read_text(encoding="utf-8")):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
