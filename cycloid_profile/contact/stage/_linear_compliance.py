"""Motions of free parts under a load: small systems of equations, one a pose, some of them singular."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray

# Determinant of a stiffness matrix over the product of its diagonal, 1 without coupling; of a free disc it is rounding.
_REGULAR = 1e-10


def solve_linear_compliance(
    stiffness: FloatArray, load: FloatArray, rcond: float, symmetric: bool = True
) -> FloatArray:
    """The motion x with K x = ``load``, shape (poses, n, loads); the least one where a part is unloaded.

    ``stiffness`` K shape (poses, n, n); ``load`` shape (poses, n, loads); ``rcond`` as of ``numpy.linalg.pinv``.
    """
    diagonal = np.prod(np.diagonal(stiffness, axis1=1, axis2=2), axis=1)
    regular = np.linalg.det(stiffness) > _REGULAR * diagonal
    motion = np.empty_like(load)
    motion[regular] = np.linalg.solve(stiffness[regular], load[regular])
    if not np.all(regular):
        inverse = np.linalg.pinv(stiffness[~regular], hermitian=symmetric, rcond=rcond)
        motion[~regular] = inverse @ load[~regular]
    return motion
