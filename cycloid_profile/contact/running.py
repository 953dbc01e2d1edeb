"""What a running drive adds to a load sharing: sliding at the pins, bearing loads, an estimate of the losses.

Docs: docs/theory.md, Eqs. 47–49.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry.drive import Drive

# Constant friction of caged needle rollers, referred to half their bore: the usual catalogue figure.
NEEDLE_FRICTION = 0.0025


def sliding_speed(drive: Drive, phase: ArrayLike, output_speed: float) -> FloatArray:
    """Speed of the tooth past a pin that does not turn, |Ω|·|r_p/S − r_rp|, in the shape of ``phase`` [mm/s] (Eq. 47).

    The disc turns about the pitch point, a z_p from the middle of the housing, with the ``output_speed`` Ω
    [rad/s]. A pin that turns in its seat moves this sliding from the tooth to the seat.
    """
    distance = drive.trochoid.pin_circle_radius * drive.trochoid.speed_ratio(phase) - drive.pin_radius
    speed: FloatArray = abs(output_speed) * np.abs(distance)
    return speed


@dataclass(frozen=True, slots=True)
class Losses:
    """Mean power over the poses of ``sharing`` [W]: ``mesh`` and ``bearings`` lost, ``output`` delivered."""

    sharing: LoadSharing
    mesh: float
    bearings: float
    output: float

    @property
    def efficiency(self) -> float:
        """Output over output and losses of this stage; seals, churning and the first stage are not in it."""
        return self.output / (self.output + self.mesh + self.bearings)


def losses(sharing: LoadSharing, output_speed: float, friction: float, bearing_radius: float = 0.0) -> Losses:
    """Estimate of the friction losses (Eqs. 48–49).

    Parameters
    ----------
    sharing : load on the pins; solvers of one disc stand for all discs
    output_speed : Ω [rad/s]
    friction : coefficient of friction between tooth and pin
    bearing_radius : radius of the crank bearings' rolling circle [mm]; 0 leaves them out, as do solvers that
        know no bearing forces

    Raises
    ------
    LoadError
        If speed or friction is negative or not finite.
    """
    for name, value, unit in (("output_speed", output_speed, " rad/s"), ("friction", friction, "")):
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
        bearings = NEEDLE_FRICTION * load * bearing_radius * turning
    output = float(np.mean(np.abs(sharing.torque))) * output_speed
    watt = 1e-3  # N·mm/s
    return Losses(sharing, mesh * watt, bearings * watt, output * watt)
