"""Friction and sensor: they change what a bench reads, not how the parts lie."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place, angle, size
from cycloid_profile.units import ARCSEC, DEGREE, NEWTON_METRE


@dataclass(frozen=True)
class CoulombFriction(Effect):
    """Friction that does not depend on load: seals, preload, grease. The loop opens evenly.

    Cure: softer seals, less preload.
    """

    name: ClassVar[str] = "coulomb_friction"
    place: ClassVar[Place] = Place.FRICTION
    torque_nm: float = size("friction torque at the output [N·m]", 5.0, 0.0, 1e5)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        return replace(built, coulomb_torque=built.coulomb_torque + self.torque_nm * NEWTON_METRE)


@dataclass(frozen=True)
class LoadProportionalFriction(Effect):
    """Friction of the loaded contacts: a share of the torque. The loop opens towards its ends.

    Cure: lubricant, surface of the flanks, pins that turn.
    """

    name: ClassVar[str] = "load_proportional_friction"
    place: ClassVar[Place] = Place.FRICTION
    coefficient: float = size("friction torque over torque", 0.03, 0.0, 0.9)

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        return replace(built, proportional_friction=built.proportional_friction + self.coefficient)


@dataclass(frozen=True)
class EncoderEccentricity(Effect):
    """Angle encoder mounted off the axis: the angle read is wrong by A cos(Θ − φ), once per turn of the output.

    Cure: centre the encoder, or read two heads.
    """

    name: ClassVar[str] = "encoder_eccentricity"
    place: ClassVar[Place] = Place.SENSOR
    amplitude_arcsec: float = size("amplitude of the angle error [arcsec]", 5.0, 0.0, 36000.0)
    phase_deg: float = angle("output angle of the largest error [°]")

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        error = self.amplitude_arcsec * ARCSEC * np.exp(1j * self.phase_deg * DEGREE)
        return replace(built, encoder=built.encoder + complex(error))
