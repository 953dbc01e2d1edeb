"""Sliding at the pins, bearing loads and estimated losses of a running drive.

Docs: docs/theory.md, Eqs. 47–49, and "Running" for the ranges of the friction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.result import LoadSharing
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Drive

# Caged needle rollers, referred to half their bore: the range of JTEKT's bearing knowledge, Table 8-1, and its middle.
NEEDLE_FRICTION = 0.0025
NEEDLE_FRICTION_RANGE = (0.002, 0.003)
# Lubricated steel, textbook values: mixed film as on gears to boundary film. Halving or doubling does so to the loss.
TOOTH_FRICTION_RANGE = (0.03, 0.12)
EXCLUDED = "seals, churning, main bearings and first stage are excluded"


def sliding_speed(drive: Drive, phase: ArrayLike, output_speed: float) -> FloatArray:
    """Sliding speed |Ω|·|r_p/S − r_rp| at a pin that does not turn, array shape of ``phase`` [mm/s] (Eq. 47).

    The disc turns about the pitch point, a z_p from the middle of the housing, with the ``output_speed`` Ω
    [rad/s]. A pin that turns in its seat moves this sliding from the tooth to the seat.
    """
    distance = drive.trochoid.pin_circle_radius * drive.trochoid.speed_ratio(phase) - drive.pin_radius
    speed: FloatArray = abs(output_speed) * np.abs(distance)
    return speed


@dataclass(frozen=True, slots=True)
class Losses:
    """Mean power over the poses of ``sharing`` [W]: ``mesh`` and ``bearings`` lost, ``output`` delivered.

    ``friction`` between tooth and pin and ``needle_friction`` of the crank bearings are the coefficients behind it.
    """

    sharing: LoadSharing
    mesh: float
    bearings: float
    output: float
    friction: float
    needle_friction: float

    @property
    def heat(self) -> float:
        """Power that becomes heat in this stage [W]; seals, churning and the first stage are excluded."""
        return self.mesh + self.bearings

    @property
    def efficiency(self) -> float:
        """Output over output and losses of this stage; seals, churning and the first stage are excluded."""
        return self.output / (self.output + self.heat)


@dataclass(frozen=True, slots=True)
class LossRange:
    """Losses with the least, the likely and the largest friction; ``bearing_radius`` of the crank bearings [mm]."""

    low: Losses
    likely: Losses
    high: Losses
    bearing_radius: float

    @property
    def assumption(self) -> str:
        """The assumptions behind the range, one sentence."""
        low, likely, high = self.low, self.likely, self.high
        case = likely.sharing.case
        steel = case.disc_material.is_steel and case.pin_material.is_steel
        bodies = "" if steel else ", though the bodies are not both steel"
        bearings = (
            f"{low.needle_friction:g} to {high.needle_friction:g} (caged needle rollers, likely "
            f"{likely.needle_friction:g}) at {self.bearing_radius:.4g} mm in the crank bearings"
            if likely.bearings > 0.0
            else "crank bearings left out"
        )
        return (
            f"friction {low.friction:g} (mixed film) to {high.friction:g} (boundary film), likely {likely.friction:g}, "
            f"of lubricated steel{bodies}, on pins that do not turn; {bearings}; {EXCLUDED}"
        )


def loss_range(sharing: LoadSharing, output_speed: float, friction: float, bearing_radius: float = 0.0) -> LossRange:
    """Losses over the range of friction of lubricated steel and of needle rollers; ``friction`` is the likely one.

    Arguments and errors as of ``losses``.
    """
    least, largest = TOOTH_FRICTION_RANGE
    cases = zip(
        (min(least, friction), friction, max(largest, friction)),
        (NEEDLE_FRICTION_RANGE[0], NEEDLE_FRICTION, NEEDLE_FRICTION_RANGE[1]),
        strict=True,
    )
    low, likely, high = (losses(sharing, output_speed, mu, bearing_radius, needle) for mu, needle in cases)
    return LossRange(low, likely, high, bearing_radius)


def losses(
    sharing: LoadSharing,
    output_speed: float,
    friction: float,
    bearing_radius: float = 0.0,
    needle_friction: float = NEEDLE_FRICTION,
) -> Losses:
    """Estimate of the friction losses (Eqs. 48–49).

    Parameters
    ----------
    sharing : load on the pins; a result of a single disc is taken as valid for every disc
    output_speed : Ω [rad/s]
    friction : coefficient of friction between tooth and pin
    bearing_radius : half the bore of the crank bearings, the radius of the eccentric they run on [mm]; 0 leaves them
        out, as do solvers that know no bearing forces
    needle_friction : coefficient of friction of the crank bearings, referred to that radius

    Raises
    ------
    LoadError
        If speed or friction is negative or not finite.
    """
    frictions = (("friction", friction, ""), ("needle_friction", needle_friction, ""))
    for name, value, unit in (("output_speed", output_speed, " rad/s"), *frictions):
        if not (math.isfinite(value) and value >= 0.0):
            raise LoadError(name, f"{value}{unit}", "is negative or not finite", f"give a {name} of zero or more")
    drive = sharing.case.drive
    speed = sliding_speed(drive, sharing.phase, output_speed)
    discs = drive.discs / sharing.force.shape[1]
    mesh = discs * friction * float(np.mean(np.sum(sharing.force * speed, axis=(1, 2))))
    bearings = 0.0
    if sharing.stage is not None:
        # A crank turns z_p times as fast against the disc as the output against the housing.
        turning = output_speed * drive.trochoid.pins
        load = float(np.mean(np.sum(np.abs(sharing.stage.bearing_force), axis=(1, 2))))
        bearings = needle_friction * load * bearing_radius * turning
    output = float(np.mean(np.abs(sharing.torque))) * output_speed
    watt = 1e-3  # N·mm/s
    return Losses(sharing, mesh * watt, bearings * watt, output * watt, friction, needle_friction)
