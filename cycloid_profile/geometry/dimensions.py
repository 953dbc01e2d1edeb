"""Dimensions checked on a finished tooth: least radii of curvature and size over two rollers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.trochoid import require_positive

_GRID = 4001  # phases; isolates the extremes of curvature
_ZOOMS = 3  # each refines the phase 2,000 times, to rounding


@dataclass(frozen=True, slots=True)
class LeastRadii:
    """Least radius of curvature of the convex and the concave part of a tooth [mm]; inf where there is none.

    ``largest_corner`` is the largest tangent discontinuity at root or tip [rad], 0 for a smooth tooth.
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
        # Flanks before and after the corner, at the tip (odd multiple of π) or at the root (even).
        sides = (1.0, -1.0) if round(phase / math.pi) % 2 else (-1.0, 1.0)
        before, after = (profile.at(np.array([phase]), np.array([side])).first[0] for side in sides)
        corner = max(corner, abs(float(np.angle(after / before))))
    return LeastRadii(convex=_least_radius(-kappa), concave=_least_radius(kappa), largest_corner=corner)


def _least_radius(curvature: FloatArray) -> float:
    """Reciprocal of the largest value of a curvature that is positive somewhere [mm], else infinity."""
    i = int(np.argmax(curvature))
    peak = float(curvature[i])
    if 0 < i < curvature.size - 1:
        left, right = float(curvature[i - 1]), float(curvature[i + 1])
        droop = 2.0 * peak - left - right
        # A jump at a corner is no parabola: refine only where the neighbours are close.
        if 0.0 < droop < 0.01 * abs(peak):
            peak += (right - left) ** 2 / (8.0 * droop)
    return 1.0 / peak if peak > 0.0 else math.inf


@dataclass(frozen=True, slots=True)
class OverRollers:
    """Rollers of ``roller_radius`` in two opposite roots, or nearly opposite ones with an odd number of lobes.

    ``size`` over both rollers [mm]; ``centre_radius`` of a roller's axis [mm]; ``seat`` is the contact phase, 0 at the
    bottom of the root, else ± on both flanks [rad].
    """

    roller_radius: float
    size: float
    centre_radius: float
    seat: float


def over_rollers(profile: ToothProfile, roller_radius: float) -> OverRollers:
    """Size over two rollers of ``roller_radius`` [mm], exact.

    A roller on the axis of its root touches where P_x + √(r² − P_y²) is largest, P being the tooth
    with the root on the x axis. With an odd number of lobes opposite roots miss the diameter by π/z_c.

    Raises ``GeometryError`` if the radius is not positive.
    """
    require_positive("roller radius", roller_radius, "mm", "give a roller's radius")
    low, high = 0.0, math.pi
    centre, seat = -math.inf, 0.0
    for _ in range(_ZOOMS):
        psi = np.linspace(low, high, _GRID)
        tooth = profile.at(psi, np.ones_like(psi)).position
        room = roller_radius**2 - tooth.imag**2
        reach = np.where(room >= 0.0, tooth.real + np.sqrt(np.maximum(room, 0.0)), -np.inf)
        best = int(np.argmax(reach))
        centre, seat = float(reach[best]), float(psi[best])
        low, high = float(psi[max(best - 1, 0)]), float(psi[min(best + 1, _GRID - 1)])
    lobes = profile.trochoid.lobes
    off_diameter = 0.5 * math.pi / lobes if lobes % 2 else 0.0
    return OverRollers(roller_radius, 2.0 * (centre * math.cos(off_diameter) + roller_radius), centre, seat)
