"""What play of the involute stage is worth at the output (docs/budget.md, Eqs. B4–B6)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.contact.as_built import AsBuilt
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry.drive import Cranks, Drive, InvoluteStage
from cycloid_profile.units import DEGREE

PRESSURE_ANGLE = 20.0 * DEGREE
_LEAD = 1e-5  # rad; small against every tooth, large against rounding


@dataclass(frozen=True, slots=True)
class InvolutePair:
    """Sun and planet without profile shift at their own centre distance, ``pressure_angle`` α [rad]."""

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
        """Turn of the sun that a common normal shorter by ``thinner`` [mm] leaves, planet held [rad].

        Exact: the normal is tangent to the base circle r_1 cosα.
        """
        return thinner / (self.sun_radius * math.cos(self.pressure_angle))

    def play_of_centre_distance(self, wider: float) -> float:
        """Turn of the sun that axes further apart by ``wider`` [mm] leave, planet held; below 0 they jam [rad].

        Exact: 2(1 + z2/z1)(inv α' − inv α) with the working angle cosα' = A cosα/(A + ΔA).
        """
        axes = self.sun_radius + self.planet_radius
        working = math.acos(axes * math.cos(self.pressure_angle) / (axes + wider))
        return 2.0 * axes / self.sun_radius * (_involute(working) - _involute(self.pressure_angle))


def _involute(angle: float) -> float:
    return math.tan(angle) - angle


def output_per_sun_play(case: LoadCase) -> float:
    """Turn of the output for a turn of the sun that leaves the planets where they are, by the stage model.

    All planets are driven ahead and behind by the same small angle and the carrier is let follow, under the rated
    torque, at crank angle 0. Needs a first stage; kinematics alone say 1/ratio.
    """
    drive = case.drive
    stage = drive.first_stage
    assert stage is not None
    assert isinstance(drive.support, Cranks)
    turned = []
    for sign in (0.5, -0.5):
        lead = np.full(drive.support.count, sign * _LEAD, dtype=np.complex128)
        solved = StageEquilibrium(as_built=AsBuilt(crank_lead=lead)).at(case, [0.0])
        if not solved.converged:
            raise SolveError(
                "equilibrium of the stage", solved.status.value, "", "check the modification amounts", ": "
            )
        turned.append(float(solved.rotation[0]))
    return abs(turned[0] - turned[1]) / _LEAD * stage.tooth_ratio


def crank_held(drive: Drive) -> Drive:
    """The same drive with its cranks as the input: what they do does not depend on the first stage."""
    return replace(drive, first_stage=None)
