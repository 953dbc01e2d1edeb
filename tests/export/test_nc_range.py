"""NC programs over the whole range: 3 to 300 lobes, K1 from 0.1 to 0.95, round, grooved and ridged; odd openings."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from dialects import along, run

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export import check_deviation
from cycloid_profile.export.curves import SpecifiedProfile
from cycloid_profile.export.inspection import DmisExporter
from cycloid_profile.export.nc import (
    Blank,
    GcodeExporter,
    GcodePathExporter,
    PolarExporter,
    WireExporter,
    check_grinding,
    interpret,
    machine_of,
    read_machine,
)
from cycloid_profile.export.points import VdaExporter
from cycloid_profile.geometry import (
    CentralEccentric,
    Contour,
    DiscOutline,
    Drive,
    Line,
    ToothProfile,
    Trochoid,
    circular_contour,
    keyed_bore,
    ring_of_windows,
    undercut_limit,
)
from cycloid_profile.modification import DeformationCompensation, MeasuredDeviation, NormalDeviation, modify


def record_with(
    record: DesignRecord, profile: ToothProfile, contours: tuple[Contour, ...], **keys: Any
) -> DesignRecord:
    """The design of the RV-40E with another tooth, other openings and other keys under ``[export]``."""
    export = msgspec.structs.replace(record.spec.export, chord_tolerance_um=1.0, **keys)
    return replace(
        record,
        spec=msgspec.structs.replace(record.spec, export=export),
        drive=Drive(profile.trochoid, 0.5 * profile.pin_radius, 10.0, 2, CentralEccentric(4e5)),
        profile=profile,
        outline=DiscOutline(profile, contours),
    )


@pytest.mark.slow
@pytest.mark.parametrize("delta", [0.0, 0.002, -0.002], ids=["round", "groove", "ridge"])
@pytest.mark.parametrize("K1", [0.1, 0.95])
@pytest.mark.parametrize("lobes", [3, 300])
def test_every_program_keeps_its_promise(
    rv40e_record: DesignRecord, tmp_path: Path, lobes: int, K1: float, delta: float
) -> None:
    pins, ring = lobes + 1, max(64.0, 0.64 * lobes)
    trochoid = Trochoid(pins, ring, K1 * ring / pins)
    profile = ToothProfile(trochoid, 0.6 * min(undercut_limit(trochoid), ring * math.sin(math.pi / pins)))
    if delta:
        profile = modify(profile, DeformationCompensation(delta))
    record = record_with(rv40e_record, profile, (circular_contour("bore", 0j, 5.0),), wheel_compensation="G41")
    for exporter in (GcodeExporter(), PolarExporter(), WireExporter()):
        for file in exporter.write(record, tmp_path):
            assert check_deviation(file).deviation is not None


def test_wire_cuts_windows_and_keyways(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    openings = (
        keyed_bore("bore", 12.0, 2, 4.0, 2.0, 0.3, 0.0),
        *ring_of_windows("window", 6, (20.0, 30.0), math.radians(40.0), 2.0, 0.3),
    )
    record = record_with(rv40e_record, rv40e_record.profile, openings)
    WireExporter().write(record, tmp_path)
    steps = run((tmp_path / "wire_edm.nc").read_text(encoding="ascii"), "linuxcnc")
    begins = [k for k, step in enumerate(steps) if step.code == 0]
    assert len(begins) == len(openings) + 1
    for contour, first, last in zip(openings, begins[:-1], begins[1:], strict=True):
        edge = contour.points(1e-5)
        corners = np.append(edge, edge[0])
        # All of the wire's path, lead-in included, is inside, and never nearer than radius and gap.
        z = np.concatenate([along(step, np.linspace(0.0, 1.0, 9)) for step in steps[first + 1 : last]])
        winding = np.sum(np.angle((corners[1:] - z[:, np.newaxis]) / (corners[:-1] - z[:, np.newaxis])), axis=1)
        assert np.allclose(winding, 2.0 * math.pi, atol=1e-6)
        side = corners[1:] - corners[:-1]
        share = np.clip(((z[:, np.newaxis] - corners[:-1]) * np.conj(side)).real / np.abs(side) ** 2, 0.0, 1.0)
        away = np.min(np.abs(z[:, np.newaxis] - corners[:-1] - share * side), axis=1)
        assert np.min(away) == pytest.approx(0.14, abs=1e-4)


def test_wire_rounds_a_sharp_corner_off(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    # An L of lines: five corners that the wheel of the wire cannot enter, and one that it goes round.
    places = [complex(x, y) for x, y in ((-6, -6), (6, -6), (6, 0), (0, 0), (0, 6), (-6, 6))]
    contour = Contour("window 1", tuple(Line(a, b) for a, b in zip(places, [*places[1:], places[0]], strict=True)))
    WireExporter().write(record_with(rv40e_record, rv40e_record.profile, (contour,)), tmp_path)
    steps = run((tmp_path / "wire_edm.nc").read_text(encoding="ascii"), "linuxcnc")
    second = [k for k, step in enumerate(steps) if step.code == 0][1]
    arcs = [step for step in steps[:second] if step.code in (2, 3)]
    # Arcs about the inner corner in each of three cuts; all other corners are crossings of lines.
    radii = [abs(step.start - step.centre) for step in arcs]
    assert sorted(set(np.round(radii, 4).tolist())) == [0.14, 0.15, 0.18]
    assert all(abs(step.centre) < 2e-5 for step in arcs)
    # The cuts run to and fro about it.
    assert [step.code for step, radius in zip(arcs, radii, strict=True) if radius < 0.145] == [2] * len(
        [radius for radius in radii if radius < 0.145]
    )
    ends = np.array([step.end for step in steps[:second]])
    assert np.min(np.abs(ends - complex(-5.86, -5.86))) < 2e-5


@pytest.mark.slow
def test_lobes_that_differ_go_into_every_program(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    trochoid = Trochoid(12, 64.0, 4.0)
    psi = np.linspace(0.0, trochoid.phase_period, 20 * trochoid.lobes, endpoint=False)
    runout = NormalDeviation(psi, 0.01 * np.cos(psi / trochoid.lobes), trochoid.lobes)
    tooth = modify(ToothProfile(trochoid, 10.0), MeasuredDeviation(runout))
    record = record_with(rv40e_record, tooth, ())
    path = SpecifiedProfile(record.spec, record.drive, tooth)
    for exporter in (GcodeExporter(), PolarExporter(), VdaExporter()):
        for file in exporter.write(path, tmp_path):
            check_deviation(file)
    for name in ("grinding.nc", "grinding_polar.nc"):
        assert "LOBES DIFFER" in (tmp_path / name).read_text(encoding="ascii")


@pytest.mark.parametrize("decimals", [3, 6])
def test_decimals_are_those_the_control_reads(eleven_lobes: DesignRecord, tmp_path: Path, decimals: int) -> None:
    record = record_with(eleven_lobes, eleven_lobes.profile, (), nc_decimals=decimals, wheel_radius_mm=2.5)
    for exporter in (GcodeExporter(), PolarExporter(), WireExporter()):
        file = exporter.write(record, tmp_path)[0]
        check_deviation(file)
        assert file.tolerance is not None
        assert file.tolerance <= 1e-3 + 1.5 * 10.0**-decimals
    steps = run((tmp_path / "grinding_polar.nc").read_text(encoding="ascii"), "linuxcnc")
    turning = [step for step in steps if step.c != step.c_start and step.code == 1]
    assert all(step.c > step.c_start for step in turning)
    assert turning[-1].c - turning[0].c_start == pytest.approx(6 * 360.0, abs=1e-7)
    words = re.findall(r" ([XC])-?\d+\.(\d+)", (tmp_path / "grinding_polar.nc").read_text(encoding="ascii"))
    assert {letter: len(places) for letter, places in words} == {"X": decimals, "C": decimals + 1}


@pytest.mark.slow
def test_equal_input_gives_equal_bytes(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    # A feed that the axes cannot follow everywhere, so that the linear program is solved as well.
    record = record_with(
        rv40e_record, rv40e_record.profile, (circular_contour("bore", 0j, 5.0),), feed_mm_per_min=6000.0
    )
    names = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        for exporter in (PolarExporter(), WireExporter(), GcodePathExporter(), DmisExporter(), VdaExporter()):
            names += [file.name for file in exporter.write(record, folder)]
    assert "TO 6000.0 MM/MIN" in (tmp_path / "a" / "grinding_polar.nc").read_text(encoding="ascii")
    assert "6000.0 TO 6000.0" not in (tmp_path / "a" / "grinding_polar.nc").read_text(encoding="ascii")
    for name in names:
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_wire_starts_on_the_axis_of_a_keyed_bore_and_overlaps_its_start(
    rv40e_record: DesignRecord, tmp_path: Path
) -> None:
    record = record_with(rv40e_record, rv40e_record.profile, (keyed_bore("bore", 12.0, 2, 4.0, 2.0, 0.3, 0.0),))
    WireExporter().write(record, tmp_path)
    text = (tmp_path / "wire_edm.nc").read_text(encoding="ascii")
    bore, _ = (part for part in text.split("START HOLE")[1:])
    assert not re.search(
        r"\b(?:G43|G49|G80|G41|G42|T\d|S\d|M3|M6|M8)\b|Z", text.split("WIRE", 1)[1].replace("THREAD", "")
    )
    steps = run(text, "linuxcnc")
    assert steps[0].end == 0j
    # The first cut begins at the offset from the bore, exactly, and stops twice: to hold the slug, to take it out.
    assert abs(steps[1].end) == pytest.approx(12.0 - 0.18, abs=2e-5)
    assert bore.index("HOLD THE SLUG") < bore.index("REMOVE THE SLUG") < bore.index("CUT 2 OF 3")
    # The tab is half a millimetre along the wire's path, and the cut after it runs as far past the start.
    before, after = (re.findall(r"\nG[123] X(\S+) Y(\S+)", part) for part in bore.split("HOLD THE SLUG"))
    begin, at_stop = (complex(float(x), float(y)) for x, y in (before[0], before[-1]))
    assert begin == steps[1].end
    assert 0.4 < abs(at_stop - begin) <= 0.5 + 1e-4
    # One arc, because a cut begins in the middle of an arc of the bore.
    past = complex(*map(float, after[0]))
    assert 0.4 < abs(past - begin) <= 0.5 + 1e-4


def test_a_machine_file_is_merged_and_its_faults_are_one_sentence(tmp_path: Path) -> None:
    mine = tmp_path / "my.toml"
    mine.write_text('name = "Grinder 7"\ncontrol = "fanuc"\n[tool]\nnumber = 12\n', encoding="utf-8")
    machine = read_machine(mine)
    assert (machine.name, machine.tool.number, machine.tool.offset) == ("Grinder 7", 12, 1)
    assert machine.numbers.inverse_time_per_min == (0.001, 9999.999)
    for text, fault in (
        ('control = "okuma"', r"my\.toml', control = 'okuma' is not a known control: choose from linuxcnc"),
        ('control = "fanuc"\n[tool]\nnumbr = 2', r"tool\.numbr = 2 is not a key of a machine file: did you mean"),
        ('control = "fanuc"\n[tool]\nnumber = 0', r"tool\.number = 0 must be >= 1: give 1 to 9999"),
        ('control = "fanuc"\n[axes]\nx_mm = [5.0, 1.0]', r"axes\.x_mm = \[5\.0, 1\.0\] is no rising range"),
        ('control = "fanuc"\n[blocks]\ntool = ["T{wheel}"]', r"blocks\.tool = 'T\{wheel\}' has an unknown place"),
        ('control = "fanuc"\n[blocks]\ntool = ["T{tool.__class__}"]', "has an unknown place"),
        ('control = "fanuc"\n[blocks]\ntool = ["T{tool:999999999}"]', "has an unknown place"),
        ('control = "fanuc"\n[blocks]\ntool = ["T{tool"]', "has an unknown place"),
        ("control = ", r"my\.toml' is not valid TOML"),
        ("# \ud8ff", r"my\.toml' cannot be read \(it is not UTF-8 text\)"),
    ):
        mine.write_bytes(text.encode("utf-8", "surrogatepass"))
        with pytest.raises(ExportError, match=fault):
            read_machine(mine)


@pytest.mark.parametrize(
    ("change", "finding"),
    [
        ("[blocks]\nspindle_on = []", "without spindle"),
        ("[blocks]\nspindle_off = []", "is not off and retracted"),
        ("[blocks]\ntool = []", "without spindle, tool"),
        ('[blocks]\nend = ["M48", "M30"]', "'M48' is no known word"),
        ('[blocks]\nend = ["G28 X0"]', "'G28' is no known word"),
        ("[axes]\nx_mm = [-60.0, 60.0]", "leaves the travel of X"),
        ("[numbers]\nfeed_mm_per_min = [600.0, 9999.0]", ""),
    ],
)
def test_a_program_that_breaks_a_rule_of_its_machine_is_refused(
    eleven_lobes: DesignRecord, tmp_path: Path, change: str, finding: str
) -> None:
    mine = tmp_path / "my.toml"
    mine.write_text(f'control = "fanuc"\n{change}\n', encoding="utf-8")
    record = record_with(
        eleven_lobes, eleven_lobes.profile, (), machine=str(mine), wheel_compensation="G41", wheel_radius_mm=2.5
    )
    if not finding:
        # A feed below the range is raised to it.
        GcodeExporter().write(record, tmp_path)
        assert " F600\n" in (tmp_path / "grinding.nc").read_text(encoding="ascii")
        return
    with pytest.raises(ExportError, match=re.escape(finding)):
        GcodeExporter().write(record, tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "finding"),
    [
        ("G0 Z30.00000\n(PASS", "(PASS", "rapid move"),
        ("M9\nM5", "G0 X0.00000 Y0.00000 Z5.00000\nM9\nM5", "rapid move"),
        ("G1 Z-1.00000 F500\nG41.1 D5.00000\n", "G41.1 D5.00000\nG1 Z-1.00000 F500\n", ""),
        ("G2 X", "G1 Z2.00000\nG2 X", "plunges into the blank"),
        ("T1 M6", "T1 M6 Q7", "is no known word"),
        ("G1 Z-1.00000 F500", "G1 Z-1.0000001 F500", "more than the 5 decimals"),
    ],
)
def test_a_program_changed_by_hand_is_refused(
    eleven_lobes: DesignRecord, tmp_path: Path, old: str, new: str, finding: str
) -> None:
    record = record_with(eleven_lobes, eleven_lobes.profile, (), wheel_compensation="G41", wheel_radius_mm=2.5)
    GcodeExporter().write(record, tmp_path)
    text = (tmp_path / "grinding.nc").read_text(encoding="ascii")
    assert old in text
    machine = machine_of(record.spec.export)
    tip = float(np.max(np.abs(record.profile.at(np.pi * (2.0 * np.arange(11) + 1.0)).position)))

    def check(changed: str) -> None:
        check_grinding(interpret(changed, machine), machine, Blank(tip + 0.015, 10.0), 2.5, "grinding.nc")

    check(text)
    changed = text.replace(old, new, 1)
    if not finding:
        # Switched on the way down, still in air.
        check(changed)
        return
    with pytest.raises(ExportError, match=finding):
        check(changed)
