"""Where each pin stands on each disc at a crank pose (docs/theory.md, Eqs. 19–20).

The housing and its pins stand still. Every pin is looked at from the lobe it works with, so that its
phase ψ lies in [−π, π]: 0 with the pin in the root, ±π on the tip. Positive ψ is the flank that
resists a disc turned anticlockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.geometry.trochoid import Trochoid


@dataclass(frozen=True, slots=True)
class Meshing:
    """Pins as seen by the discs, over poses × discs × pins.

    ``crank_angle`` shape (poses, discs) [rad]; ``phase`` shape (poses, discs, pins), in [−π, π] [rad];
    ``into_lobe`` the unit complex number that turns a housing vector into the pin's lobe frame.
    """

    trochoid: Trochoid
    crank_angle: FloatArray
    phase: FloatArray
    into_lobe: ComplexArray

    def pin_in_lobe(self, displacement: ComplexArray | complex = 0.0, rotation: ArrayLike = 0.0) -> ComplexArray:
        """Pin centres in the lobe frame of a displaced disc, shape of ``phase`` [mm] (Eq. 20).

        ``displacement`` of the disc centre in the housing frame [mm] and ``rotation`` of the disc [rad],
        each broadcastable to (poses, discs).
        """
        shift = np.asarray(displacement, dtype=np.complex128)
        turn = np.asarray(rotation, dtype=np.float64)
        moved = self.trochoid.pin_centre(self.phase) - shift[..., np.newaxis] * self.into_lobe
        centre: ComplexArray = np.exp(-1j * turn)[..., np.newaxis] * moved
        return centre


def mesh(trochoid: Trochoid, crank_angle: ArrayLike, discs: int = 1) -> Meshing:
    """Meshing of ``discs`` evenly phased discs at the crank angles of disc 1, shape (poses,) [rad]."""
    first = np.atleast_1d(np.asarray(crank_angle, dtype=np.float64))
    phi = first[:, np.newaxis] + 2.0 * math.pi * np.arange(discs) / discs
    pin_angle = 2.0 * math.pi * np.arange(trochoid.pins) / trochoid.pins
    psi = pin_angle - phi[..., np.newaxis]
    psi = psi - 2.0 * math.pi * np.round(psi / (2.0 * math.pi))
    into_lobe = np.exp(1j * (-psi / trochoid.lobes - pin_angle))
    return Meshing(trochoid, phi, psi, into_lobe)


def mesh_cycle(trochoid: Trochoid, poses: int) -> FloatArray:
    """Crank angles of one mesh cycle, a pin pitch 2π/z_p, evenly spaced, shape (poses,) [rad].

    The first is 0: a pin stands exactly in the root, and phases are multiples of one pitch.
    """
    pitch = 2.0 * math.pi / trochoid.pins
    angles: FloatArray = np.arange(poses, dtype=np.float64) * (pitch / poses)
    return angles
