"""What the profile needs to know of a normal removal: its value and two derivatives, and its corners.

Positive removes material. A removal that mirrors about the tooth's axis may have a corner at root and
tip; ``side`` then chooses the smooth branch: +1 for the flank 0 < ψ < π, −1 for −π < ψ < 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.geometry.trochoid import Trochoid


class RemovalJet(NamedTuple):
    """Normal removal h [mm] with its first and second derivative by phase [mm/rad, mm/rad²]."""

    value: FloatArray
    first: FloatArray
    second: FloatArray


class NormalRemoval(Protocol):
    """A removal h(ψ) along the outward normal of the trochoid."""

    @property
    def whole_disc(self) -> bool:
        """Whether it repeats once a turn of the disc, 2π z_c, instead of on every lobe, 2π."""
        ...

    @property
    def spacing(self) -> float | None:
        """Phase between the points of a measured curve, which bounds its shortest wave; None for a formula [rad]."""
        ...

    @property
    def corners(self) -> tuple[float, ...]:
        """Phases in [0, 2π) where h has a corner [rad]."""
        ...

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """Removal and derivatives on the flank ``side`` (±1), in the shape of ``phase``."""
        ...


def flank_side(phase: ArrayLike) -> FloatArray:
    """Flank of each phase: +1 for ψ in [0, π) modulo 2π, −1 for ψ in [π, 2π)."""
    half_turns = np.floor(np.asarray(phase, dtype=np.float64) / math.pi)
    side: FloatArray = np.where(half_turns % 2 == 0, 1.0, -1.0)
    return side
