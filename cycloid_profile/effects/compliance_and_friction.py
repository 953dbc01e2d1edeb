"""Compliance beyond the stage model, friction, and sensor errors: the dimensions of the parts stay as drawn."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from cycloid_profile.contact.laws import OnSpring
from cycloid_profile.effects.base import Effect, EffectLocation, angle_field, shape_field, size_field
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.effects.series import CreepTwist, PowerTwist
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM


@dataclass(frozen=True)
class SeriesCompliance(Effect):
    """Compliance of shafts, carrier, main bearings and housing in series with the stage: Θ increases by T/k.

    The torsional compliance increases by the same amount at every torque.
    """

    remedy = "nothing on the machine; it belongs to the model"
    location = EffectLocation.COMPLIANCE
    linear_in_reciprocal = True
    stiffness_nm_per_arcmin: float = size_field("stiffness in series [N·m/′]", 150.0, 1e-6, 1e6)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        stiffness = self.stiffness_nm_per_arcmin * NEWTON_METRE / ARCMIN
        return replace(reducer, series_compliance=reducer.series_compliance + 1.0 / stiffness)


@dataclass(frozen=True)
class NonlinearSeriesCompliance(Effect):
    """Joints, bearings and housing in series with the stage twist with a power of the torque.

    An exponent below 1 stiffens under load, as contacts do; one above 1 softens, as plastics do.
    """

    remedy = "tighter joints, preload; it belongs to the model"
    location = EffectLocation.COMPLIANCE
    law_varies = True
    shapes = MappingProxyType({"exponent": (0.7, 0.4, 1.0, 1.5, 2.0)})
    twist_arcmin: float = size_field("twist at rated torque [arcmin]", 1.0, 0.0, 21600.0)
    exponent: float = shape_field("exponent of the torque", 0.7, 0.2, 5.0)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        twist = PowerTwist(self.twist_arcmin * ARCMIN, self.exponent, abs(reducer.case.torque))
        return replace(reducer, further_twists=(*reducer.further_twists, twist))


@dataclass(frozen=True)
class ViscoelasticCreep(Effect):
    """Plastic parts in series with the stage go on twisting after the torque has changed, and come back late.

    The loop opens as friction opens it, and its ends are round. At rest the twist is proportional to the torque.
    """

    remedy = "stiffer material, lower stress, measure more slowly"
    location = EffectLocation.COMPLIANCE
    shapes = MappingProxyType({"relaxation_share": (0.3, 0.1, 1.0)})
    twist_arcmin: float = size_field("late twist at rated torque, at rest [arcmin]", 1.0, 0.0, 21600.0)
    relaxation_share: float = shape_field(
        "change of torque, over the rated one, in which 63 % of the twist follows", 0.3, 0.01, 10.0
    )

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        rated = abs(reducer.case.torque)
        twist = CreepTwist(self.twist_arcmin * ARCMIN, self.relaxation_share * rated, rated)
        return replace(reducer, further_twists=(*reducer.further_twists, twist))


@dataclass(frozen=True)
class CrankBearingCompliance(Effect):
    """Crank bearings softer than the drawing has them: their compliance grows by the amount."""

    remedy = "check preload and fits of the crank bearings"
    location = EffectLocation.COMPLIANCE
    added_um_per_kn: float = size_field("added radial compliance of each bearing [µm/kN]", 1.0, 0.0, 1e7)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return reducer.with_bearings(softer=self.added_um_per_kn * UM / 1e3)


@dataclass(frozen=True)
class PinSupportCompliance(Effect):
    """Compliance of the pins in their seats, and their bending between these: δ increases by c·F."""

    remedy = "half-bores over the whole length, thicker ring"
    location = EffectLocation.COMPLIANCE
    added_um_per_kn: float = size_field("added compliance of each pin [µm/kN]", 1.0, 0.0, 1e7)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        law = OnSpring(reducer.case.law, self.added_um_per_kn * UM / 1e3)
        return replace(reducer, case=replace(reducer.case, law=law))


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Friction that does not depend on load: seals, preload, grease. The loop opens evenly."""

    remedy = "softer seals, less preload"
    location = EffectLocation.FRICTION
    torque_nm: float = size_field("friction torque at the output [N·m]", 5.0, 0.0, 1e5)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return replace(reducer, coulomb_torque=reducer.coulomb_torque + self.torque_nm * NEWTON_METRE)


@dataclass(frozen=True)
class ElastoslideFriction(Effect):
    """Coulomb friction of many contacts that slip one after the other: the loop turns round at its ends."""

    remedy = "softer seals, less preload"
    location = EffectLocation.FRICTION
    shapes = MappingProxyType({"spread": (1.0, 0.5)})
    torque_nm: float = size_field("mean friction torque at the output [N·m]", 5.0, 0.0, 1e5)
    spread: float = shape_field("half the range of the slip torques over their mean", 1.0, 0.0, 1.0)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        torque = self.torque_nm * NEWTON_METRE
        return replace(
            reducer,
            coulomb_torque=reducer.coulomb_torque + torque,
            friction_spread=reducer.friction_spread + self.spread * torque,
        )


@dataclass(frozen=True)
class StribeckFriction(Effect):
    """Friction that is larger at break-away than in motion, the falling part of Stribeck's curve.

    After a reversal the stage sticks up to the break-away torque, then friction falls, or with a ratio below 1 rises,
    to its value in motion (docs/theory.md, Eq. 129). Ratio 1 is Coulomb friction. Source: Stribeck, Z. VDI 46 (1902).
    """

    remedy = "another lubricant, softer seals, less preload"
    location = EffectLocation.FRICTION
    shapes = MappingProxyType({"breakaway_ratio": (1.5, 0.3), "travel_share": (1.0, 4.0)})
    torque_nm: float = size_field("friction torque in motion, at the output [N·m]", 5.0, 0.0, 1e5)
    breakaway_ratio: float = shape_field("friction at break-away over that in motion", 1.5, 0.0, 5.0)
    travel_share: float = shape_field(
        "change of the stage's torque, over the friction in motion, in which the difference falls to 1/e",
        1.0,
        0.01,
        100.0,
    )

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        torque = self.torque_nm * NEWTON_METRE
        return replace(
            reducer,
            coulomb_torque=reducer.coulomb_torque + torque,
            breakaway_torque=reducer.breakaway_torque + (self.breakaway_ratio - 1.0) * torque,
            breakaway_travel=reducer.breakaway_travel + self.travel_share * torque,
        )


@dataclass(frozen=True)
class LoadProportionalFriction(Effect):
    """Friction of the loaded contacts: a share of the torque. The loop opens towards its ends."""

    remedy = "lubricant, surface of the flanks, pins that turn"
    location = EffectLocation.FRICTION
    coefficient: float = size_field("friction torque over torque", 0.03, 0.0, 0.9)

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        return replace(reducer, proportional_friction=reducer.proportional_friction + self.coefficient)


@dataclass(frozen=True)
class EncoderEccentricity(Effect):
    """Angle encoder mounted off the axis: the angle read is wrong by A cos(Θ − φ), once per turn of the output."""

    remedy = "centre the encoder, or read two heads"
    location = EffectLocation.SENSOR
    amplitude_arcsec: float = size_field("amplitude of the angle error [arcsec]", 5.0, 0.0, 36000.0)
    phase_deg: float = angle_field("output angle of the largest error [°]")

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        error = self.amplitude_arcsec * ARCSEC * np.exp(1j * self.phase_deg * DEGREE)
        return replace(reducer, encoder=reducer.encoder + complex(error))
