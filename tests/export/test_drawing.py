"""The drawing: true size, widths of lines, letters of every script, no overlaps, repeatable bytes, and its texts."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import zlib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import matplotlib.font_manager
import msgspec
import numpy as np
import pytest
import shapely
from ezdxf import path as dxf_path
from fontTools.fontBuilder import FontBuilder
from fontTools.pens.ttGlyphPen import TTGlyphPen
from independent import ExactCurve

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.design import DesignRecord, design_disc, disc_records
from cycloid_profile.errors import ExportError
from cycloid_profile.export.drawing import DrawingExporter, _text
from cycloid_profile.export.drawing._sheet import APPLICATION, Sheet, print_drawing
from cycloid_profile.export.drawing._space import A3
from cycloid_profile.export.drawing._tolerances import tolerances
from cycloid_profile.export.drawing._tooth_data import check_sizes, mass_text, tooth_data
from cycloid_profile.export.drawing.exporter import draw_sheet, scale_text
from cycloid_profile.export.dxf import save
from cycloid_profile.export.inspection import inspection_plan
from cycloid_profile.geometry import Drive
from cycloid_profile.spec.model import DiscSpec, DrawingSpec, Spec
from cycloid_profile.spec.model.drive import CranksSpec, DriveSpec, HolesSpec, KeywaySpec, WindowsSpec
from cycloid_profile.spec.model.load import MaterialSpec, MaterialsSpec
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
MANY = Spec(name="齿轮 Ø ψ", drive=DriveSpec(60, 52.0, 2.0, 0.7, 9.0, 2, cranks=CranksSpec(2, 28.0)))
MISSING_LETTERS = "齿轮"


def with_fields(record: DesignRecord, fields: DrawingSpec) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, drawing=fields)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


@pytest.fixture(scope="module")
def full(rv40e_record: DesignRecord) -> DesignRecord:
    """The RV-40E with every field filled in."""
    return with_fields(rv40e_record, FIELDS)


@pytest.fixture(scope="module")
def sheet(full: DesignRecord) -> Sheet:
    return draw_sheet(full)[0]


def texts_of(doc: Any, unit: float) -> list[tuple[str, shapely.Polygon]]:
    """Characters and outlines of every text, in mm of paper."""
    found = []
    for hatch in doc.modelspace().query('HATCH[layer=="TEXT"]'):
        (_, text) = hatch.get_xdata(APPLICATION)[-1]
        points = np.concatenate([np.array(one.vertices)[:, :2] for one in hatch.paths.paths]) / unit
        upright = shapely.box(*points.min(axis=0), *points.max(axis=0))
        # An upright box of slanted text holds the dimension line that the text is parallel to.
        slanted = shapely.MultiPoint(points).minimum_rotated_rectangle
        found.append((text, slanted if slanted.area < 0.7 * upright.area else upright))
    return found


def strokes_of(doc: Any, unit: float) -> list[tuple[str, Any]]:
    """Layer and course of everything but the texts, in mm of paper."""
    found = []
    for entity in doc.modelspace().query('*[layer!="TEXT"]'):
        if entity.dxftype() == "HATCH":
            corners = np.array(entity.paths.paths[0].vertices)[:, :2] / unit
            found.append((entity.dxf.layer, shapely.Polygon(corners)))
        elif entity.dxftype() == "SOLID":
            found.append((entity.dxf.layer, shapely.Polygon([v.vec2 / unit for v in entity.vertices()])))
        else:
            points = [v.vec2 / unit for v in dxf_path.make_path(entity).flattening(0.01 * unit)]
            found.append((entity.dxf.layer, shapely.LineString(points)))
    return found


def assert_clear(sheet: Sheet) -> None:
    """Every text is in the frame, and neither another text nor any stroke comes within 0.2 mm of it."""
    texts, strokes = texts_of(sheet.doc, sheet.unit), strokes_of(sheet.doc, sheet.unit)
    frame = shapely.box(20.0, 10.0, A3[0] - 10.0, A3[1] - 10.0)
    courses = shapely.STRtree([stroke for _, stroke in strokes])
    boxes = [box for _, box in texts]
    tree = shapely.STRtree(boxes)
    assert len(boxes) > 100
    for i, (text, box) in enumerate(texts):
        assert frame.contains(box.buffer(0.5)), text
        near = {texts[j][0] for j in tree.query(box.buffer(0.1), predicate="intersects") if j != i}
        assert near == set(), f"'{text}' touches a text"
        crossed = [strokes[j] for j in courses.query(box.buffer(0.2), predicate="intersects")]
        assert crossed == [], f"'{text}' is crossed"


def assert_frames_apart(sheet: Sheet) -> None:
    """Frames of sizes, tolerances and datums are in the frame of the sheet and share at most an edge."""
    boxes = [
        shapely.Polygon(stroke.coords)
        for layer, stroke in strokes_of(sheet.doc, sheet.unit)
        if layer == "DIMENSIONS" and stroke.geom_type == "LineString" and stroke.is_ring and len(stroke.coords) == 5
    ]
    assert len(boxes) > 8
    one, other = shapely.STRtree(boxes).query(boxes, predicate="overlaps")
    assert [shapely.intersection(boxes[i], boxes[j]).area for i, j in zip(one, other, strict=True)] == pytest.approx(
        np.zeros(len(one)), abs=1e-6
    )


def test_dimensions_are_true_in_text_and_in_length(sheet: Sheet, full: DesignRecord) -> None:
    """No reader has to scale a length: there is no DIMENSION, whose factor some ignore."""
    outline = full.outline
    texts = {text for text, _ in texts_of(sheet.doc, sheet.unit)}
    chord = 2.0 * outline.root_radius * np.sin(np.pi / 39)
    tips = np.array([complex(*arrow.dxf.vtx0.vec2) for arrow in sheet.space.query("SOLID")])
    lengths = np.abs(tips[:, np.newaxis] - tips)
    for value, text, scale in (
        (11.5, "11.5 ±0.01", 1.0),
        (2.0 * outline.root_radius, f"Ø{2.0 * outline.root_radius:.3f} root", 1.0),
        (2.0 * outline.tip_radius, f"Ø{2.0 * outline.tip_radius:.3f} tip", 1.0),
        (chord, f"{chord:.3f}", 10.0),
        (outline.tip_radius - outline.root_radius, f"{outline.tip_radius - outline.root_radius:.3f}", 10.0),
    ):
        assert text in texts
        assert np.min(np.abs(lengths - scale * value)) < 1e-6, text
    assert {"Ø32 H7", "3 × Ø26 H6", "Ø72", "3 × 120°", "Ø101.4", "39 × 9.23077°"} <= texts
    assert len(sheet.space.query("DIMENSION TEXT MTEXT")) == 0


def test_the_height_of_the_tooth_is_between_its_root_and_tip_arcs(sheet: Sheet) -> None:
    """Its extension lines begin at the right ends of both arcs, and continue them."""
    scale = 10.0 / sheet.unit
    for radius in (119.388 / 2.0, 124.588 / 2.0):
        (arc,) = (arc for arc in sheet.space.query("ARC") if arc.dxf.radius == pytest.approx(radius * scale, abs=1e-2))
        end, across = arc.start_point.vec2, (arc.start_point - arc.dxf.center).vec2.normalize()
        lines = sheet.space.query('LINE[layer=="DIMENSIONS"]')
        (line,) = (one for one in lines if (one.dxf.start.vec2 - end).magnitude < 1.0 * sheet.unit)
        assert abs((line.dxf.end - line.dxf.start).vec2.normalize().dot(across)) < 1e-9


def test_tolerances_of_the_spec_are_framed_and_others_have_their_source(
    sheet: Sheet, full: DesignRecord, rv40e_record: DesignRecord
) -> None:
    texts = [text for text, _ in texts_of(sheet.doc, sheet.unit)]
    # Perpendicularity of the bore and parallelism of the faces are the general ones.
    assert {"0.005 CZ", "Ø0.02", "0.015", "Ø0.4†", "0.4†", "Ra 0.4", "Ra 1.6"} <= set(texts)
    assert any(text.endswith("† not in the spec: ISO 2768-mK.") for text in texts)
    given, proposed = tolerances(full), tolerances(rv40e_record)
    assert (given.profile.mark, proposed.profile.mark) == ("", "*")
    assert proposed.hole_position.mark == proposed.hole_angle_arcmin.mark == "**"
    assert proposed.notes[:2] == (
        "* not in the spec: IT4, ground, ISO 286-1; to be agreed.",
        "** not in the spec: IT5, ground, ISO 286-1; to be agreed.",
    )


def frames_of(doc: Any, unit: float) -> set[tuple[str, ...]]:
    """Texts of the cells of every tolerance frame, and single letters in their boxes, from left to right."""
    cells = [
        shapely.Polygon(stroke.coords)
        for layer, stroke in strokes_of(doc, unit)
        if layer == "DIMENSIONS" and stroke.geom_type == "LineString" and stroke.is_ring and len(stroke.coords) == 5
    ]
    held = [
        (cell, next((text for text, box in texts_of(doc, unit) if cell.contains(box.centroid)), "sign"))
        for cell in sorted(cells, key=lambda cell: cell.bounds[0])
    ]
    rows: list[list[tuple[Any, str]]] = []
    for cell, text in held:
        row = next((row for row in rows if abs(row[-1][0].bounds[2] - cell.bounds[0]) < 1e-6
                    and abs(row[-1][0].bounds[1] - cell.bounds[1]) < 1e-6), None)  # fmt: skip
        if row is None:
            rows.append([(cell, text)])
        else:
            row.append((cell, text))
    return {tuple(text for _, text in row) for row in rows}


def test_frames_name_the_datums_of_the_inspection_plan(sheet: Sheet, full: DesignRecord) -> None:
    """A, B, C in boxes; teeth and crank holes are related to A and B, bore and lower face to A."""
    texts = [text for text, _ in texts_of(sheet.doc, sheet.unit)]
    frames = frames_of(sheet.doc, sheet.unit)
    assert {("A",), ("B",), ("C",)} <= frames
    assert {one[1:] for one in frames if one[0] == "sign"} == {
        ("0.005 CZ", "A", "B"), ("0.015", "A", "B"), ("Ø0.02", "A", "B"), ("Ø0.4†", "A"), ("0.4†", "A"),
    }  # fmt: skip
    assert inspection_plan(full).datums.names == {"A": "upper face", "B": "bore", "C": "crank hole 1"}
    assert {"upper face", "bore", "crank hole 1", "C to axis of root 1"} <= set(texts)
    # Triangles of the datums, two sides of √(2.5² + 1.5²) mm; arrows are slender.
    sides = [sorted(np.abs(np.diff([complex(*v.vec2) for v in [*one.vertices()][:3]], append=0.0))[:2])
             for one in sheet.space.query("SOLID")]  # fmt: skip
    assert sum(side == pytest.approx([np.hypot(2.5, 1.5), 3.0]) for side in sides) == 3


def test_faces_have_general_tolerances_or_those_of_the_spec(full: DesignRecord) -> None:
    """ISO 2768-1 and -2: parallelism is the larger of the width's whole tolerance and the flatness of the face."""
    for name, width_um, expected in (
        ("ISO 2768-mK", 10.0, 0.4),  # flatness K up to 300 mm
        ("ISO 2768-mH", None, 0.4),  # ±0.2 mm of 11.5 mm
        ("ISO 2768-fH", None, 0.2),  # flatness H up to 300 mm, and ±0.1 mm
        ("ISO 22081", None, None),
    ):
        fields = msgspec.structs.replace(FIELDS, general_tolerance=name, width_tolerance_um=width_um)
        assert tolerances(with_fields(full, fields)).parallelism.size == expected
    given = tolerances(with_fields(full, DrawingSpec(parallelism_um=8.0, perpendicularity_um=5.0)))
    assert (given.parallelism.size, given.perpendicularity.size) == pytest.approx((0.008, 0.005))
    assert (given.parallelism.mark, given.perpendicularity.mark) == ("", "")


