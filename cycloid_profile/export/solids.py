"""Exact plates of the CAD kernel: closed chains of splines, lines and arcs, extruded along z."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from cycloid_profile.export.spline import SplinePiece
from cycloid_profile.geometry.contour import Arc, Contour, Line

Segment = SplinePiece | Line | Arc


def plate(edge: tuple[SplinePiece, ...] | Contour, openings: Iterable[Contour], low: float, high: float) -> Any:
    """A plate between the heights ``low`` and ``high`` [mm] with ``openings``.

    ``edge`` is a closed contour, or the splines of a tooth curve in their order, which runs clockwise. Every
    segment becomes one edge of its own exact curve, and neighbours share their corner.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.gp import gp_Dir, gp_Pln, gp_Pnt, gp_Vec

    plane = gp_Pln(gp_Pnt(0.0, 0.0, low), gp_Dir(0.0, 0.0, 1.0))
    outer = _wire(edge.segments, low) if isinstance(edge, Contour) else _reversed(_wire(edge, low))
    made = BRepBuilderAPI_MakeFace(plane, outer, False)
    for opening in openings:
        made.Add(_reversed(_wire(opening.segments, low)))
    return BRepPrimAPI_MakePrism(made.Face(), gp_Vec(0.0, 0.0, high - low)).Shape()


def joined_solid(bodies: Sequence[Any]) -> Any:
    """Bodies that touch or overlap as one."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    whole = bodies[0]
    for body in bodies[1:]:
        whole = BRepAlgoAPI_Fuse(whole, body).Shape()
    return whole


def _wire(segments: Sequence[Segment], z: float) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Pnt

    starts = [_start(segment) for segment in segments]
    corners = [BRepBuilderAPI_MakeVertex(gp_Pnt(p.real, p.imag, z)).Vertex() for p in starts]
    made = BRepBuilderAPI_MakeWire()
    for i, segment in enumerate(segments):
        made.Add(_edge(segment, z, corners[i], corners[(i + 1) % len(corners)]))
    return made.Wire()


def _reversed(wire: Any) -> Any:
    from OCP.TopoDS import TopoDS

    return TopoDS.Wire(wire.Reversed())


def _start(segment: Segment) -> complex:
    return complex(segment.control_points[0]) if isinstance(segment, SplinePiece) else segment.start


def _edge(segment: Segment, z: float, start: Any, end: Any) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
    from OCP.gp import gp_Ax2, gp_Circ, gp_Dir, gp_Pnt

    if isinstance(segment, SplinePiece):
        return BRepBuilderAPI_MakeEdge(_bspline(segment, z), start, end).Edge()
    if isinstance(segment, Line):
        return BRepBuilderAPI_MakeEdge(start, end).Edge()
    centre = gp_Pnt(segment.centre.real, segment.centre.imag, z)
    # A clockwise arc is a counterclockwise one about the axis that points down.
    axis = gp_Ax2(centre, gp_Dir(0.0, 0.0, 1.0 if segment.turn > 0.0 else -1.0), gp_Dir(1.0, 0.0, 0.0))
    return BRepBuilderAPI_MakeEdge(gp_Circ(axis, segment.radius), start, end).Edge()


def _bspline(piece: SplinePiece, z: float) -> Any:
    """The piece as it is: no fitting by the kernel."""
    from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
    from OCP.Geom import Geom_BSplineCurve
    from OCP.gp import gp_Pnt

    knots, multiplicities = np.unique(piece.knots, return_counts=True)
    poles = Array1_gp_Pnt(1, len(piece.control_points))
    for i, pole in enumerate(piece.control_points.tolist(), start=1):
        poles.SetValue(i, gp_Pnt(pole.real, pole.imag, z))
    knot_array, multiplicity_array = Array1_double(1, len(knots)), Array1_int(1, len(knots))
    for i, (knot, multiplicity) in enumerate(zip(knots.tolist(), multiplicities.tolist(), strict=True), start=1):
        knot_array.SetValue(i, knot)
        multiplicity_array.SetValue(i, multiplicity)
    return Geom_BSplineCurve(poles, knot_array, multiplicity_array, piece.degree)
