"""Parts of all pictures of a diagnosis: units, both sides, held-out rows, residual curves, orders and legends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile import _display
from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.diagnosis import Diagnosis, FileGap, Finding, Residuals, nuisance_fitted
from cycloid_profile.plot.measured import draw_orders as draw_spectra
from cycloid_profile.plot.measured import draw_residual, noise_mark, order_namer
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, ORANGE, line_mark, patch_mark
from cycloid_profile.rig import folded_order
from cycloid_profile.units import SIGNS

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARK_WIDTH = 1.8  # inch; the longest mark with its line
HELD: dict[str, Any] = {"color": GREEN, "linewidth": 2.5, "solid_capstyle": "butt"}
DRIFT: dict[str, Any] = {"color": GREEN, "linewidth": 1.3, "linestyle": "--"}
OUTLINE: dict[str, Any] = {"facecolor": "none", "edgecolor": BLACK, "linewidth": 1.3}


def unit(gap: FileGap) -> str:
    """Sign of the unit of a file."""
    return SIGNS[gap.recording.unit]


def with_unit(value: float, gap: FileGap) -> str:
    """Three figures with the unit; no space before signs of angles."""
    # The alternate format keeps trailing zeros, and a point that a whole number does not need.
    return _display.with_unit(f"{value:#.3g}".rstrip("."), unit(gap))


def before_and_after(diagnosis: Diagnosis, gap: FileGap) -> list[tuple[str, Residuals]]:
    """Before and after; once only where no effect was added."""
    if not diagnosis.effects:
        return [("against the prediction of the spec", gap.before)]
    return [("before", gap.before), ("after, effects added", gap.after)]


def significant(diagnosis: Diagnosis, gap: FileGap, coordinate: str) -> list[Finding]:
    """Significant deviations of a file, in one coordinate."""
    return [f for f in diagnosis.where if f.file == gap.recording.name and f.coordinate == coordinate]


def row_marks(gap: FileGap, outlined: bool) -> list[Artist]:
    """Legend of held-out rows, of a drift and of outlined ranges, where there are any."""
    held = gap.recording.held_out
    handles: list[Artist] = []
    if np.any(held) and not np.all(held):
        handles.append(line_mark("rows held out, not fitted", **HELD))
    if np.all(held):
        handles.append(line_mark("whole file held out, not fitted", linestyle=""))
    if gap.recording.kind.is_curve and gap.recording.drift:
        handles.append(line_mark("drift, subtracted", **DRIFT))
    if outlined:
        handles.append(patch_mark("most significant", **OUTLINE))
    return handles


def legend(figure: Figure, handles: Sequence[Artist]) -> None:
    """One legend of the marks below the figure, in as many lines as its width needs."""
    lines = math.ceil(len(handles) * _MARK_WIDTH / figure.get_figwidth())
    columns = math.ceil(len(handles) / lines)
    figure.legend(handles=handles, loc="outside lower center", ncols=columns, fontsize=9)


def with_gaps(rows: IntArray, x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """A path, interrupted where rows of the file are excluded."""
    gaps = np.flatnonzero(np.diff(rows) > 1) + 1
    return np.insert(x, gaps, np.nan), np.insert(y, gaps, np.nan)


def draw_file_residual(ax: Axes, x: FloatArray, residuals: Residuals, gap: FileGap) -> None:
    """Residual of a curve over ``x``, shape (rows,), with its noise, its held-out rows and the drift subtracted."""
    left = nuisance_fitted(residuals)
    draw_residual(ax, *with_gaps(gap.recording.rows, x, left), gap.noise, unit(gap))
    if gap.recording.drift:
        drift = residuals.residual - left
        drift -= float(np.nanmean(drift))
        ax.plot(x, drift, **DRIFT)
        low, high = ax.get_ylim()
        ax.set_ylim(min(low, 1.1 * float(np.nanmin(drift))), max(high, 1.1 * float(np.nanmax(drift))))
    held = gap.recording.held_out
    if not np.all(held):
        ax.plot(x, np.where(held, 0.012, np.nan), transform=ax.get_xaxis_transform(), **HELD)


def outline_span(ax: Axes, start: float, end: float) -> None:
    """Frame a range of x, at least 0.8 % of the axis wide."""
    low, high = ax.get_xlim()
    widen = max(0.5 * (0.008 * (high - low) - (end - start)), 0.0)
    ax.axvspan(start - widen, end + widen, ymin=0.03, ymax=0.97, zorder=5, **OUTLINE)


def curve_marks() -> list[Artist]:
    """Legend of measured, predicted and noise."""
    lines = [line_mark("measured", color=BLUE), line_mark("predicted", color=ORANGE)]
    return [*lines, noise_mark()]


def draw_orders(
    spectra: Any, diagnosis: Diagnosis, gap: FileGap, angle: FloatArray, residuals: Sequence[FloatArray]
) -> None:
    """Amplitudes of the orders before and after, with the names of the largest."""
    trochoid = diagnosis.reducer.case.drive.trochoid
    poses = round(360.0 / float(np.median(np.diff(angle))))
    ax = spectra.subplots()
    amplitudes = [_amplitudes(angle, values, poses) for values in residuals]
    floor = gap.noise * math.sqrt(math.pi / angle.size)
    ax.axvline(folded_order(trochoid.lobes * trochoid.pins, poses), color=GREEN, linewidth=1.0, linestyle=":")
    draw_spectra(ax, amplitudes, (BLUE, ORANGE), floor, order_namer(diagnosis.reducer, poses), unit(gap))
    part = "" if angle[-1] - angle[0] > 0.95 * 360.0 else "; part of a turn only, so that orders run into each other"
    ax.set_title(f"orders of measured minus predicted{part}", fontsize=10)


def order_marks(diagnosis: Diagnosis) -> list[Artist]:
    """Legend of the orders."""
    trochoid = diagnosis.reducer.case.drive.trochoid
    handles: list[Artist] = []
    if diagnosis.effects:
        handles.append(line_mark("orders before", color=BLUE, linewidth=1.6))
        handles.append(line_mark("orders after", color=ORANGE, linewidth=0.9))
    handles.append(line_mark("orders of noise alone", color=BLACK, linestyle="--"))
    mesh = f"mesh order {trochoid.lobes * trochoid.pins}, as sampled"
    return [*handles, line_mark(mesh, color=GREEN, linestyle=":")]


def _amplitudes(angle: FloatArray, values: FloatArray, poses: int) -> FloatArray:
    """Amplitude of each order from 0, by a Fourier sum over the sampled angles; approximate for uneven spacing."""
    orders = np.arange(poses // 2 + 1)
    centred = values - np.mean(values)
    turned = np.exp(-1j * np.outer(orders, np.deg2rad(angle)))
    found: FloatArray = 2.0 * np.abs(turned @ centred) / angle.size
    return found
