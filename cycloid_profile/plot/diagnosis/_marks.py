"""Parts of all pictures of a diagnosis: units, both sides, held-out rows, residual curves, orders and legends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile import _display
from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.diagnosis import Diagnosis, FileGap, Finding, Residuals
from cycloid_profile.plot.measured import draw_residual, folded_order, noise_mark, order_label
from cycloid_profile.plot.style import BLACK, BLUE, GREEN, ORANGE, line_mark, note, patch_mark
from cycloid_profile.units import SIGNS

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LABELLED_ORDERS = 5  # upright names of more would overlap
_LOW_ORDERS = 6.5  # times the number of pins
_MARK_WIDTH = 1.8  # inch; the longest mark with its line
HELD: dict[str, Any] = {"color": GREEN, "linewidth": 2.5, "solid_capstyle": "butt"}
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
    """Legend of held-out rows and of outlined ranges, where there are any."""
    held = gap.recording.held_out
    handles: list[Artist] = []
    if np.any(held) and not np.all(held):
        handles.append(line_mark("rows held out, not fitted", **HELD))
    if np.all(held):
        handles.append(line_mark("whole file held out, not fitted", linestyle=""))
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


def draw_file_residual(ax: Axes, x: FloatArray, residual: FloatArray, gap: FileGap) -> None:
    """Residual of a file over ``x``, shape (rows,), with its noise and held-out rows."""
    draw_residual(ax, *with_gaps(gap.recording.rows, x, residual), gap.noise, unit(gap))
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
    """Amplitudes of the orders before and after: low orders with their names, higher orders in a second panel."""
    trochoid = diagnosis.reducer.case.drive.trochoid
    poses = round(360.0 / float(np.median(np.diff(angle))))
    low = min(round(_LOW_ORDERS * trochoid.pins), poses // 2)
    split = low < 0.9 * (poses // 2)
    panels = spectra.subplots(1, 2 if split else 1, squeeze=False, sharey=True, width_ratios=(2.0, 1.0)[: 1 + split])[0]
    amplitudes = [_amplitudes(angle, values, poses) for values in residuals]
    floor = gap.noise * math.sqrt(math.pi / angle.size)
    top = max(float(np.max(a[1:])) for a in amplitudes)
    bottom = 0.3 * min(floor, top)
    mesh = folded_order(trochoid.lobes * trochoid.pins, poses)
    looks = ((BLUE, 1.6), (ORANGE, 0.9))
    for ax in panels:
        for amplitude, (colour, width) in zip(amplitudes, looks[: len(residuals)], strict=True):
            x = np.repeat(np.arange(1.0, amplitude.size), 3)
            y = np.stack([np.full(x.size // 3, bottom), amplitude[1:], np.full(x.size // 3, np.nan)], axis=1).ravel()
            ax.plot(x, y, color=colour, linewidth=width, rasterized=True)
        ax.axhline(floor, color=BLACK, linewidth=1.0, linestyle="--")
        ax.axvline(mesh, color=GREEN, linewidth=1.0, linestyle=":")
        ax.set_yscale("log")
        # Room above for the names of the orders.
        ax.set_ylim(bottom, top * max((top / bottom) ** 0.9, 30.0))
        ax.set_xlabel("order per turn of the output [–]")
    part = "" if angle[-1] - angle[0] > 0.95 * 360.0 else "; part of a turn only, so that orders run into each other"
    panels[0].set_title(f"orders of measured minus predicted{part}", fontsize=10)
    panels[0].set_ylabel(f"amplitude [{unit(gap)}]")
    panels[0].set_xlim(0, low)
    if split:
        panels[1].set_xlim(low, poses // 2 + 0.02 * poses)
        panels[1].set_title("higher orders", fontsize=10)
    for ax, (first, last) in zip(panels, ((1, low), (low + 1, poses // 2)), strict=False):
        _name_orders(ax, amplitudes[0], first, last, 4.0 * floor, (trochoid.lobes, trochoid.pins, poses))


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


def _name_orders(
    ax: Axes, amplitude: FloatArray, first: int, last: int, least: float, lobes_pins_poses: tuple[int, int, int]
) -> None:
    """Names of the largest orders in a panel, upright so that neighbours do not cover each other."""
    largest = first + np.argsort(amplitude[first : last + 1])[::-1]
    named = sorted(int(o) for o in largest[:_LABELLED_ORDERS] if amplitude[o] > least)
    room = 0.03 * (last - first) * (1.0 if first == 1 else 2.0)
    # Move overlapping names to the right, and back where they would leave the panel.
    x = np.asarray(named, dtype=np.float64)
    for i in range(x.size):
        x[i] = max(x[i], x[i - 1] + room if i else first + 0.5 * room)
    for i in reversed(range(x.size)):
        x[i] = min(x[i], x[i + 1] - room if i + 1 < x.size else last - 0.2 * room)
    for order, at in zip(named, x, strict=True):
        height = float(np.max(amplitude[[o for o in named if abs(o - at) < 2.0 * room] or [order]]))
        look = {"rotation": 90, "ha": "center", "va": "bottom", "fontsize": 7.5}
        note(ax, order_label(order, *lobes_pins_poses), (float(at), height), (0, 3), **look).set_in_layout(False)
