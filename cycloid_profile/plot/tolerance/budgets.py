"""Figures of the published budgets, compared with those of a drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.articles import FACTORS, TABLE, TEXT, BacklashSensitivity, Budget, BudgetPart
from cycloid_profile.catalog import lost_motion_article
from cycloid_profile.plot.style import BLACK, BLUE, GREY, ORANGE, SKY, canvas, note, plain, row_axis
from cycloid_profile.units import ARCMIN

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_PARTS = ("involute stage", "cycloid stage", "eccentric bearing", "total")
_BAR = 0.26
# Below this the axis is linear, so that small and negative values are visible next to large ones.
_LINEAR = 1.0  # ′/mm


def sensitivities(rows: tuple[BacklashSensitivity, ...], ax: Any = None, *, name: str = "") -> Any:
    """Bars of the fifteen factors [′/mm]: published, corrected and measured, whiskers over a turn; one pair of axes."""
    y = np.arange(len(rows), dtype=np.float64)
    with canvas(ax, (10.0, 9.0)) as drawn:
        axes = drawn.axes
        for offset, label, colour, values in (
            (-_BAR, "as published", GREY, [row.as_published for row in rows]),
            (0.0, "as published, corrected", SKY, [row.corrected for row in rows]),
            (
                _BAR,
                "from geometry, mean over a turn",
                BLUE,
                [None if row.geometry is None else row.geometry.mean for row in rows],
            ),
        ):
            sizes = [0.0 if value is None else value / ARCMIN for value in values]
            axes.barh(y + offset, sizes, 0.9 * _BAR, color=colour, label=label)
        for place, row in zip(y, rows, strict=True):
            _whiskers(axes, place, row)
        axes.set_xscale("symlog", linthresh=_LINEAR, linscale=0.5)
        ticks = [-100, -10, -1, 0, 1, 10, 100]
        axes.set_xticks(ticks, [str(tick).replace("-", "−") for tick in ticks])
        axes.set_xticks([], minor=True)
        axes.axvline(0.0, color=BLACK, linewidth=0.8)
        row_axis(axes, [f"{row.name}  {row.factor.number}" for row in rows])
        axes.set_xlabel("change of the backlash per mm of the error [′/mm], linear within ±1; below 0 play is lost")
        drawn.legend(4)
        drawn.title(name, "sensitivity of the backlash, crank held")
    return axes


def _whiskers(ax: Axes, place: float, row: BacklashSensitivity) -> None:
    """Whiskers of the range over a turn; a cross for a printed number whose formula is not known."""
    if row.geometry is None:
        at = place if row.corrected is None else place + _BAR
        note(ax, row.why, (0.0, at), (5, 0), va="center", color=GREY)
        return
    ends = row.geometry.least / ARCMIN, row.geometry.greatest / ARCMIN
    label = "least to greatest" if row.factor.number == len(FACTORS) else None
    ax.plot(ends, [place + _BAR] * 2, color=ORANGE, linewidth=1.6, marker="|", markersize=7, label=label)
    if row.as_published is None:
        printed = row.printed / ARCMIN
        ax.plot(printed, place - _BAR, "x", color=GREY)
        note(ax, f"{printed:.4f} printed, not derived", (printed, place - _BAR), (7, 0), va="center", color=GREY)


def budget(result: Budget, ax: Any = None, *, name: str = "") -> Any:
    """Mean and band of the parts at the output and of their total [′], with the published range; one pair of axes."""
    article = lost_motion_article()
    drive = plain(name) or "this drive"
    cases = (
        (f"[LM], {TEXT.name}", GREY, TEXT.of(article), -0.24),
        (f"[LM], {TABLE.name}", SKY, TABLE.of(article), 0.0),
        (f"{drive}, from geometry", BLUE, result, 0.24),
    )
    with canvas(ax, (9.0, 4.8)) as drawn:
        axes = drawn.axes
        low, high = article.total.low_arcmin, article.total.high_arcmin
        axes.axvspan(low, high, color=ORANGE, alpha=0.15, label=f"published range of the total, {low:g}′ to {high:g}′")
        for label, colour, one, offset in cases:
            _bands(axes, one, offset, color=colour, label=label)
        for place, part in enumerate(_parts(result)):
            if part is None:
                note(axes, f"{drive}: absent", (0.0, place + 0.24), (8, 0), va="center", color=BLUE, fontsize=9)
        axes.axvline(0.0, color=BLACK, linewidth=0.8)
        row_axis(axes, list(_PARTS))
        axes.set_ylim(len(_PARTS) - 0.5, -0.5)
        left, right = axes.get_xlim()
        axes.set_xlim(left, right + 0.2 * (right - left))
        axes.set_xlabel("lost motion at the output [′], mean ± half band")
        drawn.legend(2)
        drawn.title(name, "lost motion by its three parts")
    return axes


def _bands(ax: Axes, budget: Budget, offset: float, **look: Any) -> None:
    shown = [(place, part) for place, part in enumerate(_parts(budget)) if part is not None]
    y = np.array([place for place, _ in shown]) + offset
    mean = np.array([part.mean for _, part in shown]) / ARCMIN
    half = np.array([part.half_band for _, part in shown]) / ARCMIN
    ax.errorbar(mean, y, xerr=half, fmt="o", capsize=4, **look)
    for place, at, band in zip(y, mean, half, strict=True):
        digits = 4 if max(abs(at), band) < 0.05 else 3
        text = f"{at:.{digits}f} ± {band:.{digits}f}".replace("-", "−")
        note(ax, text, (at + band, place), (8, 0), va="center", fontsize=9)


def _parts(budget: Budget) -> tuple[BudgetPart | None, ...]:
    """The three parts at the output and the total, None where the drive has none."""
    first = None if budget.involute is None else budget.involute.divided_by(budget.ratio)
    return first, budget.cycloid, budget.bearing, budget.total
