"""Motions of free parts under a load: small systems of equations, one a pose, some of them singular."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray

# Determinant of a stiffness matrix over the product of its diagonal, 1 without coupling; of a free disc it is rounding.
_REGULAR = 1e-10


def solve_linear_compliance(
    stiffness: FloatArray, load: FloatArray, rcond: float, symmetric: bool = True
) -> FloatArray:
    """The motion x with K x = ``load``, shape (poses, n, loads); the least one where a part is unloaded, NaN without an
    equilibrium.

    ``stiffness`` K shape (poses, n, n); ``load`` shape (poses, n, loads); ``rcond`` as of ``numpy.linalg.pinv``.
    """
    known = np.all(np.isfinite(stiffness), axis=(1, 2))
    diagonal = np.prod(np.diagonal(stiffness, axis1=1, axis2=2), axis=1)
    regular = known.copy()
    regular[known] = np.linalg.det(stiffness[known]) > _REGULAR * diagonal[known]
    motion = np.full_like(load, np.nan)
    motion[regular] = np.linalg.solve(stiffness[regular], load[regular])
    singular = known & ~regular
    if np.any(singular):
        inverse = np.linalg.pinv(stiffness[singular], hermitian=symmetric, rcond=rcond)
        motion[singular] = inverse @ load[singular]
    return motion
