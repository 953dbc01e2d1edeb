"""A drawing in SVG and PDF at its size on paper, through the drawing add-on of ezdxf and matplotlib."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from cycloid_profile.export.drawing_sheet import A3

_INCH = 25.4
_SALT = "cycloid_profile"
# No dates, so that equal input gives equal bytes.
_METADATA = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}, ".png": {}}


@contextmanager
def _settled_chance() -> Iterator[None]:
    """The same random numbers each time: ezdxf moves hatch lines by chance, by a thousandth of their distance."""
    before = random.getstate()
    random.seed(0)
    try:
        yield
    finally:
        random.setstate(before)


@cache
def use_own_font() -> None:
    """Let ezdxf take the fonts that come with matplotlib, not other versions of them on this machine."""
    import matplotlib
    from ezdxf.fonts import fonts

    fonts.font_manager.scan_folder(Path(matplotlib.get_data_path()) / "fonts" / "ttf")


def print_drawing(doc: Any, unit: float, paths: list[Path], dpi: float = 150.0) -> None:
    """Write the model space as pictures of an A3 sheet, ``unit`` mm of the model to one of paper."""
    import matplotlib
    from ezdxf.addons.drawing import Frontend, RenderContext
    from ezdxf.addons.drawing.config import (
        BackgroundPolicy,
        ColorPolicy,
        Configuration,
        LineweightPolicy,
    )
    from ezdxf.addons.drawing.matplotlib import MatplotlibBackend
    from matplotlib.figure import Figure

    config = Configuration(
        background_policy=BackgroundPolicy.WHITE,
        color_policy=ColorPolicy.BLACK,
        lineweight_policy=LineweightPolicy.ABSOLUTE,
        max_flattening_distance=0.01 * unit,
    )
    with matplotlib.rc_context({"svg.hashsalt": _SALT, "path.simplify": False}), _settled_chance():
        figure = Figure(figsize=(A3[0] / _INCH, A3[1] / _INCH))
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        backend = MatplotlibBackend(axes, adjust_figure=False)
        Frontend(RenderContext(doc), backend, config=config).draw_layout(doc.modelspace(), finalize=True)
        axes.set_xlim(0.0, A3[0] * unit)
        axes.set_ylim(0.0, A3[1] * unit)
        for path in paths:
            figure.savefig(path, dpi=dpi, metadata=_METADATA[path.suffix])
