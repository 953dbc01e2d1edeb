"""A drawing sheet in millimetres of paper, drawn over a model at true size and printed as SVG and PDF."""

from __future__ import annotations

import cmath
import math
import random
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from cycloid_profile.export.drawing._space import A3, Space
from cycloid_profile.export.drawing._text import outlines, text_box, text_width
from cycloid_profile.export.dxf import LAYERS, Layer, draw_contour, new_document
from cycloid_profile.geometry import Contour

TEXT, SMALL, LARGE = 2.5, 1.8, 5.0  # heights of capitals
APPLICATION = "CYCLOID_PROFILE"  # of the extended data that holds the characters of a text
# Wide 0.5 and narrow 0.25 mm (ISO 128-2, line group 0.5), the frame 0.7 mm (ISO 5457); black, for white paper.
_SHEET_LAYERS = (
    *(Layer(layer.name, 7, layer.linetype, layer.lineweight) for layer in LAYERS),
    Layer("FRAME", 7, lineweight=70),
    Layer("TABLE", 7, lineweight=50),
    Layer("THIN", 7),
    Layer("DIMENSIONS", 7),
    Layer("HATCH", 7),
)
_INCH, _POINT = 25.4, 25.4 / 72.0
_DECIMALS = 3  # of the outlines of letters [mm of paper]
_SALT = "cycloid_profile"
_ALIGN = {"LEFT": 0.0, "CENTER": 0.5, "RIGHT": 1.0}
# No dates, so that equal input gives equal bytes.
_METADATA = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}


@dataclass(frozen=True, slots=True)
class Sheet:
    """A drawing sheet; points are complex, in mm of paper from its lower left corner.

    Everything drawn takes its cells of ``taken``, so that labels find free places. ``texts`` lists what is written.
    """

    doc: Any
    unit: float
    taken: Space = field(default_factory=Space)
    texts: list[str] = field(default_factory=list)

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
        self.taken.stroke([start, end])
        self.space.add_line(self.at(start), self.at(end), dxfattribs={"layer": layer})

    def polyline(self, points: Sequence[complex], layer: str = "THIN", closed: bool = False) -> None:
        """Straight segments through the points."""
        self.taken.stroke([*points, points[0]] if closed else points)
        self.space.add_lwpolyline([self.at(p) for p in points], close=closed, dxfattribs={"layer": layer})

    def box(self, corner: complex, size: complex, layer: str = "THIN") -> None:
        """A rectangle from its lower left corner."""
        w, h = size.real, size.imag
        self.polyline([corner, corner + w, corner + size, corner + 1j * h], layer, closed=True)

    def circle(self, centre: complex, radius: float, layer: str = "THIN") -> None:
        """A circle."""
        self.taken.stroke([centre + polar(radius, 3.0 * i) for i in range(121)])
        self.space.add_circle(self.at(centre), radius * self.unit, dxfattribs={"layer": layer})

    def arc(self, centre: complex, radius: float, from_deg: float, to_deg: float, layer: str = "THIN") -> None:
        """An arc, anticlockwise between two angles [°]."""
        self.taken.stroke([centre + polar(radius, from_deg + (to_deg - from_deg) * i / 60.0) for i in range(61)])
        self.space.add_arc(self.at(centre), radius * self.unit, from_deg, to_deg, dxfattribs={"layer": layer})

    def contour(self, contour: Contour, centre: complex) -> None:
        """An opening of the disc at true size, the disc's centre at ``centre`` of the paper."""
        draw_contour(self.space, contour, shift=complex(*self.at(centre)))

    def solid(self, corners: Sequence[complex]) -> None:
        """A filled triangle."""
        self.taken.stroke([*corners, corners[0]])
        self.space.add_solid([self.at(p) for p in (*corners, corners[-1])], dxfattribs={"layer": "DIMENSIONS"})

    def arrow(self, tip: complex, away: complex, length: float = 3.0) -> None:
        """A filled arrow head whose shaft points ``away`` from the tip."""
        along = length * away / abs(away)
        self.solid([tip, tip + along * (1.0 + 1j / 6.0), tip + along * (1.0 - 1j / 6.0)])

    def text(
        self, at: complex, text: str, height: float = TEXT, align: str = "LEFT", room: float = math.inf,
        turn: complex = 1.0,
    ) -> None:  # fmt: skip
        """One line of text as filled outlines, smaller where it is wider than ``room``; ``turn`` has unit length."""
        if not text:
            return
        self.texts.append(text)
        height *= min(1.0, room / max(text_width(text, height), 1e-9))
        start = at - turn * _ALIGN[align] * text_width(text, height)
        corner, size = text_box(text, height)
        ends = (start + turn * corner, start + turn * (corner + size))
        low = complex(min(e.real for e in ends), min(e.imag for e in ends))
        self.taken.text(low, complex(abs((ends[1] - ends[0]).real), abs((ends[1] - ends[0]).imag)))
        hatch = self.space.add_hatch(color=256, dxfattribs={"layer": "TEXT", "hatch_style": 0})
        hatch.set_xdata(APPLICATION, [(1000, text)])
        decimals = _DECIMALS - math.floor(math.log10(self.unit))
        for letter in outlines(text, height):
            points = ((start + turn * p) * self.unit for p in letter)
            hatch.paths.add_polyline_path([(round(p.real, decimals), round(p.imag, decimals)) for p in points])

    def symbol(self, middle: complex, symbol: str, height: float = TEXT) -> None:
        """A symbol centred on ``middle``; characters after an underscore are a subscript."""
        main, _, below = symbol.partition("_")
        small = 0.7 * height
        left = middle - 0.5 * (text_width(main, height) + text_width(below, small))
        self.text(left, main, height)
        self.text(left + text_width(main, height) + 0.2 - 0.35j * height, below, small)


def new_sheet(unit: float) -> Sheet:
    """An empty sheet on which a millimetre of paper is ``unit`` mm of the model."""
    doc = new_document(_SHEET_LAYERS, unit)
    doc.appids.add(APPLICATION)
    return Sheet(doc, unit)


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


def print_drawing(doc: Any, unit: float, paths: list[Path], dpi: float = 150.0) -> None:
    """Write the model space as A3 pages, ``unit`` mm of the model per mm of paper, lines in their widths."""
    import matplotlib
    from ezdxf.addons.drawing import Frontend, RenderContext
    from ezdxf.addons.drawing.config import BackgroundPolicy, ColorPolicy, Configuration, LineweightPolicy
    from ezdxf.addons.drawing.matplotlib import MatplotlibBackend
    from matplotlib.figure import Figure

    config = Configuration(
        background_policy=BackgroundPolicy.WHITE,
        color_policy=ColorPolicy.BLACK,
        lineweight_policy=LineweightPolicy.ABSOLUTE,
        # The backend takes widths of the layers [mm] for points, and none below a pixel.
        lineweight_scaling=1.0 / _POINT,
        min_lineweight=0.01,
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
