"""Axes of curves over a revolution of the output, names of their orders, and maps of the deviations of a disc."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.plot.style import BLUE, SKY, patch_mark

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage

_MESH_HARMONICS = (1, 2, 3)
# Points of a cell: their mean has half the noise of one point.
_POINTS_PER_CELL = 4
# Cells of a lobe: 12 still show which flank deviates, and more than 60 are narrower than a pixel.
_COARSEST, _FINEST = 12, 60
_NO_POINTS = "#BDBDBD"  # white is a deviation of zero
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


def order_label(order: int, lobes: int, pins: int, poses: int) -> str:
    """An order as 39·k, 40·k or of the mesh; ``poses`` rows a turn may fold its harmonics back several times."""
    mesh = {k: lobes * pins * k for k in _MESH_HARMONICS}
    for k, true in mesh.items():
        if order == true:
            return f"{order} = {_harmonic(k)}"
    names = [f"{number}·{order // number}" for number in (lobes, pins) if order % number == 0]
    # Of several harmonics that fold to one order the lowest is the strongest.
    names += [f"{_harmonic(k)}, folded" for k, true in mesh.items() if order == folded_order(true, poses)][:1]
    return f"{order} = {' or '.join(names)}" if names else str(order)


def folded_order(order: int, poses: int) -> int:
    """Order at which ``poses`` rows a turn alias an ``order``."""
    return abs((order + poses // 2) % poses - poses // 2)


def _harmonic(k: int) -> str:
    return "mesh" if k == 1 else f"{k}·mesh"


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


def draw_lobe_image(ax: Axes, mean: FloatArray, scale: float, half_width: float, **look: Any) -> AxesImage:
    """Image with one row of cells per lobe, from −``half_width`` to ``half_width``. Red is positive up to ``scale``,
    blue negative, and a cell without points grey."""
    drawn = ax.imshow(
        mean,
        origin="lower",
        aspect="auto",
        extent=(-half_width, half_width, 0.5, mean.shape[0] + 0.5),
        cmap="RdBu_r",
        vmin=-scale,
        vmax=scale,
        **look,
    )
    ax.grid(visible=False)
    ax.set_facecolor(_NO_POINTS)
    return drawn


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
