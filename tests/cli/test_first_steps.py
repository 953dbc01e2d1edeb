"""Five users at the command line: each reaches the first useful file in a few commands."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from cycloid_profile.cli.main import run
from tests.diagnosis.blind import Hidden, Reducer
from tests.diagnosis.blind.tooth import ground
from tests.spec_texts import RIGID_EXAMPLE, RV40E

ROOT = Path(__file__).parents[2]
FOREIGN = ROOT / "tests" / "measurement" / "foreign" / "files"


@pytest.fixture(autouse=True)
def _in_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.slow
def test_a_hobbyist_prints_a_set_of_parts_after_two_commands() -> None:
    size = ("--pin-diameter", "3", "--outer-diameter", "60", "--material", "PLA", "--torque", "2")
    assert run(["new", "--ratio", "11", *size, "--out", "drive.toml"]) == 0
    assert run(["export", "drive.toml", "--format", "parts-stl", "--format", "bom", "--out", "parts"]) == 0
    # The list of parts names each file to print and how often.
    listed = (Path("parts") / "bom.csv").read_text(encoding="utf-8")
    printed = sorted(Path("parts").rglob("*.stl"))
    assert len(printed) >= 5
    for file in printed:
        assert file.stem.removeprefix("part_") in listed
        solid = trimesh.load(file)
        assert solid.is_watertight
        assert solid.volume > 0.0


def test_a_grinder_gets_points_in_his_own_line_after_one_command() -> None:
    points = "[export.points]\nper_lobe = 90\ntemplate = 'N{n} X{x:.4f} Y{y:.4f}'\n"
    Path("disc.toml").write_text(RIGID_EXAMPLE + points, encoding="utf-8")
    assert run(["export", "disc.toml", "--format", "csv", "--out", "out"]) == 0
    lines = (Path("out") / "points.txt").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 90 * 39
    assert all(re.fullmatch(r"N\d+ X-?\d+\.\d{4} Y-?\d+\.\d{4}", line) for line in lines)


def test_a_metrologist_reads_deviations_of_a_german_machine_in_one_command() -> None:
    reducer = Reducer()
    runout = (Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}),)
    real, nominal = ground(reducer, runout, 1), ground(reducer, (), 1)
    psi = np.linspace(0.0, reducer.period, 40 * 39, endpoint=False)
    along = nominal.points(psi + 1e-6) - nominal.points(psi - 1e-6)
    normal = 1j * along / np.abs(along)
    normal *= np.sign(np.real(normal * np.conj(nominal.points(psi))))
    at = nominal.points(psi)
    deviation = np.real(np.conj(normal) * (real.points(psi) - at))
    rows = [f"{p.real:.6f};{p.imag:.6f};{d:.6f}" for p, d in zip(at, deviation, strict=True)]
    Path("messung.csv").write_text("X;Y;dev\n" + "\n".join(rows).replace(".", ","), encoding="cp1252")
    Path("disc.toml").write_text(RV40E, encoding="utf-8")
    assert run(["inspect", "disc.toml", "messung.csv", "--out", "out", "--json=found.json", "-q"]) in {0, 1}
    found = json.loads(Path("found.json").read_text(encoding="utf-8"))
    # A runout of 3 µm moves the roots up and down by twice as much over a turn.
    (runout,) = [one for one in found["checks"] if one["symbol"] == "F_r"]
    assert runout["value_um"] == pytest.approx(6.0, rel=0.02)


def test_a_bench_engineer_compares_degrees_and_semicolons_in_one_command() -> None:
    Path("drive.toml").write_text(RV40E, encoding="utf-8")
    file = str(FOREIGN / "bench_german.csv")
    assert run(["compare", "drive.toml", file, "--out", "out", "--json=found.json", "-q"]) == 0
    (gap,) = json.loads(Path("found.json").read_text(encoding="utf-8"))["gap"]
    rigidity = next(value for name, value in gap["figures"].items() if "rigidity" in name)
    # The bench has a shaft of 134 N·m/′ in series, which the design has not.
    assert rigidity["measured"] < 134.0 < rigidity["predicted"]


def test_a_researcher_adds_a_law_in_ten_lines() -> None:
    page = (ROOT / "docs" / "own-law.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    lines = [line for line in code.splitlines() if line.strip() and not line.startswith(("import", "from", '    """'))]
    assert len(lines) <= 10
    exec(compile(code, "docs/own-law.md", "exec"), {})
