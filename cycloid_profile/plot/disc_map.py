"""A disc as a picture of its deviations: rings of a magnified deviation, and lobe over phase, unrolled."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.image import AxesImage


def cell_means(lobe: IntArray, part: FloatArray, values: FloatArray, lobes: int, cells: int) -> FloatArray:
    """Mean of the values in each cell of a lobe, shape (lobes, cells), NaN without points.

    ``lobe`` from 0 and ``part`` of it from 0 to 1, both in the shape of ``values``, (points,).
    """
    place = lobe * cells + np.minimum((part * cells).astype(int), cells - 1)
    count = np.bincount(place, minlength=lobes * cells)
    total = np.bincount(place, weights=values, minlength=lobes * cells)
    mean: FloatArray = np.where(count > 0, total / np.maximum(count, 1), np.nan).reshape(lobes, cells)
    return mean


def unrolled(ax: Axes, mean: FloatArray, scale: float, half_width: float, **look: Any) -> AxesImage:
    """The cells of each lobe in a row, from −``half_width`` to ``half_width``; red ``scale`` above, blue below zero."""
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
    return drawn


def deviation_rings(ax: Any, scale: float, outermost: float, text: str) -> None:
    """Rings of a polar picture at zero and ± ``scale`` [µm], which ``text`` names; its middle lies 3 scales below."""
    ax.set_ylim(-3.0 * scale, outermost * scale)
    ax.set_yticks([-scale, 0.0, scale], [f"−{text}", "0", f"+{text} µm"], fontsize=8)
