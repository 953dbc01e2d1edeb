"""Which tolerance counts: contributions in order with Sobol indices beside them, and sensitivities times tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.plot.style import BLACK, BLUE, GREEN, GREY, ORANGE, SKY, new_figure, plain, style
from cycloid_profile.tolerance.contributions import Contribution, Contributions
from cycloid_profile.tolerance.responses import RESPONSES
from cycloid_profile.tolerance.sensitivity import PartsSensitivity
from cycloid_profile.tolerance.sobol import Share, SobolShares
from cycloid_profile.units import sign_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BAR = 0.38


def ranking_plot(found: Contributions, shares: SobolShares, quantity: str, name: str) -> Figure:
    """Pareto picture of one quantity.

    Left what each tolerance adds to the variance, largest first, with the running sum; middle what the 99.73 %
    percentile changes by when it is halved; right its Sobol indices of first and total order with what first
    derivatives say.
    """
    which = found.quantities.index(quantity)
    rows = sorted(found.rows, key=lambda row: row.variance_share[which].value, reverse=True)
    groups = {share.group: share for share in shares.of(quantity)}
    y = np.arange(len(rows), dtype=np.float64)
    with style():
        figure = new_figure(13.0, 2.6 + 0.42 * len(rows))
        left, middle, right = figure.subplots(1, 3, sharey=True)
        _variance(left, rows, which, y)
        _halved(middle, rows, which, y, _unit(quantity))
        _indices(right, [_group_of(groups, row) for row in rows], y)
        left.set_yticks(y, [_label(row.label, row.plus_minus, row.unit) for row in rows])
        # Room for the legends below the last row.
        left.set_ylim(len(rows) + 1.4, -0.6)
        figure.suptitle(f"{plain(name)}: {RESPONSES[quantity]}, {found.reducers:,} reducers".replace(",000", " 000"))
    return figure


def tornado_plot(rows: Sequence[PartsSensitivity], quantities: Sequence[str], name: str) -> Figure:
    """Sensitivity times tolerance of every scatter, an axis a quantity: all parts together, and the worst alone."""
    with style():
        across = 2 if len(quantities) == 4 else min(len(quantities), 3)
        down = -(-len(quantities) // across)
        figure = new_figure(4.6 * across + 2.0, (1.6 + 0.34 * len(rows)) * down)
        axes = np.atleast_1d(figure.subplots(down, across, sharey=False)).ravel()
        for ax, quantity in zip(axes, quantities, strict=False):
            _tornado(ax, rows, quantity)
        for ax in axes[len(quantities) :]:
            ax.set_visible(False)
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
        figure.suptitle(f"{plain(name)}: sensitivity × tolerance, each part at its limit")
    return figure


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


def _indices(ax: Axes, shares: Sequence[Share | None], y: np.ndarray) -> None:
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


def _tornado(ax: Axes, rows: Sequence[PartsSensitivity], quantity: str) -> None:
    ordered = sorted(rows, key=lambda row: row.worth(quantity), reverse=True)
    y = np.arange(len(ordered), dtype=np.float64)
    which = list(RESPONSES).index(quantity)
    together = np.array([row.worth(quantity) for row in ordered])
    low, high = np.array([row.worst[which].ends(quantity) for row in ordered]).T
    ax.barh(y, 2.0 * together, 0.72, -together, color=SKY, label="all parts, root-sum-square")
    ax.barh(y, high - low, 0.34, low, color=BLUE, label="worst part alone, towards either limit")
    ax.axvline(0.0, color=BLACK, linewidth=0.8)
    ax.set_yticks(y, [_label(row.label, row.tolerance, row.unit, row.count) for row in ordered], fontsize=8.5)
    ax.set_ylim(len(ordered) - 0.4, -0.6)
    ax.grid(visible=False, axis="y")
    ax.set_xlabel(f"{RESPONSES[quantity].split(',')[0]} [{_unit(quantity)}]")
    ax.set_title(RESPONSES[quantity].split(",")[-1].strip() if "," in RESPONSES[quantity] else "")


def _group_of(groups: dict[str, Share], row: Contribution) -> Share | None:
    """Share of the group a scatter is in; None where it is one of several that are correlated."""
    return groups.get(row.label)


def _label(label: str, plus_minus: float | None, unit: str, count: int = 1) -> str:
    words = plain(label.replace("_", " "))
    parts = f"{count} × " if count > 1 else ""
    return (
        words
        if plus_minus is None
        else f"{words}\n{parts}±{plus_minus:g} {unit}"
        if count > 1
        else (f"{words} ±{plus_minus:g} {unit}")
    )


def _unit(quantity: str) -> str:
    return sign_of(quantity)
