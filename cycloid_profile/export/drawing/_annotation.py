"""Frame, title block, notes and table of a drawing."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

from cycloid_profile.export.drawing._sheet import LARGE, SMALL, TEXT, Sheet
from cycloid_profile.export.drawing._space import A3
from cycloid_profile.export.drawing._symbols import Roughness
from cycloid_profile.export.drawing._text import text_width

_TITLE_CORNER, _TITLE_SIZE = 230 + 10j, 180 + 39j
_SQUEEZED = 1.6  # times its field a value may be wide and made smaller; a wider one takes two lines
_ROW = 5.4


def draw_frame(sheet: Sheet) -> None:
    """Edge of the sheet, frame with a filing margin on the left, centring marks."""
    width, height = A3
    sheet.box(0j, complex(width, height))
    sheet.box(20 + 10j, complex(width - 30, height - 20), "FRAME")
    for mark in (0.5 * width, complex(0.5 * width, height - 10), 0.5j * height, complex(width - 10, 0.5 * height)):
        across = 10j if mark.imag in (0.0, height - 10) else (20 if mark.real == 0.0 else 10)
        sheet.line(mark, mark + across, "FRAME")


def draw_title(
    sheet: Sheet, cells: Sequence[tuple[float, float, float, str, str]], tooth: Roughness, others: Roughness
) -> None:
    """Title block; fields without a value stay empty. Above it the roughness of surfaces without a symbol.

    A cell: corner above and along that of the block, width [mm], label and value.
    """
    for up, along, width, label, value in cells:
        corner = _TITLE_CORNER + complex(along, up)
        sheet.box(corner, complex(width, 13))
        sheet.text(corner + complex(1.2, 13 - 1.2 - SMALL), label, SMALL, room=width - 2.4)
        height = LARGE if label == "title" else 3.5
        if text_width(value, height) <= _SQUEEZED * (width - 4.0):
            sheet.text(corner + complex(2.0, 2.6), value, height, room=width - 4.0)
            continue
        for line, above in zip(_halves(value), (6.2, 1.8), strict=False):
            sheet.text(corner + complex(2.0, above), line, 3.0, room=width - 4.0)
    sheet.box(_TITLE_CORNER, _TITLE_SIZE, "TABLE")
    _projection_symbol(sheet, _TITLE_CORNER + 165 + 4.9j)
    # ISO 21920-1: the surfaces without a symbol of their own; those with one in brackets.
    at = _TITLE_CORNER + complex(0.0, _TITLE_SIZE.imag + 2.0)
    others.draw(sheet, at)
    sheet.text(at + others.size.real + 1.5 + 1.5j, "(", 3.5)
    tooth.draw(sheet, at + others.size.real + 4.0)
    sheet.text(at + others.size.real + tooth.size.real + 5.5 + 1.5j, ")", 3.5)


def _halves(text: str) -> list[str]:
    """At most two lines, as even as its words allow."""
    widths = range(math.ceil(0.5 * len(text)), len(text) + 1)
    return next(lines for width in widths if len(lines := textwrap.wrap(text, width)) <= 2)


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


def draw_table(sheet: Sheet, rows: Sequence[tuple[str, str, str]], corner: complex, width: float) -> None:
    """The table of tooth data with name, symbol and value of each row, below its upper right ``corner``."""
    left, height = corner - width, _ROW * (len(rows) + 1)
    symbol_at, value_at = 0.56 * width, 0.70 * width
    sheet.box(left - 1j * height, complex(width, height), "TABLE")
    sheet.text(left + complex(0.5 * width, -_ROW + 1.4), "Tooth data", 3.0, "CENTER")
    for at in (symbol_at, value_at):
        sheet.line(left + at - 1j * _ROW, left + at - 1j * height)
    for i, (name, symbol, value) in enumerate(rows, start=1):
        base = left - 1j * _ROW * (i + 1) + 1.5j
        sheet.line(left - 1j * _ROW * i, corner - 1j * _ROW * i)
        sheet.text(base + 1.2, name, 2.2, room=symbol_at - 2.0)
        sheet.symbol(base + 0.5 * (symbol_at + value_at), symbol, 2.2)
        sheet.text(base + width - 1.2, value, 2.2, "RIGHT", room=width - value_at - 2.0)
