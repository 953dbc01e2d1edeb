"""3MF and STL read by the zip, XML and struct modules, STL by trimesh too: closed, within the stated chords."""

from __future__ import annotations

import io
import math
import struct
import sys
import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from independent import ExactCurve, area_inside

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export import write_formats
from cycloid_profile.export.cad import MeshExporter, PrintOffsets, extruded, open_edges, printed, tooth_chords
from cycloid_profile.export.writing import WrittenFile
from cycloid_profile.spec.model.export import PrintSpec

pytest.importorskip("lib3mf", reason="lib3mf is not installed")

CHORD, OFFSET = 0.005, 0.080
CORE = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
HOLES = math.pi * (16.0**2 + 3 * 13.0**2)


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    """The tooth with the printer's offset added to its equidistant modification."""
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006 + OFFSET, delta_max=rv40e_record.compensation.delta_max)


@pytest.fixture(scope="module")
def files(rv40e_record: DesignRecord, tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, WrittenFile]]:
    record = with_print(rv40e_record, PrintSpec(chord_um=1e3 * CHORD, flank_offset_um=1e3 * OFFSET))
    folder = tmp_path_factory.mktemp("mesh")
    found = {}
    for kind in ("3mf", "stl"):
        (written,) = MeshExporter(kind, f"disc.{kind}").write(record, folder)
        found[kind] = (folder / f"disc.{kind}", written)
    return found


def with_print(record: DesignRecord, wanted: PrintSpec) -> DesignRecord:
    export = msgspec.structs.replace(record.spec.export, print=wanted)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


def read_3mf(path: Path) -> tuple[np.ndarray, np.ndarray, str, str]:
    """Corners, triangles, unit and name of the one object, by zip and XML."""
    with zipfile.ZipFile(path) as package:
        assert package.testzip() is None
        root = ET.fromstring(package.read("3D/3dmodel.model"))
    (body,) = root.iter(f"{CORE}object")
    corners = [[float(corner.attrib[axis]) for axis in "xyz"] for corner in body.iter(f"{CORE}vertex")]
    triangles = [[int(one.attrib[f"v{i}"]) for i in (1, 2, 3)] for one in body.iter(f"{CORE}triangle")]
    return np.array(corners), np.array(triangles), root.attrib["unit"], body.attrib["name"]


def read_stl(path: Path) -> np.ndarray:
    """Triangles of a binary STL, shape (n, 3 corners, 3)."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    assert len(data) == 84 + 50 * count
    rows = np.frombuffer(data, dtype=np.dtype([("normal", "<3f4"), ("corner", "<9f4"), ("more", "<u2")]), offset=84)
    return rows["corner"].reshape(-1, 3, 3).astype(float)


def volume(triangles: np.ndarray) -> float:
    """Enclosed volume by the divergence theorem, positive where normals point outwards [mm³]."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    return float(np.sum(a * np.cross(b, c)) / 6.0)


def rim(triangles: np.ndarray, beyond: float) -> np.ndarray:
    """Points along the chords of upright sides further from the axis than ``beyond``, shape (n, 2) [mm]."""
    edges = np.concatenate([np.stack([triangles[:, i], triangles[:, (i + 1) % 3]], axis=1) for i in range(3)])
    upright = np.repeat(np.ptp(triangles[:, :, 2], axis=1)[None] > 0.0, 3, axis=0).ravel()
    at_foot = np.all(edges[:, :, 2] == 0.0, axis=1) & (np.min(np.hypot(*edges[:, :, :2].T), axis=0) > beyond)
    chosen = edges[upright & at_foot][:, :, :2]
    share = np.linspace(0.0, 1.0, 5)[:, None]
    return np.concatenate([start + share * (end - start) for start, end in chosen])


