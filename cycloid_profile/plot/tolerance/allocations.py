"""Figures of an allocation: tolerances and their costs before and after, and the limited quantities."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.plot.style import BLACK, BLUE, GREY, ORANGE, canvas, note, plain, row_axis
from cycloid_profile.tolerance.allocation import AllocatedTolerance, Allocation, percent
from cycloid_profile.tolerance.inputs import Limit
from cycloid_profile.tolerance.model import QUANTITIES
from cycloid_profile.units import SIGNS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BAR = 0.38
_BINS = 80
_SHOWN = 4.5  # half widths of the middle two thirds; the tail of reducers that bind would hide the rest


def tolerance_bars(allocation: Allocation, ax: Any = None, *, name: str = "") -> Any:
    """Each tolerance before and after on a logarithmic axis, marked where it met a bound; one pair of axes."""
    lines = allocation.lines
    units = sorted({line.unit for line in lines})
    with canvas(ax, (10.0, 1.6 + 0.45 * len(lines))) as drawn:
        axes = drawn.axes
        _bars(axes, -0.5, GREY, "as drawn", [line.plus_minus_before for line in lines])
        _bars(axes, 0.5, BLUE, "allocated", [line.plus_minus_after for line in lines])
        for place, line in enumerate(lines):
            widest = max(line.plus_minus_before, line.plus_minus_after)
            note(axes, _change(line), (widest, place), (6, 0), va="center", fontsize=9)
        axes.set_xscale("log")
        _room_for_numbers(axes, lines)
        row_axis(axes, [_label(line) for line in lines])
        axes.set_xlabel(f"tolerance ± [{units[0] if len(units) == 1 else 'unit of each'}]")
        drawn.legend(2)
        drawn.title(name, f"tolerances for a yield of {100.0 * allocation.wanted:g} %")
    return axes


def _bars(ax: Axes, side: float, colour: str, label: str, widths: Sequence[float]) -> Any:
    return ax.barh(np.arange(len(widths)) + side * _BAR, widths, 0.95 * _BAR, color=colour, label=label)


def _label(line: AllocatedTolerance) -> str:
    return plain(line.label.replace("_", " "))


def _change(line: AllocatedTolerance) -> str:
    text = f"±{line.plus_minus_before:.3g} → ±{line.plus_minus_after:.3g} {line.unit}"
    if line.cost_before is None:
        return f"±{line.plus_minus_before:.3g} {line.unit}, no cost given"
    return f"{text}, {line.bound} allowed" if line.bound else text


def _room_for_numbers(ax: Axes, lines: tuple[AllocatedTolerance, ...]) -> None:
    """Set ticks at 1, 2 and 5 of each decade, and leave room on the right for the text."""
    widths = [width for line in lines for width in (line.plus_minus_before, line.plus_minus_after) if width > 0.0]
    low, high = 0.6 * min(widths), max(widths)
    ax.set_xlim(low, high * (high / low) ** 0.6)
    ticks = [
        m * 10.0**e for e in range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1) for m in (1, 2, 5)
    ]
    shown = [tick for tick in ticks if low <= tick <= 1.2 * high]
    ax.set_xticks(shown, [f"{tick:g}" for tick in shown])
    ax.set_xticks([], minor=True)


def cost_bars(allocation: Allocation, ax: Any = None, *, name: str = "") -> Any:
    """Cost of each tolerance before and after, as a share of the cost of all as drawn; one pair of axes."""
    lines = [line for line in allocation.lines if line.cost_before is not None]
    whole = allocation.cost_before
    with canvas(ax, (10.0, 1.6 + 0.45 * len(lines))) as drawn:
        axes = drawn.axes
        for side, colour, label, total, costs in (
            (-0.5, GREY, "as drawn", allocation.cost_before, [line.cost_before for line in lines]),
            (0.5, BLUE, "allocated", allocation.cost_after, [line.cost_after for line in lines]),
        ):
            shares = [100.0 * (cost or 0.0) / whole for cost in costs]
            total_label = f"{label}, {total:.4g} in all, {100.0 * total / whole:.3g} %"
            bars = _bars(axes, side, colour, total_label, shares)
            axes.bar_label(bars, [f"{share:.1f}" for share in shares], padding=4, fontsize=8)
        row_axis(axes, [_label(line) for line in lines])
        axes.margins(x=0.08)
        axes.set_xlabel("cost of a tolerance [% of the cost of all as drawn]")
        drawn.legend(2)
        each = ", all costs assumed equal" if allocation.assumed_costs else ""
        per_percent = 100.0 * allocation.cost_per_percent / whole
        drawn.title(name, f"cost of tolerances{each}; one more percent of yield costs {per_percent:.2g} %")
    return axes


def limited_quantities(allocation: Allocation, ax: Any = None, *, name: str = "") -> Any:
    """Distribution of every limited quantity before and after, with its limits and yield; an array of axes."""
    count = len(allocation.limits)
    with canvas(ax, (9.0, 1.4 + 2.9 * count), count, 1, squeeze=False) as drawn:
        panels = drawn.axes[:, 0]
        for axes, limit in zip(panels, allocation.limits, strict=True):
            column = allocation.names.index(limit.quantity)
            _distribution(axes, limit, allocation.before[:, column], allocation.after[:, column])
        before, after = percent(allocation.yield_before), percent(allocation.yield_after)
        drawn.title(name, f"all limits kept by {before} as drawn,\n{after} as allocated")
    return panels


def _distribution(ax: Axes, limit: Limit, before: FloatArray, after: FloatArray) -> None:
    ends = [end for end in (limit.at_least, limit.at_most) if math.isfinite(end)]
    shown = [*_range(before), *_range(after), *ends]
    low, high = min(shown), max(shown)
    edges = np.linspace(low - 0.03 * (high - low), high + 0.03 * (high - low), _BINS + 1)
    for values, label, colour in ((before, "as drawn", GREY), (after, "allocated", BLUE)):
        share = 100.0 * float(np.mean(limit.beyond(values) <= 0.0))
        off = 100.0 * float(np.mean(~((values >= edges[0]) & (values <= edges[-1]))))
        more = f", {off:.1f} % off the picture" if off >= 0.1 else ""
        weights = np.full(values.shape, 100.0 / values.size)
        fill = {"alpha": 0.45} if colour == GREY else {"histtype": "step", "linewidth": 1.8}
        ax.hist(
            values, list(edges), weights=weights, color=colour, label=f"{label}: {share:.1f} % within{more}", **fill
        )
    for end in ends:
        ax.axvline(end, color=ORANGE if end == limit.at_most else BLACK, linewidth=1.6)
        ax.annotate(
            f" {'≤' if end == limit.at_most else '≥'} {end:g}", (end, 1.0), xycoords=("data", "axes fraction"),
            va="top", ha="left" if end == limit.at_least else "right", fontsize=9,
        )  # fmt: skip
    ax.set_xlim(edges[0], edges[-1])
    words, _, unit = limit.quantity.rpartition("_")
    label = QUANTITIES.get(limit.quantity, words.replace("_", " "))
    ax.set_xlabel(f"{plain(label)} [{SIGNS.get(unit, unit)}]")
    ax.set_ylabel("reducers [% a bin]")
    ax.legend()


def _range(values: FloatArray) -> tuple[float, float]:
    """Ends of the part of a sample that is drawn, none beyond its extremes."""
    sixth, middle, last = np.nanquantile(values, [1.0 / 6.0, 0.5, 5.0 / 6.0])
    reach = 0.5 * _SHOWN * (last - sixth)
    return float(max(np.nanmin(values), middle - reach)), float(min(np.nanmax(values), middle + reach))
