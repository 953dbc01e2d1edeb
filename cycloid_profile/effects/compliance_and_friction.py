"""Compliance beyond the stage model, friction, and sensor errors: the dimensions of the parts stay as drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.contact.laws import OnSpring
from cycloid_profile.effects.base import Effect, EffectLocation, angle_field, size_field
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM


@dataclass(frozen=True)
class SeriesCompliance(Effect):
    """Shafts, carrier, main bearings and housing give way in series with the stage: Θ increases by T/k.

    The torsional compliance increases by the same amount at every torque.
    """

    cure = "nothing on the machine; it belongs to the model"
    location = EffectLocation.COMPLIANCE
    linear_in_reciprocal = True
    stiffness_nm_per_arcmin: float = size_field("stiffness in series [N·m/′]", 150.0, 0.1, 1e6)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        stiffness = self.stiffness_nm_per_arcmin * NEWTON_METRE / ARCMIN
        return replace(reducer, series_compliance=reducer.series_compliance + 1.0 / stiffness)


@dataclass(frozen=True)
class CrankBearingCompliance(Effect):
    """Crank bearings softer than the drawing has them: their compliance grows by the amount."""

    cure = "check preload and fits of the crank bearings"
    location = EffectLocation.COMPLIANCE
    added_um_per_kn: float = size_field("added radial compliance of each bearing [µm/kN]", 1.0, 0.0, 1000.0)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return reducer.with_bearings(softer=self.added_um_per_kn * UM / 1e3)


@dataclass(frozen=True)
class PinSupportCompliance(Effect):
    """Pins that give way in their seats, or bend between them: δ increases by c·F."""

    cure = "half-bores over the whole length, thicker ring"
    location = EffectLocation.COMPLIANCE
    added_um_per_kn: float = size_field("added compliance of each pin [µm/kN]", 1.0, 0.0, 1000.0)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        law = OnSpring(reducer.case.law, self.added_um_per_kn * UM / 1e3)
        return replace(reducer, case=replace(reducer.case, law=law))


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Friction that does not depend on load: seals, preload, grease. The loop opens evenly."""

    cure = "softer seals, less preload"
    location = EffectLocation.FRICTION
    torque_nm: float = size_field("friction torque at the output [N·m]", 5.0, 0.0, 1e5)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return replace(reducer, coulomb_torque=reducer.coulomb_torque + self.torque_nm * NEWTON_METRE)


@dataclass(frozen=True)
class LoadProportionalFriction(Effect):
    """Friction of the loaded contacts: a share of the torque. The loop opens towards its ends."""

    cure = "lubricant, surface of the flanks, pins that turn"
    location = EffectLocation.FRICTION
    coefficient: float = size_field("friction torque over torque", 0.03, 0.0, 0.9)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return replace(reducer, proportional_friction=reducer.proportional_friction + self.coefficient)


@dataclass(frozen=True)
class EncoderEccentricity(Effect):
    """Angle encoder mounted off the axis: the angle read is wrong by A cos(Θ − φ), once per turn of the output."""

    cure = "centre the encoder, or read two heads"
    location = EffectLocation.SENSOR
    amplitude_arcsec: float = size_field("amplitude of the angle error [arcsec]", 5.0, 0.0, 36000.0)
    phase_deg: float = angle_field("output angle of the largest error [°]")

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        error = self.amplitude_arcsec * ARCSEC * np.exp(1j * self.phase_deg * DEGREE)
        return replace(reducer, encoder=reducer.encoder + complex(error))
