"""Axes of curves over a revolution of the output, and maps of the deviations of a disc."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.plot.style import BLACK, BLUE, SKY, note, patch_mark, phase_axis, round_up
from cycloid_profile.rig import order_label, single_orders

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

# Points of a cell: their mean has half the noise of one point.
_POINTS_PER_CELL = 4
# Cells of a lobe: 12 still show which flank deviates, and more than 60 are narrower than a pixel.
_COARSEST, _FINEST = 12, 60
_NOISE_FLOOR = 5.0  # standard deviations of a cell that are the least full colour, so that noise looks pale
_STEPS = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)  # of the colour scale
_LEAST_SCALE = 1e-3  # µm
_NO_POINTS = "#BDBDBD"  # white is a deviation of zero
_LABELLED_ORDERS = 6  # upright names of more would overlap
_NO_ORDER = 1e-6  # in the unit of the curve: rounding errors of a spectrum without orders
_LEAST_STEM = 1e-3  # of the highest stem: where the axis begins, if not at the noise
_BEFORE_FIRST = 0.8  # order at which the axis begins, so that order 1 is clear of it
_STEM_WIDTHS = (1.6, 0.9)
_NOISE_BAND: dict[str, Any] = {"color": SKY, "alpha": 0.35}


def turn_ticks(ax: Axes) -> None:
    """A mark every 60°."""
    ax.set_xticks(range(0, 361, 60))


def widened(ax: Axes, share: float, least: float) -> None:
    """Extend the y axis to ``share`` of its height on either side of its middle, and to at least ``least``.

    The lost motion of a perfect reducer is constant; its numerical ripple must not fill the axis.
    """
    low, high = ax.get_ylim()
    middle, half = 0.5 * (low + high), max(share * (high - low), least)
    ax.set_ylim(middle - half, middle + half)


def draw_residual(ax: Axes, x: FloatArray, residual: FloatArray, noise: float, unit: str) -> None:
    """Measured minus predicted over ``x``, shape (rows,), on a band of ±2σ of the noise; zero is in the middle.

    NaN interrupts the line.
    """
    # The edge of the band keeps it visible where the residual is many times the noise.
    ax.axhspan(-2.0 * noise, 2.0 * noise, **_NOISE_BAND)
    ax.plot(x, residual, color=BLUE, linewidth=0.7)
    ax.set_ylabel(f"measured minus predicted [{unit}]")
    low, high = float(np.nanmin(x)), float(np.nanmax(x))
    ax.set_xlim(low - 0.01 * (high - low), high + 0.01 * (high - low))
    half = 1.15 * max(float(np.nanmax(np.abs(residual))), 2.5 * noise)
    ax.set_ylim(-half, half)


def order_namer(reducer: AsBuiltReducer | None, poses: int) -> Callable[[int], str]:
    """Name of an order of a curve of ``poses`` rows a turn; its number alone without a reducer."""
    if reducer is None:
        return str
    drive = reducer.case.drive
    return partial(
        order_label, lobes=drive.trochoid.lobes, pins=drive.trochoid.pins, poses=poses, single=single_orders(drive)
    )


def draw_orders(
    ax: Axes,
    amplitudes: Sequence[FloatArray],
    colours: Sequence[str],
    floor: float,
    name: Callable[[int], str],
    unit: str,
) -> None:
    """Amplitudes of the orders, from 0 on, as stems on logarithmic axes; the largest get a ``name``.

    ``floor``, the mean amplitude of noise alone, is dashed. Stems of later spectra are narrower and drawn on top.
    """
    last = amplitudes[0].size - 1
    highest = max(_NO_ORDER, *(float(np.max(amplitude[1:])) for amplitude in amplitudes))
    bottom = max(0.3 * min(floor, highest), _LEAST_STEM * highest)
    orders = np.arange(1.0, last + 1.0)
    for amplitude, colour, width in zip(amplitudes, colours, _STEM_WIDTHS, strict=False):
        # One path with gaps: a thousand stems of their own take a second to draw.
        stems = np.stack([np.full(last, bottom), np.maximum(amplitude[1:], bottom), np.full(last, np.nan)], axis=1)
        ax.plot(np.repeat(orders, 3), stems.ravel(), color=colour, linewidth=width, rasterized=True)
        seen = amplitude[1:] > bottom
        ax.plot(orders[seen], amplitude[1:][seen], "o", color=colour, markersize=1.5 * width, rasterized=True)
    if floor > bottom:
        ax.axhline(floor, color=BLACK, linewidth=1.0, linestyle="--")
    ax.set(xscale="log", yscale="log", xlabel="order per turn of the output [–]", ylabel=f"amplitude [{unit}]")
    ax.set_xlim(_BEFORE_FIRST, last * 1.1)
    # Room above for the names of the orders.
    ax.set_ylim(bottom, highest * max((highest / bottom) ** 0.9, 30.0))
    ax.xaxis.set_major_formatter("{x:.0f}")
    _name_orders(ax, np.maximum.reduce(amplitudes), max(4.0 * floor, 0.02 * highest), name)


def _name_orders(ax: Axes, amplitude: FloatArray, least: float, name: Callable[[int], str]) -> None:
    """Names of the largest orders, upright so that neighbours do not cover each other."""
    largest = (np.argsort(amplitude[1:])[::-1] + 1)[:_LABELLED_ORDERS]
    named = sorted(int(order) for order in largest if amplitude[order] > max(least, _NO_ORDER))
    first, last = math.log(_BEFORE_FIRST), math.log(1.1 * (amplitude.size - 1))
    room = 0.014 * (last - first)
    # Move overlapping names to the right, and back where they would leave the panel.
    x = np.log(np.asarray(named, dtype=np.float64))
    for i in range(x.size):
        x[i] = max(x[i], x[i - 1] + room if i else first + 0.5 * room)
    for i in reversed(range(x.size)):
        x[i] = min(x[i], x[i + 1] - room if i + 1 < x.size else last - 0.5 * room)
    for order, at in zip(named, x, strict=True):
        height = float(np.max(amplitude[[o for o in named if abs(math.log(o) - at) < 2.0 * room] or [order]]))
        look = {"rotation": 90, "ha": "center", "va": "bottom", "fontsize": 7.5}
        note(ax, name(order), (math.exp(at), height), (0, 4), **look).set_in_layout(False)


def noise_mark() -> Any:
    """Legend entry of the band of ``draw_residual``."""
    return patch_mark("± 2σ of the noise", **_NOISE_BAND)


def cells_of_a_lobe(points_per_lobe: float) -> int:
    """Number of cells that a lobe with this number of points is divided into."""
    return int(np.clip(points_per_lobe / _POINTS_PER_CELL, _COARSEST, _FINEST))


def cell_means(lobe: IntArray, part: FloatArray, values: FloatArray, lobes: int, cells: int) -> FloatArray:
    """Mean of the values in each cell of a lobe, shape (lobes, cells), NaN without points.

    ``lobe`` from 0 and ``part`` of it from 0 to 1, both in the shape of ``values``, (points,).
    """
    place = lobe * cells + np.minimum((part * cells).astype(int), cells - 1)
    count = np.bincount(place, minlength=lobes * cells)
    total = np.bincount(place, weights=values, minlength=lobes * cells)
    return np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(lobes, cells)


def draw_lobe_image(ax: Axes, mean: FloatArray, scale: float) -> AxesImage:
    """Image with one row of cells per lobe over the phase ψ. Red is positive up to ``scale``, blue negative, and a cell
    without points grey."""
    drawn = ax.imshow(
        mean,
        origin="lower",
        aspect="auto",
        extent=(-180.0, 180.0, 0.5, mean.shape[0] + 0.5),
        cmap="RdBu_r",
        vmin=-scale,
        vmax=scale,
        interpolation="nearest",
    )
    phase_axis(ax)
    ax.set_ylabel("lobe [number]")
    ax.grid(visible=False)
    ax.set_facecolor(_NO_POINTS)
    return drawn


def deviation_scale(mean: FloatArray, noise: float, points_per_lobe: float) -> float:
    """Round limit ± of the colours of an image of cell means, from the data; two cells of a thousand may exceed it.

    ``noise`` of a point in the unit of ``mean`` keeps an image of noise alone pale.
    """
    least = _NOISE_FLOOR * noise / math.sqrt(points_per_lobe / mean.shape[1])
    largest = max(float(np.nanquantile(np.abs(mean), 0.998)), np.nan_to_num(least), _LEAST_SCALE)
    return float(f"{round_up(largest, _STEPS):.2g}")


def no_points_marks(mean: FloatArray) -> list[Artist]:
    """Legend entry of the cells without points, where there are any."""
    return [patch_mark("no points", color=_NO_POINTS)] if np.any(np.isnan(mean)) else []


def draw_deviation_rings(ax: Any, scale: float, outermost: float, text: str) -> None:
    """Rings of a polar picture at zero and ± ``scale`` [µm], which ``text`` names; its centre is at −3 scales."""
    ax.set_ylim(-3.0 * scale, outermost * scale)
    ax.set_yticks([-scale, 0.0, scale], [f"−{text}", "0", f"+{text} µm"], fontsize=8)
    # Between the marks of 90° and 135°, and readable on top of the curve.
    ax.set_rlabel_position(112.5)
    for label in ax.get_yticklabels():
        label.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5})
