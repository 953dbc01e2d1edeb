"""The drawing: true size, no overlaps, repeatable bytes, and its texts."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import ezdxf
import msgspec
import numpy as np
import pytest
from ezdxf import bbox
from independent import ExactCurve

from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.errors import ExportError
from cycloid_profile.export.drawing import DrawingExporter
from cycloid_profile.export.drawing._sheet import A3, Sheet, use_own_font
from cycloid_profile.export.drawing._tooth_data import check_sizes, tooth_data
from cycloid_profile.export.drawing.exporter import draw_sheet, scale_text
from cycloid_profile.geometry import Drive
from cycloid_profile.spec.model import DiscSpec, DrawingSpec, Spec
from cycloid_profile.spec.model.drive import DriveSpec, HolesSpec, KeywaySpec, WindowsSpec
from cycloid_profile.spec.model.modification import ModificationSpec

FIELDS = DrawingSpec(
    number="CD-40E-01", heat_treatment="through hardened 60 to 64 HRC", tooth_roughness_ra_um=0.4, roughness_ra_um=1.6,
    bore_fit="H7", hole_fit="H6", hole_position_um=20.0, width_tolerance_um=10.0, profile_tolerance_um=5.0,
    single_pitch_tolerance_um=5.0, cumulative_pitch_tolerance_um=15.0, runout_tolerance_um=15.0,
    notes=("Both discs of a pair are ground in one clamping.",),
)  # fmt: skip
HOBBY = Spec(
    name="hobby",
    drive=DriveSpec(11, 30.0, 3.0, 1.5, 8.0, 1),
    modification=ModificationSpec(equidistant_um=100.0),
    disc=DiscSpec(output_holes=HolesSpec(6, 17.0, 3.5)),
)
THREE = Spec(name="three lobes", drive=DriveSpec(4, 12.0, 3.0, 1.0, 4.0, 2))


def with_fields(record: DesignRecord, fields: DrawingSpec) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, drawing=fields)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


@pytest.fixture(scope="module")
def full(rv40e_record: DesignRecord) -> DesignRecord:
    """The RV-40E with every field filled in."""
    return with_fields(rv40e_record, FIELDS)


@pytest.fixture(scope="module")
def sheet(full: DesignRecord) -> Sheet:
    use_own_font()
    return draw_sheet(full)[0]


def paper_boxes(sheet: Sheet, kinds: str) -> list[tuple[str, np.ndarray]]:
    """Text and box (x0, y0, x1, y1) of entities, in mm of paper."""
    found = []
    for entity in sheet.space.query(kinds):
        box = bbox.extents([entity], fast=False)
        text = entity.dxf.get("text", "") or ""
        found.append((text, np.array([*box.extmin.vec2, *box.extmax.vec2]) / sheet.unit))
    return found


def test_dimensions_measure_the_disc(sheet: Sheet, full: DesignRecord) -> None:
    measured = sorted(
        round(d.get_measurement() * d.override().get("dimlfac"), 6) for d in sheet.space.query("DIMENSION")
    )
    outline = full.outline
    chord = 2.0 * outline.root_radius * np.sin(np.pi / 39)
    wanted = [11.5, 32.0, 2.0 * outline.root_radius, 2.0 * outline.tip_radius, chord]
    wanted.append(outline.tip_radius - outline.root_radius)
    assert measured == pytest.approx(sorted(wanted), abs=2e-6)


def test_the_table_holds_the_data_of_the_disc(full: DesignRecord) -> None:
    rows = {row.name: row.value for row in tooth_data(full, FIELDS)}
    assert full.compensation is not None
    expected = {
        "number of lobes": "39",
        "number of pins": "40",
        "pin circle radius": "64.000 mm",
        "pin radius": "3.000 mm",
        "eccentricity": "1.300 mm",
        "short-width ratio": "0.8125",
        "equidistant modification": "+6.00 µm",
        "radial-moving modification": "+0.00 µm",
        "deformation compensation": f"{full.compensation.delta_max * 1e3:.3f} µm",
        "pitch circle diameter": "101.400 mm",
        "root diameter": "119.388 mm",
        "tip diameter": "124.588 mm",
        "profile tolerance": "0.005 mm",
        "runout of the teeth": "0.015 mm",
    }
    assert {name: rows[name] for name in expected} == expected
    # Rows of tolerances that were not given are there to be filled in.
    assert {row.value for row in tooth_data(full, DrawingSpec()) if "runout" in row.name} == {"________"}
    nominal, larger = check_sizes(full)
    assert nominal.seat < 0.02
    assert 0.5 < larger.seat < 1.0


def test_no_two_texts_touch_and_all_lie_in_the_frame(sheet: Sheet) -> None:
    boxes = paper_boxes(sheet, "TEXT")
    for text, (x0, y0, x1, y1) in boxes:
        assert x0 >= 20.0, text
        assert y0 >= 10.0, text
        assert x1 <= A3[0] - 10.0, text
        assert y1 <= A3[1] - 10.0, text
    for i, (text, a) in enumerate(boxes):
        for other, b in boxes[i + 1 :]:
            apart = a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]
            assert apart, f"'{text}' and '{other}'"
    assert min(b[3] - b[1] for t, b in boxes if t.isupper()) >= 1.2, "letters too low to be read"


def test_names_of_scales() -> None:
    assert [scale_text(s) for s in (10.0, 2.0, 1.0, 0.5, 0.05)] == ["10:1", "2:1", "1:1", "1:2", "1:20"]


def test_a_disc_that_no_scale_fits_is_refused(full: DesignRecord) -> None:
    drive = object.__new__(Drive)
    for name in ("trochoid", "pin_radius", "discs", "support", "first_stage"):
        object.__setattr__(drive, name, getattr(full.drive, name))
    object.__setattr__(drive, "disc_width", 1e6)
    with pytest.raises(ExportError, match="fits A3 at no standard scale"):
        draw_sheet(replace(full, drive=drive))


@pytest.mark.slow
def test_files_are_true_to_size_and_repeat(full: DesignRecord, tmp_path: Path) -> None:
    first, second = tmp_path / "1", tmp_path / "2"
    for folder in (first, second):
        folder.mkdir()
        dxf, svg, pdf = DrawingExporter().write(full, folder)
    assert (dxf.name, svg.name, pdf.name) == ("drawing.dxf", "drawing.svg", "drawing.pdf")
    for name in DrawingExporter().filenames:
        assert (first / name).read_bytes() == (second / name).read_bytes()
    assert dxf.deviation is not None
    assert max(dxf.deviation.largest, dxf.deviation.from_curve or 1.0) <= 5e-5
    head = (first / "drawing.svg").read_text(encoding="utf-8")[:2000]
    width, height = (float(re.search(rf'{side}="([\d.]+)pt"', head)[1]) for side in ("width", "height"))  # type: ignore[index]
    assert (width, height) == pytest.approx((A3[0] * 72 / 25.4, A3[1] * 72 / 25.4), abs=1e-3)
    page = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", (first / "drawing.pdf").read_bytes())
    assert page is not None
    assert (float(page[1]), float(page[2])) == pytest.approx((width, height), abs=1e-2)
    assert b"CreationDate" not in (first / "drawing.pdf").read_bytes()
    # The tooth at true size in the model space, root 1 upwards, by an independent curve.
    (spline,) = ezdxf.readfile(first / "drawing.dxf").modelspace().query('SPLINE[layer=="PROFILE"]')
    points = np.array([tuple(p)[:2] for p in spline.construction_tool().approximate(20_000)])
    centre = complex(*draw_sheet(full)[0].at(66.0 + full.outline.tip_radius + 200j))
    z = (points[:, 0] + 1j * points[:, 1] - centre) / 1j
    assert full.compensation is not None
    exact = ExactCurve(0.006, full.compensation.delta_max)
    assert np.max(exact.distance(np.stack([z.real, z.imag], axis=-1))) <= 5e-5 + 3e-9


@pytest.mark.slow
@pytest.mark.parametrize("spec", [HOBBY, THREE], ids=lambda spec: spec.name)
def test_texts_keep_apart_on_other_discs(spec: Spec) -> None:
    use_own_font()
    test_no_two_texts_touch_and_all_lie_in_the_frame(draw_sheet(design_disc(spec))[0])


@pytest.mark.slow
def test_windows_and_keyway_are_drawn_and_named(rv40e_record: DesignRecord) -> None:
    disc = msgspec.structs.replace(
        rv40e_record.spec.disc,
        windows=WindowsSpec(3, 26.0, 48.0, 50.0, 4.0),
        keyway=KeywaySpec(6.0, 2.8, 1, 0.3, 90.0),
    )
    use_own_font()
    sheet = draw_sheet(design_disc(msgspec.structs.replace(rv40e_record.spec, disc=disc)))[0]
    texts = {text.dxf.text for text in sheet.space.query("TEXT")}
    assert {"3 × window 50°", "R26 to R48", "keyway 6", "height 34.8"} <= texts
    test_no_two_texts_touch_and_all_lie_in_the_frame(sheet)
