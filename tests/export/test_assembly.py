"""The stage as an assembly: parts where the contact engine has them, none inside another."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from shapely.affinity import rotate, translate

from cycloid_profile.catalog import catalog_names, catalog_text
from cycloid_profile.contact.mesh import gaps, mesh
from cycloid_profile.design import DesignRecord
from cycloid_profile.design.from_spec import conventional_profile, disc_outline, drive_of
from cycloid_profile.export.cad import Placement, disc_placements, mounted, ring_bore, stage_parts
from cycloid_profile.geometry import ChordTolerance, Contour, DiscOutline, Drive, sample
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import Spec

FINE = 2e-6  # mm, chords of teeth
COARSE = 1e-3  # mm, chords of everything else


def polygon(contour: Contour, openings: tuple[Contour, ...] = (), chord: float = COARSE) -> shapely.Polygon:
    rings = [contour.points(chord), *(opening.points(chord) for opening in openings)]
    outer, *inner = [np.stack([ring.real, ring.imag], axis=-1) for ring in rings]
    return shapely.Polygon(outer, inner)


def placed(shape: shapely.Polygon, place: Placement) -> shapely.Polygon:
    rotated = rotate(shape, place.rotation, origin=(0.0, 0.0), use_radians=True)
    return translate(rotated, place.shift.real, place.shift.imag)


def disc(outline: DiscOutline, place: Placement, chord: float) -> shapely.Polygon:
    holes = [contour.points(chord) for contour in mounted(outline, place).contours]
    teeth = sample(outline.profile, ChordTolerance(chord)).xy
    return placed(shapely.Polygon(teeth, [np.stack([h.real, h.imag], axis=-1) for h in holes]), place)


def stage(spec: Spec) -> tuple[Drive, DiscOutline]:
    drive = drive_of(spec)
    return drive, disc_outline(spec, drive, conventional_profile(spec, drive))


def test_pins_stand_from_the_discs_as_the_contact_engine_says(rv40e_record: DesignRecord) -> None:
    drive, outline = rv40e_record.drive, rv40e_record.outline
    engine = gaps(outline.profile, drive.pin_radius, mesh(drive.trochoid, [0.0], drive.discs))
    angle = 2.0 * math.pi * np.arange(drive.trochoid.pins) / drive.trochoid.pins
    centres = shapely.points(drive.trochoid.pin_circle_radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1))
    for j, place in enumerate(disc_placements(drive)):
        found = shapely.distance(disc(outline, place, FINE).exterior, centres) - drive.pin_radius
        # 6 µm of equidistant and compensation: no pin nearer than the engine's gap, none further.
        assert np.allclose(found, engine.gap[0, j], atol=2.0 * FINE)
        assert np.min(found) > 0.0


def test_discs_share_their_crank_holes_and_run_opposite(rv40e_record: DesignRecord) -> None:
    first, second = disc_placements(rv40e_record.drive)
    assert (first.shift, second.shift) == pytest.approx((1.3, -1.3))
    assert second.rotation == pytest.approx(-math.pi / 39.0)
    for j, place in enumerate((first, second)):
        holes = mounted(rv40e_record.outline, place).holes
        centres = [hole.centre * np.exp(1j * place.rotation) + place.shift for hole in holes if "crank" in hole.name]
        wanted = 36.0 * np.exp(2j * math.pi * np.arange(3) / 3) + (1.3 if j == 0 else -1.3)
        assert np.allclose(centres, wanted, atol=1e-12)


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) for name in catalog_names() if name != "printed_11"] + ["printed_11"],
)
def test_no_part_is_inside_another(name: str) -> None:
    spec = parse_spec(catalog_text(name))
    drive, outline = stage(spec)
    bodies = [
        (place.name, place.height, place.height + drive.disc_width, disc(outline, place, COARSE))
        for place in disc_placements(drive)
    ]
    for part in stage_parts(drive, outline):
        for place in part.placements:
            for slab in part.slabs:
                shape = placed(polygon(slab.edge, slab.openings), place)
                bodies.append((place.name, slab.low + place.height, slab.high + place.height, shape))
    assert len({one[0] for one in bodies}) >= drive.trochoid.pins + drive.discs + 3
    for a, b in itertools.combinations(bodies, 2):
        if a[0] != b[0] and min(a[2], b[2]) > max(a[1], b[1]) + 1e-9 and a[3].intersects(b[3]):
            # Parts that fit into each other touch: their chords may cross by a sagitta along the joint.
            shared = a[3].intersection(b[3])
            assert shared.area <= 2.0 * COARSE * a[3].length, (a[0], b[0])
            assert shared.buffer(-2.0 * COARSE).is_empty, (a[0], b[0])


def test_thin_pins_leave_the_ring_without_grooves() -> None:
    assert ring_bore(40, 64.0, 0.5, 66.0).full_circle_arc is not None
    grooved = ring_bore(40, 64.0, 3.0, 64.5)
    assert len(grooved.segments) == 80
    # Each groove holds its pin: the ring's bore reaches round it on the pin's own radius.
    radius = np.abs(grooved.points(1e-4))
    assert np.max(radius) == pytest.approx(67.0, abs=1e-4)
    assert np.min(radius) == pytest.approx(64.5, abs=1e-4)


@pytest.mark.slow
def test_assembly_file_holds_every_part_in_its_place(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    pytest.importorskip("OCP", reason="the CAD kernel is not installed")
    from build123d import CenterOf

    from cycloid_profile.export.cad import StepAssemblyExporter
    from cycloid_profile.export.cad._solids import read_shape, sound_solids

    (written,) = StepAssemblyExporter().write(rv40e_record, tmp_path)
    assert written.entities == {"solids": 2 + 40 + 1 + 3 + 6 + 2, "shapes": 7, "discs": 2, "pins": 40}
    assert written.deviation is not None
    assert written.deviation.largest <= 5e-5
    assert written.deviation.from_curve is not None
    assert written.deviation.from_curve <= 5e-5
    path = tmp_path / "assembly.step"
    first = path.read_bytes()
    text = re.sub(r"\s+", " ", first.decode("ascii"))
    occurrences = re.findall(r"NEXT_ASSEMBLY_USAGE_OCCURRENCE\( ?'(\d+)', ?'([^']*)'", text)
    assert [number for number, _ in occurrences] == [str(i) for i in range(1, 55)]
    named = [name for _, name in occurrences]
    assert named[:2] == ["disc 1", "disc 2"]
    assert {"pin 40", "pin ring", "crank shaft 3", "crank bearing 2.1", "carrier plate 2"} <= set(named)
    assert len(re.findall(r"COLOUR_RGB", text)) >= 6
    # Centres of the pins in the assembly, as the kernel finds them.
    centres = []
    for solid in sound_solids(read_shape(path), path, 54)[2:42]:
        centre = solid.center(CenterOf.MASS)
        centres.append(complex(centre.X, centre.Y))
    assert np.allclose(centres, 64.0 * np.exp(2j * math.pi * np.arange(40) / 40), atol=1e-9)
    StepAssemblyExporter().write(rv40e_record, tmp_path)
    assert path.read_bytes() == first


def test_a_single_disc_needs_no_turn(rv40e_record: DesignRecord) -> None:
    (only,) = disc_placements(replace(rv40e_record.drive, discs=1))
    assert only.rotation == 0.0
    assert mounted(rv40e_record.outline, only).contours == rv40e_record.outline.contours
