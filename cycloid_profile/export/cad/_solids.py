"""Solids through build123d: exact plates, STEP files of named, coloured parts, and solids read back.

Importing this module loads build123d and the kernel, 3 s; call ``require_cad_kernel`` before. Two things go to the
kernel directly: splines by their poles, which build123d only interpolates, and the writing of STEP, because build123d
0.13 writes no material and names a part by its last occurrence.
"""

from __future__ import annotations

import cmath
import itertools
import math
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from build123d import Axis, Color, Compound, Edge, Face, Location, Part, Plane, Solid, Vector, Wire, import_step
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.collections import Array1_double, Array1_gp_Pnt, Array1_int
from OCP.Geom import Geom_BSplineCurve
from OCP.gp import gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Message import Message, Message_Gravity
from OCP.Quantity import Quantity_Color, Quantity_ColorRGBA, Quantity_TOC_sRGB
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.cad.parts import CadPart, Placement
from cycloid_profile.export.curves import SplinePiece
from cycloid_profile.export.writing import read_back_error, step_text
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
_STRING, _ESCAPE = re.compile("'[^']*'"), "\\X"
_MESH_ANGLE = 0.5  # rad between neighbouring chords at most
_VOLUME_ERROR = 1e-6  # of a face, relative
_CHECKS_PER_SPAN = 9  # more than the extremes of the error of a cubic span


def plate(edge: tuple[SplinePiece, ...] | Contour, openings: Iterable[Contour], low: float, high: float) -> Solid:
    """A plate between the heights ``low`` and ``high`` [mm] with ``openings``.

    ``edge`` is a closed contour, or the splines of a tooth curve. Every segment becomes one exact edge.
    """
    segments = edge.segments if isinstance(edge, Contour) else edge
    face = Face(_wire(segments, low), [_wire(opening.segments, low) for opening in openings])
    if face.normal_at().Z < 0.0:
        face = -face
    return Solid.extrude(face, Vector(0.0, 0.0, high - low))


def joined_solid(bodies: Sequence[Solid]) -> Solid:
    """The union of bodies that touch or overlap."""
    return bodies[0] if len(bodies) == 1 else bodies[0].fuse(*bodies[1:]).solid()


def model(part: CadPart) -> Part:
    """The part as an object of build123d with its label and colour, without its placements."""
    return Part([part.solid], label=part.name, color=_colour(part))


def assembly(name: str, parts: Sequence[CadPart]) -> Compound:
    """All parts at their placements as children of one compound."""
    children = []
    for part in parts:
        for placement in part.placements:
            child = model(part).locate(location(placement))
            child.label = placement.name
            children.append(child)
    return Compound(label=name, children=children)


def location(placement: Placement) -> Location:
    """A placement as a location of build123d."""
    shift = (placement.shift.real, placement.shift.imag, placement.height)
    return Location(shift, (0.0, 0.0, math.degrees(placement.rotation)))


def _colour(part: CadPart) -> Color:
    # The colours are sRGB, those of build123d linear.
    return Color(Quantity_ColorRGBA(Quantity_Color(*part.colour, Quantity_TOC_sRGB)))


def _wire(segments: Sequence[Segment], z: float) -> Wire:
    return Wire([_edge(segment, z) for segment in segments])


def _edge(segment: Segment, z: float) -> Edge:
    if isinstance(segment, SplinePiece):
        return Edge(BRepBuilderAPI_MakeEdge(_bspline(segment, z)).Edge())
    start, end = ((point.real, point.imag, z) for point in (segment.start, segment.end))
    if isinstance(segment, Line):
        return Edge.make_line(start, end)
    if segment.full_circle:
        return Edge.make_circle(segment.radius, Plane((segment.centre.real, segment.centre.imag, z)))
    middle = segment.centre + cmath.rect(segment.radius, 0.5 * (segment.from_angle + segment.to_angle))
    return Edge.make_three_point_arc(start, (middle.real, middle.imag, z), end)


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


def write_part(part: CadPart, path: Path, schema: str) -> None:
    """Write one part without its placements. Raises ``ExportError`` if the kernel cannot."""
    document, shapes = _document()
    _add(document, shapes, part)
    _save(document, path, part.name, schema)


def write_assembly(name: str, parts: tuple[CadPart, ...], path: Path, schema: str) -> None:
    """Write parts at their placements, each shape stored once. Raises ``ExportError`` if the kernel cannot."""
    document, shapes = _document()
    assembly = shapes.NewShape()
    TDataStd_Name.Set_s(assembly, TCollection_ExtendedString(step_text(name)))
    for part in parts:
        label = _add(document, shapes, part)
        for placement in part.placements:
            component = shapes.AddComponent(assembly, label, location(placement).wrapped)
            TDataStd_Name.Set_s(component, TCollection_ExtendedString(step_text(placement.name)))
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


