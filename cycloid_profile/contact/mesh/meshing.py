"""Phase of each pin on each disc at a crank pose (docs/theory.md, Eqs. 19–20).

The housing and its pins are fixed. The phase ψ of a pin is counted from the root of the lobe that it meshes
with, and lies in [−π, π]: 0 at the root, ±π at the tip. The flank of positive ψ resists a disc turned
anticlockwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray, IntArray
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Trochoid

_REMEMBERED = 64  # blocks of poses, of a megabyte each
_OVER_POSES = ("crank_angle", "phase", "lobe", "pin_centre", "into_lobe")


@dataclass(frozen=True, eq=False, slots=True)
class Meshing:
    """Pins as seen by the discs, over poses × discs × pins.

    ``crank_angle`` shape (poses, discs) [rad]; the others have shape (poses, discs, pins): ``phase`` in
    [−π, π] [rad]; ``lobe``, whole numbers in [0, z_c), the lobe each pin meshes with; ``pin_centre`` in the
    frame of that lobe, disc in its nominal place [mm]; ``into_lobe`` the unit complex number that turns a
    housing vector into that frame.
    """

    trochoid: Trochoid
    crank_angle: FloatArray
    phase: FloatArray
    lobe: FloatArray
    pin_centre: ComplexArray
    into_lobe: ComplexArray

    @property
    def carrier_angle(self) -> FloatArray:
        """Angle of the carrier that goes with each crank angle, −φ/z_c, shape (poses,) [rad]."""
        angle: FloatArray = -self.crank_angle[:, 0] / self.trochoid.lobes
        return angle

    def poses(self, which: slice | IntArray) -> Meshing:
        """The meshing at some of the poses."""
        return replace(self, **{name: getattr(self, name)[which] for name in _OVER_POSES})

    @staticmethod
    def of_blocks(blocks: list[Meshing]) -> Meshing:
        """Blocks of poses as one."""
        joined: dict[str, Any] = {
            name: np.concatenate([getattr(block, name) for block in blocks]) for name in _OVER_POSES
        }
        return replace(blocks[0], **joined)

    def disc(self, j: int) -> Meshing:
        """The meshing of disc ``j`` alone, counted from 0."""
        return replace(self, **{name: getattr(self, name)[:, j : j + 1] for name in _OVER_POSES})

    def pin_in_lobe(
        self,
        displacement: ComplexArray | complex = 0.0,
        rotation: ArrayLike = 0.0,
        pin_shift: ComplexArray | complex = 0.0,
    ) -> ComplexArray:
        """Pin centres in the lobe frame of a displaced disc, shape of ``phase`` [mm] (Eq. 20).

        ``displacement`` of the disc centre in the housing frame [mm] and ``rotation`` of the disc [rad],
        each broadcastable to (poses, discs); ``pin_shift`` of the pins from their places in the housing
        frame, broadcastable to (pins,) [mm].
        """
        shift = np.asarray(displacement, dtype=np.complex128)
        turn = np.asarray(rotation, dtype=np.float64)
        moved = self.pin_centre + (pin_shift - shift[..., np.newaxis]) * self.into_lobe
        centre: ComplexArray = np.exp(-1j * turn)[..., np.newaxis] * moved
        return centre


def mesh(trochoid: Trochoid, crank_angle: ArrayLike, discs: int = 1) -> Meshing:
    """Meshing of ``discs`` evenly phased discs at the crank angles of disc 1, shape (poses,) [rad].

    Raises
    ------
    LoadError
        If a crank angle is not finite.
    """
    first = finite_angles(crank_angle)
    phi = first[:, np.newaxis] + 2.0 * math.pi * np.arange(discs) / discs
    pin = np.arange(trochoid.pins)
    pin_angle = 2.0 * math.pi * pin / trochoid.pins
    psi = pin_angle - phi[..., np.newaxis]
    turns = np.round(psi / (2.0 * math.pi))
    psi = psi - 2.0 * math.pi * turns
    # Counted along the disc, pin k meets phase α_k − φ − 2πk: the pins run against the lobes.
    lobe = np.mod(turns - pin, trochoid.lobes)
    slow = np.exp(-1j * psi / trochoid.lobes)
    into_lobe = slow * np.exp(-1j * pin_angle)
    path = trochoid.derivatives(psi)
    return Meshing(trochoid, phi, psi, lobe, path.centre, into_lobe)


def remembered_mesh(trochoid: Trochoid, crank_angle: FloatArray, discs: int) -> Meshing:
    """Cached ``mesh`` of a block of poses; the latest 64 blocks are kept."""
    return _remembered(trochoid, finite_angles(crank_angle).tobytes(), discs)


@lru_cache(maxsize=_REMEMBERED)
def _remembered(trochoid: Trochoid, crank_angle: bytes, discs: int) -> Meshing:
    return mesh(trochoid, np.frombuffer(crank_angle), discs)


def finite_angles(crank_angle: ArrayLike) -> FloatArray:
    """Crank angles, shape (poses,) [rad]; raises ``LoadError`` if one is not finite or there are none."""
    angles = np.atleast_1d(np.asarray(crank_angle, dtype=np.float64))
    if angles.ndim != 1 or angles.size == 0:
        raise LoadError("crank_angle", f"of shape {angles.shape}", "is no row of poses", "give one angle a pose")
    finite = np.isfinite(angles)
    if not np.all(finite):
        bad = int(np.argmin(finite))
        raise LoadError("crank_angle", f"{angles[bad]} rad at pose {bad + 1}", "is not finite", "give an angle in rad")
    return angles


def mesh_cycle(trochoid: Trochoid, poses: int) -> FloatArray:
    """Crank angles of one mesh cycle, a pin pitch 2π/z_p, evenly spaced, shape (poses,) [rad].

    The first is 0: a pin lies exactly in the root, and phases are multiples of one pitch.
    """
    pitch = 2.0 * math.pi / trochoid.pins
    angles: FloatArray = np.arange(poses, dtype=np.float64) * (pitch / poses)
    return angles


def output_turn(trochoid: Trochoid, poses: int) -> FloatArray:
    """Crank angles of one whole turn of the output, z_c turns of the crank, shape (poses,) [rad].

    They run so that the output turns forwards (anticlockwise). A turn holds z_c·z_p mesh cycles; the mesh
    frequency is resolved with more than 2 z_c z_p poses.
    """
    turn = 2.0 * math.pi * trochoid.lobes
    angles: FloatArray = -np.arange(poses, dtype=np.float64) * (turn / poses)
    return angles
