"""The parts except the discs: sizes that follow from each other, files that read back, and clearance when turned."""

from __future__ import annotations

import csv
import itertools
import math
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from cycloid_profile.catalog import catalog_text
from cycloid_profile.contact.mesh import gaps, mesh
from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.design.from_spec import output_sizes
from cycloid_profile.errors import ExportError, SpecError
from cycloid_profile.export import write_formats
from cycloid_profile.export.cad import (
    Placement,
    PrintOffsets,
    disc_placements,
    enlarged,
    mounted,
    parts_of,
    print_offsets,
    printed,
)
from cycloid_profile.geometry import ChordTolerance, Contour, keyed_bore, ring_of_windows, sample
from cycloid_profile.spec import parse_spec
from tests.spec_texts import PLAIN

CHORD = 1e-4  # mm, of the polygons
DRIVE = PLAIN.replace("discs = 1", "discs = 2").replace("equidistant_um = 20.0", "equidistant_um = 100.0")
TEXT = f"""{DRIVE}[materials.disc]
youngs_modulus_gpa = 3.0
[load]
rated_torque_nm = 4.0
[disc]
bore_radius_mm = 8.5
[disc.output_holes]
count = 6
circle_radius_mm = 17.0
roller_radius_mm = 2.5
clearance_um = 50.0
pin_radius_mm = 1.5
[export]
chord_tolerance_um = 2.0
"""
OFFSETS = """
[export.print]
flank_offset_um = 80.0
hole_offset_um = 120.0
seat_offset_um = 60.0
"""
Body = tuple[str, float, float, shapely.Polygon]


@pytest.fixture(scope="module")
def record() -> DesignRecord:
    return design_disc(parse_spec(TEXT + OFFSETS))


def polygon(contour: Contour, openings: tuple[Contour, ...] = ()) -> shapely.Polygon:
    outer, *inner = [one.points(CHORD) for one in (contour, *openings)]
    xy = [np.stack([ring.real, ring.imag], axis=-1) for ring in (outer, *inner)]
    return shapely.Polygon(xy[0], xy[1:])


def placed(shape: shapely.Polygon, place: Placement) -> shapely.Polygon:
    turned = rotate(shape, place.rotation, origin=(0.0, 0.0), use_radians=True)
    return translate(turned, place.shift.real, place.shift.imag)


def bodies(record: DesignRecord, crank_angle: float, offsets: PrintOffsets) -> list[Body]:
    """Sections of all printed parts at a crank angle: name, lower and upper height, polygon."""
    drive, found = record.drive, []
    at_zero = disc_placements(drive)
    for place, start in zip(disc_placements(drive, crank_angle), at_zero, strict=True):
        outline = printed(mounted(record.outline, start), offsets)
        teeth = sample(outline.profile, ChordTolerance(CHORD)).xy
        holes = [np.stack([p.real, p.imag], axis=-1) for p in (c.points(CHORD) for c in outline.contours)]
        disc = placed(shapely.Polygon(teeth, holes), place)
        found.append((place.name, place.height, place.height + drive.disc_width, disc))
    for part in parts_of(record, crank_angle, offsets):
        for place, slab in itertools.product(part.placements, part.slabs):
            shape = placed(polygon(slab.edge, slab.openings), place)
            found.append((place.name, place.height + slab.low, place.height + slab.high, shape))
    return found


def kind(name: str) -> str:
    return name.rstrip("0123456789. ")


def clearances(found: list[Body]) -> dict[tuple[str, str], float]:
    """Least distance of parts of two kinds that meet at some height [mm]; negative where they overlap."""
    least: dict[tuple[str, str], float] = {}
    for a, b in itertools.combinations(found, 2):
        if a[0] == b[0] or min(a[2], b[2]) <= max(a[1], b[1]) + 1e-9:
            continue
        overlap = a[3].intersection(b[3]).area
        distance = float(a[3].distance(b[3])) if overlap < 1e-9 else -overlap
        one, other = sorted((kind(a[0]), kind(b[0])))
        least[one, other] = min(least.get((one, other), math.inf), distance)
    return least


