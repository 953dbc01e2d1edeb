"""Figures of a tolerance study: distributions with their yield, contributions of the tolerances, sensitivities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.design import TighteningAdvice, ToleranceRecord
from cycloid_profile.errors import CycloidError, did_you_mean
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, canvas, plain, row_axis
from cycloid_profile.tolerance.model import QUANTITIES, RESPONSES
from cycloid_profile.tolerance.ranking import Contribution, SobolShare, ToleranceSensitivity
from cycloid_profile.tolerance.study import QuantitySummary, StudySummary, Yield, histogram
from cycloid_profile.units import sign_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BAR = 0.38
_BINS = 80
_LEAST = "least_backlash_arcmin"  # only its share below zero matters, which the text reports
_SHORT = {
    "backlash_arcmin": ("backlash", "′"),
    "lost_motion_arcmin": ("lost motion at ±3 %", "′"),
    "transmission_error_arcsec": ("transmission error at rated torque", "″"),
    "peak_pressure_mpa": ("peak pressure at rated torque", " MPa"),
}
_AXIS_UNIT = {"′": "arcmin", "″": "arcsec", " MPa": "MPa"}


def distributions(result: ToleranceRecord | StudySummary, ax: Any = None, *, name: str = "") -> Any:
    """Distribution of each quantity over the reducers of a study, with percentiles, limit, yield and drawing.

    An array of axes, two in a row; the last is empty where their number is odd.
    """
    shown = _panels(result)
    across = min(2, len(shown))
    down = -(-len(shown) // across)
    with canvas(ax, (5.2 * across + 0.4, 3.4 * down + 0.5), down, across, squeeze=False) as drawn:
        for axes, one in zip(drawn.axes.flat, shown, strict=False):
            _panel(axes, *one)
        for axes in drawn.axes.flat[len(shown) :]:
            axes.set_axis_off()
        drawn.title(result.spec.name if isinstance(result, ToleranceRecord) else name, "reducers with their tolerances")
    return drawn.axes


def _panels(result: ToleranceRecord | StudySummary) -> list[tuple[QuantitySummary, Yield | None, float | None]]:
    """Each quantity once, from the study with most reducers, with its yield and its value for the reducer as drawn."""
    summaries, drawn = ((result,), {}) if isinstance(result, StudySummary) else (result.summaries, result.drawn)
    found: dict[str, QuantitySummary] = {}
    passed: dict[str, Yield] = {}
    for summary in reversed(summaries):
        found.update((one.name, one) for one in summary.quantities)
        passed.update((one.limit.quantity, one) for one in summary.yields if one.limit is not None)
    names = [name for name in QUANTITIES if name in found and name != _LEAST]
    return [(found[name], passed.get(name), drawn.get(name)) for name in names]


def _panel(ax: Axes, quantity: QuantitySummary, passed: Yield | None, drawn: float | None) -> None:
    label, unit = _SHORT[quantity.name]
    edges, share = histogram(quantity.spread, _BINS if quantity.spread.count > 5000 else 40)
    ax.stairs(100.0 * share, edges, fill=True, color=SKY, alpha=0.8)
    marks = [] if drawn is None else [(drawn, BLACK, "-", f"as drawn {_figure(drawn)}{unit}")]
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


def ranking(advice: TighteningAdvice, ax: Any = None, *, quantity: str = "backlash_arcmin", name: str = "") -> Any:
    """Pareto chart of one quantity, three axes.

    Left: the share of each tolerance in the variance, largest first, with the cumulative sum. Middle: the change of the
    99.73 % percentile and of the mean when the tolerance is halved. Right: its first- and total-order Sobol indices,
    with the estimate by first derivatives. Raises ``CycloidError`` for a quantity that is not ranked.
    """
    _refuse_unknown([quantity], advice)
    ranked = advice.of(quantity)
    found, which = ranked.found, ranked.found.quantities.index(quantity)
    rows = sorted(found.rows, key=lambda row: row.variance_share[which].value, reverse=True)
    groups = {share.group: share for share in ranked.shares.of(quantity)}
    y = np.arange(len(rows), dtype=np.float64)
    with canvas(ax, (13.0, 2.6 + 0.42 * len(rows)), 1, 3, sharey=True) as drawn:
        left, middle, right = drawn.axes
        _variance(left, rows, which, y)
        _halved(middle, rows, which, y, sign_of(quantity))
        # A tolerance that is one of several correlated ones has no index by itself.
        _indices(right, [groups.get(row.label) for row in rows], y)
        left.set_yticks(y, [_label(row.label, row.plus_minus, row.unit) for row in rows])
        # Room for the legends below the last row.
        left.set_ylim(len(rows) + 1.4, -0.6)
        drawn.title(name, f"{RESPONSES[quantity]}, {found.reducers:,} reducers".replace(",000", " 000"))
    return drawn.axes


def tornado(
    advice: TighteningAdvice, ax: Any = None, *, quantities: Sequence[str] | None = None, name: str = ""
) -> Any:
    """Sensitivity times tolerance of every scatter, one pair of axes per quantity: all parts together, and the worst
    part alone."""
    shown = [name for name in advice.quantities if name != _LEAST] if quantities is None else list(quantities)
    _refuse_unknown(shown, advice)
    rows = advice.sensitivities
    across = 2 if len(shown) == 4 else min(len(shown), 3)
    down = -(-len(shown) // across)
    with canvas(ax, (4.6 * across + 2.0, (1.6 + 0.34 * len(rows)) * down), down, across, squeeze=False) as drawn:
        for axes, quantity in zip(drawn.axes.flat, shown, strict=False):
            _tornado(axes, rows, quantity)
        for axes in drawn.axes.flat[len(shown) :]:
            axes.set_visible(False)
        handles, labels = drawn.axes.flat[0].get_legend_handles_labels()
        drawn.legend(2, handles=handles, labels=labels)
        drawn.title(name, "sensitivity × tolerance, each part at its limit")
    return drawn.axes


def _refuse_unknown(quantities: Sequence[str], advice: TighteningAdvice) -> None:
    for quantity in quantities:
        if quantity not in advice.quantities:
            remedy = did_you_mean(quantity, advice.quantities, f"ranked are {', '.join(advice.quantities)}")
            raise CycloidError("quantity", quantity, "is not ranked", remedy)


def _variance(ax: Axes, rows: Sequence[Contribution], which: int, y: np.ndarray) -> None:
    share = 100.0 * np.array([row.variance_share[which].value for row in rows])
    error = 100.0 * np.array([row.variance_share[which].error for row in rows])
    ax.barh(y, share, 0.7, color=BLUE, label="share")
    ax.errorbar(share, y, xerr=error, fmt="none", ecolor=BLACK, elinewidth=1.0, capsize=2.5)
    ax.plot(np.cumsum(share), y, color=ORANGE, marker="o", markersize=3.5, label="running sum")
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("variance that goes with the tolerance [%]\n± standard error")
    ax.legend(loc="lower right")


def _halved(ax: Axes, rows: Sequence[Contribution], which: int, y: np.ndarray, unit: str) -> None:
    for offset, label, colour, figures in (
        (-0.5 * _BAR, "99.73 % percentile", GREEN, [row.halved[which].percentile_9973 for row in rows]),
        (0.5 * _BAR, "mean", SKY, [row.halved[which].mean for row in rows]),
    ):
        value, error = (np.array([getattr(one, part) for one in figures]) for part in ("value", "error"))
        ax.barh(y + offset, value, _BAR, color=colour, label=label)
        ax.errorbar(value, y + offset, xerr=error, fmt="none", ecolor=BLACK, elinewidth=1.0, capsize=2.0)
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    ax.grid(visible=False, axis="y")
    ax.locator_params(axis="x", nbins=5)
    ax.set_xlabel(f"change when halved [{unit}]\n± standard error")
    ax.legend(loc="lower right")


def _indices(ax: Axes, shares: Sequence[SobolShare | None], y: np.ndarray) -> None:
    for offset, label, colour, marker, pick in (
        (-0.18, "first order", BLUE, "o", "first"),
        (0.18, "total", ORANGE, "s", "total"),
    ):
        found = [(at, getattr(share, pick)) for at, share in zip(y, shares, strict=True) if share is not None]
        value = np.array([one.value for _, one in found])
        ends = np.array([[one.value - one.low, one.high - one.value] for _, one in found]).T
        at = np.array([place for place, _ in found]) + offset
        ax.errorbar(
            value, at, xerr=np.maximum(ends, 0.0), fmt=marker, color=colour, markersize=4.5, capsize=2.5, label=label
        )
    linear = [(at, s.linear) for at, s in zip(y, shares, strict=True) if s is not None and s.linear is not None]
    if linear:
        ax.plot(*np.array(linear)[:, ::-1].T, "x", color=GREY, label="by first derivatives")
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    ax.set_xlabel("Sobol index, share of the variance\n95 % interval")
    ax.legend(loc="lower right")


def _tornado(ax: Axes, rows: Sequence[ToleranceSensitivity], quantity: str) -> None:
    ordered = sorted(rows, key=lambda row: row.effect_of_tolerance(quantity), reverse=True)
    y = np.arange(len(ordered), dtype=np.float64)
    which = list(RESPONSES).index(quantity)
    together = np.array([row.effect_of_tolerance(quantity) for row in ordered])
    low, high = np.array([row.worst[which].change_range(quantity) for row in ordered]).T
    ax.barh(y, 2.0 * together, 0.72, -together, color=SKY, label="all parts, root-sum-square")
    ax.barh(y, high - low, 0.34, low, color=BLUE, label="worst part alone, towards either limit")
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    row_axis(ax, [_label(row.label, row.tolerance, row.unit, row.count) for row in ordered], fontsize=8.5)
    ax.set_xlabel(f"{RESPONSES[quantity].split(',')[0]} [{sign_of(quantity)}]")
    ax.set_title(RESPONSES[quantity].split(",")[-1].strip() if "," in RESPONSES[quantity] else "")


def _label(label: str, plus_minus: float | None, unit: str, count: int = 1) -> str:
    words = plain(label.replace("_", " "))
    if plus_minus is None:
        return words
    return f"{words}\n{count} × ±{plus_minus:g} {unit}" if count > 1 else f"{words} ±{plus_minus:g} {unit}"
