"""Labels and dimensions: texts, boxed sizes, tolerance frames, roughness, datum letters, and their free places."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.errors import ExportError
from cycloid_profile.export.drawing._sheet import TEXT, Sheet, polar
from cycloid_profile.export.drawing._text import text_width

_FRAME, _PAD = 2.0 * TEXT, 1.2  # height of a tolerance frame (ISO 1101), and the space before and after its text
_LAYER = "DIMENSIONS"
_FIRST, _STEP, _LAST = 8.0, 1.0, 60.0  # distances of a dimension line from the outline that are tried
_CLEAR = 3.0  # mm round a dimension line
_BEYOND = 1.5  # of an extension line past the dimension line
_ABOVE = 1.2  # mm from a dimension line to its text
_TRIANGLE = 2.5
_CIRCLE = [0.3 * cmath.rect(1.0, math.radians(10.0 * i)) for i in range(37)]
# Strokes of signs that fonts lack, in heights of capitals about their centre (ISO 1101).
_SIGNS: dict[str, tuple[list[complex], ...]] = {
    "position": (_CIRCLE, [-0.55 + 0j, 0.55 + 0j], [-0.55j, 0.55j]),
    "profile": ([2.0 * p - 0.3j for p in _CIRCLE[:19]],),
    "perpendicularity": ([-0.5 - 0.45j, 0.5 - 0.45j], [-0.45j, 0.5j]),
    "parallelism": ([-0.55 - 0.45j, -0.05 + 0.45j], [0.05 - 0.45j, 0.55 + 0.45j]),
    "runout": ([-0.4 - 0.5j, 0.45 + 0.5j], [0.08 + 0.4j, 0.45 + 0.5j, 0.4 + 0.1j]),
}


class Row(Protocol):
    """One row of a label, with its ``size`` [mm of paper]."""

    @property
    def size(self) -> complex: ...

    def draw(self, sheet: Sheet, corner: complex) -> None:
        """Draw the row from its lower left corner."""
        ...


@dataclass(frozen=True, slots=True)
class Words:
    """Plain text."""

    text: str
    height: float = TEXT

    @property
    def size(self) -> complex:
        return complex(text_width(self.text, self.height), 1.7 * self.height)

    def draw(self, sheet: Sheet, corner: complex) -> None:
        sheet.text(corner + 0.4j * self.height, self.text, self.height)


@dataclass(frozen=True, slots=True)
class Frame:
    """Cells in one frame: a theoretically exact size, or a sign with its tolerance and datums; words ``after`` it."""

    cells: tuple[str, ...]
    after: str = ""

    def _widths(self) -> list[float]:
        return [_FRAME if cell in _SIGNS else max(_FRAME, text_width(cell, TEXT) + 2.0 * _PAD) for cell in self.cells]

    @property
    def size(self) -> complex:
        return complex(sum(self._widths()) + (_PAD + text_width(self.after, TEXT) if self.after else 0.0), _FRAME + 0.8)

    def draw(self, sheet: Sheet, corner: complex) -> None:
        corner += 0.4j
        for cell, width in zip(self.cells, self._widths(), strict=True):
            middle = corner + complex(0.5 * width, 0.5 * _FRAME)
            sheet.box(corner, complex(width, _FRAME), _LAYER)
            for stroke in _SIGNS.get(cell, ()):
                sheet.polyline([middle + 1.2 * TEXT * p for p in stroke], _LAYER)
            if cell not in _SIGNS:
                sheet.text(middle - 0.5j * TEXT, cell, TEXT, "CENTER")
            corner += width
        # Leaders keep clear of the signs, too.
        whole = sum(self._widths())
        sheet.taken.text(corner - whole, complex(whole, _FRAME))
        sheet.text(corner + _PAD + 0.5j * (_FRAME - TEXT), self.after)


@dataclass(frozen=True, slots=True)
class Roughness:
    """Symbol of a surface whose material is removed (ISO 21920-1), with Ra [µm], or a line to fill in."""

    ra_um: float | None

    @property
    def text(self) -> str:
        return "Ra ____" if self.ra_um is None else f"Ra {self.ra_um:g}"

    @property
    def size(self) -> complex:
        return complex(4.4 + text_width(self.text, TEXT) + 1.0, 6.0)

    def draw(self, sheet: Sheet, corner: complex) -> None:
        foot = corner + 1.6 + 0.4j
        left, top = foot + polar(3.0, 120.0), foot + polar(6.0, 60.0)
        right = complex(corner.real + self.size.real, top.imag)
        sheet.polyline([left, foot, top, right], _LAYER)
        sheet.line(left, foot + polar(3.0, 60.0), _LAYER)
        sheet.text(complex(corner.real + 4.9, top.imag - TEXT - 0.9), self.text)


@dataclass(frozen=True, slots=True)
class Datum:
    """Letter of a datum below the frame or size that it belongs to, with a filled triangle (ISO 5459)."""

    letter: str

    @property
    def size(self) -> complex:
        return complex(_FRAME, _TRIANGLE + 1.5 + _FRAME + 0.4)

    def draw(self, sheet: Sheet, corner: complex) -> None:
        self.draw_on(sheet, corner + self.size - 0.5 * _FRAME, -1j)

    def draw_on(self, sheet: Sheet, foot: complex, out: complex) -> None:
        """Draw the triangle with its base on a line at ``foot``, the letter in the direction ``out``."""
        peak, middle = foot + _TRIANGLE * out, foot + (_TRIANGLE + 1.5 + 0.5 * _FRAME) * out
        sheet.solid([foot - 0.6j * _TRIANGLE * out, foot + 0.6j * _TRIANGLE * out, peak])
        sheet.line(peak, middle - 0.5 * _FRAME * out, _LAYER)
        sheet.box(middle - 0.5 * complex(_FRAME, _FRAME), complex(_FRAME, _FRAME), _LAYER)
        sheet.text(middle - 0.5j * TEXT, self.letter, TEXT, "CENTER")


def label(sheet: Sheet, tip: complex, rows: Sequence[Row]) -> None:
    """Rows at the nearest free place, with a leader from the tip.

    Raises ``ExportError`` where the sheet has no place.
    """
    size = complex(max(row.size.real for row in rows), sum(row.size.imag for row in rows))
    found = sheet.taken.place(tip, size, size.imag - 0.5 * rows[0].size.imag)
    if found is None:
        raise ExportError("drawing", "A3", "has no place for another label", "leave the format drawing out", " ")
    corner, path = found
    sheet.polyline(path, _LAYER)
    sheet.taken.leader(path)
    sheet.arrow(tip, path[1] - tip)
    top = corner + 1j * size.imag
    # Towards the leader.
    to_right = path[-1].real > corner.real
    for row in rows:
        top -= 1j * row.size.imag
        row.draw(sheet, top + (size.real - row.size.real if to_right else 0.0))


def dimension(sheet: Sheet, start: complex, end: complex, out: complex, text: str) -> None:
    """A dimension between two points, its line at the nearest free distance in the direction ``out``.

    The text is the one given: no reader has to scale a measured length.
    """
    along = (end - start) / abs(end - start)
    # Read from below or from the right.
    turn = -along if along.real < -1e-9 or (abs(along.real) < 1e-9 and along.imag < 0.0) else along
    width, length = text_width(text, TEXT), abs(end - start)
    inside = length > 9.0
    for distance in np.arange(_FIRST, _LAST, _STEP):
        a, b = start + out * distance, end + out * distance
        # Over the line, else past either end.
        shifts = [0.5 * length] if width + 2.0 <= length else [length + 5.0 + 0.5 * width, -5.0 - 0.5 * width]
        for shift in shifts:
            middle = a + along * shift
            low, high = min(0.0, shift - 0.5 * width), max(length, shift + 0.5 * width)
            reach = [a + along * (low if low < 0.0 or inside else -5.0)]
            reach.append(a + along * (high if high > length or inside else length + 5.0))
            base = middle + 1j * turn * _ABOVE
            ends = [*reach, base - 0.5 * width * turn, base + turn * (0.5 * width + 1j * TEXT)]
            low_corner = complex(min(p.real for p in ends), min(p.imag for p in ends))
            size = complex(max(p.real for p in ends), max(p.imag for p in ends)) - low_corner
            if sheet.taken.free(np.array([low_corner]), size, _CLEAR - 1.0)[0]:
                _draw_dimension(sheet, (start, end), (a, b), reach, inside)
                sheet.text(base, text, TEXT, "CENTER", turn=turn)
                return
    label(sheet, 0.5 * (start + end), [Words(text)])


def _draw_dimension(
    sheet: Sheet, feet: tuple[complex, complex], ends: tuple[complex, complex], reach: list[complex], inside: bool
) -> None:
    """Extension lines from the ``feet``, the dimension line over ``reach``, and arrows at its ``ends``."""
    for foot, end in zip(feet, ends, strict=True):
        out = (end - foot) / abs(end - foot)
        sheet.line(foot + 0.8 * out, end + _BEYOND * out, _LAYER)
    sheet.line(reach[0], reach[1], _LAYER)
    inwards = (ends[1] - ends[0]) * (1.0 if inside else -1.0)
    sheet.arrow(ends[0], inwards)
    sheet.arrow(ends[1], -inwards)
