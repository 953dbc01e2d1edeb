"""The four numbers of accuracy against torque, from a light load to an overload (docs/rig.md, "Torque sweep")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.rig.transmission import carrier_rotation

SHARES = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5])


@dataclass(frozen=True, slots=True)
class TorqueSweep:
    """Values at each torque, shape (torques,).

    ``torque`` [N·mm]; ``twist`` between +T and −T, mean over a turn [rad]; ``stiffness`` of the chord to the next lower
    torque [N·mm/rad], NaN at the first; ``transmission_error`` peak to peak [rad].
    """

    built: Built
    torque: FloatArray
    twist: FloatArray
    stiffness: FloatArray
    transmission_error: FloatArray


def torque_sweep(built: Built, shares: FloatArray = SHARES, poses: int = 240) -> TorqueSweep:
    """Load the reducer both ways at ``shares`` of its rated torque, at ``poses`` over a turn of the output."""
    torque = shares * abs(built.case.torque)
    both = carrier_rotation(built, np.concatenate([torque, -torque]), poses)
    there, back = both[: torque.size], both[torque.size :]
    twist = np.mean(there - back, axis=1)
    slope = np.full(torque.size, np.nan)
    slope[1:] = 2.0 * np.diff(torque) / np.diff(twist)
    return TorqueSweep(built, torque, twist, slope, np.ptp(there, axis=1))
