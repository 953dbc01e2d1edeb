"""Wire programs by the strict interpreter: stops, overlap, flushing, no milling, and where a cut begins."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.errors import ExportError
from cycloid_profile.export import interpret, machine_of
from cycloid_profile.export.curves import chain_of, distance_to_chain
from cycloid_profile.export.nc import Motion, Program, WireExporter, check_wire
from cycloid_profile.geometry import DiscOutline, keyed_bore
from cycloid_profile.spec import parse_spec
from cycloid_profile.units import UM
from tests.spec_texts import PLAIN

BORE, KEY, FIRST_AT = 8.0, 4.0, math.radians(30.0)


@pytest.fixture(scope="module")
def plain() -> DesignRecord:
    record = design_disc(parse_spec(PLAIN + "[export]\nchord_tolerance_um = 1.0\n"))
    bore = keyed_bore("bore", BORE, 1, KEY, 1.8, 0.3, FIRST_AT)
    return replace(record, outline=DiscOutline(record.profile, (bore,)))


def asked(record: DesignRecord, wire: dict[str, Any] | None = None, **export: Any) -> DesignRecord:
    settings = msgspec.structs.replace(record.spec.export, **export)
    settings = msgspec.structs.replace(settings, wire=msgspec.structs.replace(settings.wire, **(wire or {})))
    return replace(record, spec=msgspec.structs.replace(record.spec, export=settings))


def program_of(record: DesignRecord, folder: Path) -> Program:
    WireExporter().write(record, folder)
    text = (folder / "wire_edm.nc").read_text(encoding="ascii")
    return interpret(text, machine_of(record.spec.export), "wire_edm.nc")


def cuts_of(program: Program) -> list[list[Motion]]:
    """Motions of each contour after its rapid move."""
    begins = [k for k, motion in enumerate(program.motions) if motion.kind == "rapid"]
    return [program.motions[a + 1 : b] for a, b in itertools.pairwise([*begins, len(program.motions)])]


def length(motions: list[Motion]) -> float:
    """Length of the path [mm]."""
    total = 0.0
    for one in motions:
        if one.kind == "line":
            total += abs(one.end.plane - one.start.plane)
            continue
        sense = 1.0 if one.kind == "anticlockwise" else -1.0
        turn = np.angle((one.end.plane - one.centre) / (one.start.plane - one.centre)) * sense
        total += abs(one.start.plane - one.centre) * float(turn % (2.0 * math.pi))
    return total


def test_every_cut_of_a_keyed_bore_begins_on_its_contour_away_from_the_key(plain: DesignRecord, tmp_path: Path) -> None:
    program = program_of(plain, tmp_path)
    bore, _ = cuts_of(program)
    chain = chain_of(plain.outline.contours[0])
    edges = BORE * np.exp(1j * (FIRST_AT + np.array([-1.0, 1.0]) * math.asin(0.5 * KEY / BORE)))
    begin = bore[0].end.plane
    assert abs(distance_to_chain(chain, np.array([begin]))[0] - 0.18) < 1.0 * UM
    assert np.min(np.abs(edges - begin)) > 3.0
    # The first cut to the tab, the tab, and two skims: every point is one of the three offsets away.
    ends = np.array([one.end.plane for one in bore[:-1]])
    off = distance_to_chain(chain, ends)
    assert np.max(np.min(np.abs(off[:, np.newaxis] - [0.18, 0.15, 0.14]), axis=1)) < 1.0 * UM
    # Also the cut from hole to contour and back stays inside the bore.
    assert bore[0].start.plane == bore[-1].end.plane == 0j


@pytest.mark.parametrize("overlap", [0.0, 0.3, 1.0])
def test_the_tab_is_cut_after_the_stop_and_past_the_start(plain: DesignRecord, tmp_path: Path, overlap: float) -> None:
    program = program_of(asked(plain, {"overlap_mm": overlap, "slug_tab_mm": 0.8}), tmp_path)
    bore, _ = cuts_of(program)
    (hold, text), (remove, _), (clamp, clamping) = program.stops
    assert "HOLD THE SLUG" in text
    assert "CLAMP" in clamping
    first = program.motions.index(bore[0])
    before, tab = bore[1 : hold - first], bore[hold - first : remove - first]
    assert length(tab) == pytest.approx(0.8 + overlap, abs=1e-3)
    whole = length(before) + 0.8
    skim = bore[remove - first + 1 :]
    # Two skims, each a whole turn and the overlap, at other offsets; lines between them and to the hole.
    assert length(skim) == pytest.approx(2.0 * (whole + overlap) + 7.9, rel=0.01)
    # The last lobe is cut after the clamping stop, and held until then.
    cut_free = program.motions[clamp:]
    held = [one.end.plane for one in program.motions[program.motions.index(bore[-1]) + 2 : clamp]]
    lobe = 2.0 * math.pi / plain.profile.trochoid.lobes
    angle = np.sort(np.angle(held))
    assert np.max(np.diff(np.append(angle, angle[0] + 2.0 * math.pi))) > 0.9 * lobe
    assert len(cut_free) > 10


def test_without_a_tab_only_the_clamping_stops_remain(plain: DesignRecord, tmp_path: Path) -> None:
    program = program_of(asked(plain, {"slug_tab_mm": 0.0, "skim_stock_um": ()}), tmp_path)
    assert ["CLAMP" in text for _, text in program.stops] == [True]


@pytest.mark.parametrize("control", ["linuxcnc", "fanuc", "siemens", "heidenhain"])
def test_a_wire_program_has_no_milling_words(plain: DesignRecord, tmp_path: Path, control: Any) -> None:
    program = program_of(asked(plain, nc_dialect=control), tmp_path)
    for state in [motion.state for motion in program.motions] + [program.state]:
        assert (state.spindle, state.coolant, state.side, state.tool, state.flushing) == (0.0, False, "", 0, False)


def machine_file(folder: Path, blocks: str) -> str:
    file = folder / "wire.toml"
    file.write_text(f'name = "Cutter"\ncontrol = "fanuc"\n[blocks]\n{blocks}\n', encoding="utf-8")
    return str(file)


@pytest.mark.parametrize(("on", "off"), [("M78", "M79"), ("M8", "M9")])
def test_flushing_words_of_the_machine_file(plain: DesignRecord, tmp_path: Path, on: str, off: str) -> None:
    machine = machine_file(tmp_path, f'flush_on = ["{on}"]\nflush_off = ["{off}"]')
    program = program_of(asked(plain, machine=machine), tmp_path)
    assert all(motion.state.flushing == (motion.kind != "rapid") for motion in program.motions)
    assert not program.state.flushing
    words = (tmp_path / "wire_edm.nc").read_text(encoding="ascii").splitlines()
    assert words.count(on) == words.count(off) == 2


@pytest.mark.parametrize(
    ("blocks", "finding"),
    [
        ('flush_on = ["M78"]', "flushed without a wire"),
        ('thread = ["M60", "M8"]', ""),
        ('wire = ["G17 G21 G40 G54 G90 G94", "M8"]', "milling word"),
        ('wire = ["G17 G21 G40 G54 G90 G94", "S1000 M3"]', "milling word"),
        ('wire = ["G17 G21 G40 G54 G90 G94", "T1 M6"]', "milling word"),
        ('wire = ["G17 G21 G41 G54 G90 G94"]', "milling word"),
        ("cut_wire = []", "rapid move with the wire threaded"),
    ],
)
def test_what_a_wire_program_must_not_do_is_refused(
    plain: DesignRecord, tmp_path: Path, blocks: str, finding: str
) -> None:
    record = asked(plain, machine=machine_file(tmp_path, blocks))
    if not finding:
        program_of(record, tmp_path)
        return
    with pytest.raises(ExportError, match=finding):
        program_of(record, tmp_path)


def test_flushing_left_on_is_refused(plain: DesignRecord, tmp_path: Path) -> None:
    program = program_of(plain, tmp_path)
    left_on = program._replace(state=program.state._replace(flushing=True))
    with pytest.raises(ExportError, match="leaves the flushing on"):
        check_wire(left_on, machine_of(plain.spec.export), "wire_edm.nc")
