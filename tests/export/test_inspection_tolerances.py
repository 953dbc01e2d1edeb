"""Tolerances where the spec states none: ISO 286-1, and the same values in plan, DMIS program, drawing and evaluation.

Zones of ISO 286-1:2010, Table 1, typed from the standard: IT4 12 µm and IT5 13 µm of 120 to 180 mm and 50 to 80 mm.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.drawing._tolerances import tolerances
from cycloid_profile.export.drawing.exporter import draw_sheet
from cycloid_profile.export.inspection import DmisExporter, inspect_scan, inspection_tolerances
from cycloid_profile.geometry import DiscOutline
from cycloid_profile.measurement import PROFILE_SCAN, Measurement
from cycloid_profile.report import inspection_to_json
from cycloid_profile.spec import Quality
from cycloid_profile.spec.model import DrawingSpec, standard_zone
from tests.export.test_drawing import texts_of


def with_spec(record: DesignRecord, **changes: object) -> DesignRecord:
    return replace(record, spec=msgspec.structs.replace(record.spec, **changes))


def with_export(record: DesignRecord, **tables: object) -> DesignRecord:
    return with_spec(record, export=msgspec.structs.replace(record.spec.export, **tables))


def scan_of(record: DesignRecord) -> Measurement:
    points = record.profile.at(np.linspace(0.0, record.profile.trochoid.phase_period, 4000, endpoint=False)).position
    return Measurement(PROFILE_SCAN, {"x_mm": points.real, "y_mm": points.imag}, {"datum": "bore"}, "scan.csv")


def printed_um(record: DesignRecord, folder: Path) -> list[list[float]]:
    """Profile ±, single pitch ±, cumulative pitch and runout [µm] as four outputs print them."""
    DmisExporter().write(record, folder)
    page = (folder / "inspection_plan.md").read_text(encoding="utf-8")
    program = (folder / "cmm.dmi").read_text(encoding="ascii")
    sheet, _ = draw_sheet(record)
    texts = [text for text, _ in texts_of(sheet.doc, sheet.unit)]

    def in_program(pattern: str) -> float:
        found = re.search(pattern, program, re.MULTILINE)
        assert found is not None
        return float(found[1])

    def in_table(name: str) -> float:
        # The cells of a row follow each other: name, symbol where there is one, value.
        value = next(text for text in texts[texts.index(name) :] if text.endswith(("mm", "*")) and text != name)
        return 1e3 * float(value.strip("±*").removesuffix(" mm"))

    radius = inspect_scan(record, scan_of(record)).plan.pitch_radius
    evaluated = inspection_to_json("", inspect_scan(record, scan_of(record)))["checks"]
    return [
        [float(cells[4].strip("± ")) for cells in (row.split("|") for row in page.splitlines()[4:8])],
        [
            1e3 * in_program(r"^T\(1\)=TOL/PROFP,-.*,(.*)$"),
            1e3 * in_program(r"TOL/DISTB,.*,(.*),PT2PT$"),
            1e3 * math.radians(in_program(r"^T\(1\d\d\)=TOL/ANGLB,.*,(.*)$")) * radius,
            1e3 * in_program(r"TOL/CRNOUT,(.*),DAT\(B\)$"),
        ],
        [
            0.5 * in_table("profile, whole zone"),
            *map(in_table, ("single pitch deviation", "cumulative pitch deviation", "runout of the teeth")),
        ],
        [check["tolerance_um"] for check in evaluated],
    ]


@pytest.mark.parametrize(("quality", "zone"), [("ground", 12.0), ("printed", 400.0)])
def test_all_print_the_zone_of_the_grade(
    rv40e_record: DesignRecord, tmp_path: Path, quality: Quality, zone: float
) -> None:
    expected = [0.5 * zone, 0.5 * zone, zone, zone]
    for found in printed_um(with_spec(rv40e_record, quality=quality), tmp_path):
        assert found == pytest.approx(expected, abs=1e-3)


def test_all_print_what_the_table_of_the_drawing_states(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    stated = DrawingSpec(
        profile_tolerance_um=9.0,
        single_pitch_tolerance_um=3.0,
        cumulative_pitch_tolerance_um=14.0,
        runout_tolerance_um=11.0,
    )
    record = with_export(rv40e_record, drawing=stated)
    for found in printed_um(record, tmp_path):
        assert found == pytest.approx([4.5, 3.0, 14.0, 11.0], abs=1e-3)


def test_each_table_wins_in_its_own_output(rv40e_record: DesignRecord) -> None:
    inspection = msgspec.structs.replace(rv40e_record.spec.export.inspection, profile_tolerance_um=4.0)
    record = with_export(rv40e_record, inspection=inspection, drawing=DrawingSpec(profile_tolerance_um=10.0))
    assert inspection_tolerances(record).profile.size == pytest.approx(4e-3)
    assert inspection_tolerances(record, on_drawing=True).profile.size == pytest.approx(5e-3)


def test_holes_have_their_grade_at_their_circle(rv40e_record: DesignRecord) -> None:
    limits = inspection_tolerances(rv40e_record)
    assert limits.hole_position.size == pytest.approx(13e-3)
    assert limits.hole_position.source == "IT5, ground"
    # ± half the zone over the radius of 36 mm: 0.62′.
    assert limits.hole_angle_arcmin.size == pytest.approx(math.degrees(6.5e-3 / 36.0) * 60.0, abs=0.01)


def test_the_material_gives_the_quality_that_the_spec_leaves_open(rv40e_record: DesignRecord) -> None:
    plastic = replace(rv40e_record.case.disc_material, youngs_modulus=3.0e3)
    record = replace(rv40e_record, case=replace(rv40e_record.case, disc_material=plastic))
    assert rv40e_record.spec.quality is None
    assert inspection_tolerances(record).runout.source == "IT12, printed"


@pytest.mark.parametrize("grade", [5, 7, 12])
def test_zones_follow_the_series_of_the_standard(grade: int) -> None:
    """a·i with i = 0.45 ∛D + 0.001 D [µm] at the geometric mean of a step, a = 7, 16, 160; rounded by Table 1."""
    factor = {5: 7.0, 7: 16.0, 12: 160.0}[grade]
    steps = [6, 10, 18, 30, 50, 80, 120, 180, 250, 315, 400, 500]
    for low, high in itertools.pairwise(steps):
        D = math.sqrt(low * high)
        assert 1e3 * standard_zone(grade, high) == pytest.approx(factor * (0.45 * D ** (1 / 3) + 1e-3 * D), rel=0.08)


def test_grade_4_lies_between_its_neighbours() -> None:
    """ISO 286-1, 4.1: IT2 to IT4 are in a geometric progression between IT1 = 0.8 + 0.020 D and IT5 = 7 i [µm]."""
    for low, high in ((50, 80), (80, 120), (120, 180), (180, 250)):
        D = math.sqrt(low * high)
        first, fifth = 0.8 + 0.02 * D, 7.0 * (0.45 * D ** (1 / 3) + 1e-3 * D)
        assert 1e3 * standard_zone(4, D) == pytest.approx(first * (fifth / first) ** 0.75, abs=1.0)


def test_a_disc_without_holes_has_no_tolerance_of_holes(rv40e_record: DesignRecord) -> None:
    record = replace(rv40e_record, outline=DiscOutline(rv40e_record.profile, ()))
    limits = inspection_tolerances(record)
    assert (limits.hole_position, limits.hole_angle_arcmin) == (None, None)
    assert not any("IT5" in note for note in tolerances(record).notes)
