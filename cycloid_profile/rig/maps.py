"""Backlash, lost motion and rigidity against the angle of the output (docs/rig.md, "Maps")."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.rig.transmission import carrier_rotation

LOST_MOTION_SHARE = 0.03
POSES = 600


@dataclass(frozen=True, slots=True)
class AngleMap:
    """A quantity over one turn of the output: ``output_angle`` and ``value``, shape (poses,).

    ``value`` is an angle [rad] or a stiffness [N·mm/rad]; ``torque`` what it was taken at [N·mm].
    """

    built: Built
    torque: float
    output_angle: FloatArray
    value: FloatArray


def lost_motion_map(built: Built, torque: float | None = None, poses: int = POSES) -> AngleMap:
    """Angle at +``torque`` minus angle at −``torque``, 3 % of the rated torque unless given.

    Friction is not in it: this is the centreline of the loop, whose two branches friction moves alike.
    """
    T = LOST_MOTION_SHARE * abs(built.case.torque) if torque is None else torque
    there, back = carrier_rotation(built, np.array([T, -T]), poses)
    return AngleMap(built, T, _angles(poses), there - back)


def rigidity_map(built: Built, poses: int = POSES) -> AngleMap:
    """b/a between 50 % and 100 % of the rated torque [N·mm/rad]."""
    T = abs(built.case.torque)
    half, full = carrier_rotation(built, np.array([0.5 * T, T]), poses)
    return AngleMap(built, T, _angles(poses), 0.5 * T / (full - half))


def backlash_map(built: Built, poses: int = POSES) -> AngleMap:
    """Turn of the output between first touch on either flank, input held, bearings unloaded [rad].

    The bearings stay where their play leaves them in the middle; what play adds is in the lost motion.
    """
    crank = output_turn(built.case.drive.trochoid, poses)
    stage = StageEquilibrium(as_built=built.parts)
    small = 1e-3 * abs(built.case.torque)
    solved = stage.at(built.case, np.tile(crank, 2), np.repeat([small, -small], poses))
    forward, backward = solved.touch.reshape(2, poses)
    return AngleMap(built, 0.0, _angles(poses), forward - backward)


def _angles(poses: int) -> FloatArray:
    angle: FloatArray = 2.0 * np.pi * np.arange(poses) / poses
    return angle
