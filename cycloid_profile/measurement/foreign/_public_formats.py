"""Point sets of measuring machines in three public formats: VDA-FS, DMIS output and QIF (docs/foreign-files.md)."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree

from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.foreign._vocabulary import LENGTH, UNITS
from cycloid_profile.measurement.foreign.table import SourceTable, number

_HEAD = 65536  # bytes that show the format
_COLUMNS = ("x", "y", "z", "nx", "ny", "nz")
_VDA_WIDTH = 72  # columns of data; the last eight of eighty number the lines
_VDA_STATEMENT = re.compile(r"\b(\w{1,16})\s*=\s*(PSET|MDI)\s*/\s*(\d+)\s*,(.*?)(?=\$\$|\b\w{1,16}\s*=|\Z)", re.DOTALL)
_DMIS_ACTUAL = re.compile(r"^\s*FA\(([^)]*)\)\s*=\s*FEAT\s*/\s*POINT\s*,\s*CART\s*,(.*)$", re.MULTILINE | re.IGNORECASE)
_DMIS_UNITS = re.compile(r"^\s*UNITS\s*/\s*(\w+)", re.MULTILINE | re.IGNORECASE)
_DMIS_LENGTHS = {"MM": "mm", "CM": "cm", "M": "m", "INCH": "inch"}
_QIF_LENGTHS = {0.001: "mm", 0.01: "cm", 1.0: "m", 0.0254: "inch", 1e-6: "um"}


@dataclass(frozen=True)
class VdaReader:
    """Point sets (PSET) and point-vector sets (MDI) of VDA-FS 2.0, DIN 66301, in mm."""

    name: str = "VDA-FS"

    def recognises(self, data: bytes) -> bool:
        """See ``MeasurementReader.recognises``."""
        return re.search(rb"=\s*HEADER\s*/\s*\d+", data[:_HEAD]) is not None

    def read(self, data: bytes, name: str) -> SourceTable:
        """See ``MeasurementReader.read``."""
        lines = data.decode("latin-1").splitlines()
        text = "\n".join(line[:_VDA_WIDTH].rstrip() for line in lines)
        rows: list[tuple[int, list[str]]] = []
        width = 3
        for label, statement, count, body in _VDA_STATEMENT.findall(text):
            per_point = 6 if statement == "MDI" else 3
            values = [value.strip() for value in body.replace("\n", "").split(",")]
            if len(values) != int(count) * per_point:
                limit = f"are not {per_point} for each of {count} points"
                remedy = "export the points again, the file is cut off"
                raise MeasurementError(f"{name}: numbers of {statement} {label}", len(values), limit, remedy)
            width = max(width, per_point)
            points = [values[i : i + per_point] for i in range(0, len(values), per_point)]
            rows += enumerate(points, len(rows) + 1)
        return _points(name, rows, width, "mm", {}, "VDA-FS point sets")


@dataclass(frozen=True)
class DmisReader:
    """Actual points ``FA(label)=FEAT/POINT,CART,x,y,z,i,j,k`` of a DMIS output file, ISO 22093."""

    name: str = "DMIS"

    def recognises(self, data: bytes) -> bool:
        """See ``MeasurementReader.recognises``."""
        return re.search(rb"^\s*(DMISM[ND]\s*/|FA?\([^)]*\)\s*=\s*FEAT\s*/)", data[:_HEAD], re.MULTILINE) is not None

    def read(self, data: bytes, name: str) -> SourceTable:
        """See ``MeasurementReader.read``."""
        text = re.sub(r"\$[ \t]*\r?\n", "", data.decode("latin-1")).replace("\r", "")  # statements over several lines
        found = _DMIS_UNITS.search(text)
        unit = _DMIS_LENGTHS.get(found[1].upper()) if found else "mm"
        if unit is None:
            raise MeasurementError(f"{name}: UNITS", f"'{found[1] if found else ''}'", "is not known", "output mm")
        bodies = [match[2] for match in _DMIS_ACTUAL.finditer(text)]
        rows = [(i, [value.strip() for value in body.split(",")]) for i, body in enumerate(bodies, 1)]
        return _points(name, rows, 6, unit, {}, "actual points of a DMIS output file")


@dataclass(frozen=True)
class QifReader:
    """Measured points (``MeasurePoint``) of a QIF document, ISO 23952.

    ``Compensated`` false and ``ProbeRadius`` say that the points are centres of the ball.
    """

    name: str = "QIF"

    def recognises(self, data: bytes) -> bool:
        """See ``MeasurementReader.recognises``."""
        return b"QIFDocument" in data[:_HEAD]

    def read(self, data: bytes, name: str) -> SourceTable:
        """See ``MeasurementReader.read``."""
        if b"<!DOCTYPE" in data or b"<!ENTITY" in data:  # none in QIF; entities can blow up a parser
            raise MeasurementError(name, "the file", "declares XML entities", "export it as plain QIF", ": ")
        try:
            root = ElementTree.fromstring(data)
        except ElementTree.ParseError as error:
            raise MeasurementError(name, "the file", f"is no XML ({error})", "export it again", ": ") from None
        points = list(_named(root, "MeasurePoint"))
        rows = [(i, _child(point, "Point").split()) for i, point in enumerate(points, 1)]
        unit = _qif_unit(root, name)
        return _points(name, rows, 3, unit, _qif_probe(points, unit, name), "measured points of a QIF file")


def _points(
    name: str, rows: list[tuple[int, list[str]]], width: int, unit: str, settings: dict[str, str], layout: str
) -> SourceTable:
    columns = _COLUMNS[:width]
    units = tuple(unit if column in "xyz" else "" for column in columns)
    return SourceTable(name, columns, units, rows, (), ".", layout, True, settings, "point")


def _named(root: ElementTree.Element, name: str) -> Iterator[ElementTree.Element]:
    return (each for each in root.iter() if each.tag.rpartition("}")[2] == name)


def _child(element: ElementTree.Element, name: str) -> str:
    return next((each.text or "" for each in element if each.tag.rpartition("}")[2] == name), "")


def _qif_unit(root: ElementTree.Element, name: str) -> str:
    for unit in _named(root, "LinearUnit"):
        factor = next((float(each.text or "nan") for each in _named(unit, "Factor")), 1.0)
        known = next((word for size, word in _QIF_LENGTHS.items() if abs(factor / size - 1.0) < 1e-9), None)
        if known is None:
            raise MeasurementError(f"{name}: LinearUnit factor", factor, "is not known", "export in mm")
        return known
    return "mm"


def _qif_probe(points: list[ElementTree.Element], unit: str, name: str) -> dict[str, str]:
    """The radius to be removed from points that are not compensated."""
    radii = {_child(each, "ProbeRadius") for each in points if _child(each, "Compensated").strip() == "false"}
    if not radii:
        return {}
    if len(radii) > 1 or any(_child(each, "Compensated").strip() != "false" for each in points):
        remedy = "export the points of one probe, or compensated ones"
        raise MeasurementError(name, "points", "of several probe radii are mixed", remedy, ": ")
    radius = number(radii.pop())
    return {"probe_radius_mm": f"{radius * UNITS[LENGTH][unit]:.12g}"} if radius else {}
