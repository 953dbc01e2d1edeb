"""Annotations of a drawing: frame, title block, notes, tables, cutting line, datum and tolerance frames."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.drawing._sheet import A3, LARGE, SMALL, TEXT, Sheet
from cycloid_profile.export.drawing._tooth_data import TableRow
from cycloid_profile.spec.model import DrawingSpec
from cycloid_profile.units import UM

_TITLE_CORNER, _TITLE_SIZE = 230 + 10j, 180 + 39j
_ROW = 5.4
_CELL = 6.0


def draw_frame(sheet: Sheet) -> None:
    """Edge of the sheet, frame with a filing margin on the left, centring marks."""
    width, height = A3
    sheet.box(0j, complex(width, height))
    sheet.box(20 + 10j, complex(width - 30, height - 20), "FRAME")
    for mark in (0.5 * width, complex(0.5 * width, height - 10), 0.5j * height, complex(width - 10, 0.5 * height)):
        across = 10j if mark.imag in (0.0, height - 10) else (20 if mark.real == 0.0 else 10)
        sheet.line(mark, mark + across, "FRAME")


def draw_title(sheet: Sheet, record: DesignRecord, fields: DrawingSpec, scale: str, material: str) -> None:
    """Title block; fields without a value stay empty."""
    cells = (
        (26, 0, 96, "title", f"Cycloid disc {record.spec.name}"),
        (26, 96, 52, "drawing number", fields.number),
        (26, 148, 16, "sheet", "1 / 1"),
        (26, 164, 16, "format", "A3"),
        (13, 0, 56, "material", material),
        (13, 56, 72, "heat treatment", fields.heat_treatment),
        (13, 128, 20, "scale", scale),
        (13, 148, 32, "units", "mm"),
        (0, 0, 36, "drawn", fields.drawn_by),
        (0, 36, 28, "date", fields.date),
        (0, 64, 32, "checked", ""),
        (0, 96, 52, "general tolerances", fields.general_tolerance),
        (0, 148, 32, "projection, first angle", ""),
    )
    for up, along, width, label, value in cells:
        corner = _TITLE_CORNER + complex(along, up)
        sheet.box(corner, complex(width, 13))
        sheet.text(corner + complex(1.2, 13 - 1.2 - SMALL), label, SMALL, room=width - 2.4)
        height = LARGE if label == "title" else 3.5
        sheet.text(corner + complex(2.0, 2.6), value, height, room=width - 4.0)
    sheet.box(_TITLE_CORNER, _TITLE_SIZE, "FRAME")
    _projection_symbol(sheet, _TITLE_CORNER + 164 + 4.9j)


def _projection_symbol(sheet: Sheet, centre: complex) -> None:
    """First angle: a frustum with its view from the left on the right (ISO 5456-2)."""
    cone, view = centre - 9.0, centre + 5.0
    sheet.polyline([cone - 3.5 - 1.5j, cone - 3.5 + 1.5j, cone + 3.5 + 3j, cone + 3.5 - 3j], closed=True)
    sheet.circle(view, 3.0)
    sheet.circle(view, 1.5)
    sheet.line(cone - 5.0, cone + 5.0, "CENTRE")
    sheet.line(view - 4.2, view + 4.2, "CENTRE")
    sheet.line(view - 4.2j, view + 4.2j, "CENTRE")


def draw_notes(sheet: Sheet, notes: Sequence[str], corner: complex, width: float) -> None:
    """Numbered notes below the upper left ``corner``."""
    sheet.text(corner - 1j * TEXT, "Notes", TEXT)
    for i, note in enumerate(notes, start=1):
        sheet.text(corner - 1j * (TEXT + 4.6 * i), f"{i}. {note}", TEXT, room=width)


def draw_table(sheet: Sheet, rows: Sequence[TableRow], corner: complex, width: float) -> None:
    """The table of tooth data with name, symbol and value, below its upper right ``corner``."""
    left, height = corner - width, _ROW * (len(rows) + 1)
    symbol_at, value_at = 0.56 * width, 0.70 * width
    sheet.box(left - 1j * height, complex(width, height), "FRAME")
    sheet.text(left + complex(0.5 * width, -_ROW + 1.4), "Tooth data", 3.0, "CENTER")
    for at in (symbol_at, value_at):
        sheet.line(left + at - 1j * _ROW, left + at - 1j * height)
    for i, row in enumerate(rows, start=1):
        base = left - 1j * _ROW * (i + 1) + 1.5j
        sheet.line(left - 1j * _ROW * i, corner - 1j * _ROW * i)
        sheet.text(base + 1.2, row.name, 2.2, room=symbol_at - 2.0)
        sheet.symbol(base + 0.5 * (symbol_at + value_at), row.symbol, 2.2)
        sheet.text(base + width - 1.2, row.value, 2.2, "RIGHT", room=width - value_at - 2.0)


def section_mark(sheet: Sheet, at: complex, outward: complex) -> None:
    """End of the cutting line A–A with the arrow of the viewing direction, to the right."""
    end = at + 7.0 * outward
    sheet.line(at, end, "FRAME")
    sheet.line(end - 9.0, end, "DIMENSIONS")
    sheet.arrow(end, -1.0)
    sheet.text(end - 12.0 - 1.7j, "A", 3.5, "CENTER")


def datum(sheet: Sheet, at: complex, name: str) -> None:
    """A filled triangle below a dimension line, with the datum's letter in a box."""
    corners = [sheet.at(p) for p in (at, at - 1.5 - 2.5j, at + 1.5 - 2.5j)]
    sheet.space.add_solid([*corners, corners[-1]], dxfattribs={"layer": "DIMENSIONS"})
    sheet.line(at - 2.5j, at - 4.5j, "DIMENSIONS")
    sheet.box(at - 2.5 - 9.5j, 5 + 5j, "DIMENSIONS")
    sheet.text(at - 8.2j, name, TEXT, "CENTER")


