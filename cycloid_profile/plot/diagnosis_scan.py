"""The gap of a scan: deviation from the prediction, round the disc and unrolled, before and after."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.detection import Finding
from cycloid_profile.discrepancy.laid import Laid, settled
from cycloid_profile.discrepancy.outcome import Diagnosis, FileGap
from cycloid_profile.plot.diagnosis_marks import HELD, OUTLINE, legend, row_marks, sides, striking
from cycloid_profile.plot.disc_map import cell_means, deviation_rings, unrolled
from cycloid_profile.plot.style import BLUE, GREEN, GREY, SKY, new_figure

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_ROWS_PER_CELL = 4
_CALM = 5.0  # standard deviations of a cell that are the least full colour, so that noise looks pale
_COARSEST, _FINEST = 12, 60  # cells of a lobe
_MISSING = "#BDBDBD"
_SMOOTHED = 12  # parts of a lobe that the line round the disc averages over


def scan_gap(diagnosis: Diagnosis, gap: FileGap) -> tuple[Figure, str]:
    """Polar and unrolled deviation from the prediction, outwards positive [µm]."""
    shown = sides(diagnosis, gap)
    lobes = diagnosis.built.case.drive.trochoid.lobes
    per_lobe = gap.recording.rows.size / np.unique(gap.before.lobe).size
    cells = int(np.clip(per_lobe / _ROWS_PER_CELL, _COARSEST, _FINEST))
    outside = [-settled(laid) for _, laid in shown]
    maps = [_cells(laid, values, lobes, cells) for (_, laid), values in zip(shown, outside, strict=True)]
    # Before and after have one scale; two cells of a thousand may exceed it.
    least = _CALM * gap.noise / math.sqrt(per_lobe / cells)
    scale = _round_up(max(float(np.nanquantile(np.abs(maps[0]), 0.998)), least))
    radius = 1e3 * float(np.mean(np.abs(gap.before.placed.placed[gap.recording.rows])))
    # The middle of the disc stands at −3 scales: a ring of that radius is the disc.
    magnified = float(f"{radius / (3.0 * scale):.2g}")
    figure = new_figure(11.0, 10.2) if len(shown) == 2 else new_figure(11.0, 5.8)
    if len(shown) == 2:
        spots: list[tuple[Any, Any]] = [((2, 2, 1), (2, 2, 3)), ((2, 2, 2), (2, 2, 4))]
    else:
        spots = [((1, 2, 1), (1, 2, 2))]
    flat = []
    for (title, laid), values, mean, (up, down) in zip(shown, outside, maps, spots, strict=True):
        ring = figure.add_subplot(*up, projection="polar")
        _ring(ring, laid, values, scale, per_lobe)
        ring.set_title(f"{title}\ndeviation magnified {magnified:,.0f} times", fontsize=10)
        ax = figure.add_subplot(*down)
        drawn = unrolled(ax, mean, scale, 180.0, interpolation="nearest")
        ax.set_facecolor(_MISSING)
        ax.set_xticks(range(-180, 181, 60))
        ax.set(xlabel="phase ψ [°] (0 root, ±180 tip)", ylabel="lobe [number]")
        _held_in_map(ax, laid)
        for finding in striking(diagnosis, gap, "lobe") if laid is gap.before else []:
            _outline_lobes(ax, finding)
        for finding in striking(diagnosis, gap, "psi_deg") if laid is gap.before else []:
            ax.axvspan(finding.start, finding.end, linestyle=":", **OUTLINE)
        ax.set_title(title, fontsize=10)
        flat.append(ax)
    bar = figure.colorbar(drawn, ax=flat, label="outwards of the prediction [µm]", pad=0.015, aspect=28)
    bar.ax.set_label("<colorbar>")
    missing = bool(np.any(np.all(np.isnan(maps[0]), axis=1)))
    outlined = bool(striking(diagnosis, gap, "lobe") or striking(diagnosis, gap, "psi_deg"))
    legend(figure, [*_point_marks(missing), *row_marks(gap, outlined)])
    caption = (
        f"deviation of the scanned flank from the prediction, ±{scale:g} µm; "
        "round the disc and unrolled, lobe over phase. Red stands out, blue is missing."
    )
    return figure, caption


def _cells(laid: Laid, outside: FloatArray, lobes: int, cells: int) -> FloatArray:
    """Mean deviation of each cell, shape (lobes, cells), NaN without points."""
    phase = np.mod(laid.phase + np.pi, 2.0 * np.pi) / (2.0 * np.pi)
    return cell_means(laid.lobe.astype(int), phase, outside, lobes, cells)


def _point_marks(missing: bool) -> list[Artist]:
    """Legend of the points, and of lobes that were not scanned."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles: list[Artist] = [
        Line2D([], [], color=SKY, marker=".", linestyle="", label="points"),
        Line2D([], [], color=BLUE, label=f"mean over 1/{_SMOOTHED} of a lobe"),
    ]
    return [*handles, Patch(color=_MISSING, label="not scanned")] if missing else handles


