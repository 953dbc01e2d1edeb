"""The DXF files by their group codes, and by programs that share no code with their writer.

The reader ``dxf_codes`` is the test's own. dxf-parser (npm), FreeCAD and LibreCAD are asked where they are installed.
"""

from __future__ import annotations

import json
import math
import os
import re
import shutil
import subprocess
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import msgspec
import numpy as np
import pytest
import shapely
from dxf_codes import Tags, entities, header, numbers, polyline_arcs, spline_points, turns_between
from hypothesis import given, settings
from hypothesis import strategies as st
from independent import ExactCurve

from cycloid_profile.design import DesignRecord
from cycloid_profile.design.from_spec import conventional_profile, disc_outline, drive_of
from cycloid_profile.errors import CycloidError, ExportError, GeometryError
from cycloid_profile.export.curves import disc_arcs
from cycloid_profile.export.dxf import (
    LAYERS,
    ArcDxfExporter,
    DxfExporter,
    OffsetDxfExporter,
    read_dxf_arcs,
    write_polyline,
)
from cycloid_profile.export.svg import SvgExporter
from cycloid_profile.geometry import ChordTolerance, ToothProfile, Trochoid, sample, undercut_limit
from cycloid_profile.modification import MeasuredDeviation, NormalDeviation
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.model.drive import DriveSpec
from cycloid_profile.spec.model.export import DxfSpec
from cycloid_profile.spec.model.modification import ModificationSpec

PROMISE = 5e-5  # mm, of the RV-40E
CHORDS = 3e-9  # mm, chord error of the polyline in place of the exact curve


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006, delta_max=rv40e_record.compensation.delta_max)


@pytest.fixture(scope="module")
def written(rv40e_record: DesignRecord, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with both files of the RV-40E."""
    folder = tmp_path_factory.mktemp("dxf")
    for exporter in (DxfExporter(), ArcDxfExporter()):
        exporter.write(rv40e_record, folder)
    return folder


def arcs_of(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and bulges of the one polyline on layer PROFILE."""
    (tags,) = entities(path, "LWPOLYLINE", "PROFILE")
    assert int(numbers(tags, 70)[0]) & 1, "the polyline is open"
    vertices = np.stack([numbers(tags, 10), numbers(tags, 20)], axis=-1)
    assert len(vertices) == int(numbers(tags, 90)[0])
    return vertices, numbers(tags, 42)


def flank_points(path: Path) -> np.ndarray:
    """Points of all splines on layer PROFILE, in the order of the file."""
    return np.concatenate([spline_points(tags, 8) for tags in entities(path, "SPLINE", "PROFILE")])


def texts(tags: Tags, code: int) -> list[str]:
    """All values of one group code as written."""
    return [value for found, value in tags if found == code]


def with_dxf(record: DesignRecord, settings: DxfSpec) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, dxf=settings)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


def with_tolerance(record: DesignRecord, um: float) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, chord_tolerance_um=um)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


@pytest.mark.parametrize("name", ["profile.dxf", "profile_arcs.dxf"])
def test_units_and_layers(written: Path, name: str) -> None:
    assert header(written / name, "$ACADVER") == "AC1024"  # R2010
    assert header(written / name, "$INSUNITS") == "4"  # mm
    assert [layer.name for layer in LAYERS] == ["PROFILE", "PITCH", "HOLES", "CENTRE", "PINS", "TEXT"]
    pins = entities(written / name, "CIRCLE", "PINS")
    assert len(pins) == 40
    # With φ = 0 the first pin is in root 1: 64 − 1.3 from the disc's centre.
    assert (numbers(pins[0], 10)[0], numbers(pins[0], 20)[0]) == (62.7, 0.0)
    assert {float(numbers(pin, 40)[0]) for pin in pins} == {3.0}
    (pitch,) = entities(written / name, "CIRCLE", "PITCH")
    assert numbers(pitch, 40)[0] == pytest.approx(1.3 * 39)
    assert sorted(numbers(hole, 40)[0] for hole in entities(written / name, "CIRCLE", "HOLES")) == [13, 13, 13, 16]
    assert len(entities(written / name, "TEXT", "TEXT")) == 3


def test_flanks_by_de_boor_from_their_group_codes(written: Path, exact: ExactCurve) -> None:
    flanks = entities(written / "profile.dxf", "SPLINE", "PROFILE")
    assert len(flanks) == 78
    for tags in flanks:
        assert not numbers(tags, 11).size, "fit points are drawn differently by every reader"
        assert int(numbers(tags, 70)[0]) & 1 == 0
    assert np.max(exact.distance(flank_points(written / "profile.dxf"))) <= PROMISE + CHORDS
    # In the order of the contour, with the same digits where one ends and the next begins.
    starts = [(texts(tags, 10)[0], texts(tags, 20)[0]) for tags in flanks]
    ends = [(texts(tags, 10)[-1], texts(tags, 20)[-1]) for tags in flanks]
    assert starts == [ends[-1], *ends[:-1]]


