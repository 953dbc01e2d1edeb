"""Removal in the shape of a rotation, the same on both flanks: h = A |sinψ| S (docs/theory.md, Eq. 15)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

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
        value, first, second = trochoid.lever_jet(phase)
        A = self.amount * side
        return RemovalJet(A * value, A * first, A * second)