def _ring(ax: Any, laid: Laid, outside: FloatArray, scale: float, per_lobe: float) -> None:
    rows = laid.recording.rows
    angle = np.angle(laid.placed.placed[rows])
    order = np.argsort(angle)
    angle, values = angle[order], outside[order]
    width = max(int(per_lobe / _SMOOTHED), 1)
    smooth = np.convolve(np.pad(values, width, mode="wrap"), np.ones(width) / width, mode="same")[width:-width]
    # A lobe that was not scanned leaves a hole in the line.
    gaps = np.flatnonzero(np.diff(angle) > 0.5 * 2.0 * np.pi / laid.placed.tooth.trochoid.lobes) + 1
    full = np.linspace(-np.pi, np.pi, 361)
    ax.plot(angle, np.clip(values, -2.9 * scale, 1.5 * scale), ".", color=SKY, markersize=1.2, rasterized=True)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(smooth, gaps, np.nan), color=BLUE, linewidth=0.8)
    ax.plot(full, np.zeros(full.size), color=GREY, linewidth=0.8)
    held = np.where(laid.recording.held_out[order], 1.58 * scale, np.nan)
    ax.plot(np.insert(angle, gaps, np.nan), np.insert(held, gaps, np.nan), **HELD)
    deviation_rings(ax, scale, 1.7, f"{scale:g}")
    ax.set_rlabel_position(112.5)
    for label in ax.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5})
    ax.set_xlabel("polar angle [°]", fontsize=9)
    ax.tick_params(axis="x", labelsize=8)


def _held_in_map(ax: Axes, laid: Laid) -> None:
    """A thin line at the foot of each lobe where rows are held out."""
    from matplotlib.collections import LineCollection

    held = laid.recording.held_out
    if not np.any(held) or np.all(held):
        return
    edges = np.flatnonzero(np.diff(np.concatenate([[False], held, [False]]).astype(int)))
    segments = []
    for first, last in zip(edges[::2], edges[1::2] - 1, strict=True):
        for (low, high), lobe in _lobe_ranges(
            laid.position[first] / (2.0 * np.pi) + 1.0, laid.position[last] / (2.0 * np.pi) + 1.0
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


def _outline_lobes(ax: Axes, finding: Finding) -> None:
    from matplotlib.patches import Rectangle

    for (low, high), lobe in _lobe_ranges(finding.start, finding.end):
        # A narrow place keeps a frame wide enough to be seen round it.
        wide = max(high - low, 12.0)
        left = min(max(0.5 * (low + high - wide), -180.0), 180.0 - wide)
        ax.add_patch(Rectangle((left, lobe - 0.6), wide, 1.2, zorder=5, clip_on=False, **OUTLINE))


def _round_up(value: float) -> float:
    """The next number of two figures that is easy to read."""
    power = 10.0 ** math.floor(math.log10(value))
    steps = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)
    return float(f"{next(s for s in steps if s * power >= value * (1.0 - 1e-9)) * power:.2g}")