def test_single_spline_on_request(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    DxfExporter().write(with_dxf(rv40e_record, DxfSpec(tooth="single")), tmp_path)
    (tags,) = entities(tmp_path / "profile.dxf", "SPLINE", "PROFILE")
    assert np.max(exact.distance(spline_points(tags, 8))) <= PROMISE + CHORDS
    # Corners of the compensation: full multiplicity at root and tip of every lobe, so that none is rounded off.
    _, times = np.unique(numbers(tags, 40)[4:-4], return_counts=True)
    assert np.count_nonzero(times == 3) == 77


def test_area_by_the_kernel_is_that_of_greens_theorem(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    (file,) = DxfExporter().write(rv40e_record, tmp_path)
    found = file.measures
    for name in ("area_mm2", "volume_mm3"):
        assert found[f"opencascade_{name}"] == pytest.approx(found[name], rel=1e-5)
    # Green's theorem on points of the curve, and the openings of the spec.
    psi = np.linspace(0.0, 2.0 * math.pi * 39, 39 * 20_000, endpoint=False)
    z = rv40e_record.profile.at(psi).position
    teeth = 0.5 * abs(float(np.sum((np.conj(z) * np.roll(z, -1)).imag)))
    assert found["area_mm2"] == pytest.approx(teeth - math.pi * (3 * 13.0**2 + 16.0**2), rel=1e-7)
    # One spline round the disc is what the kernel cannot integrate.
    (single,) = DxfExporter().write(with_dxf(rv40e_record, DxfSpec(tooth="single")), tmp_path)
    assert abs(single.measures["opencascade_area_mm2"] / single.measures["area_mm2"] - 1.0) > 1e-3


@pytest.mark.parametrize("offset", [None, 0.06])
def test_offset_contours_keep_the_distance_of_the_cutter(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, offset: float | None
) -> None:
    record = with_dxf(rv40e_record, DxfSpec(offset_mm=offset))
    (file,) = OffsetDxfExporter().write(record, tmp_path)
    path, wanted = tmp_path / "profile_offset.dxf", 0.14 if offset is None else offset
    assert file.deviation is not None
    assert file.deviation.largest <= PROMISE
    arcs = polyline_arcs(*arcs_of(path), 9).reshape(-1, 2)
    assert np.max(np.abs(exact.distance(arcs) - wanted)) <= PROMISE + CHORDS
    disc = shapely.Polygon(sample(record.profile, ChordTolerance(1e-3)).xy)
    shapely.prepare(disc)
    assert not np.any(shapely.contains(disc, shapely.points(arcs))), "the cutter is inside the disc"
    holes = entities(path, "LWPOLYLINE", "HOLES")
    widths = sorted(float(np.ptp(numbers(tags, 10))) for tags in holes)
    assert widths == pytest.approx([*3 * [2.0 * (13.0 - wanted)], 2.0 * (16.0 - wanted)])


def test_cutter_that_does_not_fit_the_roots_is_refused(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    with pytest.raises(ExportError, match=r"offset = 3.5000 mm is not below the least concave radius .* thinner tool"):
        OffsetDxfExporter().write(with_dxf(rv40e_record, DxfSpec(offset_mm=3.5)), tmp_path)


def test_svg_at_true_size_by_another_reader(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    svgpathtools = pytest.importorskip("svgpathtools")
    SvgExporter().write(rv40e_record, tmp_path)
    paths, _, drawing = svgpathtools.svg2paths2(str(tmp_path / "profile.svg"))
    box = [float(number) for number in drawing["viewBox"].split()]
    assert drawing["width"] == f"{box[2]:.4f}mm"
    assert drawing["height"] == f"{box[3]:.4f}mm"
    assert len(paths) == 5
    tooth, *openings = paths
    assert tooth.isclosed()
    points = np.array([curve.point(t) for curve in tooth for t in np.linspace(0.05, 0.95, 7)])
    # y points down.
    assert np.max(exact.distance(np.stack([points.real, -points.imag], axis=-1))) <= PROMISE + CHORDS
    assert sorted(round(opening.length() / (2.0 * math.pi), 6) for opening in openings) == [13.0, 13.0, 13.0, 16.0]


def test_arcs_from_their_bulges(written: Path, exact: ExactCurve) -> None:
    vertices, bulge = arcs_of(written / "profile_arcs.dxf")
    arcs = polyline_arcs(vertices, bulge, 9)
    assert np.max(exact.distance(arcs.reshape(-1, 2))) <= PROMISE + CHORDS
    turns = np.sort(turns_between(arcs, bulge))
    # All joints but those at the 78 corners of the compensation are tangent.
    assert turns[-79] < 1e-7
    tip, root = np.sort(np.abs(exact.corner_turns()))
    assert turns[-78:-39] == pytest.approx(tip, rel=0.05)
    assert turns[-39:] == pytest.approx(root, rel=0.05)


def test_a_tenth_of_a_micrometre_takes_1560_arcs(rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path) -> None:
    ArcDxfExporter().write(with_tolerance(rv40e_record, 0.1), tmp_path)
    vertices, bulge = arcs_of(tmp_path / "profile_arcs.dxf")
    assert len(bulge) <= 1560
    assert np.max(exact.distance(polyline_arcs(vertices, bulge, 9).reshape(-1, 2))) <= 1e-4 + CHORDS


def test_equal_input_gives_equal_bytes(rv40e_record: DesignRecord, written: Path, tmp_path: Path) -> None:
    for exporter in (DxfExporter(), ArcDxfExporter()):
        exporter.write(rv40e_record, tmp_path)
        assert (tmp_path / exporter.filename).read_bytes() == (written / exporter.filename).read_bytes()


def test_a_polyline_of_100_000_vertices_is_whole(tmp_path: Path) -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 100_000, endpoint=False)
    points = (60.0 + np.cos(39.0 * angle)) * np.exp(-1j * angle)
    write_polyline(tmp_path / "dense.dxf", points)
    (tags,) = entities(tmp_path / "dense.dxf", "LWPOLYLINE", "PROFILE")
    assert np.max(np.abs(numbers(tags, 10) + 1j * numbers(tags, 20) - points)) <= 1e-9
    assert not numbers(tags, 42).size


def test_ezdxf_reads_the_written_values(tmp_path: Path) -> None:
    arcs = disc_arcs(hobby_tooth(11), 1e-3)
    write_polyline(tmp_path / "a.dxf", arcs.ends[:-1], np.tan(0.25 * np.linspace(-1.0, 1.0, arcs.curvature.size)))
    (found,) = ezdxf.readfile(tmp_path / "a.dxf").modelspace()
    back = np.array(found.get_points("xyb"))
    assert np.max(np.abs(back[:, 0] + 1j * back[:, 1] - arcs.ends[:-1])) <= 1e-9
    assert np.allclose(4.0 * np.arctan(back[:, 2]), np.linspace(-1.0, 1.0, arcs.curvature.size), atol=1e-12)


def hobby_tooth(pins: int) -> ToothProfile:
    return ToothProfile(Trochoid(pins, 30.0, 1.5), 3.0)


@pytest.mark.slow
def test_lobes_that_differ_are_written_one_by_one(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    phase = np.linspace(0.0, 2.0 * math.pi * 39, 39 * 12, endpoint=False)
    removal = 1e-3 * np.sin(phase / 39 + 0.3) + 3e-4 * np.random.default_rng(1).normal(size=phase.size)
    program = MeasuredDeviation(NormalDeviation(phase, removal, 39)).apply(rv40e_record.profile)
    record = replace(rv40e_record, profile=program)
    fine = program.at(np.linspace(0.0, program.trochoid.phase_period, 39 * 12_000 + 1)).position
    for exporter in (DxfExporter(), ArcDxfExporter()):
        (file,) = exporter.write(record, tmp_path)
        assert file.deviation is not None
        assert max(file.deviation.largest, file.deviation.from_curve or 1.0) <= PROMISE
    flanks = flank_points(tmp_path / "profile.dxf")
    arcs = polyline_arcs(*arcs_of(tmp_path / "profile_arcs.dxf"), 9).reshape(-1, 2)
    for points in (flanks, arcs):
        z = points[:, 0] + 1j * points[:, 1]
        # By chords of 1 nm height, without the package's own feet.
        from scipy.spatial import cKDTree

        _, i = cKDTree(np.stack([fine.real, fine.imag], axis=-1)).query(points)
        off = np.full(z.size, np.inf)
        for a in (np.maximum(i - 1, 0), np.minimum(i, fine.size - 2)):
            chord = fine[a + 1] - fine[a]
            share = np.clip((np.conj(chord) * (z - fine[a])).real / np.abs(chord) ** 2, 0.0, 1.0)
            off = np.minimum(off, np.abs(z - fine[a] - share * chord))
        assert np.max(off) <= PROMISE + 2e-6


@st.composite
def drives(draw: st.DrawFn) -> dict[str, Any]:
    """Any drive of 3 to 300 lobes, K1 from 0.1 to 0.95, one disc or two, thin pins and thick."""
    pins = draw(st.integers(4, 301))
    r_p = draw(st.sampled_from([10.0, 64.0, 500.0]))
    trochoid = Trochoid(pins, r_p, draw(st.floats(0.1, 0.95)) * r_p / pins)
    room = min(undercut_limit(trochoid), r_p * math.sin(math.pi / pins))
    return {
        "pins": pins,
        "pin_circle_radius_mm": r_p,
        "pin_radius_mm": draw(st.floats(0.1, 1.1)) * room,
        "eccentricity_mm": trochoid.eccentricity,
        "disc_width_mm": 10.0,
        "discs": draw(st.sampled_from([1, 2])),
    }


@pytest.mark.slow
@settings(deadline=None, max_examples=20)
@given(drive=drives(), equidistant=st.sampled_from([0.0, 5.0]), rotation=st.sampled_from([0.0, 0.5]))
def test_any_drive_is_written_or_refused_with_its_limit(
    rv40e_record: DesignRecord, tmp_path_factory: pytest.TempPathFactory, drive: dict[str, Any], equidistant: float,
    rotation: float,
) -> None:  # fmt: skip
    spec = Spec(
        drive=DriveSpec(**drive), modification=ModificationSpec(equidistant_um=equidistant, rotation_arcmin=rotation)
    )
    try:
        made = drive_of(spec)
        profile = conventional_profile(spec, made)
        outline = disc_outline(spec, made, profile)
    except CycloidError as refused:
        # Either outcome is right, a refusal without its limit is not.
        error = refused
    else:
        error = None
    if error is not None:
        assert error.limit
        assert error.remedy
        return
    record = replace(rv40e_record, spec=spec, drive=made, profile=profile, outline=outline)
    folder = tmp_path_factory.mktemp("any")
    for exporter in (DxfExporter(), ArcDxfExporter()):
        (file,) = exporter.write(record, folder)
        assert file.deviation is not None
        assert file.tolerance is not None
        assert max(file.deviation.largest, file.deviation.from_curve or 1.0) <= file.tolerance


def test_too_thick_a_pin_is_refused_with_the_limit() -> None:
    with pytest.raises(GeometryError, match="undercut limit"):
        drive_of(Spec(drive=DriveSpec(40, 64.0, 4.7, 1.3, 11.5, 1)))


_PARSE = """
const fs = require('fs'), DxfParser = require('dxf-parser');
const parser = new (DxfParser.default || DxfParser)();
const dxf = parser.parseSync(fs.readFileSync(process.argv[1], 'utf8'));
process.stdout.write(JSON.stringify({units: dxf.header.$INSUNITS,
  entities: dxf.entities.filter(e => e.layer === 'PROFILE')}));
"""


def parsed_by_node(path: Path) -> dict[str, Any]:
    """A file as dxf-parser reads it; skips without node or the package."""
    node, npm = shutil.which("node"), shutil.which("npm")
    if node is None or npm is None:
        pytest.skip("node and npm are not installed")
    installed = subprocess.run([npm, "root", "-g"], capture_output=True, text=True, check=True).stdout.strip()
    places = os.pathsep.join(filter(None, [os.environ.get("NODE_PATH"), installed]))
    command, environment = [node, "-e", _PARSE, str(path)], {**os.environ, "NODE_PATH": places}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    if "Cannot find module 'dxf-parser'" in done.stderr:
        pytest.skip("dxf-parser is not installed: npm install -g dxf-parser")
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.mark.slow
def test_dxf_parser_of_npm_reads_the_same_curves(written: Path, exact: ExactCurve) -> None:
    found = parsed_by_node(written / "profile.dxf")
    assert found["units"] == 4
    assert len(found["entities"]) == 78
    for spline in found["entities"]:
        assert (spline["type"], spline["degreeOfSplineCurve"]) == ("SPLINE", 3)
        tags = [(71, "3"), *((40, repr(k)) for k in spline["knotValues"])]
        for point in spline["controlPoints"]:
            tags += [(10, repr(point["x"])), (20, repr(point["y"]))]
        assert np.max(exact.distance(spline_points(tags, 8))) <= PROMISE + CHORDS
    (polyline,) = parsed_by_node(written / "profile_arcs.dxf")["entities"]
    assert polyline["shape"] is True
    vertices = np.array([[v["x"], v["y"]] for v in polyline["vertices"]])
    bulge = np.array([v["bulge"] for v in polyline["vertices"]])
    assert np.max(exact.distance(polyline_arcs(vertices, bulge, 9).reshape(-1, 2))) <= PROMISE + CHORDS


_FREECAD = """
import FreeCAD, Import, json
found = []
for path in {paths!r}:
    doc = FreeCAD.newDocument("d")
    Import.readDXF(path, doc.Name)
    for part in doc.Objects:
        for edge in getattr(part, "Shape").Edges if hasattr(part, "Shape") else []:
            kind = type(edge.Curve).__name__
            count = 300 if kind == "BSplineCurve" else 9
            low, high = edge.ParameterRange
            points = [edge.valueAt(low + (high - low) * (i + 0.5) / count) for i in range(count)]
            found.append([path, kind, [[p.x, p.y] for p in points]])
json.dump(found, open({out!r}, "w"))
"""


@pytest.mark.slow
def test_freecad_reads_the_same_curves(written: Path, exact: ExactCurve, tmp_path: Path) -> None:
    freecad = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
    if freecad is None:
        pytest.skip("FreeCAD is not installed")
    script, out = tmp_path / "read.py", tmp_path / "found.json"
    paths = [str(written / name) for name in ("profile.dxf", "profile_arcs.dxf")]
    script.write_text(_FREECAD.format(paths=paths, out=str(out)))
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    subprocess.run([freecad, str(script)], stdin=subprocess.DEVNULL, capture_output=True, env=environment, check=False)
    edges = [(path, kind, np.array(points)) for path, kind, points in json.loads(out.read_text())]
    flanks = [points for _, kind, points in edges if kind == "BSplineCurve"]
    assert len(flanks) == 78
    assert np.max(exact.distance(np.concatenate(flanks))) <= PROMISE + CHORDS
    ring = [p for path, kind, p in edges if path == paths[1] and kind == "Circle" and np.ptp(p[:, 0]) < 2.0]
    assert len(ring) == len(read_dxf_arcs(Path(paths[1]))[0].curvature)
    assert np.max(exact.distance(np.concatenate(ring))) <= PROMISE + CHORDS


@pytest.mark.slow
@pytest.mark.parametrize("name", ["profile", "profile_arcs"])
def test_librecad_draws_the_whole_tooth(written: Path, rv40e_record: DesignRecord, tmp_path: Path, name: str) -> None:
    librecad = shutil.which("librecad")
    if librecad is None:
        pytest.skip("LibreCAD is not installed")
    doc = ezdxf.readfile(written / f"{name}.dxf")
    for entity in list(doc.modelspace().query('*[layer!="PROFILE"]')):
        doc.modelspace().delete_entity(entity)
    doc.saveas(tmp_path / f"{name}.dxf")
    environment = {**os.environ, "QT_QPA_PLATFORM": "offscreen", "HOME": str(tmp_path)}
    command = [librecad, "dxf2pdf", "-a", "-c", f"{name}.dxf"]
    subprocess.run(
        command, cwd=tmp_path, stdin=subprocess.DEVNULL, capture_output=True, env=environment, check=True, timeout=100
    )
    streams = re.findall(rb"stream\r?\n(x.*?)\r?\nendstream", (tmp_path / f"{name}.pdf").read_bytes(), re.DOTALL)
    text = b"".join(zlib.decompress(stream) for stream in streams if stream[:1] == b"x").decode("latin1")
    # The first path is the page itself.
    drawn = np.array([(float(x), float(y)) for x, y in re.findall(r"([\d.]+) ([\d.]+) [ml]\n", text)])[5:]
    # The middle of the best circle: 39 lobes are not symmetric about both axes.
    (u, v, _), *_ = np.linalg.lstsq(np.column_stack([2.0 * drawn, np.ones(len(drawn))]), np.sum(drawn**2, axis=1))
    away = (drawn - np.array([u, v])) @ np.array([1.0, 1j])
    outline = rv40e_record.outline
    # Units of this page are some 0.02 mm of the disc.
    assert np.min(np.abs(away)) / np.max(np.abs(away)) == pytest.approx(
        outline.root_radius / outline.tip_radius, abs=2e-3
    )
    # All round, without a gap: neighbours are closer in angle than a tenth of a lobe.
    angles = np.sort(np.angle(away))
    assert np.max(np.diff(angles, append=angles[0] + 2.0 * math.pi)) < 0.1 * 2.0 * math.pi / 39
