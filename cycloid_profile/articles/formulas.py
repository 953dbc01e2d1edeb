"""First-order sensitivities of the backlash, correct and as printed in [TP] (docs/budget.md, Eqs. B1–B7).

Symbols of the article, left, and of this package: α or a, eccentricity a; z_c, lobes; K_1, short-width ratio
a z_p/r_p; i_H, ratio i of the reducer; r_1, "pitch radius of the planetary gear" (it must be that of the sun); α_0,
"centre distance" (it must be the radius r_c of the crank circle). The article prints ′/mm; these functions return
rad/mm.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from cycloid_profile.geometry import Cranks, Drive, InvoluteStage
from cycloid_profile.units import DEGREE

PRESSURE_ANGLE = 20.0 * DEGREE


@dataclass(frozen=True, slots=True)
class InvolutePair:
    """Sun and planet without profile shift at their reference centre distance; ``pressure_angle`` α [rad]."""

    stage: InvoluteStage
    pressure_angle: float = PRESSURE_ANGLE

    @property
    def sun_radius(self) -> float:
        """Pitch radius r_1 = m z1/2 [mm]."""
        return 0.5 * self.stage.module * self.stage.sun_teeth

    @property
    def planet_radius(self) -> float:
        """Pitch radius r_2 = m z2/2 [mm]."""
        return 0.5 * self.stage.module * self.stage.planet_teeth

    def play_of_normal_length(self, thinner: float) -> float:
        """Rotation of the sun permitted by a base tangent length shorter by ``thinner`` [mm], planet fixed [rad].

        Exact: the length is measured along a tangent to the base circle r_1 cosα.
        """
        return thinner / (self.sun_radius * math.cos(self.pressure_angle))

    def play_of_centre_distance(self, wider: float) -> float:
        """Rotation of the sun permitted by a centre distance larger by ``wider`` [mm], planet fixed; negative: jamming
        [rad].

        Exact: 2(1 + z2/z1)(inv α' − inv α) with the working angle cosα' = A cosα/(A + ΔA).
        """
        axes = self.sun_radius + self.planet_radius
        working = math.acos(axes * math.cos(self.pressure_angle) / (axes + wider))
        return 2.0 * axes / self.sun_radius * (_involute(working) - _involute(self.pressure_angle))


def pin_radius(drive: Drive) -> float:
    """Pins or equidistant amount, 2/(a z_c) (Eq. B1) [rad/mm]."""
    return 2.0 / drive.trochoid.longest_lever


def pin_circle(drive: Drive) -> float:
    """Pin circle or radial-moving amount, 2√(1−K1²)/(a z_c) (Eq. B2) [rad/mm]."""
    return pin_radius(drive) * math.sqrt(1.0 - drive.trochoid.short_width_ratio**2)


def pin_circle_as_published(drive: Drive) -> float:
    """The same with 1−K1² instead of its square root, which gives the article's 46.0867 [rad/mm]."""
    return pin_radius(drive) * (1.0 - drive.trochoid.short_width_ratio**2)


def pin_position(drive: Drive) -> float:
    """2K1/(a z_c): tangential position errors of both contacting pins, in opposite directions (Eq. B3) [rad/mm]."""
    return pin_radius(drive) * drive.trochoid.short_width_ratio


def normal_length(drive: Drive) -> float:
    """Base tangent length of sun or planet: 1/(i r_1 cosα), r_1 of the sun (Eq. B4) [rad/mm]."""
    return 1.0 / (drive.reduction_ratio * _pair(drive).sun_radius * math.cos(PRESSURE_ANGLE))


def centre_distance(drive: Drive) -> float:
    """Centre distance, or worst offset of a planet: 2tanα/(i r_1), r_1 of the sun (Eq. B5) [rad/mm]."""
    return 2.0 * math.tan(PRESSURE_ANGLE) / (drive.reduction_ratio * _pair(drive).sun_radius)


def sun_over_planet(drive: Drive) -> float:
    """r_1/r_2, which converts both formulas above to those of the article, with the pitch radius of the planet."""
    return _pair(drive).sun_radius / _pair(drive).planet_radius


def crank_bearing(drive: Drive) -> float:
    """Diametral clearance of the crank bearings, 1/r_c with the radius of the crank circle (Eq. B7) [rad/mm]."""
    assert isinstance(drive.support, Cranks)
    return 1.0 / drive.support.circle_radius


def _pair(drive: Drive) -> InvolutePair:
    assert drive.first_stage is not None
    return InvolutePair(drive.first_stage)


def _involute(angle: float) -> float:
    return math.tan(angle) - angle
