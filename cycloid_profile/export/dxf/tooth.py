"""DXF R2010 of the disc: the tooth as cubic splines, as one polyline of tangent arcs, or as the cutter's path."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.export.cad import plate_measures
from cycloid_profile.export.curves import (
    Arcs,
    Deviation,
    ProfileSource,
    SplinePiece,
    chain_of,
    deviation_both_ways,
    disc_arcs,
    distances,
    fitted_splines,
    offset_left,
)
from cycloid_profile.export.curves import joined as joined_spline
from cycloid_profile.export.dxf.document import add_polyline, audited, draw_notes, draw_reference, layer_counts, new_dxf
from cycloid_profile.export.writing import SingleFileExporter, WrittenFile, read_back_error
from cycloid_profile.units import UM

_DEGREE = 3  # LibreCAD draws no higher degree
_POINTS_PER_SPAN, _POINTS_PER_ARC = 7, 9  # measured when the file is read back
_ARC_FIT_SHARE = 0.95  # of the tolerance; measured errors place the nodes of arcs, which needs little reserve


@dataclass(frozen=True)
class DxfExporter(SingleFileExporter[ProfileSource]):
    """Writes ``profile.dxf``: each flank as one cubic spline from control vertices, or all joined to one."""

    format: str = "dxf"
    filename: str = "profile.dxf"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write, audit and read back. Raises ``ExportError`` if the file fails its audit."""
        tolerance = source.spec.export.chord_tolerance
        splines = fitted_splines(source, _DEGREE)
        with new_dxf(path) as space:
            for spline in splines if source.spec.export.dxf.tooth == "flanks" else (joined_spline(splines),):
                add_spline(space, spline)
            draw_reference(space, source, f"SPLINE WITHIN {tolerance / UM:g} UM")
        back, entities = read_dxf_splines(path)
        found = deviation_both_ways(source.profile, _spans(back))
        file = self.measured(tolerance, found, "ezdxf, audited", entities)
        return replace(file, measures=plate_measures(source, back))


@dataclass(frozen=True)
class ArcDxfExporter(SingleFileExporter[ProfileSource]):
    """Writes ``profile_arcs.dxf``: the tooth as tangent arcs, for controls without splines."""

    format: str = "dxf-arcs"
    filename: str = "profile_arcs.dxf"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write, audit and read back. Raises ``ExportError`` if the file fails its audit."""
        tolerance = source.spec.export.chord_tolerance
        arcs = disc_arcs(source.profile, _ARC_FIT_SHARE * tolerance)
        with new_dxf(path) as space:
            add_polyline(space, arcs.ends[:-1], np.tan(0.5 * arcs.half_sweeps))
            draw_reference(space, source, f"ARCS WITHIN {tolerance / UM:g} UM")
        back, entities = read_dxf_arcs(path)
        found = deviation_both_ways(source.profile, back.rows(_POINTS_PER_ARC))
        return self.measured(tolerance, found, "ezdxf, audited", entities)


@dataclass(frozen=True)
class OffsetDxfExporter(SingleFileExporter[ProfileSource]):
    """Writes ``profile_offset.dxf``: the centre of a cutter round openings and teeth, as tangent arcs and lines."""

    format: str = "dxf-offset"
    filename: str = "profile_offset.dxf"

    def write_file(self, source: ProfileSource, path: Path) -> WrittenFile:
        """Write, audit and read back; the deviation is the error of the centre's distance from the tooth.

        Raises ``ExportError`` if the cutter does not fit into a root or a corner.
        """
        tolerance = source.spec.export.chord_tolerance
        offset = cutter_offset(source)
        # The outside of the teeth, which run clockwise, and the inside of the openings lie to the left.
        paths = {
            "PROFILE": [offset_left(disc_arcs(source.profile, _ARC_FIT_SHARE * tolerance), offset)],
            "HOLES": [offset_left(chain_of(contour), offset) for contour in source.outline.contours],
        }
        with new_dxf(path) as space:
            for layer, chains in paths.items():
                for chain in chains:
                    add_polyline(space, chain.ends[:-1], np.tan(0.5 * chain.half_sweeps), layer)
            draw_notes(space, source, f"CUTTER CENTRE {offset:.7g} FROM THE OUTLINE, WITHIN {tolerance / UM:g} UM")
        back, entities = read_dxf_arcs(path)
        points = back.points(_POINTS_PER_ARC)
        found = Deviation.of(points, distances(source.profile, points) - offset)
        return self.measured(tolerance, found, "ezdxf, audited", entities)


def cutter_offset(record: ProfileSource) -> float:
    """From the outline to the cutter's centre [mm]: as given, or wire radius and spark gap."""
    given, wire = record.spec.export.dxf.offset_mm, record.spec.export.wire
    return 0.5 * wire.wire_diameter_mm + wire.spark_gap_um * UM if given is None else given


def add_spline(space: Any, curve: SplinePiece, layer: str = "PROFILE") -> None:
    """The curve by its control vertices and knots: fit points are drawn differently by every reader."""
    spline = space.add_spline(degree=curve.degree, dxfattribs={"layer": layer})
    # The closed flag stays off although the curve closes: several readers drop flagged splines.
    spline.control_points = [(p.real, p.imag, 0.0) for p in curve.control_points.tolist()]
    spline.knots = curve.knots.tolist()


def read_dxf_profile(path: Path) -> tuple[ComplexArray, dict[str, int]]:
    """Points along every span of the splines on layer PROFILE, shape (spans, points) [mm], and entity counts by layer.

    Raises ``ExportError`` as ``read_dxf_splines`` does.
    """
    splines, entities = read_dxf_splines(path)
    return _spans(splines), entities


def read_dxf_splines(path: Path) -> tuple[tuple[SplinePiece, ...], dict[str, int]]:
    """The splines on layer PROFILE in the order of the file, and entity counts by layer.

    Raises ``ExportError`` if the audit finds an error, or a spline does not start exactly at the end of the previous.
    """
    doc = audited(path)
    splines = tuple(
        SplinePiece(entity.dxf.degree, np.array(entity.knots), np.array(entity.control_points) @ np.array([1.0, 1j, 0]))
        for entity in doc.modelspace().query('SPLINE[layer=="PROFILE"]')
    )
    if not splines:
        raise read_back_error("DXF file", path, "read back without a profile curve")
    ends = [splines[-1].control_points[-1], *(piece.control_points[-1] for piece in splines[:-1])]
    if any(piece.control_points[0] != end for piece, end in zip(splines, ends, strict=True)):
        raise read_back_error("DXF curve", path, "does not close")
    return splines, {**layer_counts(doc), "control_points": sum(piece.control_points.size for piece in splines)}


def _spans(splines: tuple[SplinePiece, ...]) -> ComplexArray:
    rows = []
    for piece in splines:
        edges = np.unique(piece.knots)
        rows.append(piece.at(np.linspace(edges[:-1], edges[1:], _POINTS_PER_SPAN, axis=-1)))
    return np.concatenate(rows)


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
