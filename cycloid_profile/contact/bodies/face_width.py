"""Slices over the face width: crowning, edge relief and taper of tooth and pin (docs/theory.md, "Face width").

Heights z count from the mid-plane of a disc. Positive relief removes material; at mid-height there is none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.errors import LoadError

LEAST_SLICES = 2
_READ = 81  # heights at which the largest pressure is looked for, edges included


@dataclass(frozen=True, slots=True)
class AxialRelief:
    """Relief of a flank or a pin along the axis, over the face width of one disc.

    ``crowning`` at both edges, a parabola over the width [mm]; ``edge_relief`` at both edges [mm], a parabola that
    begins ``edge_length`` before each [mm]; ``taper`` from the lower to the upper edge, zero at mid-height [mm].

    Raises ``LoadError`` where an amount is negative or not finite (a taper may be negative), or an edge relief has no
    length.
    """

    crowning: float = 0.0
    edge_relief: float = 0.0
    edge_length: float = 0.0
    taper: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and (value >= 0.0 or field.name == "taper")):
                raise LoadError(field.name, f"{value} mm", "is negative or not finite", "give an amount, 0 for none")
        if (self.edge_relief > 0.0) != (self.edge_length > 0.0):
            raise LoadError(
                "edge_relief", f"{self.edge_relief} mm over {self.edge_length} mm", "needs both an amount and a length",
                "give both, or neither",
            )  # fmt: skip

    def __bool__(self) -> bool:
        return any(getattr(self, field.name) != 0.0 for field in fields(self))

    def at(self, height: ArrayLike, width: float) -> FloatArray:
        """Relief at heights from the mid-plane, of a face ``width`` [mm] (Eq. 117)."""
        z = np.asarray(height, dtype=np.float64)
        relief: FloatArray = self.crowning * (2.0 * z / width) ** 2 + self.taper * z / width
        if self.edge_length > 0.0:
            into = np.maximum(np.abs(z) - (0.5 * width - self.edge_length), 0.0) / self.edge_length
            relief = relief + self.edge_relief * into**2
        return relief

    def slope(self, height: ArrayLike, width: float) -> FloatArray:
        """Derivative of ``at`` by the height."""
        z = np.asarray(height, dtype=np.float64)
        slope: FloatArray = 8.0 * self.crowning * z / width**2 + self.taper / width
        if self.edge_length > 0.0:
            into = np.maximum(np.abs(z) - (0.5 * width - self.edge_length), 0.0) / self.edge_length
            slope = slope + 2.0 * self.edge_relief * into / self.edge_length * np.sign(z)
        return slope


NO_RELIEF = AxialRelief()


@dataclass(frozen=True, slots=True)
class FaceWidth:
    """Slices over the face ``width`` of a disc [mm], and what lets a disc tilt.

    Number of ``slices``; relief of ``tooth`` and ``pin``; ``tilt_stiffness`` of each bearing against a disc
    [N·mm/rad], and ``bearing_offset``, height of its middle [mm].

    Raises ``LoadError`` with fewer than 2 slices, an edge relief longer than half the width, a stiffness that is
    negative, or a bearing beyond the width.
    """

    width: float
    slices: int
    tooth: AxialRelief = NO_RELIEF
    pin: AxialRelief = NO_RELIEF
    tilt_stiffness: float = 0.0
    bearing_offset: float = 0.0

    def __post_init__(self) -> None:
        if self.slices < LEAST_SLICES:
            raise LoadError("width_slices", self.slices, f"is below {LEAST_SLICES}", "give 8 slices, or 0 for none")
        longest = max(self.tooth.edge_length, self.pin.edge_length)
        if longest > 0.5 * self.width:
            raise LoadError(
                "edge_relief_length", f"{longest:g} mm", f"is longer than half the face width, {0.5 * self.width:g} mm",
                "give a shorter one, or a crowning",
            )  # fmt: skip
        if not (math.isfinite(self.tilt_stiffness) and self.tilt_stiffness >= 0.0):
            raise LoadError(
                "tilt_stiffness", f"{self.tilt_stiffness} N·mm/rad", "is negative or not finite", "give 0 for none"
            )
        if not abs(self.bearing_offset) <= self.width:
            raise LoadError(
                "bearing_offset", f"{self.bearing_offset} mm", "lies beyond the disc",
                f"give the height of the bearing's middle, within ±{self.width:g} mm",
            )  # fmt: skip

    def relief(self, height: ArrayLike) -> FloatArray:
        """Relief of tooth and pin together at some heights [mm]."""
        return self.tooth.at(height, self.width) + self.pin.at(height, self.width)

    @property
    def rule(self) -> tuple[FloatArray, FloatArray]:
        """Heights [mm] and weights, sum 1: two points of Gauss in each slice, each height followed by its mirror image.

        In pairs the moments of an even load cancel to the last digit.
        """
        middle = (2.0 * np.arange(self.slices) + 1.0) / self.slices - 1.0
        points = np.sort((middle[:, np.newaxis] + np.array([-1.0, 1.0]) / (math.sqrt(3.0) * self.slices)).ravel())
        upper = points[self.slices :]
        heights: FloatArray = 0.5 * self.width * np.stack([upper, -upper], axis=1).ravel()
        return heights, np.full(heights.size, 0.5 / self.slices)

    def closest(self, slope: FloatArray) -> FloatArray:
        """What the nearest height adds to the approach at mid-height, where a tooth has this ``slope`` along its normal
        [rad]; the shape of ``slope`` [mm].
        """
        most = np.full_like(slope, -np.inf)
        for z in 0.5 * self.width * np.linspace(-1.0, 1.0, _READ):
            np.maximum(most, z * slope - self.relief(z), out=most)
        return most
