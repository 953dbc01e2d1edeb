"""STEP: the disc as a solid, tooth flanks as quintic splines, with bore and holes."""

from __future__ import annotations

import cmath
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import deviation
from cycloid_profile.export.refine import FIT_SHARE
from cycloid_profile.export.spline import SplinePiece, disc_splines
from cycloid_profile.export.text import plain_name
from cycloid_profile.export.written import WrittenFile
from cycloid_profile.geometry.contour import Contour, Line
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.units import UM

_DEGREE = 5
_TIMESTAMP = "2000-01-01T00:00:00"  # fixed, so that equal input gives equal bytes
_CHECKS_PER_EDGE = 60


class CadKernelMissing(ExportError):  # noqa: N818 - a state of the machine, told in one sentence
    """The CAD kernel cannot be imported; everything but STEP works without it."""


@dataclass(frozen=True, slots=True)
class StepExporter:
    """Writes ``disc.step``."""

    format: str = "step"
    filename: str = "disc.step"

    @property
    def filenames(self) -> tuple[str, ...]:
        """See ``Exporter.filenames``."""
        return (self.filename,)

    def write(self, record: DesignRecord, folder: Path) -> tuple[WrittenFile, ...]:
        """Write and read back.

        Raises ``CadKernelMissing``, or ``ExportError`` if the solid read back is not valid and closed.
        """
        cad = _cad_kernel()
        tolerance = record.spec.export.chord_tolerance_um * UM
        pieces = disc_splines(record.profile, _DEGREE, FIT_SHARE * tolerance)
        solid = _solid(cad, record.outline, pieces, record.drive.disc_width)
        solid.label = plain_name(record.spec.name)
        path = folder / self.filename
        cad.export_step(solid, path, write_pcurves=False, timestamp=_TIMESTAMP)
        return (self._read_back(cad, record, path, tolerance),)

    def _read_back(self, cad: Any, record: DesignRecord, path: Path, tolerance: float) -> WrittenFile:
        solids = cad.import_step(path).solids()
        if len(solids) != 1 or not solids[0].is_valid or not solids[0].is_manifold:
            raise ExportError(
                "STEP file", f"'{path.name}'", "read back as no valid closed solid", "report this as a defect", " "
            )
        top = max(solids[0].faces(), key=lambda face: face.center().Z)
        edges = top.outer_wire().edges()
        return WrittenFile(
            self.filename,
            self.format,
            tolerance,
            deviation(record.profile, _points_on(edges)),
            "OpenCascade, valid closed solid",
            {"solids": 1, "faces": len(solids[0].faces()), "tooth_edges": len(edges), "holes": len(top.inner_wires())},
        )


def _cad_kernel() -> Any:
    """build123d, imported here and nowhere else: it takes seconds and needs system libraries."""
    try:
        import build123d
    except ImportError as error:
        library = "libGL" in str(error) or ".so" in str(error)
        remedy = (
            "install the system libraries libGL, libX11 and libexpat (Debian: apt install libgl1 libx11-6 libexpat1)"
            if library
            else "install it with 'pip install build123d'"
        )
        raise CadKernelMissing(
            "STEP export", "needs build123d", f"which cannot be imported ({error})", remedy, " "
        ) from None
    return build123d


def _solid(cad: Any, outline: DiscOutline, pieces: tuple[SplinePiece, ...], width: float) -> Any:
    teeth = cad.Wire([_edge(cad, piece) for piece in pieces])
    holes = [_contour_wire(cad, contour) for contour in outline.contours]
    return cad.Solid.extrude(cad.Face(teeth, holes), cad.Vector(0.0, 0.0, width))


def _contour_wire(cad: Any, contour: Contour) -> Any:
    """An opening's lines and arcs as exact edges; a circle is one edge."""
    edges = []
    for segment in contour.segments:
        if isinstance(segment, Line):
            edges.append(cad.Edge.make_line(_vector(cad, segment.start), _vector(cad, segment.end)))
        elif segment.whole:
            edges.append(cad.Edge.make_circle(segment.radius, cad.Plane(_vector(cad, segment.centre))))
        else:
            middle = segment.centre + cmath.rect(segment.radius, 0.5 * (segment.from_angle + segment.to_angle))
            ends = (segment.start, middle, segment.end)
            edges.append(cad.Edge.make_three_point_arc(*(_vector(cad, point) for point in ends)))
    return cad.Wire(edges)


def _vector(cad: Any, point: complex) -> Any:
    return cad.Vector(point.real, point.imag, 0.0)


def _edge(cad: Any, piece: SplinePiece) -> Any:
    """The piece as an exact B-spline edge: build123d itself only fits through points."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

    try:  # names since OCP 8
        from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
    except ImportError:
        from OCP.TColgp import TColgp_Array1OfPnt as Array1_gp_Pnt
        from OCP.TColStd import TColStd_Array1OfInteger as Array1_int
        from OCP.TColStd import TColStd_Array1OfReal as Array1_double

    knots, multiplicities = np.unique(piece.knots, return_counts=True)
    poles = Array1_gp_Pnt(1, len(piece.control_points))
    for i, pole in enumerate(piece.control_points.tolist(), start=1):
        poles.SetValue(i, gp_Pnt(pole.real, pole.imag, 0.0))
    knot_array, multiplicity_array = Array1_double(1, len(knots)), Array1_int(1, len(knots))
    for i, (knot, multiplicity) in enumerate(zip(knots.tolist(), multiplicities.tolist(), strict=True), start=1):
        knot_array.SetValue(i, knot)
        multiplicity_array.SetValue(i, multiplicity)
    curve = Geom_BSplineCurve(poles, knot_array, multiplicity_array, piece.degree)
    return cad.Edge(BRepBuilderAPI_MakeEdge(curve).Edge())


def _points_on(edges: Any) -> ComplexArray:
    """Points along the edges by the kernel's own evaluation."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    points: list[complex] = []
    for edge in edges:
        curve = BRepAdaptor_Curve(edge.wrapped)
        first, last = curve.FirstParameter(), curve.LastParameter()
        for i in range(_CHECKS_PER_EDGE):
            point = curve.Value(first + (last - first) * (i + 0.5) / _CHECKS_PER_EDGE)
            points.append(complex(point.X(), point.Y()))
    return np.array(points)
