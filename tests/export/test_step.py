"""STEP read back: by its text, by scipy, by steputils and by FreeCAD, against the textbook formula of the tooth.

The kernel that writes the files reads them back in the writer; nothing here relies on that but the test of its
volume integral. The promise is 0.05 µm.
"""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from independent import ExactCurve, area_inside, read_step_splines, sample_spline

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.cad import StepExporter
from cycloid_profile.export.writing import WrittenFile
from cycloid_profile.geometry import circular_contour, keyed_bore, ring_of_holes, ring_of_windows
from cycloid_profile.spec.model.export import StepSpec

pytest.importorskip("OCP", reason="the CAD kernel is not installed")

TOLERANCE = 5e-5
CHORDS = 3e-9  # chord error of the polyline in place of the exact curve


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006, delta_max=rv40e_record.compensation.delta_max)


@pytest.fixture(scope="module")
def disc(rv40e_record: DesignRecord, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, WrittenFile]:
    folder = tmp_path_factory.mktemp("step")
    (written,) = StepExporter().write(rv40e_record, folder)
    return folder / "disc.step", written


def with_step(record: DesignRecord, step: StepSpec) -> DesignRecord:
    export = _replaced(record.spec.export, step=step)
    return replace(record, spec=_replaced(record.spec, export=export))


def _replaced(table: Any, **changes: Any) -> Any:
    return msgspec.structs.replace(table, **changes)


def foot(path: Path) -> list[tuple[int, np.ndarray, np.ndarray]]:
    """Splines of the tooth at z = 0: degree, knots, control points x y."""
    return [(d, k, c[:, :2]) for d, k, c in read_step_splines(path) if np.all(c[:, 2] == 0.0)]


def test_tooth_is_within_tolerance_by_its_text(exact: ExactCurve, disc: tuple[Path, WrittenFile]) -> None:
    path, written = disc
    splines = foot(path)
    points = np.concatenate([sample_spline(*spline, 10) for spline in splines])
    off = exact.distance(points)
    assert np.max(off) <= TOLERANCE
    assert {d for d, _, _ in splines} == {5}
    assert len({tuple(c[0]) for _, _, c in splines}) == 78
    assert written.entities == {"solids": 1, "faces": 78 + 4 + 2, "tooth_edges": 78, "holes": 4}
    assert path.stat().st_size <= 1_000_000
    # The deviation stated by the writer agrees with this measurement in both directions.
    assert written.deviation is not None
    assert written.deviation.largest == pytest.approx(np.max(off), rel=0.1)
    assert written.deviation.from_curve == pytest.approx(np.max(off), rel=0.1)


def test_solid_encloses_the_area_of_the_tooth(exact: ExactCurve, disc: tuple[Path, WrittenFile]) -> None:
    from cycloid_profile.export.cad._solids import read_shape

    teeth = area_inside(exact.at(np.linspace(0.0, 2.0 * math.pi * 39, 39 * 20_000, endpoint=False)))
    # A boundary off by 0.05 µm all round would change the area by 0.02 mm², 2e-6 of it.
    ends = {}
    for spline in foot(disc[0]):
        points = sample_spline(*spline, 60)
        ends[float(np.arctan2(*points.mean(axis=0)[::-1]))] = points
    ring = np.concatenate([ends[angle] for angle in sorted(ends, reverse=True)])
    assert area_inside(ring) == pytest.approx(teeth, rel=3e-6)
    # The kernel's default volume integral takes few points on spline faces; a lost hole would show as 5 %.
    volume = (teeth - math.pi * (16.0**2 + 3 * 13.0**2)) * 11.5
    assert read_shape(disc[0]).volume == pytest.approx(volume, rel=1e-4)
    assert disc[1].measures["volume_mm3"] == pytest.approx(volume, rel=1e-7)
    # The adaptive one of the manifest is right.
    assert disc[1].measures["opencascade_volume_mm3"] == pytest.approx(volume, rel=1e-7)


def test_equal_input_gives_equal_bytes(
    rv40e_record: DesignRecord, disc: tuple[Path, WrittenFile], tmp_path: Path
) -> None:
    StepExporter().write(rv40e_record, tmp_path)
    assert (tmp_path / "disc.step").read_bytes() == disc[0].read_bytes()
    assert "'2000-01-01T00:00:00'" in disc[0].read_text(encoding="ascii")


