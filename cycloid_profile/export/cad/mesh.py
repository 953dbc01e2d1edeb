"""3MF and STL for 3D printers: the disc as a closed triangle mesh."""

from __future__ import annotations

import cmath
import ctypes
import uuid
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.errors import ExportError, GeometryError
from cycloid_profile.export.cad.parts import PrintOffsets
from cycloid_profile.export.curves import ProfileSource, chain_of, chord_points, deviation_both_ways, offset_left
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, lib3mf, read_back_error
from cycloid_profile.geometry import Arc, Contour, DiscOutline, Line, circular_contour
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

_POINTS_PER_CHORD = 5  # the deviation of a chord is largest in its middle
# Both formats hold coordinates of 24 bits: half a unit in x and in y at this radius [mm] is the rounding.
_EPSILON = 2.0**-24
_DIGITS = 9  # distinguish all coordinates of 24 bits


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Mesh(Described):
    """Triangle mesh: ``corners`` x, y, z, shape (n, 3) [mm]; ``triangles`` of corner indices, shape (m, 3).

    Triangles are counterclockwise seen from outside.
    """

    corners: FloatArray
    triangles: IntArray

    def _key_figures(self) -> dict[str, str]:
        return {"triangles": f"{len(self.triangles)}", "corners": f"{len(self.corners)}"}


def extruded(outline: DiscOutline, height: float, chord_error: float) -> Mesh:
    """The disc from z = 0 to ``height``, chords within ``chord_error`` of tooth and openings; lengths in mm."""
    rings = [chord_points(outline.profile, chord_error).position[::-1]]
    rings += [contour.points(chord_error)[::-1] for contour in outline.contours]
    flat = np.concatenate(rings)
    cap = _triangulated(rings, flat)
    low = np.arange(flat.size)
    # Material lies to the left of every ring, the teeth anticlockwise and the openings clockwise.
    successor = np.concatenate([np.roll(ring, -1) for ring in np.split(low, np.cumsum([r.size for r in rings])[:-1])])
    high, high_successor = low + flat.size, successor + flat.size
    sides = [np.stack([low, successor, high_successor], axis=-1), np.stack([low, high_successor, high], axis=-1)]
    z = np.repeat([0.0, height], flat.size)
    corners = np.stack([np.tile(flat.real, 2), np.tile(flat.imag, 2), z], axis=-1)
    return Mesh(corners, np.concatenate([cap[:, ::-1], cap + flat.size, *sides]))


def tooth_chords(mesh: Mesh) -> ComplexArray:
    """Points along every chord of the outermost edge of the base of a mesh, shape (chords, points) [mm].

    Edges between the flat base and the sides form rings; the outermost ring is the tooth.
    """
    at_base = mesh.corners[:, 2] == np.min(mesh.corners[:, 2])
    base = mesh.triangles[np.all(at_base[mesh.triangles], axis=1)]
    edges = {(int(a), int(b)) for a, b in np.concatenate([np.roll(base, -k, axis=1)[:, :2] for k in range(3)])}
    successor = {b: a for a, b in edges if (b, a) not in edges}
    rings: list[list[int]] = []
    while successor:
        ring = [next(iter(successor))]
        while (corner := successor.pop(ring[-1], None)) is not None:
            ring.append(corner)
        rings.append(ring)
    z: ComplexArray = mesh.corners[:, 0] + 1j * mesh.corners[:, 1]
    outer = z[max(rings, key=lambda ring: float(np.max(np.abs(z[ring]))))]
    share = np.linspace(0.0, 1.0, _POINTS_PER_CHORD)
    return outer[:-1, np.newaxis] + np.diff(outer)[:, np.newaxis] * share


def open_edges(mesh: Mesh) -> int:
    """Number of edges without exactly two consistently oriented triangles; 0 for a closed mesh."""
    directed = np.concatenate([np.roll(mesh.triangles, -k, axis=1)[:, :2] for k in range(3)])
    _, repeats = np.unique(directed, axis=0, return_counts=True)
    edges = {(int(a), int(b)) for a, b in directed}
    return int(np.sum(repeats - 1)) + sum((b, a) not in edges for a, b in edges)


def write_closed_mesh(mesh: Mesh, name: str, path: Path, kind: str) -> Mesh:
    """Write a mesh and read it back. Raises ``LibraryMissing``, or ``ExportError`` if it is then open."""
    library = lib3mf()
    write_mesh(library, mesh, name, path, kind)
    back = read_mesh(library, path, kind)
    if gaps := open_edges(back):
        raise read_back_error("mesh", path, f"read back with {gaps} open edges")
    return back


def _triangulated(rings: list[ComplexArray], flat: ComplexArray) -> IntArray:
    """Counterclockwise triangles between the rings as corner indices, without added corners."""
    import shapely

    xy = [np.stack([ring.real, ring.imag], axis=-1) for ring in rings]
    parts = shapely.constrained_delaunay_triangles(shapely.Polygon(xy[0], xy[1:]))
    triangles = shapely.get_coordinates(shapely.orient_polygons(shapely.get_parts(parts))).reshape(-1, 4, 2)[:, :3]
    found = triangles[..., 0] + 1j * triangles[..., 1]
    order = np.argsort(flat)
    which: IntArray = order[np.searchsorted(flat, found, sorter=order)]
    return which


