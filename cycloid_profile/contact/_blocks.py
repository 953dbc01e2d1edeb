"""Solution of many poses in blocks, which fit the cache and bound the memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.mesh import finite_angles
from cycloid_profile.errors import LoadError
from cycloid_profile.units import NEWTON_METRE

Result = TypeVar("Result")
BLOCK = 256  # poses; the arrays of one block and its temporaries fit a second-level cache
_MATRICES = 2.56e8  # bytes of the compliances of a block: up to 170 pins on two discs leave it whole


def over_blocks(solve: Callable[[slice], Result], poses: int, size: int = BLOCK) -> Iterator[Result]:
    """Results of ``solve`` for consecutive blocks of at most ``size`` poses.

    The blocks are of nearly equal size because a small block takes as long as a full one. The answer of a pose must
    not depend on its block, except for rounding. One thread solves all blocks: numpy's calls on arrays of this size
    are so short that several threads would wait for each other.
    """
    count = max(-(-poses // size), 1)
    return (solve(slice(poses * i // count, poses * (i + 1) // count)) for i in range(count))


def poses_per_block(forces: int, size: int = BLOCK) -> int:
    """Poses of a block whose compliances, ``forces`` by ``forces`` each, fit the memory set aside for them."""
    return max(1, min(size, int(_MATRICES / (8.0 * max(forces, 1) ** 2))))


def poses_and_torques(crank_angle: ArrayLike, torque: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Crank angles and torques, one of each for every pose; raises ``LoadError`` on a non-finite value or zero load."""
    phi = finite_angles(crank_angle)
    T = np.atleast_1d(np.asarray(torque, dtype=np.float64))
    bad = ~np.isfinite(T) | (T == 0.0)
    if np.any(bad):
        raise LoadError(
            "torque",
            f"{T[bad][0] / NEWTON_METRE:g} N·m",
            "is zero or not finite",
            "give a load; the unloaded drive is what backlash is for",
        )
    if T.ndim != 1 or not (T.size == phi.size or 1 in (T.size, phi.size)):
        raise LoadError(
            "torque", f"of shape {T.shape}", f"does not go with {phi.size} crank angles", "give one, or one a pose"
        )
    phi, T = np.broadcast_arrays(phi, T)
    return phi, T