@pytest.mark.slow
def test_cubics_and_the_newer_protocol_are_to_be_had(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    (written,) = StepExporter().write(with_step(rv40e_record, StepSpec(schema="AP242", degree=3)), tmp_path)
    splines = foot(tmp_path / "disc.step")
    assert {d for d, _, _ in splines} == {3}
    assert np.max(exact.distance(np.concatenate([sample_spline(*spline, 6) for spline in splines]))) <= TOLERANCE
    assert written.deviation is not None
    text = (tmp_path / "disc.step").read_text(encoding="ascii")
    assert "AP242_MANAGED_MODEL_BASED_3D_ENGINEERING_MIM_LF" in text
    assert len(text) <= 1_000_000


def test_windows_and_keyways_are_cut_out_exactly(tmp_path: Path) -> None:
    from cycloid_profile.export.cad import CadMaterial, CadPart
    from cycloid_profile.export.cad._solids import plate, read_shape, sound_solids, top_edges, write_part

    openings = (
        keyed_bore("bore", 16.0, 2, 6.0, 2.8, 0.3, 0.5 * math.pi),
        *ring_of_windows("window", 3, (26.0, 48.0), math.radians(50.0), 4.0, math.radians(60.0)),
        *ring_of_holes("crank hole", 3, 36.0, 13.0),
    )
    # A round plate, whose volume the kernel integrates exactly, unlike that of spline flanks.
    solid = plate(circular_contour("edge", 0j, 55.0), openings, -2.0, 9.5)
    path = tmp_path / "plate.step"
    write_part(CadPart("plate", solid, (0.5, 0.5, 0.5), CadMaterial("steel", "")), path, "AP214")
    (back,) = sound_solids(read_shape(path), path, 1)
    found = back.volume
    area = math.pi * 55.0**2 - sum(opening.area for opening in openings)
    assert found == pytest.approx(area * 11.5, rel=1e-10)
    edges, holes, faces = top_edges(back)
    assert (len(edges), holes) == (1, 7)
    assert faces == 2 + 1 + sum(len(opening.segments) for opening in openings)


@pytest.mark.slow
def test_steputils_counts_units_names_and_materials(disc: tuple[Path, WrittenFile], exact: ExactCurve) -> None:
    p21 = pytest.importorskip("steputils.p21", reason="steputils is not installed")
    file = p21.readfile(str(disc[0]))
    assert file.header["FILE_SCHEMA"].params[0][0].startswith("AUTOMOTIVE_DESIGN")
    instances = list(file.data[0].instances.values())
    simple = [one for one in instances if p21.is_simple_entity_instance(one)]
    named: dict[str, list[Any]] = {}
    for one in simple:
        named.setdefault(one.entity.name, []).append(one.entity.params)
    # Every flank edge twice, bottom and top, and once more as the generator of its face.
    assert len(named["B_SPLINE_CURVE_WITH_KNOTS"]) == 3 * 78
    assert len(named["SURFACE_OF_LINEAR_EXTRUSION"]) == 78
    assert len(named["CYLINDRICAL_SURFACE"]) == 4
    assert len(named["PLANE"]) == 2
    assert len(named["ADVANCED_FACE"]) == 84
    assert len(named["MANIFOLD_SOLID_BREP"]) == len(named["CLOSED_SHELL"]) == 1
    # No curve on a surface, none trimmed from another, no fitted polyline.
    assert not {"PCURVE", "SURFACE_CURVE", "SEAM_CURVE", "TRIMMED_CURVE", "POLYLINE", "COMPOSITE_CURVE"} & set(named)
    assert named["PRODUCT"][0][0] == "RV-40E"
    assert named["DESCRIPTIVE_REPRESENTATION_ITEM"][0][0] == "steel"
    assert [round(float(part), 3) for part in named["COLOUR_RGB"][0][1:]] == [0.7, 0.75, 0.8]
    units = [{e.name: e.params for e in one.entities} for one in instances if not p21.is_simple_entity_instance(one)]
    lengths = [unit["SI_UNIT"] for unit in units if "LENGTH_UNIT" in unit]
    assert [[str(word).strip(".") for word in unit] for unit in lengths] == [["MILLI", "METRE"]]
    # Every spline of the file evaluated by scipy, from the entities that steputils has parsed.
    by_ref = {str(one.ref): one.entity.params for one in simple}
    for params in named["B_SPLINE_CURVE_WITH_KNOTS"]:
        control = np.array([by_ref[str(ref)][1] for ref in params[2]], float)
        knots = np.repeat(np.array(params[7], float), np.array(params[6], int))
        assert params[1] == 5
        assert np.ptp(control[:, 2]) == 0.0
        assert np.max(exact.distance(sample_spline(5, knots, control[:, :2], 4))) <= TOLERANCE


FREECAD = """
import json, os, sys
import Part
shape = Part.Shape()
shape.read(os.environ["STEP_FILE"])
rows = []
for edge in shape.Edges:
    if edge.Curve.TypeId == "Part::GeomBSplineCurve":
        a, b = edge.ParameterRange
        points = [edge.valueAt(a + (b - a) * (i + 0.5) / 200) for i in range(200)]
        rows += [[p.x, p.y] for p in points]
found = dict(valid=shape.isValid(), solids=len(shape.Solids), faces=len(shape.Faces), volume=shape.Volume, points=rows)
with open(os.environ["STEP_FOUND"], "w") as file:
    json.dump(found, file)
os._exit(0)
"""


@pytest.mark.slow
def test_freecad_reads_the_same_disc(disc: tuple[Path, WrittenFile], exact: ExactCurve, tmp_path: Path) -> None:
    command = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
    if command is None:
        pytest.skip("FreeCAD is not installed")
    (tmp_path / "read.py").write_text(FREECAD, encoding="utf-8")
    words = {"STEP_FILE": str(disc[0]), "STEP_FOUND": str(tmp_path / "found.json"), "HOME": str(tmp_path)}
    subprocess.run([command, str(tmp_path / "read.py")], env=os.environ | words, check=False, timeout=120,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    assert (found["valid"], found["solids"], found["faces"]) == (True, 1, 84)
    assert np.max(exact.distance(np.array(found["points"]))) <= TOLERANCE
    teeth = area_inside(exact.at(np.linspace(0.0, 2.0 * math.pi * 39, 39 * 20_000, endpoint=False)))
    assert found["volume"] == pytest.approx((teeth - math.pi * (16.0**2 + 3 * 13.0**2)) * 11.5, rel=1e-4)
