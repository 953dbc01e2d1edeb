"""DXF R2010: the tooth as one closed polyline of tangent arcs, for controllers that take no splines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.biarc import Arcs, disc_arcs
from cycloid_profile.export.deviation import deviation_both_ways
from cycloid_profile.export.dxf_document import (
    audited,
    draw_reference,
    layer_counts,
    new_document,
    repeatable_bytes,
    save,
)
from cycloid_profile.export.dxf_polyline import add_polyline
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

_POINTS_PER_ARC = 9
_FIT_SHARE = 0.95  # of the tolerance; nodes are placed by measured errors, so that little need be kept back


@dataclass(frozen=True, slots=True)
class ArcDxfExporter:
    """Writes ``profile_arcs.dxf``."""

    format: str = "dxf-arcs"
    filename: str = "profile_arcs.dxf"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, audit and read back. Raises ``ExportError`` if the file does not pass its own audit."""
        tolerance = record.spec.export.chord_tolerance_um * UM
        arcs = disc_arcs(record.profile, _FIT_SHARE * tolerance)
        path = folder / self.filename
        with repeatable_bytes():
            doc = new_document()
            space = doc.modelspace()
            add_polyline(space, arcs.ends[:-1], bulges(arcs))
            draw_reference(space, record, f"ARCS WITHIN {tolerance / UM:g} UM")
            save(doc, path)
        back, entities = read_dxf_arcs(path)
        found = deviation_both_ways(record.profile, back.rows(_POINTS_PER_ARC))
        return (WrittenFile(self.filename, self.format, tolerance, found, "ezdxf, audited", entities),)


def bulges(arcs: Arcs) -> FloatArray:
    """tan(θ/4) of each arc, θ the angle it turns by, positive to the left, shape (n,)."""
    half: FloatArray = np.arcsin(0.5 * arcs.bend * np.abs(np.diff(arcs.ends)))
    return np.tan(0.5 * half)


def read_dxf_arcs(path: Path) -> tuple[Arcs, dict[str, int]]:
    """The closed polyline on layer PROFILE as a chain of arcs, and entity counts by layer.

    Raises
    ------
    ExportError
        If the audit finds an error, or there is not exactly one closed polyline on the layer.
    """
    doc = audited(path)
    found: list[Any] = list(doc.modelspace().query('LWPOLYLINE[layer=="PROFILE"]'))
    if len(found) != 1 or not found[0].closed:
        raise ExportError(
            "DXF file",
            f"'{path.name}'",
            f"read back with {len(found)} profile polylines or an open one",
            "report this as a defect",
            " ",
        )
    x, y, bulge = np.array(found[0].get_points("xyb"), dtype=np.float64).T
    ends = np.append(x + 1j * y, x[0] + 1j * y[0])
    bend = 2.0 * np.sin(2.0 * np.arctan(bulge)) / np.abs(np.diff(ends))
    return Arcs(ends, bend), {**layer_counts(doc), "arcs": len(bulge)}