def check_clearances(record: DesignRecord, crank_angle: float) -> None:
    offsets = print_offsets(record.spec)
    found = clearances(bodies(record, crank_angle, offsets))
    profile = printed(record.outline, offsets).profile
    engine = gaps(profile, record.drive.pin_radius, mesh(record.drive.trochoid, [crank_angle], record.drive.discs))
    designed = {
        ("disc", "pin"): float(np.min(engine.gap)),
        ("crank bearing", "disc"): 0.120,
        ("crank bearing", "crank shaft"): 0.120,
        ("pin", "pin ring"): 0.060,
        ("carrier plate", "crank shaft"): 0.060,
    }
    sizes, holes = output_sizes(record.spec), record.spec.disc.output_holes
    if sizes is not None and holes is not None:
        # The hole's radius less that of the roller and the eccentricity.
        designed["disc", "output pin" if holes.pin_radius_mm is None else "output roller"] = (
            sizes[0] - sizes[1] - record.spec.drive.eccentricity_mm + 0.120
        )
        designed["carrier plate", "output pin"] = 0.060
        if holes.pin_radius_mm is not None:
            designed["output pin", "output roller"] = 0.120
    for pair, gap in designed.items():
        assert found[pair] == pytest.approx(gap, abs=3.0 * CHORD), pair
    # Everything else keeps further away.
    assert min(gap for pair, gap in found.items() if pair not in designed) > 0.15


@pytest.mark.parametrize("degrees", [0.0, 37.0, 251.0])
def test_printed_parts_keep_their_designed_clearance(record: DesignRecord, degrees: float) -> None:
    check_clearances(record, math.radians(degrees))


@pytest.mark.slow
@pytest.mark.parametrize("text", [TEXT, catalog_text("printed_11"), catalog_text("rv40e")],
                         ids=["rollers", "plain output pins", "three cranks"])  # fmt: skip
def test_printed_parts_keep_their_designed_clearance_over_a_turn(text: str) -> None:
    """Central eccentrics with rollers and with plain pins, and three cranks; two different discs in each."""
    record = design_disc(parse_spec(text + OFFSETS))
    for step in range(24):
        check_clearances(record, 2.0 * math.pi * step / 24)


def test_disc_1_in_place_of_disc_2_clashes_with_the_output(record: DesignRecord) -> None:
    found = bodies(record, 0.0, print_offsets(record.spec))
    place, first = disc_placements(record.drive)[1], disc_placements(record.drive)[0]
    outline = printed(mounted(record.outline, first), print_offsets(record.spec))
    teeth = sample(outline.profile, ChordTolerance(CHORD)).xy
    holes = [np.stack([p.real, p.imag], axis=-1) for p in (c.points(CHORD) for c in outline.contours)]
    wrong = placed(shapely.Polygon(teeth, holes), place)
    found[1] = (found[1][0], found[1][1], found[1][2], wrong)
    assert clearances(found)["disc", "output roller"] < -1.0


def test_output_hole_follows_from_roller_eccentricity_and_clearance(record: DesignRecord) -> None:
    holes = [hole for hole in record.outline.holes if hole.name.startswith("output hole")]
    assert {round(hole.radius, 12) for hole in holes} == {2.5 + 1.5 + 0.05}
    (check,) = [one for one in record.checks if one.name == "clearance of the output rollers"]
    assert check.passed
    given = parse_spec(TEXT.replace("roller_radius_mm = 2.5", "roller_radius_mm = 2.5\nradius_mm = 3.9"))
    (failed,) = [one for one in design_disc(given).checks if one.name == "clearance of the output rollers"]
    assert failed.sentence == (
        "clearance of the output rollers = -100.000 µm, limit at least 50 µm: the rollers would bind, make the holes "
        "larger or the rollers smaller"
    )
    assert failed.severe


def test_output_holes_without_a_size_are_refused() -> None:
    with pytest.raises(SpecError, match=r"output_holes without radius_mm has no roller_radius_mm either: give"):
        design_disc(parse_spec(TEXT.replace("roller_radius_mm = 2.5", "")))
    with pytest.raises(SpecError, match=r"radius_mm = 1.2 is not above eccentricity and clearance, 1.55 mm"):
        design_disc(parse_spec(TEXT.replace("roller_radius_mm = 2.5", "radius_mm = 1.2")))


@pytest.mark.parametrize("offset", [0.12, -0.12])
def test_openings_of_any_shape_take_the_offset(offset: float) -> None:
    windows = ring_of_windows("window", 3, (10.0, 20.0), 1.2, 2.0, 0.3)
    for contour in (*windows, keyed_bore("bore", 8.0, 1, 3.0, 1.2, 0.4, 0.2)):
        moved = enlarged(contour, offset)
        distance = shapely.distance(polygon(contour).exterior, shapely.points(polygon(moved).exterior.coords))
        assert np.max(np.abs(distance - abs(offset))) < 2.0 * CHORD
        assert (moved.area > contour.area) == (offset > 0.0)
    assert enlarged(windows[0], 0.0) is windows[0]
    with pytest.raises(ExportError, match="is not below the least concave radius"):
        enlarged(windows[0], -2.5)


