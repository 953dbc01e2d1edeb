"""A drawing sheet in millimetres of paper: lines, text, dimensions and leaders, laid over a model at true size.

The model space holds the disc at 1:1; frame, text and arrows are ``unit`` times larger, the model length of a
millimetre of paper. Printed to fit the sheet, everything has its size on paper.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from cycloid_profile.export.dxf_document import LAYERS, Layer, draw_contour, new_document
from cycloid_profile.export.text import plain_name
from cycloid_profile.geometry.contour import Contour

A3 = (420.0, 297.0)
FONT = "DejaVuSans.ttf"  # comes with matplotlib, so that prints are alike on every machine
STYLE = "DRAWING"
TEXT, SMALL, LARGE = 2.5, 1.8, 5.0  # heights of capitals
_NARROW = 0.85
_LATIN_AND_GREEK = 0x400
_SHEET_LAYERS = (
    *LAYERS,
    Layer("FRAME", 7, lineweight=50),
    Layer("THIN", 7, lineweight=18),
    Layer("DIMENSIONS", 4, lineweight=18),
    Layer("HATCH", 8, lineweight=13),
    Layer("CUT", 7, "CENTRE", lineweight=70),
)


@dataclass(frozen=True, slots=True)
class Sheet:
    """A sheet being drawn. Points are complex, in mm of paper from its lower left corner."""

    doc: Any
    unit: float

    @property
    def space(self) -> Any:
        """The model space."""
        return self.doc.modelspace()

    def at(self, point: complex) -> tuple[float, float]:
        """Model coordinates of a point of the paper [mm]."""
        # Twelve decimals, so that the last bit of a sine changes no byte.
        return round(point.real * self.unit, 12) + 0.0, round(point.imag * self.unit, 12) + 0.0

    def line(self, start: complex, end: complex, layer: str = "THIN") -> None:
        """A straight line."""
        self.space.add_line(self.at(start), self.at(end), dxfattribs={"layer": layer})

    def path(self, points: Sequence[complex], layer: str = "THIN", closed: bool = False) -> None:
        """Straight lines through points."""
        self.space.add_lwpolyline([self.at(p) for p in points], close=closed, dxfattribs={"layer": layer})

    def box(self, corner: complex, size: complex, layer: str = "THIN") -> None:
        """A rectangle from its lower left corner."""
        w, h = size.real, size.imag
        self.path([corner, corner + w, corner + size, corner + 1j * h], layer, closed=True)

    def circle(self, centre: complex, radius: float, layer: str = "THIN") -> None:
        """A circle."""
        self.space.add_circle(self.at(centre), radius * self.unit, dxfattribs={"layer": layer})

    def arc(self, centre: complex, radius: float, from_deg: float, to_deg: float, layer: str = "THIN") -> None:
        """An arc, anticlockwise between two angles [°]."""
        self.space.add_arc(self.at(centre), radius * self.unit, from_deg, to_deg, dxfattribs={"layer": layer})

    def contour(self, contour: Contour, centre: complex) -> None:
        """An opening of the disc at true size, the disc's centre at ``centre`` of the paper."""
        draw_contour(self.space, contour, shift=complex(*self.at(centre)))

    def text(
        self, at: complex, text: str, height: float = TEXT, align: str = "LEFT", room: float = math.inf,
        turn_deg: float = 0.0,
    ) -> None:  # fmt: skip
        """One line of text, made lower where it is wider than ``room``."""
        from ezdxf.enums import TextEntityAlignment

        if not text:
            return
        shown = drawable(text)
        height *= min(1.0, room / text_width(shown, height))
        entity = self.space.add_text(
            shown,
            height=height * self.unit,
            rotation=turn_deg,
            dxfattribs={"layer": "TEXT", "style": STYLE, "width": _NARROW},
        )
        entity.set_placement(self.at(at), align=TextEntityAlignment[align])

    def symbol(self, middle: complex, symbol: str, height: float = TEXT) -> None:
        """A symbol about its middle; what follows an underscore is a subscript."""
        main, _, below = symbol.partition("_")
        small = 0.7 * height
        left = middle - 0.5 * (text_width(main, height) + text_width(below, small))
        self.text(left, main, height)
        if below:
            self.text(left + text_width(main, height) + 0.2 - 0.35j * height, below, small)

    def arrow(self, tip: complex, away: complex, length: float = 3.0) -> None:
        """A filled arrow head whose shaft goes ``away`` from the tip."""
        along = length * away / abs(away)
        side = 1j * along / 6.0
        corners = [self.at(p) for p in (tip, tip + along + side, tip + along - side)]
        self.space.add_solid([*corners, corners[-1]], dxfattribs={"layer": "DIMENSIONS"})

    def leader(self, tip: complex, knee: complex, lines: Sequence[str], to_left: bool) -> None:
        """An arrow at ``tip`` with a shoulder at ``knee`` under the first of some lines of text."""
        width = max(text_width(drawable(line), TEXT) for line in lines)
        end = knee + (-width - 1.0 if to_left else width + 1.0)
        self.path([tip, knee, end], "DIMENSIONS")
        self.arrow(tip, knee - tip)
        left = min(knee.real, end.real) + 0.5
        for i, line in enumerate(lines):
            down = -1.0 if i == 0 else 1.3 + TEXT + 1.5 * TEXT * (i - 1)
            self.text(complex(left, knee.imag - down), line)

    def dimension(
        self, start: complex, end: complex, line_at: complex, angle_deg: float, text: str = "<>", enlarged: float = 1.0
    ) -> None:
        """A linear dimension; ``enlarged`` is how much larger than the disc what is measured is drawn."""
        self.space.add_linear_dim(
            base=self.at(line_at),
            p1=self.at(start),
            p2=self.at(end),
            angle=angle_deg,
            text=text,
            dimstyle=STYLE,
            override={"dimlfac": 1.0 / enlarged},
            dxfattribs={"layer": "DIMENSIONS"},
        ).render()


def new_sheet(unit: float) -> Sheet:
    """An empty sheet on which a millimetre of paper is ``unit`` mm of the model."""
    doc = new_document(_SHEET_LAYERS, unit)
    doc.styles.add(STYLE, font=FONT).dxf.width = _NARROW
    style = doc.dimstyles.new(STYLE)
    values = {
        "dimscale": unit, "dimtxt": TEXT, "dimasz": 2.5, "dimexo": 0.8, "dimexe": 1.2, "dimgap": 0.8, "dimtad": 1,
        "dimtih": 0, "dimtoh": 0, "dimdec": 3, "dimzin": 8, "dimdsep": ord("."), "dimlunit": 2, "dimtofl": 1,
        "dimtxsty": STYLE, "dimlfac": 1.0,
    }  # fmt: skip
    for name, value in values.items():
        style.dxf.set(name, value)
    return Sheet(doc, unit)


def text_width(text: str, height: float) -> float:
    """Width of one line of text [mm of paper]."""
    from ezdxf.fonts import fonts

    width: float = fonts.make_font(FONT, height, _NARROW).text_width(text)
    return width


def drawable(text: str) -> str:
    """The text as it is where the font has its letters, else in plain ones."""
    return text if all(ord(letter) < _LATIN_AND_GREEK or letter in "′–" for letter in text) else plain_name(text)


def polar(radius: float, angle_deg: float) -> complex:
    """Point at a radius and an angle [°]."""
    return cmath.rect(radius, math.radians(angle_deg))
