"""Common style of all figures: colours for colour-blind readers and grey print, axes, titles, legends, and saving."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.errors import CycloidError
from cycloid_profile.plot._lettering import translate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe & Ito (2008), ordered so that neighbours also differ in lightness.
BLACK, BLUE, ORANGE, GREEN, SKY, GREY = "#000000", "#0072B2", "#D55E00", "#009E73", "#56B4E9", "#7F7F7F"
THEORY: dict[str, Any] = {"color": BLACK, "linestyle": "-", "linewidth": 1.0}
# Dashed and drawn on top, so that it stays visible where it runs along the compensated curve.
CONVENTIONAL: dict[str, Any] = {"color": BLUE, "linestyle": "--", "linewidth": 1.6, "zorder": 3}
COMPENSATED: dict[str, Any] = {"color": ORANGE, "linestyle": "-", "linewidth": 1.8}

_RC: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10.0,
    "axes.titlesize": 11.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#D9D9D9",
    "grid.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "cycloid-profile",
    "svg.fonttype": "none",
    "path.simplify_threshold": 0.05,
}
_PIXELS_PER_INCH = 110  # 9 inches are 1,000 pixels, the width of a page
_PNG_COLOURS = 256  # the most that a palette holds


def plain(text: str) -> str:
    """Text with escaped dollar signs, so that matplotlib does not read it as mathtext."""
    return text.replace("$", r"\$")


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib settings of this package, restored afterwards."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def new_figure(width: float = 8.0, height: float = 5.0) -> Figure:
    """An empty figure of the given size [inch], not registered with pyplot."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


@dataclass(frozen=True, slots=True)
class Canvas:
    """Axes to draw into: one, or an array of them; ``own`` where their figure was made for this drawing."""

    axes: Any
    own: bool

    @property
    def figure(self) -> Any:
        """Figure of the axes."""
        return figure_holding(self.axes)

    def title(self, name: str, text: str) -> None:
        """Heading: ``name`` of the drive and ``text``; of given axes, only a single pair gets it."""
        heading = titled(name, text)
        if self.own:
            self.figure.suptitle(heading)
        elif not isinstance(self.axes, np.ndarray):
            self.axes.set_title(heading)

    def legend(self, columns: int, **options: Any) -> None:
        """Legend below a figure of this drawing, inside the first of given axes."""
        if self.own:
            self.figure.legend(loc="outside lower center", ncols=columns, **options)
        else:
            np.asarray(self.axes, dtype=object).flat[0].legend(**options)


@contextmanager
def canvas(
    ax: Any, size: tuple[float, float], rows: int = 1, columns: int = 1, polar: Sequence[int] = (), **layout: Any
) -> Iterator[Canvas]:
    """The given axes, or those of a new figure of ``size`` [inch], with the settings of this package while drawing.

    ``polar``, numbers of the polar axes, row by row from 0; ``layout`` goes to ``Figure.subplots``. Raises
    ``CycloidError`` where the number of given axes is wrong.
    """
    with style():
        if ax is None:
            figure = new_figure(*size)
            if polar:
                names = np.arange(rows * columns).astype(str).reshape(rows, columns)
                looks: dict[Any, dict[str, Any]] = {str(number): {"projection": "polar"} for number in polar}
                made = figure.subplot_mosaic(names.tolist(), per_subplot_kw=looks, **layout)
                yield Canvas(np.squeeze(np.array(list(made.values()), dtype=object).reshape(rows, columns)), own=True)
            else:
                yield Canvas(figure.subplots(rows, columns, **layout), own=True)
            return
        given = np.asarray(ax, dtype=object)
        if given.size != rows * columns:
            raise CycloidError("ax", f"{given.size} axes", f"must be {rows * columns}", "give as many, or none")
        shape = (rows, columns) if layout.get("squeeze") is False else [n for n in (rows, columns) if n > 1]
        shaped = given.reshape(shape)
        yield Canvas(shaped if shaped.ndim else shaped.item(), own=False)


