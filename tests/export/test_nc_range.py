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
from cycloid_profile.export import check_deviation
from cycloid_profile.export.curves import SpecifiedProfile
from cycloid_profile.export.inspection import DmisExporter
from cycloid_profile.export.nc import GcodeExporter, GcodePathExporter, PolarExporter, WireExporter
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
    # One arc about the inner corner in each of three cuts; all other corners are crossings of lines.
    assert [abs(step.start - step.centre) for step in arcs] == pytest.approx([0.18, 0.15, 0.14], abs=2e-5)
    assert all(abs(step.centre) < 2e-5 and step.code == 2 for step in arcs)
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
def test_decimals_are_those_the_control_reads(rv40e_record: DesignRecord, tmp_path: Path, decimals: int) -> None:
    record = record_with(rv40e_record, rv40e_record.profile, (), nc_decimals=decimals, wheel_radius_mm=2.5)
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
