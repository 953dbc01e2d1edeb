"""Tables of points as CSV, and points of flanks with relief along the axis."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.design import flank_relief
from cycloid_profile.export.curves import Deviation, ProfileSource, deviation
from cycloid_profile.geometry import (
    EqualArc,
    EqualNormalAngle,
    Sampling,
    ToothPoints,
)

Column = tuple[str, FloatArray, int]
POINT_RESOLUTION = 1e-9  # mm, last decimal written
EQUAL_SPACINGS: dict[str, Callable[[int], Sampling]] = {"equal-arc": EqualArc, "equal-normal-angle": EqualNormalAngle}


def relieved_points(
    source: ProfileSource, points: ToothPoints, heights: Sequence[float]
) -> tuple[FloatArray, FloatArray]:
    """Points of the flanks with their relief at some heights above the lower face, and their outward unit normals,
    shape (heights, points, 3) both [mm].

    The relief is removed along the normal of the tooth; where it grows with the height, the normal leans up.
    """
    relief, width, n = flank_relief(source.spec), source.drive.disc_width, points.normal
    z = np.asarray(heights)[:, np.newaxis] + np.zeros(n.size)
    at = points.position - relief.at(z - 0.5 * width, width) * n
    lean = relief.slope(z - 0.5 * width, width)
    upright = 1.0 / np.hypot(1.0, lean)
    normal = np.stack([n.real * upright, n.imag * upright, lean * upright], axis=-1)
    return np.stack([at.real, at.imag, z], axis=-1), normal


def from_mid_height(source: ProfileSource, xyz: FloatArray, normal: FloatArray) -> Deviation:
    """Distance from the exact tooth of points (x, y, z) on relieved flanks, their relief put back; shape (points, 3)
    both."""
    width = source.drive.disc_width
    relief = flank_relief(source.spec).at(xyz[:, 2] - 0.5 * width, width)
    n: ComplexArray = normal[:, 0] + 1j * normal[:, 1]
    at: ComplexArray = xyz[:, 0] + 1j * xyz[:, 1]
    return deviation(source.profile, at + relief * (n / np.abs(n)))


def write_table(path: Path, columns: Sequence[Column]) -> FloatArray:
    """Write columns of name, values and decimals as CSV, one row per point; returns ``read_table``."""
    cells = [fixed_decimals(values, decimals) for _, values, decimals in columns]
    rows = [",".join(name for name, *_ in columns), *(",".join(row) for row in zip(*cells, strict=True))]
    path.write_text("\n".join(rows) + "\n", encoding="ascii", newline="\n")
    return read_table(path)


def read_table(path: Path) -> FloatArray:
    """Rows of a table of points, shape (points, columns), units as in its header."""
    return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)


def fixed_decimals(values: FloatArray, decimals: int) -> list[str]:
    """Numbers with a fixed number of decimals and no negative zero."""
    return [f"{value:.{decimals}f}" for value in (np.round(values, decimals) + 0.0).tolist()]
