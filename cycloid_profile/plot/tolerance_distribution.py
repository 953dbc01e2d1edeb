"""How a quantity is distributed over the reducers of a study, with its percentiles, its limit and the drawing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.plot.style import BLACK, BLUE, GREEN, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.tolerance.quantities import QUANTITIES
from cycloid_profile.tolerance.summary import QuantitySummary, Yield, histogram

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINS = 80
_SHORT = {
    "backlash_arcmin": ("backlash", "′"),
    "lost_motion_arcmin": ("lost motion at ±3 %", "′"),
    "transmission_error_arcsec": ("transmission error at rated torque", "″"),
    "peak_pressure_mpa": ("peak pressure at rated torque", " MPa"),
}
_AXIS_UNIT = {"′": "arcmin", "″": "arcsec", " MPa": "MPa"}


def distribution_plot(shown: list[tuple[QuantitySummary, Yield | None, float]], name: str) -> Figure:
    """A panel for each quantity with its yield, None without a limit, and its value as drawn; ``name`` of the drive."""
    with style():
        across = min(2, len(shown))
        down = -(-len(shown) // across)
        figure = new_figure(5.2 * across + 0.4, 3.4 * down + 0.5)
        axes = figure.subplots(down, across, squeeze=False)
        for ax, one in zip(axes.flat, shown, strict=False):
            _panel(ax, *one)
        for ax in axes.flat[len(shown) :]:
            ax.set_axis_off()
        figure.suptitle(plain(f"{name}: reducers with their tolerances"))
    return figure


def _panel(ax: Axes, quantity: QuantitySummary, passed: Yield | None, drawn: float) -> None:
    label, unit = _SHORT[quantity.name]
    edges, share = histogram(quantity.spread, _BINS if quantity.spread.count > 5000 else 40)
    ax.stairs(100.0 * share, edges, fill=True, color=SKY, alpha=0.8)
    marks = [(drawn, BLACK, "-", f"as drawn {_figure(drawn)}{unit}")]
    for percent, colour in ((50.0, BLUE), (99.0, ORANGE)):
        value = quantity.percentiles[percent].value
        marks.append((value, colour, "--", f"{percent:g} % below {_figure(value)}{unit}"))
    if passed is not None and passed.limit is not None:
        share_in = 100.0 * passed.share.value
        limit = passed.limit.at_most
        marks.append((limit, GREEN, "-", f"limit {limit:g}{unit}: {share_in:.4g} % pass"))
    for value, colour, dash, text in marks:
        ax.axvline(value, color=colour, linestyle=dash, linewidth=1.6, label=text)
    ax.set_title(f"{label}   ({quantity.spread.count:,} reducers)", loc="left")
    ax.set_xlabel(f"{QUANTITIES[quantity.name].split(',')[0].split(' at ')[0]} [{_AXIS_UNIT[unit]}]")
    ax.set_ylabel("reducers in a bar [%]")
    high = float(np.max(share)) * 100.0 if share.size else 1.0
    ax.set_ylim(0.0, 1.45 * high if high > 0.0 else 1.0)
    ax.legend(fontsize=8.5, loc="upper right", frameon=True, framealpha=0.92, edgecolor="none")


def _figure(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
