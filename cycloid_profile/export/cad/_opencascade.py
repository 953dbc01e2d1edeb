"""The CAD kernel OpenCascade: exact plates, STEP files of named, coloured parts, and solids read back.

Importing this module loads the kernel; call ``require_cad_kernel`` before.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakeVertex,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pln, gp_Pnt, gp_Trsf, gp_Vec
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Gravity
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_Reader, STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.cad.parts import Part, Placement
from cycloid_profile.export.curves import SplinePiece
from cycloid_profile.export.writing import read_back_error
from cycloid_profile.geometry import Arc, Contour, Line

Segment = SplinePiece | Line | Arc
TIMESTAMP = "2000-01-01T00:00:00"  # fixed, so that equal input gives equal bytes
# Names used by the kernel: AP214 second edition, AP242 of 2014.
SCHEMAS = {"AP214": "AP214IS", "AP242": "AP242DIS"}
# A colour's block of entities: its context, the solid it is of, red, green and blue.
_STYLE = re.compile(
    r"(PRESENTATION_REPRESENTATION\('',\(\s*#\d+\),\s*#)(\d+)(\);\s*#\d+ = STYLED_ITEM\('color',\(#\d+\),\s*#)(\d+)"
    r"(\);(?:(?!STYLED_ITEM).)*?COLOUR_RGB\()([^)]*)",
    re.DOTALL,
)
_OCCURRENCE = re.compile(r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(\s*)'\d+'")
_CHECKS_PER_SPAN = 9  # more than the extremes of the error of a cubic span


def plate(edge: tuple[SplinePiece, ...] | Contour, openings: Iterable[Contour], low: float, high: float) -> Any:
    """A plate between the heights ``low`` and ``high`` [mm] with ``openings``.

    ``edge`` is a closed contour, or the splines of a tooth curve in their clockwise order. Every segment becomes one
    exact edge, and neighbouring edges share a vertex.
    """
    plane = gp_Pln(gp_Pnt(0.0, 0.0, low), gp_Dir(0.0, 0.0, 1.0))
    outer = _wire(edge.segments, low) if isinstance(edge, Contour) else _reversed(_wire(edge, low))
    face = BRepBuilderAPI_MakeFace(plane, outer, False)
    for opening in openings:
        face.Add(_reversed(_wire(opening.segments, low)))
    return BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0.0, 0.0, high - low)).Shape()


def joined_solid(bodies: Sequence[Any]) -> Any:
    """The union of bodies that touch or overlap."""
    whole = bodies[0]
    for body in bodies[1:]:
        whole = BRepAlgoAPI_Fuse(whole, body).Shape()
    return whole


def _wire(segments: Sequence[Segment], z: float) -> Any:
    starts = [complex(s.control_points[0]) if isinstance(s, SplinePiece) else s.start for s in segments]
    corners = [BRepBuilderAPI_MakeVertex(gp_Pnt(p.real, p.imag, z)).Vertex() for p in starts]
    wire = BRepBuilderAPI_MakeWire()
    for i, segment in enumerate(segments):
        wire.Add(_edge(segment, z, corners[i], corners[(i + 1) % len(corners)]))
    return wire.Wire()


def _reversed(wire: Any) -> Any:
    return TopoDS.Wire(wire.Reversed())


def _edge(segment: Segment, z: float, start: Any, end: Any) -> Any:
    if isinstance(segment, SplinePiece):
        return BRepBuilderAPI_MakeEdge(_bspline(segment, z), start, end).Edge()
    if isinstance(segment, Line):
        return BRepBuilderAPI_MakeEdge(start, end).Edge()
    centre = gp_Pnt(segment.centre.real, segment.centre.imag, z)
    # A clockwise arc is a counterclockwise one about the axis that points down.
    axis = gp_Ax2(centre, gp_Dir(0.0, 0.0, 1.0 if segment.sweep > 0.0 else -1.0), gp_Dir(1.0, 0.0, 0.0))
    return BRepBuilderAPI_MakeEdge(gp_Circ(axis, segment.radius), start, end).Edge()


def _bspline(piece: SplinePiece, z: float) -> Any:
    """The exact spline, without fitting by the kernel."""
    knots, multiplicities = np.unique(piece.knots, return_counts=True)
    poles = Array1_gp_Pnt(1, len(piece.control_points))
    for i, pole in enumerate(piece.control_points.tolist(), start=1):
        poles.SetValue(i, gp_Pnt(pole.real, pole.imag, z))
    knot_array, multiplicity_array = Array1_double(1, len(knots)), Array1_int(1, len(knots))
    for i, (knot, multiplicity) in enumerate(zip(knots.tolist(), multiplicities.tolist(), strict=True), start=1):
        knot_array.SetValue(i, knot)
        multiplicity_array.SetValue(i, multiplicity)
    return Geom_BSplineCurve(poles, knot_array, multiplicity_array, piece.degree)


def write_part(part: Part, path: Path, schema: str) -> None:
    """Write one part without its placements. Raises ``ExportError`` if the kernel cannot."""
    document, shapes = _document()
    _add(document, shapes, part)
    _save(document, path, part.name, schema)


def write_assembly(name: str, parts: tuple[Part, ...], path: Path, schema: str) -> None:
    """Write parts at their placements, each shape stored once. Raises ``ExportError`` if the kernel cannot."""
    document, shapes = _document()
    assembly = shapes.NewShape()
    TDataStd_Name.Set_s(assembly, TCollection_ExtendedString(name))
    for part in parts:
        label = _add(document, shapes, part)
        for placement in part.placements:
            component = shapes.AddComponent(assembly, label, _location(placement))
            TDataStd_Name.Set_s(component, TCollection_ExtendedString(placement.name))
    shapes.UpdateAssemblies()
    _save(document, path, name, schema)
    _in_fixed_order(path)


def _document() -> tuple[Any, Any]:
    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    XCAFApp_Application.GetApplication_s().NewDocument(TCollection_ExtendedString("MDTV-XCAF"), document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)  # m
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    shapes.SetAutoNaming_s(False)
    return document, shapes


def _add(document: Any, shapes: Any, part: Part) -> Any:
    label = shapes.AddShape(part.solid, False)
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(part.name))
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    colours.SetColor(label, Quantity_Color(*part.colour, Quantity_TOC_sRGB), XCAFDoc_ColorType.XCAFDoc_ColorGen)
    materials = XCAFDoc_DocumentTool.MaterialTool_s(document.Main())
    texts = (part.material.name, part.material.description, "", "")
    name, description, *no_density = (TCollection_HAsciiString(text) for text in texts)
    # No density: the kernel writes its unit as g³·cm² (OCCT 8.0), which readers use literally.
    materials.SetMaterial(label, name, description, 0.0, *no_density)
    return label


def _location(placement: Placement) -> Any:
    rotation, translation = gp_Trsf(), gp_Trsf()
    rotation.SetRotation(gp_Ax1(gp_Pnt(), gp_Dir(0.0, 0.0, 1.0)), placement.rotation)
    translation.SetTranslation(gp_Vec(placement.shift.real, placement.shift.imag, placement.height))
    return TopLoc_Location(translation.Multiplied(rotation))


def _in_fixed_order(path: Path) -> None:
    """Renumber occurrences, which the kernel counts over the whole process, and sort colours, which it writes in the
    order of memory addresses.
    """
    numbers = itertools.count(1)
    text = path.read_text(encoding="ascii")
    text = _OCCURRENCE.sub(lambda found: f"{found[1]}'{next(numbers)}'", text)
    styles = [(found[2], found[4], found[6]) for found in _STYLE.finditer(text)]
    ordered = iter(sorted(styles, key=lambda style: int(style[1])))

    def restyled(found: re.Match[str]) -> str:
        context, solid, colour = next(ordered)
        return f"{found[1]}{context}{found[3]}{solid}{found[5]}{colour}"

    path.write_text(_STYLE.sub(restyled, text), encoding="ascii", newline="\n")


def _save(document: Any, path: Path, name: str, schema: str) -> None:
    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)
    STEPCAFControl_Controller.Init_s()
    # Process-wide settings, set every time. Curves on surfaces would be fitted, and read less accurately.
    Interface_Static.SetIVal_s("write.surfacecurve.mode", 0)
    Interface_Static.SetCVal_s("write.step.schema", SCHEMAS[schema])
    Interface_Static.SetCVal_s("write.step.unit", "MM")
    writer = STEPCAFControl_Writer()
    writer.SetColorMode(True)
    writer.SetNameMode(True)
    writer.SetMaterialMode(True)
    done = writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
    header = APIHeaderSection_MakeHeader(writer.ChangeWriter().Model())
    header.SetName(TCollection_HAsciiString(name))
    header.SetTimeStamp(TCollection_HAsciiString(TIMESTAMP))
    header.SetOriginatingSystem(TCollection_HAsciiString("cycloid_profile"))
    header.SetAuthorValue(1, TCollection_HAsciiString(""))
    header.SetOrganizationValue(1, TCollection_HAsciiString(""))
    header.SetDescriptionValue(1, TCollection_HAsciiString("parts of a cycloid drive, mm"))
    if not done or writer.Write(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise ExportError("STEP file", f"'{path.name}'", "was not written by the kernel", "check the folder", " ")


def read_shape(path: Path) -> Any:
    """The single shape in a STEP file, in mm. Raises ``ExportError`` if the kernel cannot read it."""
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise read_back_error("STEP file", path, "cannot be read back")
    reader.TransferRoots()
    return reader.OneShape()


def sound_solids(shape: Any, path: Path, count: int) -> list[Any]:
    """The solids of a shape; raises ``ExportError`` unless there are ``count``, each valid and closed."""
    solids = _parts(shape, TopAbs_ShapeEnum.TopAbs_SOLID)
    # In a closed shell every edge has a face on either side.
    closed = [all(map(BRep_Tool.IsClosed_s, _parts(solid, TopAbs_ShapeEnum.TopAbs_SHELL))) for solid in solids]
    sound = [BRepCheck_Analyzer(s).IsValid() and shells for s, shells in zip(solids, closed, strict=True)]
    if len(solids) != count or not all(sound):
        raise read_back_error("STEP file", path, f"read back with {sum(sound)} valid closed solids of {count}")
    return solids


def top_edges(solid: Any) -> tuple[list[Any], int, int]:
    """Edges round the top face of an extruded solid in order, number of its inner wires, number of all faces."""

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
    found = []
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        found.append(explorer.Current())
        explorer.Next()
    return found