def test_part_files_read_back_by_trimesh_with_the_volume_of_the_part(record: DesignRecord, tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    trimesh = pytest.importorskip("trimesh")
    written, skipped = write_formats(record, ("parts-step", "parts-stl", "parts-3mf", "bom"), tmp_path)
    assert not skipped
    kinds = [part.kind.replace(" ", "_") for part in parts_of(record)]
    names = [f"parts/{kind}.{suffix}" for suffix in ("step", "stl", "3mf") for kind in kinds]
    assert [file.name for file in written] == [*names, "bom.csv"]
    for part in parts_of(record, 0.0, print_offsets(record.spec)):
        solid = trimesh.load_mesh(tmp_path / "parts" / f"{part.kind.replace(' ', '_')}.stl")
        assert solid.is_watertight
        low, high = min(slab.low for slab in part.slabs), max(slab.high for slab in part.slabs)
        assert np.allclose(solid.bounds[:, 2], [low, high], atol=1e-5)
        if len(part.slabs) == 1:
            slab = part.slabs[0]
            area = slab.edge.area - sum(opening.area for opening in slab.openings)
            assert solid.volume == pytest.approx(area * (high - low), rel=3e-3), part.kind


def test_plans_of_parts_enclose_the_area_of_their_sections(record: DesignRecord, tmp_path: Path) -> None:
    written, _ = write_formats(record, ("parts-dxf",), tmp_path)
    assert [file.name for file in written] == [f"parts/{p.kind.replace(' ', '_')}.dxf" for p in parts_of(record)]
    for part in parts_of(record):
        doc = ezdxf.readfile(tmp_path / "parts" / f"{part.kind.replace(' ', '_')}.dxf")
        assert doc.header["$INSUNITS"] == 4
        areas = {}
        for layer in ("PROFILE", "HOLES"):
            entities = doc.modelspace().query(f'*[layer=="{layer}"]')
            assert {one.dxftype() for one in entities} <= {"CIRCLE", "ARC"}
            lines = [shapely.LineString([point.vec2 for point in one.flattening(CHORD)]) for one in entities]
            # Ends of neighbouring arcs agree to the last digits only.
            rings = shapely.polygonize(shapely.set_precision(lines, 1e-7))
            areas[layer] = shapely.union_all(shapely.get_parts(rings)).area
        edges = shapely.union_all([polygon(slab.edge) for slab in part.slabs]).area
        assert areas["PROFILE"] == pytest.approx(edges, rel=2e-4), part.kind
        openings = sum(opening.area for opening in part.slabs[0].openings)
        assert areas["HOLES"] == pytest.approx(openings, rel=2e-4), part.kind


def test_parts_list_counts_every_part_and_disc(record: DesignRecord, tmp_path: Path) -> None:
    write_formats(record, ("bom",), tmp_path)
    rows = list(csv.DictReader((tmp_path / "bom.csv").read_text(encoding="ascii").splitlines()))
    count = {row["part"]: int(row["quantity"]) for row in rows}
    assert count == {
        "disc 1": 1, "disc 2": 1, "pin": 11, "pin ring": 1, "crank shaft": 1, "crank bearing": 2, "output roller": 12,
        "output pin": 6, "carrier plate": 2,
    }  # fmt: skip
    (pin,) = [row for row in rows if row["part"] == "pin"]
    assert (float(pin["outer_diameter_mm"]), float(pin["length_mm"])) == pytest.approx((6.0, 18.4))


def test_assembly_turns_with_the_crank(record: DesignRecord) -> None:
    angle = 1.0
    moved = {place.name: place for part in parts_of(record, angle) for place in part.placements}
    still = {place.name: place for part in parts_of(record) for place in part.placements}
    assert moved["pin 3"] == still["pin 3"]
    assert moved["crank shaft 1"].rotation == pytest.approx(angle)
    # The output turns back by one tooth a turn of the crank: −φ/z_c.
    turned = moved["output pin 2"].shift / still["output pin 2"].shift
    assert np.angle(turned) == pytest.approx(-angle / 10.0)
