"""Signs of a drawing: cutting line, datum, tolerance frames."""

from __future__ import annotations

from collections.abc import Callable

from cycloid_profile.export.drawing_sheet import SMALL, TEXT, Sheet
from cycloid_profile.spec.drawing import DrawingSpec
from cycloid_profile.units import UM

_CELL = 6.0


def section_mark(sheet: Sheet, at: complex, outward: complex) -> None:
    """End of the cutting line A–A with the arrow of sight, which goes to the right."""
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


def runout_frames(sheet: Sheet, tooth: complex, fields: DrawingSpec) -> None:
    """Tolerance frames below the lower end of a section, with an arrow at the tooth; nothing without tolerances."""
    wanted = [
        (draw, value)
        for draw, value in ((_profile, fields.profile_tolerance_um), (_runout, fields.runout_tolerance_um))
        if value is not None
    ]
    if not wanted:
        return
    corner = tooth - 9.0 - 16.0j
    sheet.path([corner + _CELL * 1j + 4.0, corner + 13.0j + 4.0, tooth + 0.9j], "DIMENSIONS")
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