def test_every_disc_has_its_drawing(rv40e_record: DesignRecord) -> None:
    texts = []
    for record in disc_records(rv40e_record):
        sheet, _ = draw_sheet(record)
        texts.append({text for text, _ in texts_of(sheet.doc, sheet.unit)})
    assert "Cycloid disc RV-40E, disc 1" in texts[0]
    assert "Cycloid disc RV-40E, disc 2" in texts[1]
    assert "1/2" in texts[0]
    assert "2/2" in texts[1]
    assert "Crank hole 1, datum C, 4.6154° anticlockwise of root 1; 39 identical lobes." in {
        text.partition(". ")[2] for text in texts[1]
    }
    # Half a pitch: 180°/39.
    (angle,) = (text for text in texts[1] if text.startswith("4.61538° ±"))
    assert angle.replace("4.61538", "0") in texts[0]


def test_mass_is_area_times_width_times_density(rv40e_record: DesignRecord) -> None:
    kilograms = rv40e_record.outline.area * 11.5 * 7850e-9
    assert mass_text(rv40e_record) == f"{kilograms:.4g} kg at 7850 kg/m³"
    for disc, wanted in (
        (MaterialSpec(3.0, 0.36), ""),
        (MaterialSpec(3.0, 0.36, "pla"), "1240 kg/m³"),
        (MaterialSpec(170.0, 0.28), ""),
        (MaterialSpec(170.0, 0.28, "Ductile Iron"), "7100 kg/m³"),
        (MaterialSpec(170.0, 0.28, "GGG40"), ""),
    ):
        spec = msgspec.structs.replace(rv40e_record.spec, materials=MaterialsSpec(disc=disc))
        assert mass_text(replace(rv40e_record, spec=spec)).endswith(wanted)
        assert bool(mass_text(replace(rv40e_record, spec=spec))) == bool(wanted)


