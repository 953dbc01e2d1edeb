"""How parts that are free follow a load: small symmetric systems, one a pose, of which some may hold nothing at all."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray

# Determinant of a stiffness matrix over the product of its diagonal, 1 without coupling: a disc afloat has rounding.
_HELD = 1e-10


def following(stiffness: FloatArray, load: FloatArray, rcond: float) -> FloatArray:
    """The motion x with K x = ``load``, the least one where a part is afloat, shape (poses, n, loads).

    ``stiffness`` K shape (poses, n, n), symmetric; ``load`` shape (poses, n, loads); ``rcond`` as of ``pinv``.
    """
    diagonal = np.prod(np.diagonal(stiffness, axis1=1, axis2=2), axis=1)
    held = np.linalg.det(stiffness) > _HELD * diagonal
    motion = np.empty_like(load)
    motion[held] = np.linalg.solve(stiffness[held], load[held])
    if not np.all(held):
        motion[~held] = np.linalg.pinv(stiffness[~held], hermitian=True, rcond=rcond) @ load[~held]
    return motion
