"""Whether a reducer binds: its least backlash over a turn, beside the largest.

Scatter makes the largest backlash smaller, down to a reducer that does not turn. An upper limit alone is best kept by
such reducers; a lower limit of 0 for the least backlash refuses them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.clearance import Clearance
from cycloid_profile.tolerance.quantities import Answers
from cycloid_profile.units import ARCMIN


@dataclass(frozen=True)
class BacklashEnds:
    """Largest and least crank-locked backlash over a turn of the output; the least is negative where a disc binds.

    How far below zero says little: near root and tip no turn opens a gap.
    """

    clearance: Clearance
    names: tuple[str, ...] = ("backlash_arcmin", "least_backlash_arcmin")

    def of(self, x: FloatArray) -> FloatArray:
        """See ``quantities.Answers.of``."""
        turn = self.clearance.by_pose(x) / ARCMIN
        return np.stack([np.max(turn, axis=1), np.min(turn, axis=1)], axis=1)


@dataclass(frozen=True)
class Together:
    """Several ways to compute quantities as one."""

    parts: tuple[Answers, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Quantities of all parts, in their order."""
        return tuple(name for part in self.parts for name in part.names)

    def of(self, x: FloatArray) -> FloatArray:
        """See ``quantities.Answers.of``."""
        return np.concatenate([part.of(x) for part in self.parts], axis=1)
