"""The smallest size of an effect that would be detected (docs/theory.md, Eq. 54)."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import chdtri, chndtr

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, places
from cycloid_profile.discrepancy.detection import FALSE_ALARM
from cycloid_profile.discrepancy.normal import Normal

POWER = 0.8


def smallest_detectable(equations: Normal, families: int) -> dict[str, tuple[float, str]]:
    """For each effect the size that is found with 80 % probability, and the name of its parameter.

    Noncentral chi-square at the very threshold that ``detect`` uses; infinite where the files do not show the effect.
    Of an effect at many places the middle one is taken, of one with a direction the worst.
    """
    found: dict[str, list[float]] = {}
    size_of: dict[str, str] = {}
    count = places(equations.candidates)
    for i, candidate in enumerate(equations.candidates):
        size_of[candidate.name] = candidate.size
        found.setdefault(candidate.name, []).append(
            detectable(candidate, equations.R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2], families * count[candidate.name])
        )
    return {name: (float(np.median(sizes)), size_of[name]) for name, sizes in found.items()}


def detectable(candidate: Candidate, R: FloatArray, looks: int, power: float = POWER) -> float:
    """Coordinate of a candidate that is found with ``power`` among so many looks, given its information ``R``."""
    k = candidate.coordinates
    information = float(np.linalg.eigvalsh(R[:k, :k])[0])
    if information < 1e-9:
        return math.inf
    return candidate.width * math.sqrt(noncentrality(k, looks, power) / information)


def noncentrality(k: int, looks: int, power: float = POWER) -> float:
    """Noncentrality of a chi-square of ``k`` coordinates that is found with ``power`` among so many looks."""
    limit = float(chdtri(k, FALSE_ALARM / looks))
    low, high = 0.0, 4.0 * (limit + 20.0)
    for _ in range(80):
        middle = 0.5 * (low + high)
        if 1.0 - float(chndtr(limit, k, middle)) < power:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
