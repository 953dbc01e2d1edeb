"""DXF R2010 of the disc: the tooth as one cubic spline, or as one polyline of tangent arcs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design import DesignRecord
from cycloid_profile.export.curves import FIT_SHARE, Arcs, SplinePiece, deviation_both_ways, disc_arcs, disc_splines
from cycloid_profile.export.curves import joined as joined_spline
from cycloid_profile.export.dxf.document import add_polyline, audited, draw_reference, layer_counts, new_dxf
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, read_back_error
from cycloid_profile.units import UM

_DEGREE = 3  # LibreCAD draws no higher degree
_POINTS_PER_SPAN, _POINTS_PER_ARC = 7, 9  # measured when the file is read back
_CLOSED = 1e-9  # mm
_ARC_FIT_SHARE = 0.95  # of the tolerance; measured errors place the nodes of arcs, which needs little reserve


@dataclass(frozen=True)
class DxfExporter(SingleFileExporter[DesignRecord]):
    """Writes ``profile.dxf``: the tooth as one cubic spline from control vertices."""

    format: str = "dxf"
    filename: str = "profile.dxf"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """Write, audit and read back. Raises ``ExportError`` if the file fails its audit."""
        tolerance = source.spec.export.chord_tolerance_um * UM
        curve = joined_spline(disc_splines(source.profile, _DEGREE, FIT_SHARE * tolerance))
        with new_dxf(path) as space:
            add_spline(space, curve)
            draw_reference(space, source, f"SPLINE WITHIN {tolerance / UM:g} UM")
        spans, entities = read_dxf_profile(path)
        return self.measured(tolerance, deviation_both_ways(source.profile, spans), "ezdxf, audited", entities)


@dataclass(frozen=True)
class ArcDxfExporter(SingleFileExporter[DesignRecord]):
    """Writes ``profile_arcs.dxf``: the tooth as tangent arcs, for controls without splines."""

    format: str = "dxf-arcs"
    filename: str = "profile_arcs.dxf"

    def write_file(self, source: DesignRecord, path: Path) -> WrittenFile:
        """Write, audit and read back. Raises ``ExportError`` if the file fails its audit."""
        tolerance = source.spec.export.chord_tolerance_um * UM
        arcs = disc_arcs(source.profile, _ARC_FIT_SHARE * tolerance)
        with new_dxf(path) as space:
            add_polyline(space, arcs.ends[:-1], np.tan(0.5 * arcs.half_sweeps))
            draw_reference(space, source, f"ARCS WITHIN {tolerance / UM:g} UM")
        back, entities = read_dxf_arcs(path)
        found = deviation_both_ways(source.profile, back.rows(_POINTS_PER_ARC))
        return self.measured(tolerance, found, "ezdxf, audited", entities)


def add_spline(space: Any, curve: SplinePiece, layer: str = "PROFILE") -> None:
    """The curve by its control vertices and knots: fit points are drawn differently by every reader."""
    spline = space.add_spline(degree=curve.degree, dxfattribs={"layer": layer})
    # The closed flag stays off although the curve closes: several readers drop flagged splines.
    spline.control_points = [(p.real, p.imag, 0.0) for p in curve.control_points.tolist()]
    spline.knots = curve.knots.tolist()


def read_dxf_profile(path: Path) -> tuple[ComplexArray, dict[str, int]]:
    """Points along every span of the spline on layer PROFILE, shape (spans, points) [mm], and entity counts by layer.

    Raises ``ExportError`` if the audit finds an error, or there is not exactly one closed curve on the layer.
    """
    doc = audited(path)
    splines: list[Any] = list(doc.modelspace().query('SPLINE[layer=="PROFILE"]'))
    if len(splines) != 1:
        raise read_back_error("DXF file", path, f"read back with {len(splines)} profile curves")
    tool = splines[0].construction_tool()
    edges = np.unique(np.array(tool.knots()))
    parameters = np.linspace(edges[:-1], edges[1:], _POINTS_PER_SPAN, axis=-1)
    xyz = np.array([tuple(point) for point in tool.points(parameters.ravel().tolist())])
    spans: ComplexArray = (xyz[:, 0] + 1j * xyz[:, 1]).reshape(parameters.shape)
    if abs(spans[-1, -1] - spans[0, 0]) > _CLOSED:
        raise read_back_error("DXF curve", path, "does not close")
    return spans, {**layer_counts(doc), "control_points": len(splines[0].control_points)}


def read_dxf_arcs(path: Path) -> tuple[Arcs, dict[str, int]]:
    """The closed polyline on layer PROFILE as a chain of arcs, and entity counts by layer.

    Raises ``ExportError`` if the audit finds an error, or there is not exactly one closed polyline on the layer.
    """
    doc = audited(path)
    found: list[Any] = list(doc.modelspace().query('LWPOLYLINE[layer=="PROFILE"]'))
    if len(found) != 1 or not found[0].closed:
        raise read_back_error("DXF file", path, f"read back with {len(found)} profile polylines or an open one")
    x, y, bulge = np.array(found[0].get_points("xyb"), dtype=np.float64).T
    ends = np.append(x + 1j * y, x[0] + 1j * y[0])
    curvature = 2.0 * np.sin(2.0 * np.arctan(bulge)) / np.abs(np.diff(ends))
    return Arcs(ends, curvature), {**layer_counts(doc), "arcs": len(bulge)}
