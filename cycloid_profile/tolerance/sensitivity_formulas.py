"""First-order sensitivities of the backlash, as they are and as [TP] prints them (docs/budget.md, Eqs. B1–B7).

Symbols of the article, left, and of this package: α or a, eccentricity a; z_c, lobes; K_1, short-width ratio
a z_p/r_p; i_H, ratio i of the reducer; r_1, "pitch radius of the planetary gear" (it must be that of the sun); α_0,
"centre distance" (it must be the radius r_c of the crank circle). The article prints ′/mm; here it is rad/mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from cycloid_profile.geometry.drive import Cranks, Drive
from cycloid_profile.tolerance.first_stage import PRESSURE_ANGLE, InvolutePair


def pin_radius(drive: Drive) -> float:
    """Pins or equidistant amount, 2/(a z_c) (Eq. B1) [rad/mm]."""
    return 2.0 / drive.trochoid.longest_lever


def pin_circle(drive: Drive) -> float:
    """Pin circle or radial-moving amount, 2√(1−K1²)/(a z_c) (Eq. B2) [rad/mm]."""
    return pin_radius(drive) * math.sqrt(1.0 - drive.trochoid.short_width_ratio**2)


def pin_circle_as_published(drive: Drive) -> float:
    """The same with 1−K1² in place of its root, as the article's 46.0867 has it [rad/mm]."""
    return pin_radius(drive) * (1.0 - drive.trochoid.short_width_ratio**2)


def pin_position(drive: Drive) -> float:
    """2K1/(a z_c): both touching pins off their places along the circle, apart from each other (Eq. B3) [rad/mm]."""
    return pin_radius(drive) * drive.trochoid.short_width_ratio


def normal_length(drive: Drive) -> float:
    """Common normal of sun or planet: 1/(i r_1 cosα), r_1 of the sun (Eq. B4) [rad/mm]."""
    return 1.0 / (drive.reduction_ratio * _pair(drive).sun_radius * math.cos(PRESSURE_ANGLE))


def normal_length_as_published(drive: Drive) -> float:
    """The same with the pitch radius of the planet [rad/mm]."""
    return 1.0 / (drive.reduction_ratio * _pair(drive).planet_radius * math.cos(PRESSURE_ANGLE))


def centre_distance(drive: Drive) -> float:
    """Centre distance, or offset of a planet at its worst: 2tanα/(i r_1), r_1 of the sun (Eq. B5) [rad/mm]."""
    return 2.0 * math.tan(PRESSURE_ANGLE) / (drive.reduction_ratio * _pair(drive).sun_radius)


def centre_distance_as_published(drive: Drive) -> float:
    """The same with the pitch radius of the planet [rad/mm]."""
    return 2.0 * math.tan(PRESSURE_ANGLE) / (drive.reduction_ratio * _pair(drive).planet_radius)


def crank_bearing(drive: Drive) -> float:
    """Diametral clearance of the crank bearings, 1/r_c with the radius of the crank circle (Eq. B7) [rad/mm]."""
    assert isinstance(drive.support, Cranks)
    return 1.0 / drive.support.circle_radius


def part_of(share: float, of: Callable[[Drive], float]) -> Callable[[Drive], float]:
    """A sensitivity that is a fixed ``share`` of another."""
    return lambda drive: share * of(drive)


def _pair(drive: Drive) -> InvolutePair:
    assert drive.first_stage is not None
    return InvolutePair(drive.first_stage)