@dataclass(frozen=True)
class MeshExporter(SingleFileExporter[ProfileSource]):
    """Writes ``disc.3mf`` or ``disc.stl``: one closed mesh in millimetres."""

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write and read back; the deviation is from the tooth with the printer's offset, chords included.

        Raises ``LibraryMissing``, or ``ExportError`` if the mesh read back is open or the offset undercuts.
        """
        settings = source.spec.export.print
        outline = printed(source.outline, print_offsets(source.spec))
        mesh = extruded(outline, source.drive.disc_width, settings.chord_um * UM)
        back = write_closed_mesh(mesh, source.spec.name, path, self.format)
        found = deviation_both_ways(outline.profile, tooth_chords(back))
        rounding = 2.0 * _EPSILON * outline.tip_radius
        entities = {"triangles": len(back.triangles), "corners": len(back.corners), "open_edges": 0}
        return self.measured(settings.chord_um * UM + rounding, found, "lib3mf", entities)


def print_offsets(spec: Spec) -> PrintOffsets:
    """The offsets of ``[export.print]``."""
    settings = spec.export.print
    return PrintOffsets(settings.flank_offset_um * UM, settings.hole_offset_um * UM, settings.seat_offset_um * UM)


def printed(outline: DiscOutline, offsets: PrintOffsets) -> DiscOutline:
    """The outline with tooth and openings set back by the offsets of flanks and holes, exact.

    Raises ``ExportError`` for an undercut tooth, or an opening whose corners do not take the offset.
    """
    outline = replace(outline, contours=tuple(enlarged(contour, offsets.hole) for contour in outline.contours))
    offset = offsets.flank
    if offset == 0.0:
        return outline
    try:
        return replace(outline, profile=modify(outline.profile, Equidistant(offset)))
    except GeometryError as error:
        raise ExportError(
            "export.print.flank_offset_um", f"{offset / UM:g}", f"is too much ({error})", "take a smaller offset"
        ) from None


def enlarged(contour: Contour, offset: float) -> Contour:
    """An opening with ``offset`` removed all round, exact; negative adds material [mm].

    Raises ``ExportError`` where an arc of the opening is smaller than the offset.
    """
    if offset == 0.0:
        return contour
    arc, chain = contour.full_circle_arc, chain_of(contour)
    if arc is not None and arc.radius + offset > 0.0:
        return circular_contour(contour.name, arc.centre, arc.radius + offset)
    # The opening lies to the left of its contour, the material to the right.
    moved = offset_left(chain.reversed(), offset).reversed() if offset > 0.0 else offset_left(chain, -offset)
    segments: list[Line | Arc] = []
    for start, end, curvature, centre in zip(
        moved.ends[:-1].tolist(), moved.ends[1:].tolist(), moved.curvature.tolist(), moved.centres.tolist(), strict=True
    ):
        if curvature == 0.0:
            segments.append(Line(start, end))
        else:
            sweep = cmath.phase((end - centre) / (start - centre))
            first = cmath.phase(start - centre)
            segments.append(Arc(centre, 1.0 / abs(curvature), first, first + sweep))
    return Contour(contour.name, tuple(segments))


def write_mesh(library: Any, mesh: Mesh, name: str, path: Path, kind: str) -> None:
    """Write one body of the given ``name``; ``kind`` is "3mf" or "stl"."""
    wrapper = library.get_wrapper()
    model = wrapper.CreateModel()
    model.SetUnit(library.ModelUnit.MilliMeter)
    body = model.AddMeshObject()
    body.SetName(name)
    corner, triangle = ctypes.c_float * 3, ctypes.c_uint32 * 3
    body.SetGeometry(
        [library.Position(corner(*row)) for row in mesh.corners.tolist()],
        [library.Triangle(triangle(*row)) for row in mesh.triangles.tolist()],
    )
    item = model.AddBuildItem(body, wrapper.GetIdentityTransform())
    # Fixed, because the library draws them at random: equal input must give equal bytes.
    body.SetUUID(_uuid("body"))
    item.SetUUID(_uuid("item"))
    model.SetBuildUUID(_uuid("build"))
    writer = model.QueryWriter(kind)
    writer.SetDecimalPrecision(_DIGITS)
    # The library ends the whole process where it cannot write a file, as on a full disk.
    path.write_bytes(bytes(writer.WriteToBuffer()))


def read_mesh(library: Any, path: Path, kind: str) -> Mesh:
    """The single body in a file. Raises ``ExportError`` if there are more."""
    model = library.get_wrapper().CreateModel()
    model.QueryReader(kind).ReadFromFile(str(path))
    bodies = model.GetMeshObjects()
    if not bodies.MoveNext() or bodies.Count() != 1:
        raise read_back_error("mesh", path, "read back as no single body")
    body = bodies.GetCurrentMeshObject()
    corners = np.array([tuple(corner.Coordinates) for corner in body.GetVertices()], dtype=np.float64)
    triangles = np.array([tuple(triangle.Indices) for triangle in body.GetTriangleIndices()], dtype=np.intp)
    return Mesh(corners, triangles)


def _uuid(part: str) -> str:
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"cycloid_profile/{part}"))