@pytest.mark.parametrize("kind", ["3mf", pytest.param("stl", marks=pytest.mark.slow)])
def test_mesh_is_closed_and_within_its_chords(
    kind: str, files: dict[str, tuple[Path, WrittenFile]], exact: ExactCurve
) -> None:
    path, written = files[kind]
    if kind == "3mf":
        corners, rows, unit, name = read_3mf(path)
        assert (unit, name) == ("millimeter", "RV-40E")
        triangles = corners[rows]
    else:
        triangles = read_stl(path)
    assert written.entities["triangles"] == len(triangles)
    assert written.entities["open_edges"] == 0
    # Every edge occurs once in each direction: closed and consistently oriented.
    met = [tuple(map(tuple, pair)) for t in triangles.tolist() for pair in zip(t, t[1:] + t[:1], strict=True)]
    assert len(set(met)) == len(met)
    assert {pair[::-1] for pair in met} == set(met)
    off = exact.distance(rim(triangles, 50.0))
    assert np.max(off) <= CHORD + 1e-5
    assert written.deviation is not None
    assert written.deviation.largest == pytest.approx(np.max(off), rel=0.05)
    assert written.tolerance == pytest.approx(CHORD, abs=1e-5)
    teeth = area_inside(exact.at(np.linspace(0.0, 2.0 * math.pi * 39, 39 * 5_000, endpoint=False)))
    # Chords of 5 µm over all edges: 390 mm of tooth, 346 mm of holes.
    assert volume(triangles) == pytest.approx((teeth - HOLES) * 11.5, abs=(390.0 + 346.0) * CHORD * 11.5)


def test_equal_input_gives_equal_bytes(
    rv40e_record: DesignRecord, files: dict[str, tuple[Path, WrittenFile]], tmp_path: Path
) -> None:
    record = with_print(rv40e_record, PrintSpec(chord_um=1e3 * CHORD, flank_offset_um=1e3 * OFFSET))
    for kind, (path, _) in files.items():
        MeshExporter(kind, path.name).write(record, tmp_path)
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


@pytest.mark.slow
def test_trimesh_finds_it_watertight(files: dict[str, tuple[Path, WrittenFile]], exact: ExactCurve) -> None:
    trimesh: Any = pytest.importorskip("trimesh", reason="trimesh is not installed")
    mesh = trimesh.load(io.BytesIO(files["stl"][0].read_bytes()), file_type="stl")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    # One body through which 4 holes go: Euler's number is 2 − 2·4.
    assert mesh.euler_number == -6
    section = mesh.section(plane_origin=[0.0, 0.0, 5.0], plane_normal=[0.0, 0.0, 1.0])
    rims = section.vertices[np.hypot(*section.vertices[:, :2].T) > 50.0][:, :2]
    assert np.max(exact.distance(rims)) <= CHORD + 1e-5


def test_a_hole_in_the_mesh_is_counted(rv40e_record: DesignRecord) -> None:
    mesh = extruded(rv40e_record.outline, 10.0, 0.05)
    assert open_edges(mesh) == 0
    assert open_edges(replace(mesh, triangles=mesh.triangles[1:])) == 3
    rotated = mesh.triangles.copy()
    rotated[7] = rotated[7][::-1]
    assert open_edges(replace(mesh, triangles=rotated)) > 0
    # The teeth are found again whatever the openings.
    assert np.min(np.abs(tooth_chords(mesh))) > 59.0


def test_an_offset_that_undercuts_is_refused(rv40e_record: DesignRecord) -> None:
    with pytest.raises(ExportError, match=r"flank_offset_um = 2000 is too much .* take a smaller offset"):
        printed(rv40e_record.outline, PrintOffsets(flank=2.0))


def test_a_missing_library_is_reported_in_one_sentence(
    rv40e_record: DesignRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "lib3mf", None)
    written, skipped = write_formats(rv40e_record, ("cmm", "3mf", "stl"), tmp_path)
    assert [file.name for file in written] == ["cmm_nominal.csv", "cmm_nominal_disc_2.csv"]
    assert set(skipped) == {"3mf", "stl"}
    assert all("pip install lib3mf" in reason and "\n" not in reason for reason in skipped.values())
