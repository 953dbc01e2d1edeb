"""STEP files of named, coloured parts: one part alone, or an assembly of parts in their places."""

from __future__ import annotations

import itertools
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_profile.errors import ExportError
from cycloid_profile.export.stage_parts import Place

TIMESTAMP = "2000-01-01T00:00:00"  # fixed, so that equal input gives equal bytes
# What the kernel calls them: AP214 second edition, AP242 of 2014.
SCHEMAS = {"AP214": "AP214IS", "AP242": "AP242DIS"}
# A colour's block of entities: its context, the solid it is of, red, green and blue.
_STYLE = re.compile(
    r"(PRESENTATION_REPRESENTATION\('',\(\s*#\d+\),\s*#)(\d+)(\);\s*#\d+ = STYLED_ITEM\('color',\(#\d+\),\s*#)(\d+)"
    r"(\);(?:(?!STYLED_ITEM).)*?COLOUR_RGB\()([^)]*)",
    re.DOTALL,
)
_OCCURRENCE = re.compile(r"(NEXT_ASSEMBLY_USAGE_OCCURRENCE\(\s*)'\d+'")


@dataclass(frozen=True, slots=True)
class Substance:
    """Material of a part: ``name`` and ``description``."""

    name: str
    description: str


@dataclass(frozen=True, slots=True)
class Part:
    """A solid of the kernel with ``colour`` red, green, blue in 0…1, ``substance``, and its ``places``."""

    name: str
    solid: Any
    colour: tuple[float, float, float]
    substance: Substance
    places: tuple[Place, ...] = ()


def write_part(part: Part, path: Path, schema: str) -> None:
    """Write one part as drawn, its places ignored. Raises ``ExportError`` if the kernel cannot."""
    document, shapes = _document()
    _add(document, shapes, part)
    _save(document, path, part.name, schema)


def write_assembly(name: str, parts: tuple[Part, ...], path: Path, schema: str) -> None:
    """Write parts at their places: a shape is held once, and referred to from each place.

    Raises ``ExportError`` if the kernel cannot.
    """
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name

    document, shapes = _document()
    whole = shapes.NewShape()
    TDataStd_Name.Set_s(whole, TCollection_ExtendedString(name))
    for part in parts:
        label = _add(document, shapes, part)
        for place in part.places:
            component = shapes.AddComponent(whole, label, _location(place))
            TDataStd_Name.Set_s(component, TCollection_ExtendedString(place.name))
    shapes.UpdateAssemblies()
    _save(document, path, name, schema)
    _in_fixed_order(path)


def _document() -> tuple[Any, Any]:
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    document = TDocStd_Document(TCollection_ExtendedString("XmlOcaf"))
    XCAFApp_Application.GetApplication_s().NewDocument(TCollection_ExtendedString("MDTV-XCAF"), document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)  # m
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    shapes.SetAutoNaming_s(False)
    return document, shapes


def _add(document: Any, shapes: Any, part: Part) -> Any:
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
    from OCP.TDataStd import TDataStd_Name
    from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

    label = shapes.AddShape(part.solid, False)
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(part.name))
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    colours.SetColor(label, Quantity_Color(*part.colour, Quantity_TOC_sRGB), XCAFDoc_ColorType.XCAFDoc_ColorGen)
    materials = XCAFDoc_DocumentTool.MaterialTool_s(document.Main())
    texts = (part.substance.name, part.substance.description, "", "")
    name, description, *no_density = (TCollection_HAsciiString(text) for text in texts)
    # No density: the kernel writes its unit as g³·cm² (OCCT 8.0), which readers take at its word.
    materials.SetMaterial(label, name, description, 0.0, *no_density)
    return label


def _location(place: Place) -> Any:
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
    from OCP.TopLoc import TopLoc_Location

    turn, move = gp_Trsf(), gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(), gp_Dir(0.0, 0.0, 1.0)), place.turn)
    move.SetTranslation(gp_Vec(place.shift.real, place.shift.imag, place.height))
    return TopLoc_Location(move.Multiplied(turn))


def _in_fixed_order(path: Path) -> None:
    """Take out what changes from file to file: the kernel numbers the parts' occurrences on through the process,
    and writes their colours in the order of addresses in memory.
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
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.Interface import Interface_Static
    from OCP.Message import Message, Message_Gravity
    from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_StepModelType
    from OCP.TCollection import TCollection_HAsciiString

    for printer in Message.DefaultMessenger_s().Printers():
        printer.SetTraceLevel(Message_Gravity.Message_Fail)
    STEPCAFControl_Controller.Init_s()
    # Settings of the whole process, so each is set every time. Curves on surfaces would be fitted, and read worse.
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
