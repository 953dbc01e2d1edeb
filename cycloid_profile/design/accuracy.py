"""Accuracy of a design: backlash, lost motion, torsional rigidity and transmission error, four separate numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import Backlash, backlash
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.meshing import mesh_cycle
from cycloid_profile.contact.stage import StageEquilibrium

LOST_MOTION_SHARE = 0.03
LOAD_SHARES = (-1.0, -0.5, -0.2, -0.1, -LOST_MOTION_SHARE, LOST_MOTION_SHARE, 0.1, 0.2, 0.5, 1.0)


@dataclass(frozen=True, slots=True)
class Accuracy:
    """What the nominal drive does between no load and full load, over one mesh cycle.

    ``case`` at rated torque; ``crank_angle`` shape (poses,) [rad]; ``torque`` shape (loads,) [N·mm];
    ``rotation`` of the carrier with the input held, shape (loads, poses) [rad]; ``backlash`` with the
    crank held. ``converged`` is False where some pose has no equilibrium; its rotation is NaN.
    """

    case: LoadCase
    crank_angle: FloatArray
    torque: FloatArray
    rotation: FloatArray
    backlash: Backlash
    converged: bool

    @property
    def lost_motion(self) -> float:
        """Rotation between −3 % and +3 % of rated torque, largest over the mesh cycle [rad]."""
        return float(np.max(self._at(LOST_MOTION_SHARE) - self._at(-LOST_MOTION_SHARE)))

    @property
    def torsional_rigidity(self) -> float:
        """b/a between 50 % and 100 % of rated torque, mean over the mesh cycle [N·mm/rad]."""
        twist = float(np.mean(self._at(1.0) - self._at(0.5)))
        return 0.5 * abs(self.case.torque) / twist if twist else math.nan

    @property
    def transmission_error(self) -> float:
        """Peak to peak at rated torque over the mesh cycle [rad]."""
        return float(np.ptp(self._at(1.0)))

    def _at(self, share: float) -> FloatArray:
        row: FloatArray = self.rotation[LOAD_SHARES.index(share)]
        return row


def accuracy(case: LoadCase, poses: int = 48) -> Accuracy:
    """Load the drive from −100 % to +100 % of ``case.torque`` at ``poses`` poses of a mesh cycle.

    The peak-to-peak transmission error has kinks; on an RV-40E 48 poses miss 1.4 % of it, 24 poses 5.7 %.
    """
    crank_angle = mesh_cycle(case.drive.trochoid, poses)
    torque = np.array(LOAD_SHARES) * abs(case.torque)
    # All loads at all poses are one batch.
    solved = StageEquilibrium().at(case, np.tile(crank_angle, len(torque)), np.repeat(torque, poses))
    rotation = np.where(solved.settled, solved.rotation, np.nan).reshape(len(torque), poses)
    return Accuracy(case, crank_angle, torque, rotation, backlash(case.drive, case.profile, poses), solved.converged)
