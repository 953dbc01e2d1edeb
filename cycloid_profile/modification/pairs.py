"""Pairs of equidistant and radial-moving amounts with a wanted radial clearance (docs/theory.md, Eqs. 17–18)."""

from __future__ import annotations

import math

from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.setup import Equidistant, RadialMoving


def conjugate_pair(trochoid: Trochoid, radial_clearance: float) -> tuple[Equidistant, RadialMoving]:
    """Pair whose gap after take-up is almost zero along the flank, so that many pins share (Eq. 17).

    Its price is backlash, which a flank rotation or deformation compensation takes away.
    ``radial_clearance`` Δj at root and tip [mm].
    """
    s = math.sqrt(1.0 - trochoid.short_width_ratio**2)
    return Equidistant(radial_clearance / (1.0 - s)), RadialMoving(-radial_clearance * s / (1.0 - s))


def zero_backlash_pair(trochoid: Trochoid, radial_clearance: float) -> tuple[Equidistant, RadialMoving]:
    """Pair with no backlash to first order; fewer pins share the load (Eq. 18). ``radial_clearance`` [mm]."""
    s = math.sqrt(1.0 - trochoid.short_width_ratio**2)
    return Equidistant(-radial_clearance * s / (1.0 - s)), RadialMoving(radial_clearance / (1.0 - s))