def test_the_table_holds_the_data_of_the_disc(full: DesignRecord) -> None:
    rows = {row.name: row.value for row in tooth_data(full, tolerances(full))}
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
        "profile, whole zone": "0.005 mm",
        "runout of the teeth": "0.015 mm",
    }
    assert {name: rows[name] for name in expected} == expected
    bare = with_fields(full, DrawingSpec())
    assert {row.value for row in tooth_data(bare, tolerances(bare)) if "runout" in row.name} == {"0.012 mm*"}
    nominal, larger = check_sizes(full)
    assert nominal.seat < 0.02
    assert 0.5 < larger.seat < 1.0


def test_no_text_is_touched(sheet: Sheet) -> None:
    assert_clear(sheet)
    assert_frames_apart(sheet)


def test_lines_have_two_widths_and_read_back_without_error(sheet: Sheet, tmp_path: Path) -> None:
    save(sheet.doc, tmp_path / "drawing.dxf")
    doc = ezdxf.readfile(tmp_path / "drawing.dxf")
    auditor = doc.audit()
    assert not auditor.errors
    assert not auditor.fixes
    wide, narrow = 50, 25  # 1/100 mm, ISO 128-2
    widths = {layer.dxf.name: layer.dxf.lineweight for layer in doc.layers}
    assert {widths[name] for name in ("PROFILE", "HOLES")} == {wide}
    assert {widths[name] for name in ("DIMENSIONS", "CENTRE", "HATCH", "THIN", "PITCH")} == {narrow}
    assert {entity.dxf.lineweight for entity in doc.modelspace()} == {ezdxf.const.LINEWEIGHT_BYLAYER}
    # And as ezdxf's viewer prints them.
    for entity in list(doc.modelspace().query('HATCH SPLINE[layer!="PROFILE"]')):
        doc.modelspace().delete_entity(entity)
    print_drawing(doc, sheet.unit, [tmp_path / "drawing.svg"])
    drawn = re.findall(r"stroke-width: ([\d.]+)", (tmp_path / "drawing.svg").read_text(encoding="utf-8"))
    assert {round(float(width) * 25.4 / 72.0, 2) for width in drawn if float(width) != 1.0} >= {0.25, 0.5, 0.7}


