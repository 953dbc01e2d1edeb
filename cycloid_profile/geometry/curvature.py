"""Where the tooth bends most: least radii of its convex and concave parts."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.geometry.profile import ToothProfile


@dataclass(frozen=True, slots=True)
class LeastRadii:
    """Least radius of curvature of the convex and the concave part of a tooth [mm]; inf where there is none.

    ``largest_corner`` is the sharpest sudden turn of the tangent at root or tip [rad], 0 for a smooth tooth.
    """

    convex: float
    concave: float
    largest_corner: float


def inflection_phase(profile: ToothProfile) -> float:
    """Phase in (0, π) where the parallel curve passes from concave root to convex tip [rad] (Eq. 12).

    NaN where the tooth has no concave part (K1 z_p < 1).
    """
    K1, z_p = profile.trochoid.short_width_ratio, profile.trochoid.pins
    cosine = (1.0 + z_p * K1**2) / (K1 * (z_p + 1))
    return math.acos(cosine) if abs(cosine) <= 1.0 else math.nan


def least_radii(profile: ToothProfile) -> LeastRadii:
    """Least convex and concave radii of one lobe, found on a fine grid and refined by a parabola."""
    psi = np.linspace(0.0, 2.0 * math.pi, 7201)
    side = np.where(psi <= math.pi, 1.0, -1.0)
    kappa = profile.at(psi, side).curvature
    corner = 0.0
    for phase in profile.corners:
        before, after = (profile.at(np.array([phase]), np.array([s])) for s in _sides_at(phase))
        turn = float(np.angle(after.first[0] / before.first[0]))
        corner = max(corner, abs(turn))
    return LeastRadii(convex=_reciprocal_of_peak(-kappa), concave=_reciprocal_of_peak(kappa), largest_corner=corner)


def _sides_at(corner: float) -> tuple[float, float]:
    """Flanks before and after a corner at the tip (odd multiple of π) or root (even)."""
    return (1.0, -1.0) if round(corner / math.pi) % 2 else (-1.0, 1.0)


def _reciprocal_of_peak(bend: np.ndarray) -> float:
    i = int(np.argmax(bend))
    peak = float(bend[i])
    if 0 < i < bend.size - 1:
        left, right = float(bend[i - 1]), float(bend[i + 1])
        droop = 2.0 * peak - left - right
        # A jump at a corner is no parabola: refine only where the neighbours are close.
        if 0.0 < droop < 0.01 * abs(peak):
            peak += (right - left) ** 2 / (8.0 * droop)
    return 1.0 / peak if peak > 0.0 else math.inf
