"""A plug-in: the form that a disc clamped in its bore by three jaws keeps after grinding."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

import cycloid_profile as cp
from cycloid_profile.units import DEGREE, UM

JAWS = 3


@dataclass(frozen=True)
class JawRemoval:
    """h = A cos 3(θ − φ): ``amount`` A [mm], ``angle`` φ [rad]; the polar angle is θ = −ψ/z_c."""

    amount: float
    angle: float
    whole_disc: ClassVar[bool] = True  # it differs from lobe to lobe
    corners: ClassVar[tuple[float, ...]] = ()  # it is smooth
    point_spacing: ClassVar[float | None] = None  # it is a formula

    def derivatives(self, phase: np.ndarray, side: np.ndarray, trochoid: cp.Trochoid) -> cp.geometry.RemovalDerivatives:
        """Removal and its two derivatives by the phase, in the shape of ``phase``; equal on both flanks."""
        del side
        rate = JAWS / trochoid.lobes
        turned = rate * phase + JAWS * self.angle
        cos, sin = self.amount * np.cos(turned), self.amount * np.sin(turned)
        return cp.geometry.RemovalDerivatives(cos, -rate * sin, -rate * rate * cos)


@cp.effects.register
@dataclass(frozen=True)
class ThreeJawClamping(cp.effects.Effect):
    """Three jaws in the bore press the rim outwards while it is ground; released, the disc is low at the jaws."""

    location = cp.effects.EffectLocation.FLANK
    remedy = "clamp on the face, or on a mandrel that expands all round"
    harmonic = JAWS  # the angle repeats after a third of a turn
    phase_per_lobe_index = -float(JAWS)  # polar angles run against the lobes
    amplitude_um: float = cp.effects.size_field("amplitude [µm]", 2.0, 0.0, 200.0)
    phase_deg: float = cp.effects.angle_field("polar angle of a jaw [°]")
    disc: int | None = cp.effects.part_field(cp.effects.DISC_PART)

    def apply(self, reducer: cp.effects.AsBuiltReducer) -> cp.effects.AsBuiltReducer:
        """The reducer with the form on one disc, or on all in the frame of the carrier."""
        for j in cp.effects.part_indices(self, "disc", self.disc, reducer.discs):
            tooth = reducer.teeth[j]
            # Disc j is mounted at −2πj/(N z_c) to the first: one jaw has another angle in its frame.
            turned = 0.0 if self.disc is not None else 2.0 * math.pi * j / (reducer.discs * tooth.trochoid.lobes)
            removal = JawRemoval(self.amplitude_um * UM, self.phase_deg * DEGREE + turned)
            reducer = reducer.with_tooth(j, replace(tooth, removals=(*tooth.removals, removal)))
        return reducer
