"""A drawing sheet in millimetres of paper, drawn over a model at true size and printed as SVG and PDF."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from cycloid_profile.export.dxf import LAYERS, Layer, draw_contour, new_document
from cycloid_profile.export.writing import plain_name
from cycloid_profile.geometry import Contour

A3 = (420.0, 297.0)
FONT = "DejaVuSans.ttf"  # comes with matplotlib, so that prints are identical on every machine
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
_INCH = 25.4
_SALT = "cycloid_profile"
# No dates, so that equal input gives equal bytes.
_METADATA = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}


@dataclass(frozen=True, slots=True)
class Sheet:
    """A drawing sheet; points are complex, in mm of paper from its lower left corner."""

    doc: Any
    unit: float

    @property
    def space(self) -> Any:
        """The model space."""
        return self.doc.modelspace()

    def at(self, point: complex) -> tuple[float, float]:
        """Model coordinates of a point of the paper [mm]."""
        # Twelve decimals, so that the last bit of a sine does not change the file.
        return round(point.real * self.unit, 12) + 0.0, round(point.imag * self.unit, 12) + 0.0

    def line(self, start: complex, end: complex, layer: str = "THIN") -> None:
        """A straight line."""
        self.space.add_line(self.at(start), self.at(end), dxfattribs={"layer": layer})

    def polyline(self, points: Sequence[complex], layer: str = "THIN", closed: bool = False) -> None:
        """Straight segments through the points."""
        self.space.add_lwpolyline([self.at(p) for p in points], close=closed, dxfattribs={"layer": layer})

    def box(self, corner: complex, size: complex, layer: str = "THIN") -> None:
        """A rectangle from its lower left corner."""
        w, h = size.real, size.imag
        self.polyline([corner, corner + w, corner + size, corner + 1j * h], layer, closed=True)

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
        """One line of text, its height reduced where it is wider than ``room``."""
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
        """A symbol centred on ``middle``; characters after an underscore are a subscript."""
        main, _, below = symbol.partition("_")
        small = 0.7 * height
        left = middle - 0.5 * (text_width(main, height) + text_width(below, small))
        self.text(left, main, height)
        if below:
            self.text(left + text_width(main, height) + 0.2 - 0.35j * height, below, small)

    def arrow(self, tip: complex, away: complex, length: float = 3.0) -> None:
        """A filled arrow head whose shaft points ``away`` from the tip."""
        along = length * away / abs(away)
        side = 1j * along / 6.0
        corners = [self.at(p) for p in (tip, tip + along + side, tip + along - side)]
        self.space.add_solid([*corners, corners[-1]], dxfattribs={"layer": "DIMENSIONS"})

    def leader(self, tip: complex, knee: complex, lines: Sequence[str], to_left: bool) -> None:
        """A leader: an arrow at ``tip``, and from ``knee`` on a horizontal line under the first line of text."""
        width = max(text_width(drawable(line), TEXT) for line in lines)
        end = knee + (-width - 1.0 if to_left else width + 1.0)
        self.polyline([tip, knee, end], "DIMENSIONS")
        self.arrow(tip, knee - tip)
        left = min(knee.real, end.real) + 0.5
        for i, line in enumerate(lines):
            down = -1.0 if i == 0 else 1.3 + TEXT + 1.5 * TEXT * (i - 1)
            self.text(complex(left, knee.imag - down), line)

    def dimension(
        self, start: complex, end: complex, line_at: complex, angle_deg: float, text: str = "<>", enlarged: float = 1.0
    ) -> None:
        """A linear dimension; ``enlarged`` is the scale of the drawn part relative to the disc."""
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
    """The text itself if the font has its letters, else ``plain_name`` of it."""
    return text if all(ord(letter) < _LATIN_AND_GREEK or letter in "′–" for letter in text) else plain_name(text)


def polar(radius: float, angle_deg: float) -> complex:
    """Point at a radius and an angle [°]."""
    return cmath.rect(radius, math.radians(angle_deg))


@contextmanager
def _fixed_random_numbers() -> Iterator[None]:
    """Seeds the random numbers with which ezdxf shifts hatch lines by a thousandth of their spacing."""
    before = random.getstate()
    random.seed(0)
    try:
        yield
    finally:
        random.setstate(before)


@cache
def use_own_font() -> None:
    """Let ezdxf use the fonts of matplotlib instead of other versions installed on the machine."""
    import matplotlib
    from ezdxf.fonts import fonts

    fonts.font_manager.scan_folder(Path(matplotlib.get_data_path()) / "fonts" / "ttf")


def print_drawing(doc: Any, unit: float, paths: list[Path], dpi: float = 150.0) -> None:
    """Write the model space as A3 pages, ``unit`` mm of the model per mm of paper."""
    import matplotlib
    from ezdxf.addons.drawing import Frontend, RenderContext
    from ezdxf.addons.drawing.config import BackgroundPolicy, ColorPolicy, Configuration, LineweightPolicy
    from ezdxf.addons.drawing.matplotlib import MatplotlibBackend
    from matplotlib.figure import Figure

    config = Configuration(
        background_policy=BackgroundPolicy.WHITE,
        color_policy=ColorPolicy.BLACK,
        lineweight_policy=LineweightPolicy.ABSOLUTE,
        max_flattening_distance=0.01 * unit,
    )
    with matplotlib.rc_context({"svg.hashsalt": _SALT, "path.simplify": False}), _fixed_random_numbers():
        figure = Figure(figsize=(A3[0] / _INCH, A3[1] / _INCH))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        backend = MatplotlibBackend(axes, adjust_figure=False)
        Frontend(RenderContext(doc), backend, config=config).draw_layout(doc.modelspace(), finalize=True)
        axes.set_xlim(0.0, A3[0] * unit)
        axes.set_ylim(0.0, A3[1] * unit)
        for path in paths:
            figure.savefig(path, dpi=dpi, metadata=_METADATA[path.suffix])
