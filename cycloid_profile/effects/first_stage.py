"""Errors of the first stage: planets, sun and input.

On the carrier, planets turn z_p times per turn of the output and the sun z_p·z2/z1 times, against the planets. The
input turns by the ratio of the drive. A runout drives by the mean of both flanks of the involute mesh.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.effects.base import (
    LARGEST_UM,
    Effect,
    EffectLocation,
    angle_field,
    part_field,
    part_indices,
    size_field,
)
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import Cranks, InvoluteStage
from cycloid_profile.units import ARCSEC, DEGREE, UM


class _InFirstStage(Effect):
    location = EffectLocation.SENSOR

    def _first_stage(self, reducer: AsBuiltReducer) -> InvoluteStage:
        """The first stage; raises ``SpecError`` if there is none."""
        drive = reducer.case.drive
        if drive.first_stage is None or not isinstance(drive.support, Cranks):
            raise SpecError(self.name, "given", "needs planets, which this drive has not", "add [drive.first_stage]")
        return drive.first_stage


@dataclass(frozen=True)
class PlanetRunout(_InFirstStage):
    """Planet gear off the axis of its crank: it drives the crank ahead and behind, once per turn of the planet.

    Lead A/r with the pitch radius r = m z2/2.
    """

    remedy = "gear cut on the bearing seats"
    amplitude_um: float = size_field("eccentricity of the pitch circle [µm]", 10.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("direction at crank angle 0 [°]")
    planet: int | None = part_field("number of the planet, which is that of its crank", 1)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        lead = self.amplitude_um * UM / self._first_stage(reducer).planet_radius
        crank_lead = reducer.crank_lead.copy()
        planets = part_indices(self, "planet", self.planet, reducer.cranks)
        crank_lead[list(planets)] += lead * np.exp(1j * self.phase_deg * DEGREE)
        return replace(reducer, crank_lead=crank_lead)


@dataclass(frozen=True)
class CommonPlanetRunout(_InFirstStage):
    """All planets off the axes of their cranks by the same amount, as gears cut in one faulty set-up.

    ``form`` 1: all drive ahead together, so that the output follows. 2: their eccentricities are parallel, as of
    planets cut in one position on their crank shafts: leads 2π/n apart, which cancel on the mean of n planets. Planets
    with other phases are one ``planet_runout`` each.
    """

    remedy = "cut the gears on the bearing seats; mount planets with their high sides turned against each other"
    amplitude_um: float = size_field("eccentricity of the pitch circles [µm]", 10.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("direction at crank angle 0, of planet 1 [°]")
    form: int = part_field("1: all drive ahead together; 2: eccentricities parallel", 1, most=2)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        lead = self.amplitude_um * UM / self._first_stage(reducer).planet_radius
        behind = np.arange(reducer.cranks) * (2.0 * np.pi / reducer.cranks if self.form == 2 else 0.0)
        return replace(reducer, crank_lead=reducer.crank_lead + lead * np.exp(1j * (self.phase_deg * DEGREE - behind)))


@dataclass(frozen=True)
class SunRunout(_InFirstStage):
    """Sun gear off the axis of the carrier, by its own eccentricity and that of its shaft together.

    Planet m is driven ahead by −(A/r2) sin(α + φ − 2πm/n), α the angle of the sun on the carrier. Evenly spaced planets
    cancel on the mean: the cranks work against each other, and discs that differ show it at z_p(1 + z2/z1).
    """

    remedy = "cut the sun on its shaft's seats, or let it float between the planets"
    amplitude_um: float = size_field("eccentricity of the pitch circle [µm]", 10.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("direction at crank angle 0 [°]")

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        self._first_stage(reducer)
        shift = self.amplitude_um * UM * np.exp(1j * self.phase_deg * DEGREE)
        return replace(reducer, sun_shift=reducer.sun_shift + complex(shift))


@dataclass(frozen=True)
class InputRunout(Effect):
    """Coupling or motor encoder off the axis of the input: the input is ahead by A cos(α − φ) at its angle α.

    The output follows by the ratio less, once per turn of the input, at every torque.
    """

    remedy = "align the coupling, centre the motor's encoder"
    location = EffectLocation.SENSOR
    amplitude_arcsec: float = size_field("amplitude of the angle error of the input [arcsec]", 60.0, 0.0, 36000.0)
    phase_deg: float = angle_field("input angle of the largest lead [°]")

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        ahead = self.amplitude_arcsec * ARCSEC * np.exp(1j * self.phase_deg * DEGREE)
        return replace(reducer, input_error=reducer.input_error + complex(ahead))
