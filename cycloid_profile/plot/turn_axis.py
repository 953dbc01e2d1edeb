"""Axes of curves over a turn of the output."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def turn_ticks(ax: Axes) -> None:
    """A mark every 60°."""
    ax.set_xticks(range(0, 361, 60))


def widened(ax: Axes, share: float, least: float) -> None:
    """The y axis ``share`` of its height to either side of its middle, and at least ``least``.

    A perfect reducer has the same lost motion everywhere: its ripple is not drawn as if it were large.
    """
    low, high = ax.get_ylim()
    middle, half = 0.5 * (low + high), max(share * (high - low), least)
    ax.set_ylim(middle - half, middle + half)
