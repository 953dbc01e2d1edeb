"""Residual of a scan: deviation from the prediction, round the disc and unrolled, before and after."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import Diagnosis, FileGap, Residuals, nuisance_fitted
from cycloid_profile.plot.diagnosis import _marks as marks
from cycloid_profile.plot.measured import (
    cell_means,
    cells_of_a_lobe,
    deviation_scale,
    draw_deviation_rings,
    draw_lobe_image,
    no_points_marks,
)
from cycloid_profile.plot.style import BLUE, GREEN, GREY, SKY, line_mark, new_figure

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_SMOOTHED = 12  # parts of a lobe that the line round the disc averages over


def scan_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Polar and unrolled deviation from the prediction, outwards positive [µm]; with the caption."""
    shown = marks.before_and_after(diagnosis, gap)
    lobes = diagnosis.reducer.case.drive.trochoid.lobes
    per_lobe = gap.recording.rows.size / np.unique(gap.before.lobe).size
    cells = cells_of_a_lobe(per_lobe)
    outside = [-nuisance_fitted(residuals) for _, residuals in shown]
    maps = []
    for (_, residuals), values in zip(shown, outside, strict=True):
        part = np.mod(residuals.phase + np.pi, 2.0 * np.pi) / (2.0 * np.pi)
        maps.append(cell_means(residuals.lobe.astype(int), part, values, lobes, cells))
    # Before and after have one scale.
    scale = deviation_scale(maps[0], gap.noise, per_lobe)
    radius = 1e3 * float(np.mean(np.abs(gap.before.placed.placed[gap.recording.rows])))
    # The middle of the disc lies at −3 scales: a ring of that radius is the disc.
    magnified = float(f"{radius / (3.0 * scale):.2g}")
    both = len(shown) == 2
    figure = new_figure(11.0, 10.2 if both else 5.8)
    flat = []
    for column, ((title, residuals), values, mean) in enumerate(zip(shown, outside, maps, strict=True), start=1):
        ring = figure.add_subplot(1 + both, 2, column, projection="polar")
        _ring(ring, residuals, values, scale, per_lobe)
        ring.set_title(f"{title}\ndeviation magnified {magnified:,.0f} times", fontsize=10)
        ax = figure.add_subplot(1 + both, 2, column + 1 + both)
        drawn = draw_lobe_image(ax, mean, scale)
        _mark_held_out_rows(ax, residuals)
        if residuals is gap.before:
            _outline_significant(ax, diagnosis, gap)
        ax.set_title(title, fontsize=10)
        flat.append(ax)
    bar = figure.colorbar(drawn, ax=flat, label="outwards of the prediction [µm]", pad=0.015, aspect=28)
    bar.ax.set_label("<colorbar>")
    outlined = bool(marks.significant(diagnosis, gap, "lobe") or marks.significant(diagnosis, gap, "psi_deg"))
    marks.legend(figure, [*_point_marks(), *no_points_marks(np.stack(maps)), *marks.row_marks(gap, outlined)])
    caption = (
        f"deviation of the scanned flank from the prediction, ±{scale:g} µm; "
        "round the disc and unrolled, lobe over phase. Red is excess material, blue is missing material."
    )
    return figure, caption


def _point_marks() -> list[Artist]:
    """Legend entries of the points and of their mean."""
    points = line_mark("points", color=SKY, marker=".", linestyle="")
    return [points, line_mark(f"mean over 1/{_SMOOTHED} of a lobe", color=BLUE)]


def _ring(ax: Any, residuals: Residuals, outside: FloatArray, scale: float, per_lobe: float) -> None:
    rows = residuals.recording.rows
    angle = np.angle(residuals.placed.placed[rows])
    order = np.argsort(angle)
    angle, values = angle[order], outside[order]
    width = max(int(per_lobe / _SMOOTHED), 1)
    smooth = np.convolve(np.pad(values, width, mode="wrap"), np.ones(width) / width, mode="same")[width:-width]
    # A lobe that was not scanned leaves a hole in the line.
    gaps = np.flatnonzero(np.diff(angle) > 0.5 * 2.0 * np.pi / residuals.placed.tooth.trochoid.lobes) + 1
    full = np.linspace(-np.pi, np.pi, 361)
    ax.plot(angle, np.clip(values, -2.9 * scale, 1.5 * scale), ".", color=SKY, markersize=1.2, rasterized=True)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(smooth, gaps, np.nan), color=BLUE, linewidth=0.8)
    ax.plot(full, np.zeros(full.size), color=GREY, linewidth=0.8)
    held = np.where(residuals.recording.held_out[order], 1.58 * scale, np.nan)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(held, gaps, np.nan), **marks.HELD)
    draw_deviation_rings(ax, scale, 1.7, f"{scale:g}")
    ax.set_xlabel("polar angle [°]", fontsize=9)
    ax.tick_params(axis="x", labelsize=8)


def _mark_held_out_rows(ax: Axes, residuals: Residuals) -> None:
    """A thin line at the foot of each lobe where rows are held out."""
    from matplotlib.collections import LineCollection

    held = residuals.recording.held_out
    if not np.any(held) or np.all(held):
        return
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    segments = []
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        for (low, high), lobe in _lobe_ranges(
            residuals.position[first] / (2.0 * np.pi) + 1.0, residuals.position[last] / (2.0 * np.pi) + 1.0
        ):
            segments.append([(low, lobe - 0.42), (high, lobe - 0.42)])
    ax.add_collection(LineCollection(segments, colors=GREEN, linewidths=0.9, capstyle="butt"))


def _lobe_ranges(start: float, end: float) -> list[tuple[tuple[float, float], int]]:
    """A range of lobe numbers with their parts, as ranges of ψ [°] with the lobe of each."""
    found = []
    for lobe in range(math.floor(start), math.ceil(end)):
        low, high = max(start, lobe) - lobe, min(end, lobe + 1) - lobe
        if high > low:
            found.append(((360.0 * low - 180.0, 360.0 * high - 180.0), lobe))
    return found


def _outline_significant(ax: Axes, diagnosis: Diagnosis, gap: FileGap) -> None:
    """Frame significant ranges of lobes, and of ψ over all lobes."""
    from matplotlib.patches import Rectangle

    for finding in marks.significant(diagnosis, gap, "lobe"):
        for (low, high), lobe in _lobe_ranges(finding.start, finding.end):
            # The frame of a narrow range is widened to be visible.
            wide = max(high - low, 12.0)
            left = min(max(0.5 * (low + high - wide), -180.0), 180.0 - wide)
            ax.add_patch(Rectangle((left, lobe - 0.6), wide, 1.2, zorder=5, clip_on=False, **marks.OUTLINE))
    for finding in marks.significant(diagnosis, gap, "psi_deg"):
        ax.axvspan(finding.start, finding.end, linestyle=":", **marks.OUTLINE)
