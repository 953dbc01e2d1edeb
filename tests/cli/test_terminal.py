"""Tables in terminals of several widths and in pipes, and output in encodings that lack the signs of units."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from cycloid_profile.articles import PlainTable
from cycloid_profile.catalog import catalog_names
from cycloid_profile.cli.output._tables import fold, table_lines
from cycloid_profile.spec.model import EFFECT_NAMES
from tests.cli.terminals import ROOT, in_terminal

RV40E = "examples/rv40e.toml"
WIDTHS = (60, 80, 100, 120)
COMMAND = ("-m", "cycloid_profile")
DIAGNOSIS = {
    "verdict": "effects_found",
    "effects": [
        {
            "name": "pin_ring_cumulative_pitch",
            "parameters": {"amplitude_um": 1.02, "phase_deg": 41.0},
            "uncertainty": {"amplitude_um": 0.01, "phase_deg": 0.6},
            "group": ["pin_ring_cumulative_pitch", "generating_eccentricity_error", "equidistant_error"],
            "elsewhere": False,
            "separate_by": "a lost_motion_map over one turn of the output",
        }
    ],
    "where": [
        {"file": "scan.csv", "coordinate": "lobe", "from": 10, "to": 11, "rms_um": 2.1, "p_value": 1e-9},
    ],
    "remainder": {
        "file": "loop.csv", "coordinate": "row", "from": 124, "to": 128, "rms_arcmin": 11.8, "p_value": None,
        "within_model_error": True,
    },
    "nearest": [],
    "not_seen": [],
    "gap": [
        {"file": "scan_of_the_first_specimen.csv", "unit": "um", "noise": 0.3, "fit_before": 0.77, "fit_after": 0.3,
         "held_out_before": 0.77, "held_out_after": 0.3}
    ],
}  # fmt: skip
SHOW_DIAGNOSIS = (
    "import json, sys\n"
    "from cycloid_profile.cli.output._terminal import print_tables\n"
    "from cycloid_profile.report.diagnosis import diagnosis_tables\n"
    "print_tables(diagnosis_tables(json.loads(sys.argv[1])))\n"
)


class Terminal(NamedTuple):
    """What commands show in a terminal of a width, and the folder that the export names."""

    width: int
    folder: Path
    diagnosis: str
    catalogue: str
    files: str


def piped(*words: str, encoding: str = "utf-8") -> subprocess.CompletedProcess[str]:
    """Python with these words, its output piped in ``encoding``."""
    environment = {**os.environ, "PYTHONIOENCODING": encoding, "PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, *words], cwd=ROOT, env=environment, capture_output=True, encoding=encoding, check=False
    )


# Commands one after another in one process, a line between what they print.
BETWEEN = "---- next ----"
COMMANDS = (
    "import json, sys\n"
    "from cycloid_profile.cli.main import run\n"
    "from cycloid_profile.cli.output._terminal import print_tables\n"
    "from cycloid_profile.report.diagnosis import diagnosis_tables\n"
    "diagnosis, *commands = json.loads(sys.argv[1])\n"
    "print_tables(diagnosis_tables(diagnosis))\n"
    "for words in commands:\n"
    f"    print('{BETWEEN}')\n"
    "    assert run(words) == 0\n"
)


@pytest.fixture(scope="module", params=WIDTHS)
def terminal(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Terminal:
    """A terminal of each width with a diagnosis, the catalogue, and the list of an export."""
    out = tmp_path_factory.mktemp("out") / ("a folder with a long name " * 3).strip().replace(" ", "_")
    commands = [DIAGNOSIS, ["catalog"], ["export", RV40E, "--list", "--out", str(out)]]
    status, shown = in_terminal(["-c", COMMANDS, json.dumps(commands)], request.param)
    assert status == 0, shown
    return Terminal(request.param, out, *shown.split(f"{BETWEEN}\n"))


def test_catalogue_names_its_drives_at_every_width(terminal: Terminal) -> None:
    width, shown = terminal.width, terminal.catalogue
    starts = [line.split()[0] for line in shown.splitlines() if line.strip()]
    assert set(catalog_names()) <= set(starts)
    assert max(map(cell_len, shown.splitlines())) <= width
    assert "pin circle radius [mm]" in " ".join(shown.split()).replace("[mm] radius", "radius [mm]") or width < 120


def test_a_diagnosis_names_its_effects_at_every_width(terminal: Terminal) -> None:
    width, shown = terminal.width, terminal.diagnosis
    for name in ("pin_ring_cumulative_pitch", "generating_eccentricity_error", "scan_of_the_first_specimen.csv"):
        assert name in shown
    assert "left by the effects" in shown
    assert "124 to 128" in " ".join(shown.split())
    assert max(map(cell_len, shown.splitlines())) <= width
    assert not {"′", "[′]", "[mm]", "[µm]"} & {line.strip() for line in shown.splitlines()}


def test_files_keep_their_paths_at_every_width(terminal: Terminal) -> None:
    assert f"{terminal.folder}/disc.step" in terminal.files


def test_a_pipe_gets_every_row_on_one_line() -> None:
    ended = piped(*COMMAND, "catalog")
    head, *rows = ended.stdout.splitlines()[1:]
    assert [row.split()[0] for row in rows] == list(catalog_names())
    assert "pin circle radius [mm]" in head
    ended = piped("-c", SHOW_DIAGNOSIS, json.dumps(DIAGNOSIS))
    assert "pin_ring_cumulative_pitch   amplitude_um" in ended.stdout
    assert "a lost_motion_map over one turn of the output\n" in ended.stdout


CHINESE = re.compile(r"[\u3040-\u30ff\u3400-\u9fff]")
words = st.text(st.characters(codec="utf-8", categories=["L", "Nd"]), min_size=1, max_size=12)
texts = st.lists(words, min_size=1, max_size=6).map(" ".join)


@given(
    names=st.lists(st.sampled_from(sorted(EFFECT_NAMES)), min_size=1, max_size=4),
    columns=st.lists(st.tuples(texts, texts), max_size=6), width=st.integers(50, 130),
)  # fmt: skip
def test_no_word_is_lost_and_no_line_is_too_long(names: list[str], columns: list[tuple[str, str]], width: int) -> None:
    head = ("effect", *(head for head, _ in columns))
    rows = tuple((name, *(cell for _, cell in columns)) for name in names)
    lines = table_lines(PlainTable("", head, rows), width)
    assert max(map(cell_len, lines)) <= width
    shown = " ".join(lines).split()
    for name in names:
        assert name in shown
    for each_head, cell in columns:
        for word in (*each_head.split(), *cell.split()):
            # A line may end between the signs of a script without blanks.
            assert word in shown or (CHINESE.search(word) and set(word) <= set("".join(shown)))


@pytest.mark.parametrize(
    ("text", "width", "lines"),
    [
        ("torsional rigidity [N·m/′]", 20, ("torsional", "rigidity [N·m/′]")),
        ("twist of 12.5 ′ at most", 12, ("twist of", "12.5 ′ at", "most")),
        ("amplitude_um = 1.02 ± 0.01, disc = 1", 30, ("amplitude_um = 1.02 ± 0.01,", "disc = 1")),
        ("减速器 减速器 减速器", 14, ("减速器 减速器", "减速器")),
    ],
)
def test_a_number_keeps_its_unit(text: str, width: int, lines: tuple[str, ...]) -> None:
    assert fold(text, width) == lines


@pytest.mark.parametrize("encoding", ["cp1252", "ascii", "gbk"])
def test_signs_that_the_encoding_lacks_become_words(encoding: str) -> None:
    script = f"{COMMANDS}print('46.8′, [N·m/′], 3 µm², ψ ≤ 2″, é')\n"
    ended = piped("-c", script, json.dumps([DIAGNOSIS, ["catalog"]]), encoding=encoding)
    assert (ended.returncode, ended.stderr) == (0, "")
    assert ("± 0.01" in ended.stdout) == (encoding != "ascii")
    last = ended.stdout.splitlines()[-1]
    assert (
        last
        == {
            "cp1252": "46.8 arcmin, [N·m/arcmin], 3 µm², psi <= 2 arcsec, é",
            "ascii": "46.8 arcmin, [N.m/arcmin], 3 um^2, psi <= 2 arcsec, e",
            "gbk": "46.8′, [N·m/′], 3 um^2, ψ ≤ 2″, é",
        }[encoding]
    )


@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
def test_help_and_specs_are_printed_in_every_encoding(encoding: str) -> None:
    commands = (["--help"], ["tolerance", "--help"], ["catalog", "rv40e"], ["catalog", "rv40e", "--json"])
    ended = piped("-c", COMMANDS, json.dumps([DIAGNOSIS, *commands]), encoding=encoding)
    assert (ended.returncode, ended.stderr) == (0, "")
    _, _, _, *specs = ended.stdout.split(f"{BETWEEN}\n")
    assert len(specs) == 2
    # A spec file is UTF-8, whatever the terminal: nothing but ASCII may be redirected into one.
    assert all(text.isascii() for text in specs)