def tolerance_frames(sheet: Sheet, tooth: complex, fields: DrawingSpec) -> None:
    """Frames of the given profile and runout tolerances below a section, with an arrow at the tooth."""
    wanted = [
        (draw, value)
        for draw, value in ((_profile, fields.profile_tolerance_um), (_runout, fields.runout_tolerance_um))
        if value is not None
    ]
    if not wanted:
        return
    corner = tooth - 9.0 - 16.0j
    sheet.polyline([corner + _CELL * 1j + 4.0, corner + 13.0j + 4.0, tooth + 0.9j], "DIMENSIONS")
    sheet.arrow(tooth + 0.9j, corner + 13.0j + 4.0 - tooth - 0.9j)
    for i, (draw, value) in enumerate(wanted):
        _frame(sheet, corner - 1j * _CELL * i, draw, f"{value * UM:g}")


def _frame(sheet: Sheet, corner: complex, draw: Callable[[Sheet, complex], None], value: str) -> None:
    sheet.box(corner, complex(_CELL + 14.0 + _CELL, _CELL), "DIMENSIONS")
    for at in (_CELL, _CELL + 14.0):
        sheet.line(corner + at, corner + at + 1j * _CELL, "DIMENSIONS")
    draw(sheet, corner + 0.5 * complex(_CELL, _CELL))
    sheet.text(corner + _CELL + 7.0 + 1.8j, value, TEXT, "CENTER")
    sheet.text(corner + _CELL + 17.0 + 1.8j, "A", TEXT, "CENTER")


def _profile(sheet: Sheet, centre: complex) -> None:
    """Profile of a line: a half circle."""
    sheet.arc(centre - 1.0j, 2.0, 0.0, 180.0, "DIMENSIONS")


def _runout(sheet: Sheet, centre: complex) -> None:
    """Circular runout: an arrow to the upper right."""
    tip = centre + SMALL + 1j * SMALL
    sheet.line(centre - SMALL - 1j * SMALL, tip, "DIMENSIONS")
    sheet.arrow(tip, -1.0 - 1.0j, 1.8)
