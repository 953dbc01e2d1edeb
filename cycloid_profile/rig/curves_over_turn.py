"""Curves over one turn of the output, without friction: transmission error, lost motion, backlash, rigidity.

Constructions: docs/rig.md, "Transmission error", "Maps" and "Torque sweep".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.rig._equivalent_poses import equivalent_poses
from cycloid_profile.rig.hysteresis import LOST_MOTION_SHARE
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

# Over a turn of the output. Of 40 pins the mesh order, 1,560, is aliased to 1,440 by 3,000 poses, as docs/rig.md says.
TRANSMISSION_POSES, MAP_POSES, SWEEP_POSES = 3000, 600, 240
SHARES = np.linspace(0.1, 1.5, 15).round(1)  # of the rated torque, in steps of a tenth
_TOUCH_SHARE = 1e-3  # of the rated torque: presses a flank without deforming it


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class TransmissionError(Described):
    """Actual minus ideal angle of the output at one torque over one turn.

    ``output_angle`` from 0 to 2π [rad]; ``error`` with zero mean [rad], NaN where no equilibrium was found;
    both shape (poses,). ``torque`` on the output [N·mm].
    """

    reducer: AsBuiltReducer
    torque: float
    output_angle: FloatArray
    error: FloatArray

    @property
    def peak_to_peak(self) -> float:
        """Largest minus smallest error [rad]."""
        return float(np.ptp(self.error))

    @property
    def orders(self) -> FloatArray:
        """Amplitude of each order per turn of the output, from 0 on [rad]; too few poses alias the mesh order."""
        return spectrum(self.error)

    def to_frame(self) -> Any:
        """``output_angle_deg`` and ``error_arcsec`` as a ``pandas.DataFrame``."""
        return frame({"output_angle_deg": self.output_angle / DEGREE, "error_arcsec": self.error / ARCSEC})

    def _key_figures(self) -> dict[str, str]:
        return {
            "torque": f"{self.torque / NEWTON_METRE:.4g} N·m",
            "poses": str(self.error.size),
            "peak to peak": f"{self.peak_to_peak / ARCSEC:.4g}″",
            "largest order": str(int(np.argmax(self.orders[1:])) + 1),
        }


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class AngleMap(Described):
    """A quantity over one turn of the output: ``output_angle`` [rad] and ``value``, shape (poses,).

    ``value`` is an angle [rad], or a stiffness [N·mm/rad] where ``is_stiffness``; taken at ``torque`` [N·mm].
    """

    reducer: AsBuiltReducer
    torque: float
    output_angle: FloatArray
    value: FloatArray
    is_stiffness: bool = False

    def to_frame(self) -> Any:
        """``output_angle_deg`` and the value, in arcmin or N·m/arcmin, as a ``pandas.DataFrame``."""
        column, scaled = self._scaled
        return frame({"output_angle_deg": self.output_angle / DEGREE, column: scaled})

    @property
    def _scaled(self) -> tuple[str, FloatArray]:
        if self.is_stiffness:
            return "value_nm_per_arcmin", self.value * ARCMIN / NEWTON_METRE
        return "value_arcmin", self.value / ARCMIN

    def _key_figures(self) -> dict[str, str]:
        _, scaled = self._scaled
        unit = "N·m/′" if self.is_stiffness else "′"
        figures = {"mean": np.mean(scaled), "smallest": np.min(scaled), "largest": np.max(scaled)}
        return {
            "torque": f"{self.torque / NEWTON_METRE:.4g} N·m",
            "poses": str(scaled.size),
            **{name: f"{value:.4g} {unit}" for name, value in figures.items()},
        }


@dataclass(frozen=True, eq=False, slots=True)
class TorqueSweep:
    """Values at each torque, shape (torques,).

    ``torque`` [N·mm]; ``twist`` between +T and −T, mean over a turn [rad]; ``stiffness`` of the chord to the next lower
    torque [N·mm/rad], NaN at the first; ``transmission_error`` peak to peak [rad].
    """

    reducer: AsBuiltReducer
    torque: FloatArray
    twist: FloatArray
    stiffness: FloatArray
    transmission_error: FloatArray


def transmission_error(reducer: AsBuiltReducer, torque: float, poses: int = TRANSMISSION_POSES) -> TransmissionError:
    """Transmission error under ``torque`` [N·mm]; raises ``LoadError`` if it is zero or not finite."""
    (error,) = encoder_readings(reducer, np.array([torque]), poses)
    solved = error[np.isfinite(error)]
    return TransmissionError(reducer, torque, output_angles(poses), error - np.mean(solved) if solved.size else error)


def lost_motion_map(reducer: AsBuiltReducer, torque: float | None = None, poses: int = MAP_POSES) -> AngleMap:
    """Angle at +``torque`` minus angle at −``torque``, 3 % of the rated torque unless given.

    Friction is excluded: this is the centreline of the loop, whose two branches friction shifts equally.
    """
    T = LOST_MOTION_SHARE * abs(reducer.case.torque) if torque is None else torque
    forward, backward = encoder_readings(reducer, np.array([T, -T]), poses)
    return AngleMap(reducer, T, output_angles(poses), forward - backward)


def rigidity_map(reducer: AsBuiltReducer, poses: int = MAP_POSES) -> AngleMap:
    """Torsional rigidity b/a between 50 % and 100 % of the rated torque [N·mm/rad]."""
    T = abs(reducer.case.torque)
    half, full = encoder_readings(reducer, np.array([0.5 * T, T]), poses)
    return AngleMap(reducer, T, output_angles(poses), 0.5 * T / (full - half), is_stiffness=True)


def backlash_map(reducer: AsBuiltReducer, poses: int = MAP_POSES) -> AngleMap:
    """Rotation of the output between first contacts of the two flanks, input held, bearings unloaded [rad].

    The bearings rest in the middle of their play; the lost motion includes the play.
    """
    forward, backward = touch_angles(reducer, poses)
    return AngleMap(reducer, 0.0, output_angles(poses), forward - backward)


def torque_sweep(reducer: AsBuiltReducer, shares: FloatArray = SHARES, poses: int = SWEEP_POSES) -> TorqueSweep:
    """Load the reducer both ways at ``shares`` of its rated torque, at ``poses`` over a turn of the output."""
    torque = shares * abs(reducer.case.torque)
    both = encoder_readings(reducer, np.concatenate([torque, -torque]), poses)
    forward, backward = both[: torque.size], both[torque.size :]
    twist = np.mean(forward - backward, axis=1)
    slope = np.full(torque.size, np.nan)
    slope[1:] = 2.0 * np.diff(torque) / np.diff(twist)
    return TorqueSweep(reducer, torque, twist, slope, np.ptp(forward, axis=1))


def spectrum(values: FloatArray) -> FloatArray:
    """Amplitudes of the orders of evenly spaced values over one turn, from order 0 on, in their unit."""
    amplitude: FloatArray = 2.0 * np.abs(np.fft.rfft(values)) / values.size
    amplitude[0] *= 0.5
    if values.size % 2 == 0:
        amplitude[-1] *= 0.5
    return amplitude


def output_angles(poses: int) -> FloatArray:
    """Evenly spaced angles over a turn of the output, from 0 on [rad]."""
    return np.asarray(2.0 * np.pi * np.arange(poses) / poses)


def encoder_readings(reducer: AsBuiltReducer, torques: FloatArray, poses: int) -> FloatArray:
    """Angle the encoder reads beyond the ideal one over a turn, shape (torques, poses) [rad]; no friction."""
    angle = output_angles(poses)
    outputs, loads = np.tile(angle, torques.size), np.repeat(torques, poses)
    solved, equivalent = equivalent_poses(reducer, outputs, loads)
    crank = np.tile(output_turn(reducer.case.drive.trochoid, poses), torques.size)
    stage = StageEquilibrium(deviations=reducer.deviations)
    blocks = stage.blocks(reducer.case, crank[solved], loads[solved])
    rotation = np.concatenate([np.where(block.settled, block.rotation, np.nan) for block in blocks])
    turned = rotation[equivalent.representative].reshape(torques.size, poses)
    read = reducer.angle_error(angle)
    return np.asarray(turned + reducer.series_twist(torques)[:, np.newaxis] + read)


def touch_angles(reducer: AsBuiltReducer, poses: int) -> FloatArray:
    """Carrier rotations at first touch of the forward and the backward flanks over a turn, shape (2, poses) [rad]."""
    crank = output_turn(reducer.case.drive.trochoid, poses)
    light = _TOUCH_SHARE * abs(reducer.case.torque)
    stage = StageEquilibrium(deviations=reducer.deviations)
    solved = stage.at(reducer.case, np.tile(crank, 2), np.repeat([light, -light], poses))
    return np.asarray(solved.touch.reshape(2, poses))
