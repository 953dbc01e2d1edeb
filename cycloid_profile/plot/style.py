"""One look for all pictures: colours told apart by all eyes and in grey print, no fonts to install."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
_PIXELS_PER_INCH = 110
_PNG_COLOURS = 256


def plain(text: str) -> str:
    """Text in which a dollar sign is a dollar sign, not the start of a formula."""
    return text.replace("$", r"\$")


@contextmanager
def style() -> Iterator[None]:
    """Matplotlib settings of this package, put back afterwards."""
    import matplotlib as mpl

    with mpl.rc_context(_RC):
        yield


def new_figure(width: float = 8.0, height: float = 5.0) -> Figure:
    """An empty figure of the given size [inch], not known to pyplot."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def save(figure: Figure, folder: Path, name: str) -> tuple[Path, Path]:
    """Write ``name.png`` and ``name.svg``; the same figure gives the same bytes."""
    png, svg = folder / f"{name}.png", folder / f"{name}.svg"
    with style(), warnings.catch_warnings():
        # A name in another script shows as boxes in the PNG only; the SVG and the report keep its letters.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        with _laid_out(figure):
            _save_png(figure, png)
            figure.savefig(svg, metadata={"Date": None, "Creator": None})
    return png, svg


def save_png(figure: Figure, path: Path) -> None:
    """Write one PNG; the same figure gives the same bytes."""
    with style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from font")
        with _laid_out(figure):
            _save_png(figure, path)


@contextmanager
def _laid_out(figure: Figure) -> Iterator[None]:
    """Place the axes once for all files: a figure that still has a layout engine is drawn twice for each of them."""
    import matplotlib as mpl

    engine = figure.get_layout_engine()
    if engine is not None:
        figure.set_dpi(_PIXELS_PER_INCH)
        engine.execute(figure)
    with mpl.rc_context({"figure.constrained_layout.use": False}):
        figure.set_layout_engine(None)
        yield


def _save_png(figure: Figure, path: Path) -> None:
    """A palette image, a third of the size of a full-colour one.

    The palette covers all colours there are, not the frequent ones best: the ends of a colour map are rare, and what
    stands out most.
    """
    from PIL import Image

    buffer = BytesIO()
    figure.savefig(buffer, format="png", dpi=_PIXELS_PER_INCH)
    image = Image.open(buffer).convert("RGB")
    palette = image.quantize(_PNG_COLOURS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    palette.save(path, optimize=True)


def phase_axis(ax: Axes, low: int = -180, high: int = 180) -> None:
    """Label the x axis as the phase of one lobe, root in the middle."""
    ax.set_xlim(low, high)
    ax.set_xticks(range(low, high + 1, 30 if high - low <= 200 else 60))
    ax.set_xlabel("phase ψ [°]   (0 root, ±180 tip)")