def test_blanks_have_a_width() -> None:
    assert _text.text_width("a b", 2.5) > _text.text_width("ab", 2.5) + 0.5


def test_letters_are_filled_and_their_holes_are_empty() -> None:
    """Whatever rule fills them: Ø has two holes side by side, % two rings."""
    for letter, least, most in (("Ø", 0.28, 0.45), ("%", 0.25, 0.45), ("ψ", 0.15, 0.5), ("I", 0.9, 1.1)):
        polygons = [shapely.Polygon([(p.real, p.imag) for p in polygon]) for polygon in _text.outlines(letter, 2.5)]
        whole = shapely.union_all([polygon.buffer(0.0) for polygon in polygons])
        assert sum(polygon.area for polygon in polygons) == pytest.approx(whole.area, rel=1e-6)
        assert least < whole.area / shapely.box(*whole.bounds).area < most, letter


@pytest.fixture
def fresh_fonts() -> Iterator[None]:
    """Searches for fonts forgotten, before and after."""
    searches = (_text._font_of, _text.shown, _text._letter)
    for search in searches:
        search.cache_clear()
    yield
    for search in searches:
        search.cache_clear()


def named(record: DesignRecord, name: str) -> Sheet:
    return draw_sheet(replace(record, spec=msgspec.structs.replace(record.spec, name=name)))[0]


