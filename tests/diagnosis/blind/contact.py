"""Line contact of a pin and a tooth: approach and force after Roark, energy, stiffness, peak pressure."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Line:
    """δ = G F (K − ln F), with ``slope`` G [mm/N] and ``constant`` K; ``relative_radius`` R [mm].

    The constant holds springs in series with the contact as well: δ + c F is the same law with K + c/G.
    """

    slope: float
    constant: Array
    relative_radius: Array

    def answer(self, approach: Array) -> tuple[Array, Array, Array]:
        """Force [N], stiffness [N/mm], energy [N·mm] of an approach [mm]; nothing where it is not positive."""
        pressed = approach > 0.0
        # v = K − ln F solves v − ln v = K − ln(δ/G); the larger root, from above.
        # Steel would yield long before the floor of the right side.
        right = np.maximum(self.constant - np.log(np.where(pressed, approach, 1e-12) / self.slope), 1.5)
        v = right + np.log(right) + 0.1
        for _ in range(4):
            v = v - (v - np.log(v) - right) / (1.0 - 1.0 / v)
        force = np.where(pressed, approach / (self.slope * v), 0.0)
        stiffness = np.where(pressed, 1.0 / (self.slope * (v - 1.0)), 0.0)
        return force, stiffness, 0.5 * self.slope * force * force * (v - 0.5)


def line(curvature: Array, pin_radius: Array, width: float, compliance: float, cap: float, seat: float = 0.0) -> Line:
    """Contact of pins of ``pin_radius`` with a tooth of ``curvature``, convex negative [1/mm].

    ``compliance`` C_E of both [1/MPa]; ``cap``, the largest tooth radius in the logarithm [mm]; ``seat``, further
    compliance of each pin [mm/N].
    """
    slope = compliance / (math.pi * width)
    relative = 1.0 / np.maximum(1.0 / pin_radius - curvature, 1e-3 / pin_radius)
    tooth = 1.0 / np.maximum(np.abs(curvature), 1.0 / cap)
    band_squared = 1.6**2 * 2.0 * relative * compliance / width  # full width of the band, for 1 N
    constant = 2.0 / 3.0 + np.log(16.0 * pin_radius * tooth / band_squared) + seat / slope
    return Line(slope, constant, relative)


def peak_pressure(force: Array, relative_radius: Array, width: float, compliance: float) -> Array:
    """Pressure in the middle of the band, after Hertz [MPa]."""
    return np.sqrt(force / (math.pi * width * relative_radius * compliance))