def _add(document: Any, shapes: Any, part: CadPart) -> Any:
    label = shapes.AddShape(part.solid.wrapped, False)
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(step_text(part.name)))
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    colours.SetColor(label, _colour(part).wrapped.GetRGB(), XCAFDoc_ColorType.XCAFDoc_ColorGen)
    materials = XCAFDoc_DocumentTool.MaterialTool_s(document.Main())
    texts = (part.material.name, part.material.description, "", "")
    name, description, *no_density = (TCollection_HAsciiString(step_text(text)) for text in texts)
    # No density: the kernel writes its unit as g³·cm² (OCCT 8.0), which readers use literally.
    materials.SetMaterial(label, name, description, 0.0, *no_density)
    return label


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
    header.SetName(TCollection_HAsciiString(step_text(name)))
    header.SetTimeStamp(TCollection_HAsciiString(TIMESTAMP))
    header.SetOriginatingSystem(TCollection_HAsciiString("cycloid_profile"))
    header.SetAuthorValue(1, TCollection_HAsciiString(""))
    header.SetOrganizationValue(1, TCollection_HAsciiString(""))
    header.SetDescriptionValue(1, TCollection_HAsciiString("parts of a cycloid drive, mm"))
    if not done or writer.Write(str(path)) != IFSelect_ReturnStatus.IFSelect_RetDone:
        raise ExportError("STEP file", f"'{path.name}'", "was not written by the kernel", "check the folder", " ")
    text = path.read_text(encoding="ascii")
    if _ESCAPE in text:
        # The kernel breaks its lines inside escaped characters, which its own reader then does not understand.
        whole = _STRING.sub(lambda found: found[0].replace("\n", ""), text)
        path.write_text(whole, encoding="ascii", newline="\n")


def read_shape(path: Path) -> Compound:
    """The shape in a STEP file, in mm. Raises ``ExportError`` if the kernel cannot read it."""
    try:
        return import_step(path)
    except (RuntimeError, ValueError):
        raise read_back_error("STEP file", path, "cannot be read back") from None


def sound_solids(shape: Compound, path: Path, count: int) -> list[Solid]:
    """The solids of a shape; raises ``ExportError`` unless there are ``count``, each valid and closed."""
    solids = list(shape.solids())
    sound = [solid.is_valid and solid.is_manifold for solid in solids]
    if len(solids) != count or not all(sound):
        raise read_back_error("STEP file", path, f"read back with {sum(sound)} valid closed solids of {count}")
    return solids


def top_edges(solid: Solid) -> tuple[list[Edge], int, int]:
    """Edges round the top face of an extruded solid, number of its inner wires, number of all faces."""
    faces = solid.faces()
    top = faces.sort_by(Axis.Z)[-1]
    return list(top.outer_wire().edges()), len(top.inner_wires()), len(faces)


def measured(solid: Solid) -> tuple[float, float]:
    """Area of the top face [mm²], and volume by the kernel's integration over all faces [mm³]."""
    # Its default takes too few points on spline faces, 3e-5 off on the flanks of an RV-40E, and its other adaptive
    # one ends 5e-3 off; the one by Gauss and Kronrod is to the error asked for.
    found = GProp_GProps()
    BRepGProp.VolumePropertiesGK_s(solid.wrapped, found, _VOLUME_ERROR, True, True)
    return float(solid.faces().sort_by(Axis.Z)[-1].area), float(found.Mass())


def face_count(solid: Solid) -> int:
    """Number of faces of a solid."""
    return len(solid.faces())


def tessellated(solid: Solid, chord_error: float) -> tuple[FloatArray, IntArray]:
    """Corners, shape (n, 3) [mm], and triangles, shape (m, 3), of a solid's closed mesh with chords within
    ``chord_error`` [mm]."""
    # build123d alone takes the error relative to the size of each edge.
    BRepMesh_IncrementalMesh(solid.wrapped, chord_error, False, _MESH_ANGLE)
    points, triangles = solid.tessellate(chord_error, _MESH_ANGLE)
    # Neighbouring faces share the points on their edge, here to the last bits.
    xyz = np.round(np.array([tuple(point) for point in points]), 7) + 0.0
    corners, which = np.unique(xyz, axis=0, return_inverse=True)
    return corners, which.ravel()[np.array(triangles, dtype=np.intp)]


def points_on(edges: list[Edge]) -> ComplexArray:
    """Points along every knot span of spline edges, by the kernel's own evaluation; shape (spans, points) [mm]."""
    rows = []
    for edge in edges:
        adaptor = edge.geom_adaptor()
        curve = adaptor.BSpline()
        knots = [curve.Knot(i) for i in range(1, curve.NbKnots() + 1)]
        for low, high in itertools.pairwise(knots):
            at = np.linspace(low, high, _CHECKS_PER_SPAN).tolist()
            rows.append([complex(point.X(), point.Y()) for point in map(adaptor.Value, at)])
    return np.array(rows)