@pytest.mark.usefixtures("fresh_fonts")
def test_letters_without_a_font_become_code_points(rv40e_record: DesignRecord, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(matplotlib.font_manager, "findSystemFonts", list)
    sheet = named(rv40e_record, "齿轮 Ø ψ")
    assert "Cycloid disc 齿轮 Ø ψ, disc 1" in {text for text, _ in texts_of(sheet.doc, sheet.unit)}
    assert _text.shown("齿轮 Ø ψ") == "U+9F7F U+8F6E Ø ψ"
    (note,) = _text.font_notes(sheet.texts)
    assert "shows 轮 as U+8F6E, 齿 as U+9F7F:" in note
    assert "install" in note
    assert _text.font_notes(["Ø ψ"]) == ()


@pytest.mark.usefixtures("fresh_fonts")
def test_letters_of_another_script_come_from_a_font_of_the_system(
    rv40e_record: DesignRecord, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    font = square_font(tmp_path / "SquareForTests.ttf")
    monkeypatch.setattr(matplotlib.font_manager, "findSystemFonts", lambda: [str(font)])
    assert _text.shown("齿轮 Ø ψ") == "齿轮 Ø ψ"
    square = shapely.Polygon([(p.real, p.imag) for p in _text.outlines("齿", 1.0)[0]])
    assert shapely.box(*square.bounds).area == pytest.approx(square.area)
    assert_clear(named(rv40e_record, "齿轮 Ø ψ"))


def test_a_long_name_takes_two_legible_lines(rv40e_record: DesignRecord) -> None:
    sheet = named(rv40e_record, "W" * 60)
    heights = [
        box.bounds[3] - box.bounds[1] for text, box in texts_of(sheet.doc, sheet.unit) if text.count("W") > 20
    ]  # fmt: skip
    assert len(heights) == 2
    assert min(heights) >= 1.8
    assert_clear(sheet)


def square_font(path: Path) -> Path:
    """A font whose letters are squares."""
    pen = TTGlyphPen(None)
    for step, point in enumerate(((100, 0), (100, 700), (800, 700), (800, 0))):
        (pen.lineTo if step else pen.moveTo)(point)
    pen.closePath()
    square = pen.glyph()
    builder = FontBuilder(1000, isTTF=True)
    builder.setupGlyphOrder([".notdef", "square"])
    builder.setupCharacterMap({ord(letter): "square" for letter in MISSING_LETTERS + "Xx HE"})
    builder.setupGlyf({".notdef": square, "square": square})
    builder.setupHorizontalMetrics({".notdef": (900, 100), "square": (900, 100)})
    builder.setupHorizontalHeader(ascent=800, descent=-200)
    builder.setupNameTable({"familyName": "SquareForTests", "styleName": "Regular"})
    builder.setupOS2()
    builder.setupPost()
    builder.save(str(path))
    return path


@pytest.mark.slow
def test_librecad_draws_every_letter_and_both_widths(sheet: Sheet, tmp_path: Path) -> None:
    librecad = shutil.which("librecad")
    if librecad is None:
        pytest.skip("LibreCAD is not installed")
    save(sheet.doc, tmp_path / "drawing.dxf")
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    command = [librecad, "dxf2pdf", "-a", "-m", "-p", "420x297", "drawing.dxf"]
    subprocess.run(
        command, cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, env=environment, check=True, timeout=100
    )
    streams = re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", (tmp_path / "drawing.pdf").read_bytes(), re.DOTALL)
    page = b"".join(zlib.decompress(stream) for stream in streams).decode("latin1")
    # A text is one filled path, and no letter is left to a font of LibreCAD.
    assert len(re.findall(r"^f\*$", page, re.MULTILINE)) == len(texts_of(sheet.doc, sheet.unit))
    assert "BT\n" not in page
    unit = float(re.search(r"^([\d.]+) 0 0 -[\d.]+ 0 \d+ cm$", page, re.MULTILINE)[1])  # type: ignore[index]
    widths = {float(width) * unit * 25.4 / 72.0 for width in re.findall(r"^([\d.]+) w ", page, re.MULTILINE)}
    assert sorted(widths) == pytest.approx([0.25, 0.5, 0.7], abs=0.02)


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
@pytest.mark.parametrize(
    "spec",
    [HOBBY, THREE, MANY, *(catalog_drive(name) for name in ("rv20e_like", "rv80e", "printed_11"))],
    ids=lambda spec: spec.name,
)
def test_texts_keep_apart_on_other_discs(spec: Spec) -> None:
    for record in disc_records(design_disc(spec)):
        sheet, _ = draw_sheet(record)
        assert_clear(sheet)
        assert_frames_apart(sheet)


@pytest.mark.slow
def test_a_keyway_is_datum_c_of_a_disc_without_holes() -> None:
    disc = DiscSpec(bore_radius_mm=10.0, keyway=KeywaySpec(6.0, 2.8, 1, 0.3, 30.0))
    sheet, _ = draw_sheet(design_disc(Spec(name="keyed", drive=DriveSpec(11, 30.0, 3.0, 1.5, 8.0, 1), disc=disc)))
    texts = {text for text, _ in texts_of(sheet.doc, sheet.unit)}
    assert {"keyway 1", "1/1", "C to axis of root 1"} <= texts
    assert {("A",), ("B",), ("C",)} <= frames_of(sheet.doc, sheet.unit)
    assert_clear(sheet)
    assert_frames_apart(sheet)


@pytest.mark.slow
def test_windows_and_keyway_are_drawn_and_named(rv40e_record: DesignRecord) -> None:
    disc = msgspec.structs.replace(
        rv40e_record.spec.disc,
        windows=WindowsSpec(3, 26.0, 48.0, 50.0, 4.0),
        keyway=KeywaySpec(6.0, 2.8, 1, 0.3, 90.0),
    )
    sheet, _ = draw_sheet(design_disc(msgspec.structs.replace(rv40e_record.spec, disc=disc)))
    texts = {text for text, _ in texts_of(sheet.doc, sheet.unit)}
    assert {"3 × window 50°", "R26 to R48", "keyway 6", "height 34.8"} <= texts
    assert_clear(sheet)
