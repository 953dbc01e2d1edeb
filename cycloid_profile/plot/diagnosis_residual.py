"""Measured minus predicted of a loop or a curve over a turn, beside the noise, with the marks that belong to it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.discrepancy.outcome import FileGap
from cycloid_profile.plot.diagnosis_marks import HELD, OUTLINE, unit
from cycloid_profile.plot.style import BLUE, ORANGE, SKY

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes


def draw_residual(ax: Axes, x: FloatArray, left: FloatArray, gap: FileGap) -> None:
    """What is left over ``x``, shape (rows,), on a band of ±2σ of the noise."""
    ax.axhspan(-2.0 * gap.noise, 2.0 * gap.noise, color=SKY, alpha=0.35, linewidth=0)
    ax.plot(x, left, color=BLUE, linewidth=0.7)
    ax.set_ylabel(f"measured − predicted [{unit(gap)}]")
    low, high = float(np.min(x)), float(np.max(x))
    ax.set_xlim(low - 0.01 * (high - low), high + 0.01 * (high - low))
    half = 1.15 * max(float(np.nanmax(np.abs(left))), 2.5 * gap.noise)
    ax.set_ylim(-half, half)
    _held_strip(ax, x, gap.recording.held_out)


def outline_span(ax: Axes, start: float, end: float) -> None:
    """A frame about a range of x, wide enough to be seen."""
    low, high = ax.get_xlim()
    widen = max(0.5 * (0.008 * (high - low) - (end - start)), 0.0)
    ax.axvspan(start - widen, end + widen, ymin=0.03, ymax=0.97, zorder=5, **OUTLINE)


def curve_marks() -> list[Artist]:
    """Legend of measured, predicted and noise."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    return [
        Line2D([], [], color=BLUE, label="measured"),
        Line2D([], [], color=ORANGE, label="predicted"),
        Patch(color=SKY, alpha=0.35, label="± 2σ of the noise"),
    ]


def _held_strip(ax: Axes, x: FloatArray, held: BoolArray) -> None:
    """A thin strip at the foot of an axis where rows are held out."""
    if np.all(held):
        return
    ax.plot(x, np.where(held, 0.012, np.nan), transform=ax.get_xaxis_transform(), **HELD)