def titled(name: str, text: str) -> str:
    """Title of a picture, after the name of the drive where there is one."""
    return f"{plain(name)}: {text}" if name else text


def save(drawn: Any, folder: Path, name: str) -> tuple[Path, Path]:
    """Write ``name.png`` and ``name.svg`` of a figure or of the figure of axes; the same input gives the same bytes."""
    figure = figure_holding(drawn)
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    with _ready(figure):
        _save_png(figure, png)
        figure.savefig(svg, metadata={"Date": None, "Creator": None})
    return png, svg


def save_png(drawn: Any, path: Path) -> None:
    """Write one PNG of a figure, or of the figure of some axes; the same input gives the same bytes."""
    figure = figure_holding(drawn)
    with _ready(figure):
        _save_png(figure, path)


def figure_holding(drawn: Any) -> Figure:
    """The figure itself, or that of the first of the axes."""
    if hasattr(drawn, "savefig"):
        return drawn  # type: ignore[no-any-return]
    # The figure of a subfigure is the whole one.
    return np.asarray(drawn, dtype=object).flat[0].figure.figure  # type: ignore[no-any-return]


@contextmanager
def _ready(figure: Figure) -> Iterator[None]:
    """Compute the layout once for all files; with a layout engine each file would draw the figure twice."""
    import matplotlib as mpl

    with style(), warnings.catch_warnings():
        translate(figure)
        # A name in another script shows as boxes in the PNG only; the SVG and the report keep its letters.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        engine = figure.get_layout_engine()
        if engine is not None:
            figure.set_dpi(_PIXELS_PER_INCH)
            engine.execute(figure)
        with mpl.rc_context({"figure.constrained_layout.use": False}):
            figure.set_layout_engine(None)
            yield


def _save_png(figure: Figure, path: Path) -> None:
    """A palette image, a third of the size of a full-colour one.

    The palette covers the whole range of colours: the ends of a colour map are rare, and the most significant.
    """
    from PIL import Image

    buffer = BytesIO()
    # Read again at once: compressing it would be lost time.
    figure.savefig(buffer, format="png", dpi=_PIXELS_PER_INCH, pil_kwargs={"compress_level": 0})
    image = Image.open(buffer).convert("RGB")
    palette = image.quantize(_PNG_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    palette.save(path, optimize=True)


def phase_axis(ax: Axes, low: int = -180, high: int = 180) -> None:
    """Label the x axis as the phase of one lobe, root in the middle."""
    ax.set_xlim(low, high)
    ax.set_xticks(range(low, high + 1, 30 if high - low <= 200 else 60))
    ax.set_xlabel("phase ψ [°]   (0 root, ±180 tip)")


def headroom(ax: Axes, share: float) -> None:
    """Room for a legend above the curves, as a share of their height."""
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + share * (high - low))


def row_axis(ax: Axes, labels: list[str], **look: Any) -> None:
    """Label the rows of a bar chart, the first at the top."""
    ax.set_yticks(range(len(labels)), labels, **look)
    ax.set_ylim(len(labels) - 0.4, -0.6)
    ax.grid(visible=False, axis="y")


def note(ax: Axes, text: str, at: tuple[float, float], points: tuple[float, float], **look: Any) -> Any:
    """Text ``points`` to the right of and above a place; the annotation."""
    return ax.annotate(text, at, xytext=points, textcoords="offset points", **look)


def line_mark(label: str, **look: Any) -> Any:
    """A line or marker of a legend."""
    from matplotlib.lines import Line2D

    return Line2D([], [], label=label, **look)


def patch_mark(label: str, **look: Any) -> Any:
    """A filled or framed box of a legend."""
    from matplotlib.patches import Patch

    return Patch(label=label, **look)


def round_up(value: float, steps: tuple[float, ...] = (1.0, 2.0, 5.0, 10.0)) -> float:
    """The least of ``steps`` times a power of ten that is not below ``value``."""
    decade = 10.0 ** math.floor(math.log10(value))
    return next(step * decade for step in steps if step * decade >= value * (1.0 - 1e-9))
