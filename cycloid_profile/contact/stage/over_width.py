"""Slices over the face width in the stage: slopes of its discs, and what they add at each pin (Eqs. 115–118)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.contact.bodies import FaceWidth

if TYPE_CHECKING:
    from cycloid_profile.contact.stage._kernels import SlicedWidth


class PinTilt(NamedTuple):
    """What slices over the width add at each pin, shape (poses, discs, pins): ``slope`` of the tooth along the normal
    [rad], ``moment`` of the force about the mid-plane [N·mm], ``centre`` of its stiffness [mm] and ``spread``
    [N·mm/rad] about that (Eq. 118).
    """

    slope: FloatArray
    moment: FloatArray
    centre: FloatArray
    spread: FloatArray


@dataclass(frozen=True, eq=False, slots=True)
class WidthState:
    """Slices of an energy: the ``face`` width, the ``unknowns`` of the slopes, shape (discs, 2) or (0, 2) for discs
    that cannot tilt, the ``slope`` at the configuration, shape (poses, discs, 2) [rad], and the ``stiffness`` of all
    bearings of a disc against its tilt [N·mm/rad].
    """

    face: FaceWidth
    unknowns: IntArray
    slope: FloatArray
    stiffness: float

    def moved(self, step: FloatArray) -> FloatArray:
        """Slopes a step away, shape of ``slope``."""
        moved: FloatArray = self.slope + step[:, self.unknowns] if self.unknowns.size else self.slope
        return moved

    def arrays(self) -> SlicedWidth:
        """The slices in the form of the compiled search."""
        return sliced_width(self.face, self.unknowns, np.ascontiguousarray(self.slope), self.stiffness)


def sliced_width(face: FaceWidth | None, unknowns: IntArray, slope: FloatArray, stiffness: float) -> SlicedWidth:
    """The slices in the form of the compiled search; empty without a face width."""
    from cycloid_profile.contact.stage._kernels import SlicedWidth

    z, weight = (np.zeros(0), np.zeros(0)) if face is None else face.rule
    relief = np.zeros(0) if face is None else face.relief(z)
    tilt = np.ascontiguousarray(unknowns, dtype=np.intp)
    return SlicedWidth(z, weight, relief, tilt, slope, float(stiffness))


def no_slices(slope: FloatArray) -> SlicedWidth:
    """No slices, for line contacts; ``slope`` is empty, but has the dimensions of the others."""
    return sliced_width(None, np.zeros((0, 2), dtype=np.intp), slope, 0.0)
