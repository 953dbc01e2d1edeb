"""Names in any script: every file keeps the name as it is, or in ASCII letters where its readers take no others."""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import ezdxf
import msgspec
import pytest
from ezdxf.tools.text import plain_text

from cycloid_profile.cli.main import run
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.export import ascii_name_notes, exporter_for, interpret, machine_of, write_formats
from cycloid_profile.export.points.nominal_points import read_sequences
from cycloid_profile.export.writing import notes_of, plain_name, step_text
from cycloid_profile.report.design import build_package
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import Dialect
from tests.spec_texts import PLAIN

NAME = "齿轮 δ-Ρ 2"
IN_ASCII = "ChiLun d-R 2"
AWKWARD = "<a> & \"b\" 50%%d ^J 'ü'"
Named = Callable[..., DesignRecord]


@pytest.fixture(scope="module")
def named() -> Named:
    """The plain drive under any name, its disc of a material with a name of its own."""
    text = PLAIN + '[materials.disc]\nname = "钢, 42"\n[export]\nchord_tolerance_um = 1.0\n'
    record = design_disc(parse_spec(text))
    return lambda name, **export: replace(
        record,
        spec=msgspec.structs.replace(
            record.spec, name=name, export=msgspec.structs.replace(record.spec.export, **export)
        ),
    )


