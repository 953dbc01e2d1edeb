"""Size over two rollers laid into opposite roots: a check of the tooth with a micrometer."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothProfile

_GRID = 4001
_ZOOMS = 3


@dataclass(frozen=True, slots=True)
class OverRollers:
    """A roller of ``roller_radius`` in each of two roots that lie as far apart as they can.

    ``size`` over both rollers [mm]; ``centre_radius`` from the disc's centre to a roller's [mm]; ``seat`` the
    phase at which a roller touches, 0 at the bottom of the root, else ± on both flanks [rad].
    """

    roller_radius: float
    size: float
    centre_radius: float
    seat: float


def over_rollers(profile: ToothProfile, roller_radius: float) -> OverRollers:
    """Size over two rollers of ``roller_radius`` [mm], exact.

    A roller pressed in on the axis of its root rests where P_x + √(r² − P_y²) is largest, P being the tooth
    with the root on the x axis. With an odd number of lobes the roots stand π/z_c off a diameter.

    Raises
    ------
    GeometryError
        If the radius is not positive.
    """
    if not (math.isfinite(roller_radius) and roller_radius > 0.0):
        raise GeometryError(
            "roller radius", f"{roller_radius} mm", "is not a positive length", "give a roller's radius"
        )
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
