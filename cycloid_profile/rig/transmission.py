"""Transmission error over a turn of the output, and its orders (docs/rig.md, "Transmission error")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.rig.alike_poses import alike_poses

POSES = 3000


@dataclass(frozen=True, slots=True)
class TransmissionError:
    """Actual minus ideal angle of the output at one torque over one turn.

    ``output_angle`` from 0 to 2π [rad]; ``error``, its mean taken off [rad], NaN where no equilibrium was found;
    both shape (poses,). ``torque`` on the output [N·mm].
    """

    built: Built
    torque: float
    output_angle: FloatArray
    error: FloatArray

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest error [rad]."""
        return float(np.ptp(self.error))

    @property
    def orders(self) -> FloatArray:
        """Amplitude of each order per turn of the output, from 0 on [rad]; the mesh order folds back at few poses."""
        return spectrum(self.error)


def spectrum(values: FloatArray) -> FloatArray:
    """Amplitudes of the orders of evenly spaced values over one turn, from order 0 on, in their unit."""
    amplitude: FloatArray = 2.0 * np.abs(np.fft.rfft(values)) / values.size
    amplitude[0] *= 0.5
    if values.size % 2 == 0:
        amplitude[-1] *= 0.5
    return amplitude


def transmission_error(built: Built, torque: float, poses: int = POSES) -> TransmissionError:
    """Transmission error under ``torque`` [N·mm]; raises ``LoadError`` if it is zero or not finite."""
    (error,) = carrier_rotation(built, np.array([torque]), poses)
    angle = 2.0 * np.pi * np.arange(poses) / poses
    settled = error[np.isfinite(error)]
    return TransmissionError(built, torque, angle, error - np.mean(settled) if settled.size else error)


def carrier_rotation(built: Built, torques: FloatArray, poses: int) -> FloatArray:
    """Angle the encoder reads beyond the ideal one over a turn, shape (torques, poses) [rad]; no friction."""
    angle = 2.0 * np.pi * np.arange(poses) / poses
    turns, through = np.tile(angle, torques.size), np.repeat(torques, poses)
    solved, alike = alike_poses(built, turns, through)
    crank = np.tile(output_turn(built.case.drive.trochoid, poses), torques.size)
    stage = StageEquilibrium(as_built=built.parts)
    blocks = stage.blocks(built.case, crank[solved], through[solved])
    turned = np.concatenate([np.where(block.settled, block.rotation, np.nan) for block in blocks])[alike.of]
    read = (built.encoder * np.exp(-1j * angle)).real
    total: FloatArray = turned.reshape(torques.size, poses) + built.series_compliance * torques[:, np.newaxis] + read
    return total
