"""One disc at first touch at many poses, and the plain loop that finds what its pins carry."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

import cycloid_profile as cp
from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.mesh import first_touch


class TouchedDisc:
    """Gaps, levers and contacts of disc 1 where it first touches, over an output turn: what both sides are given."""

    def __init__(self, case: cp.LoadCase, poses: int) -> None:
        self.law = case.law
        self.crank_angle = cp.output_turn(case.drive.trochoid, poses)
        touch = first_touch(case.profile, case.drive.pin_radius, cp.mesh(case.drive.trochoid, self.crank_angle), +1.0)
        self.gap = np.maximum(touch.gaps.gap[:, 0], 0.0)
        self.lever = np.ascontiguousarray(touch.gaps.lever[:, 0])
        self.curvature = touch.gaps.curvature[:, 0]
        self.line_contact = case.line_contact
        self.contact = case.line_contact(self.curvature)
        self.torque = np.full(poses, case.torque / case.drive.discs)

    def looped(self, poses: range) -> FloatArray:
        """Rotation beyond touch, a pose at a time; the law is called once for all pins of the pose."""
        return np.array([self._root(i) for i in poses])

    def _root(self, pose: int) -> float:
        gap, lever, torque = self.gap[pose], self.lever[pose], float(self.torque[pose])
        contact = self.line_contact(self.curvature[pose])
        longest = int(np.argmax(lever))

        def excess(beta: float) -> float:
            return float(np.sum(self.law.force(beta * lever - gap, contact) * lever)) - torque

        # With the pin of the longest lever carrying all alone the disc turns further than with all together.
        alone = self.law.approach(torque / lever[longest], self.line_contact(self.curvature[pose, longest]))
        beta: float = brentq(excess, 0.0, (gap[longest] + float(alone)) / lever[longest], xtol=1e-16, rtol=1e-12)
        return beta
