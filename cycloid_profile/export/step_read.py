"""A STEP file read back by the kernel: its solids, whether they are sound, and points on their edges."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.errors import ExportError

_CHECKS_PER_SPAN = 9


def read_shape(path: Path) -> Any:
    """The one shape of a STEP file, in mm. Raises ``ExportError`` if the kernel cannot read it."""
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise ExportError("STEP file", f"'{path.name}'", "cannot be read back", "report this as a defect", " ")
    reader.TransferRoots()
    return reader.OneShape()


def sound_solids(shape: Any, path: Path, count: int) -> list[Any]:
    """The solids of a shape; raises ``ExportError`` unless there are ``count``, each valid and closed."""
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_ShapeEnum

    solids = _parts(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    sound = [BRepCheck_Analyzer(solid).IsValid() and _closed(solid) for solid in solids]
    if len(solids) != count or not all(sound):
        raise ExportError(
            "STEP file",
            f"'{path.name}'",
            f"read back with {sum(sound)} valid closed solids of {count}",
            "report this as a defect",
            " ",
        )
    return solids


def top_edges(solid: Any) -> tuple[list[Any], int, int]:
    """Edges round the highest face of an extruded solid in order, its inner wires and all faces counted."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib
    from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_ShapeEnum
    from OCP.TopoDS import TopoDS

    def lowest(face: Any) -> float:
        box = Bnd_Box()
        BRepBndLib.Add_s(face, box)
        return float(box.CornerMin().Z())

    faces = _parts(solid, TopAbs_ShapeEnum.TopAbs_FACE)
    top = max(faces, key=lowest)
    edges = []
    explorer = BRepTools_WireExplorer(BRepTools.OuterWire_s(TopoDS.Face(top)))
    while explorer.More():
        edges.append(explorer.Current())
        explorer.Next()
    return edges, len(_parts(top, TopAbs_ShapeEnum.TopAbs_WIRE)) - 1, len(faces)


def points_on(edges: list[Any]) -> ComplexArray:
    """Points along every knot span of spline edges, by the kernel's own evaluation; shape (spans, points) [mm]."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve

    rows = []
    for edge in edges:
        adaptor = BRepAdaptor_Curve(edge)
        curve = adaptor.BSpline()
        knots = [curve.Knot(i) for i in range(1, curve.NbKnots() + 1)]
        for low, high in itertools.pairwise(knots):
            at = np.linspace(low, high, _CHECKS_PER_SPAN).tolist()
            rows.append([complex(point.X(), point.Y()) for point in map(adaptor.Value, at)])
    return np.array(rows)


def _parts(shape: Any, kind: Any) -> list[Any]:
    from OCP.TopExp import TopExp_Explorer

    found = []
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found


def _closed(solid: Any) -> bool:
    """Whether every edge of the solid has a face on either side."""
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_ShapeEnum

    return all(BRep_Tool.IsClosed_s(shell) for shell in _parts(solid, TopAbs_ShapeEnum.TopAbs_SHELL))
