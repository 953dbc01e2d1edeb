"""3MF and STL for 3D printers: the disc in chords, its flanks set back for what a printer puts on too much."""

from __future__ import annotations

import ctypes
import uuid
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError, GeometryError
from cycloid_profile.export.deviation import deviation_both_ways
from cycloid_profile.export.libraries import lib3mf
from cycloid_profile.export.mesh import Mesh, extruded, open_edges, tooth_chords
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.modification.setup import Equidistant, modify
from cycloid_profile.units import UM

# Both formats hold coordinates of 24 bits: half a unit in x and in y at this radius [mm] is the rounding.
_EPSILON = 2.0**-24
_DIGITS = 9


@dataclass(frozen=True, slots=True)
class MeshExporter:
    """Writes ``disc.3mf`` or ``disc.stl``: one closed mesh in millimetres."""

    format: str
    filename: str

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back; the deviation is from the tooth with the printer's offset, chords included.

        Raises ``LibraryMissing``, or ``ExportError`` if the mesh read back is open or the offset undercuts.
        """
        library = lib3mf()
        wanted = record.spec.export.print
        outline = printed(record.outline, wanted.flank_offset_um * UM)
        mesh = extruded(outline, record.drive.disc_width, wanted.chord_um * UM)
        path = folder / self.filename
        _write(library, mesh, plain_name(record.spec.name), path, self.format)
        back = _read(library, path, self.format)
        if left := open_edges(back):
            raise ExportError(
                "mesh", f"'{self.filename}'", f"read back with {left} open edges", "report this as a defect", " "
            )
        found = deviation_both_ways(outline.profile, tooth_chords(back))
        rounding = 2.0 * _EPSILON * outline.tip_radius
        entities = {"triangles": len(back.triangles), "corners": len(back.corners), "open_edges": left}
        return (WrittenFile(self.filename, self.format, wanted.chord_um * UM + rounding, found, "lib3mf", entities),)


def printed(outline: DiscOutline, offset: float) -> DiscOutline:
    """The outline with ``offset`` [mm] taken off the tooth all round, exactly.

    Raises ``ExportError`` if that would undercut the tooth.
    """
    if offset == 0.0:
        return outline
    try:
        return replace(outline, profile=modify(outline.profile, Equidistant(offset)))
    except GeometryError as error:
        raise ExportError(
            "export.print.flank_offset_um", f"{offset / UM:g}", f"is too much ({error})", "take a smaller offset"
        ) from None


def _write(library: Any, mesh: Mesh, name: str, path: Path, kind: str) -> None:
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
    # Random numbers otherwise: equal input must give equal bytes.
    body.SetUUID(_uuid("body"))
    item.SetUUID(_uuid("item"))
    model.SetBuildUUID(_uuid("build"))
    writer = model.QueryWriter(kind)
    writer.SetDecimalPrecision(_DIGITS)
    writer.WriteToFile(str(path))


def _read(library: Any, path: Path, kind: str) -> Mesh:
    model = library.get_wrapper().CreateModel()
    model.QueryReader(kind).ReadFromFile(str(path))
    bodies = model.GetMeshObjects()
    if not bodies.MoveNext() or bodies.Count() != 1:
        raise ExportError("mesh", f"'{path.name}'", "read back as no single body", "report this as a defect", " ")
    body = bodies.GetCurrentMeshObject()
    corners = np.array([tuple(corner.Coordinates) for corner in body.GetVertices()], dtype=np.float64)
    triangles = np.array([tuple(triangle.Indices) for triangle in body.GetTriangleIndices()], dtype=np.intp)
    return Mesh(corners, triangles)


def _uuid(part: str) -> str:
    return str(uuid.uuid5(uuid.NAMESPACE_URL, f"cycloid_profile/{part}"))
