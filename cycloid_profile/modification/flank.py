"""Removal in the shape of a rotation, the same on both flanks: h = A |sinψ| S (docs/theory.md, Eq. 15)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.removal import RemovalJet
from cycloid_profile.geometry.trochoid import Trochoid


@dataclass(frozen=True, slots=True)
class FlankRemoval:
    """h(ψ) = amount·|sinψ|·S: the whole ``amount`` [mm] at ψ0, nothing at root and tip."""

    amount: float
    whole_disc: ClassVar[bool] = False
    spacing: ClassVar[None] = None

    @property
    def corners(self) -> tuple[float, ...]:
        """Root and tip, where |sinψ| turns."""
        return (0.0, math.pi) if self.amount else ()

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """Removal and derivatives on the flank ``side``, in the shape of ``phase``."""
        K1, A = trochoid.short_width_ratio, self.amount
        sin, cos = np.sin(phase), np.cos(phase)
        S = 1.0 / trochoid.speed_ratio(phase)
        slope = (cos - K1) * (1.0 - K1 * cos)
        return RemovalJet(
            value=A * side * sin * S,
            first=A * side * S**3 * slope,
            second=-A * side * sin * S * (1.0 + 3.0 * K1 * S**4 * slope),
        )
