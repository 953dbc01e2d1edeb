"""DXF R2010: the tooth as one cubic spline from control vertices, openings and reference lines on layers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import deviation_both_ways
from cycloid_profile.export.dxf_document import (
    audited,
    draw_reference,
    layer_counts,
    new_document,
    repeatable_bytes,
    save,
)
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.spline import SplinePiece, disc_splines, joined
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.units import UM

_DEGREE = 3  # LibreCAD draws no higher degree
_POINTS_PER_SPAN = 7
_CLOSED = 1e-9  # mm


@dataclass(frozen=True, slots=True)
class DxfExporter:
    """Writes ``profile.dxf``."""

    format: str = "dxf"
    filename: str = "profile.dxf"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write, audit and read back. Raises ``ExportError`` if the file does not pass its own audit."""
        tolerance = record.spec.export.chord_tolerance_um * UM
        curve = joined(disc_splines(record.profile, _DEGREE, FIT_SHARE * tolerance))
        path = folder / self.filename
        with repeatable_bytes():
            doc = new_document()
            space = doc.modelspace()
            add_spline(space, curve)
            draw_reference(space, record, f"SPLINE WITHIN {tolerance / UM:g} UM")
            save(doc, path)
        spans, entities = read_dxf_profile(path)
        found = deviation_both_ways(record.profile, spans)
        return (WrittenFile(self.filename, self.format, tolerance, found, "ezdxf, audited", entities),)


def add_spline(space: Any, curve: SplinePiece, layer: str = "PROFILE") -> None:
    """The curve by its control vertices and knots: fit points are drawn differently by every reader."""
    spline = space.add_spline(degree=curve.degree, dxfattribs={"layer": layer})
    # The closed flag stays off although the curve closes: several readers drop flagged splines.
    spline.control_points = [(p.real, p.imag, 0.0) for p in curve.control_points.tolist()]
    spline.knots = curve.knots.tolist()


def read_dxf_profile(path: Path) -> tuple[ComplexArray, dict[str, int]]:
    """Points along every span of the spline on layer PROFILE, shape (spans, points) [mm], and entity counts by layer.

    Raises
    ------
    ExportError
        If the audit finds an error, or there is not exactly one closed curve on the layer.
    """
    doc = audited(path)
    splines: list[Any] = list(doc.modelspace().query('SPLINE[layer=="PROFILE"]'))
    if len(splines) != 1:
        raise ExportError(
            "DXF file",
            f"'{path.name}'",
            f"read back with {len(splines)} profile curves",
            "report this as a defect",
            " ",
        )
    tool = splines[0].construction_tool()
    edges = np.unique(np.array(tool.knots()))
    parameters = np.linspace(edges[:-1], edges[1:], _POINTS_PER_SPAN, axis=-1)
    xyz = np.array([tuple(point) for point in tool.points(parameters.ravel().tolist())])
    spans: ComplexArray = (xyz[:, 0] + 1j * xyz[:, 1]).reshape(parameters.shape)
    if abs(spans[-1, -1] - spans[0, 0]) > _CLOSED:
        raise ExportError("DXF curve", f"'{path.name}'", "does not close", "report this as a defect", " ")
    return spans, {**layer_counts(doc), "control_points": len(splines[0].control_points)}
