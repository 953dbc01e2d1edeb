"""What a measuring machine would read of one disc: points of the tooth curve (docs/rig.md, "Profile scan")."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry.sampling import EqualArc, sample


@dataclass(frozen=True, slots=True)
class ProfileScan:
    """Points of a disc, x + iy with the bore axis as origin, shape (points,) [mm].

    In the order of the scan, clockwise. Ball radius is taken off: these are points of the tooth itself.
    """

    built: Built
    disc: int
    points: ComplexArray


def profile_scan(built: Built, disc: int = 0, points: int = 5000, turned: float = 0.0) -> ProfileScan:
    """Scan of a disc, counted from 0, at about ``points`` points of equal arc; ``turned`` on the table by [rad].

    Raises
    ------
    LoadError
        If there is no such disc, or there would be fewer than 8 points on a lobe.
    """
    if not 0 <= disc < built.discs:
        raise LoadError("disc", disc + 1, f"is not one of the {built.discs} discs", "count from 1")
    tooth = built.teeth[disc]
    per_lobe = math.ceil(points / tooth.trochoid.lobes)
    if per_lobe < 8:
        raise LoadError("points", points, "are fewer than 8 on a lobe", f"give at least {8 * tooth.trochoid.lobes}")
    found = sample(tooth, EqualArc(per_lobe))
    return ProfileScan(built, disc, found.position * np.exp(1j * turned))
