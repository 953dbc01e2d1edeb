"""The published budgets beside those of the drive at hand."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.catalog.published import lost_motion_article
from cycloid_profile.plot.style import BLACK, BLUE, GREY, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.tolerance.published_budget import TABLE, TEXT, Budget, Part
from cycloid_profile.tolerance.published_sensitivities import FACTORS, Sensitivity
from cycloid_profile.units import ARCMIN

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PARTS = ("involute stage", "cycloid stage", "eccentric bearing", "total")
_BAR = 0.26
# Below this the axis is linear, so that small and negative values are seen beside large ones.
_LINEAR = 1.0  # ′/mm


def sensitivity_plot(rows: tuple[Sensitivity, ...], name: str) -> Figure:
    """Bars of the fifteen factors [′/mm]: as published, corrected and measured, whiskers over a turn of the output."""
    y = np.arange(len(rows), dtype=np.float64)
    with style():
        figure = new_figure(10.0, 9.0)
        ax = figure.subplots()
        for offset, label, colour, values in (
            (-_BAR, "as published", GREY, [row.as_published for row in rows]),
            (0.0, "as published, corrected", SKY, [row.corrected for row in rows]),
            (_BAR, "from geometry, mean over a turn", BLUE, [_mean(row) for row in rows]),
        ):
            sizes = [0.0 if value is None else value / ARCMIN for value in values]
            ax.barh(y + offset, sizes, 0.9 * _BAR, color=colour, label=label)
        for place, row in zip(y, rows, strict=True):
            _mark(ax, place, row)
        ax.set_xscale("symlog", linthresh=_LINEAR, linscale=0.5)
        ticks = [-100, -10, -1, 0, 1, 10, 100]
        ax.set_xticks(ticks, [str(tick).replace("-", "−") for tick in ticks])
        ax.set_xticks([], minor=True)
        ax.axvline(0.0, color=BLACK, linewidth=0.8)
        ax.set_yticks(y, [f"{row.name}  {row.factor.number}" for row in rows])
        ax.set_ylim(len(rows) - 0.4, -0.6)
        ax.grid(visible=False, axis="y")
        ax.set_xlabel("change of the backlash per mm of the error [′/mm], linear within ±1; below 0 play is lost")
        figure.legend(loc="outside lower center", ncols=4)
        figure.suptitle(f"{plain(name)}: sensitivity of the backlash, crank held")
    return figure


def _mean(row: Sensitivity) -> float | None:
    return None if row.geometry is None else row.geometry.mean


def _mark(ax: Axes, place: float, row: Sensitivity) -> None:
    """Whiskers of what was measured; a cross where a number was printed whose formula is not known."""
    if row.geometry is None:
        at = place if row.corrected is None else place + _BAR
        ax.annotate(row.why, (0.0, at), xytext=(5, 0), textcoords="offset points", va="center", color=GREY)
        return
    ends = row.geometry.least / ARCMIN, row.geometry.greatest / ARCMIN
    label = "least to greatest" if row.factor.number == len(FACTORS) else None
    ax.plot(ends, [place + _BAR] * 2, color=ORANGE, linewidth=1.6, marker="|", markersize=7, label=label)
    if row.as_published is None:
        printed = row.printed / ARCMIN
        ax.plot(printed, place - _BAR, "x", color=GREY)
        text = f"{printed:.4f} printed, not derived"
        ax.annotate(text, (printed, place - _BAR), xytext=(7, 0), textcoords="offset points", va="center", color=GREY)


def budget_plot(budget: Budget, name: str) -> Figure:
    """Mean and band of the three parts at the output and of their total [′], against the range that was published."""
    article = lost_motion_article()
    cases = (
        (f"[LM], {TEXT.name}", GREY, TEXT.of(article)),
        (f"[LM], {TABLE.name}", SKY, TABLE.of(article)),
        (f"{plain(name)}, from geometry", BLUE, budget),
    )
    with style():
        figure = new_figure(9.0, 4.8)
        ax = figure.subplots()
        low, high = article.total.low_arcmin, article.total.high_arcmin
        ax.axvspan(low, high, color=ORANGE, alpha=0.15, label=f"published range of the total, {low:g}′ to {high:g}′")
        for (label, colour, of), offset in zip(cases, (-0.24, 0.0, 0.24), strict=True):
            shown = [(place, part) for place, part in enumerate(_parts(of)) if part is not None]
            y = np.array([place for place, _ in shown]) + offset
            mean = np.array([part.mean for _, part in shown]) / ARCMIN
            half = np.array([part.half_band for _, part in shown]) / ARCMIN
            ax.errorbar(mean, y, xerr=half, fmt="o", color=colour, capsize=4, label=label)
            for place, at, band in zip(y, mean, half, strict=True):
                digits = 4 if max(abs(at), band) < 0.05 else 3
                text = f"{at:.{digits}f} ± {band:.{digits}f}".replace("-", "−")
                ax.annotate(
                    text, (at + band, place), xytext=(8, 0), textcoords="offset points", va="center", fontsize=9
                )
        for place, part in enumerate(_parts(budget)):
            if part is None:
                ax.annotate(
                    f"{plain(name)}: absent", (0.0, place + 0.24), xytext=(8, 0), textcoords="offset points",
                    va="center", color=BLUE, fontsize=9,
                )  # fmt: skip
        ax.axvline(0.0, color=BLACK, linewidth=0.8)
        ax.set_yticks(range(len(_PARTS)), _PARTS)
        ax.set_ylim(len(_PARTS) - 0.5, -0.5)
        left, right = ax.get_xlim()
        ax.set_xlim(left, right + 0.2 * (right - left))
        ax.grid(visible=False, axis="y")
        ax.set_xlabel("lost motion at the output [′], mean ± half band")
        figure.legend(loc="outside lower center", ncols=2)
        figure.suptitle(f"{plain(name)}: lost motion by its three parts")
    return figure


def _parts(budget: Budget) -> tuple[Part | None, ...]:
    """The three parts at the output and the total, None where the drive has none."""
    first = None if budget.involute is None else budget.involute.over(budget.ratio)
    return first, budget.cycloid, budget.bearing, budget.total