@pytest.mark.parametrize("name", [NAME, AWKWARD])
def test_dxf_svg_and_3mf_keep_the_name(named: Named, name: str, tmp_path: Path) -> None:
    from cycloid_profile.export.writing import lib3mf

    write_formats(named(name), ("dxf-arcs", "dxf-offset", "svg", "3mf", "dmis"), tmp_path)
    for file in ("profile_arcs.dxf", "profile_offset.dxf"):
        texts = [text.dxf.text for text in ezdxf.readfile(tmp_path / file).modelspace().query("TEXT")]
        assert name in [plain_text(text) for text in texts]
    svg = ElementTree.parse(tmp_path / "profile.svg").getroot()
    assert svg.findtext("{http://www.w3.org/2000/svg}title") == name
    model = lib3mf().get_wrapper().CreateModel()
    model.QueryReader("3mf").ReadFromFile(str(tmp_path / "disc.3mf"))
    bodies = model.GetMeshObjects()
    assert bodies.MoveNext()
    assert bodies.GetCurrentMeshObject().GetName() == name
    assert name in (tmp_path / "inspection_plan.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("dialect", ["linuxcnc", "fanuc", "siemens", "heidenhain"])
@pytest.mark.parametrize("name", [NAME, AWKWARD, "漢" * 80])
def test_programs_hold_the_name_in_ascii_and_run(named: Named, name: str, dialect: Dialect, tmp_path: Path) -> None:
    record = named(name, nc_dialect=dialect)
    (file,) = exporter_for("gcode").write(record, tmp_path)
    text = (tmp_path / file.name).read_text(encoding="ascii")
    assert plain_name(name).upper() in text
    assert max(map(len, text.splitlines())) <= 120
    assert interpret(text, machine_of(record.spec.export), file.name).motions


def test_measuring_programs_hold_the_name_in_ascii(named: Named, tmp_path: Path) -> None:
    for name in (NAME, AWKWARD, "漢" * 80):
        write_formats(named(name), ("dmis", "vdafs"), tmp_path)
        first = (tmp_path / "cmm.dmi").read_text(encoding="ascii").splitlines()[0]
        assert re.fullmatch(r"DMISMN/'[^']*',05\.2", first)
        assert plain_name(name) in first
        lines = (tmp_path / "cmm_nominal.vda").read_text(encoding="ascii").splitlines()
        assert {len(line) for line in lines} == {80}
        count = int(lines[0][:72].rpartition("/")[2])
        header = " ".join(line[:72].strip() for line in lines[1 : count + 1])
        assert plain_name(name).upper().replace(" ", "") in header.replace(" ", "")
        assert read_sequences(tmp_path / "cmm_nominal.vda").shape[1] == 6


def test_plain_names_are_ascii_and_keep_every_word() -> None:
    assert plain_name(NAME) == IN_ASCII
    assert plain_name("RV-40E") == "RV-40E"
    assert plain_name("Größe №3 (A/2)") == "Grosse No3 _A_2_"
    assert plain_name("шестерня") == "shesternya"
    assert len(plain_name("漢" * 80)) == 100
    # Nothing that ends a comment, a string, a block or a tape.
    assert not set("()%;'~\"") & set(plain_name("(a) % ; ' ~ \""))


def test_step_texts_are_those_of_the_standard() -> None:
    # ISO 10303-21:2016, 6.4.3: \X2\ with four digits, \X4\ with eight.
    assert step_text("RV-40E") == "RV-40E"
    assert step_text("aü齿b") == "a\\X2\\00FC9F7F\\X0\\b"
    assert step_text("🦾") == "\\X4\\0001F9BE\\X0\\"
    assert step_text("a\\b") == "a\\\\b"


@pytest.mark.slow
@pytest.mark.parametrize("name", [NAME, "<a> & \"b\" 'ü' 🦾", "漢" * 80])
def test_step_keeps_the_name_in_header_part_and_material(named: Named, name: str, tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    from build123d import import_step

    record = named(name)
    write_formats(record, ("step", "step-assembly", "parts-3mf", "bom"), tmp_path)
    for file in ("disc.step", "assembly.step"):
        text = re.sub(r"\n\s*", "", (tmp_path / file).read_text(encoding="ascii"))
        header = re.search(r"FILE_NAME\('((?:[^']|'')*)'", text)
        assert header is not None
        assert decoded(header[1]) == name
        # build123d writes blanks as underscores.
        assert import_step(tmp_path / file).label.replace("_", " ") == name
        materials = re.findall(r"DESCRIPTIVE_REPRESENTATION_ITEM\('((?:[^']|'')*)'", text)
        assert "钢, 42" in [decoded(one) for one in materials]
    rows = list(csv.reader((tmp_path / "bom.csv").read_text(encoding="utf-8").splitlines()))
    assert rows[1][rows[0].index("material")] == "钢, 42"


def decoded(text: str) -> str:
    """Text of a STEP file, by the standard."""
    text = re.sub(r"\\X2\\([0-9A-F]*)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-16-be"), text)
    text = re.sub(r"\\X4\\([0-9A-F]*)\\X0\\", lambda m: bytes.fromhex(m[1]).decode("utf-32-be"), text)
    return text.replace("''", "'").replace("\\\\", "\\")


@pytest.mark.slow
def test_the_report_keeps_the_name(named: Named, tmp_path: Path) -> None:
    record = named(AWKWARD, formats=("csv",))
    build_package(record, tmp_path / "out")
    found: list[str] = []
    parser = HTMLParser()
    parser.handle_data = found.append  # type: ignore[method-assign]
    parser.feed((tmp_path / "out" / "report.html").read_text(encoding="utf-8"))
    assert any(AWKWARD in text for text in found)
    manifest = msgspec.json.decode((tmp_path / "out" / "manifest.json").read_bytes())
    assert manifest["name"] == AWKWARD


def test_the_command_says_how_the_name_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "named.toml"
    file.write_text(PLAIN.replace('"plain"', f'"{NAME}"'), encoding="utf-8")
    assert run(["export", str(file), "--format", "csv", "gcode", "--out", str(tmp_path / "out")]) in (0, 1)
    error = capsys.readouterr().err
    assert f"the name '{NAME}' is '{IN_ASCII}' in gcode" in error


def test_no_note_where_the_name_is_kept() -> None:
    spec = parse_spec(PLAIN.replace('"plain"', f'"{NAME}"'))
    assert ascii_name_notes(spec, ("csv", "dxf", "step", "3mf")) == []
    assert ascii_name_notes(parse_spec(PLAIN), ("gcode", "dmis")) == []
    assert len(ascii_name_notes(spec, ("gcode", "dmis"))) == 1


@pytest.mark.slow
def test_letters_without_a_font_are_a_note_of_command_and_manifest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """U+50000 lies in a plane without letters: no font has it."""
    spec, out = tmp_path / "spec.toml", tmp_path / "out"
    spec.write_text(PLAIN.replace('"plain"', '"plain \U00050000"'), encoding="utf-8")
    assert run(["export", str(spec), "--format", "drawing", "--out", str(out)]) == 0
    (noted,) = notes_of(json.loads((out / "manifest.json").read_text(encoding="utf-8"))["files"])
    assert "\U00050000 as U+50000" in noted
    assert noted in capsys.readouterr().err


def test_a_quiet_command_says_no_notes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "named.toml"
    file.write_text(PLAIN.replace('"plain"', f'"{NAME}"'), encoding="utf-8")
    assert run(["export", str(file), "--format", "vdafs", "--out", str(tmp_path / "out"), "--quiet"]) == 0
    assert capsys.readouterr().err == ""
