"""Smallest detectable size of an effect: linear (docs/theory.md, Eq. 54), and checked with the exact model.

Linear equations hold near zero. Under load clearances close and pins lose contact, so that the visible change can be a
tenth of the linear one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate, places
from cycloid_profile.diagnosis.model.detection import FALSE_ALARM
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened
from cycloid_profile.errors import CycloidError

SUFFICIENT_SHARE = 0.8  # of the required noncentrality
_ROUNDS, _LEAST, _MOST = 12, 1.1, 2.0  # iterations, and the range of the factor between two sizes
POWER = 0.8  # probability of detection, the usual choice in the design of experiments


def smallest_detectable(equations: NormalEquations, families: int) -> dict[str, tuple[float, str]]:
    """For each effect the size detected with 80 % probability, and the name of its parameter.

    Noncentral chi-square at the threshold of ``detect``; infinite where the files do not show the effect. Median over
    the locations of the effect; least favourable direction.
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
    """Coordinate of a candidate detected with ``power`` among ``looks`` tests, given its information ``R``."""
    k = candidate.coordinates
    information = float(np.linalg.eigvalsh(R[:k, :k])[0])
    if information < 1e-9:
        return math.inf
    return candidate.width * math.sqrt(noncentrality(k, looks, power) / information)


def noncentrality(k: int, looks: int, power: float = POWER) -> float:
    """Noncentrality of a chi-square of ``k`` degrees of freedom detected with ``power`` among ``looks`` tests."""
    from scipy.special import chdtri, chndtr

    limit = float(chdtri(k, FALSE_ALARM / looks))
    low, high = 0.0, 4.0 * (limit + 20.0)
    for _ in range(80):
        middle = 0.5 * (low + high)
        if 1.0 - float(chndtr(limit, k, middle)) < power:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def exact_size(
    residuals: Sequence[Residuals], candidate: Candidate, size: float, needed: float, enough: float = SUFFICIENT_SHARE
) -> float:
    """First size from ``size`` up that reaches the share ``enough`` of the ``needed`` noncentrality.

    In the unit of the coordinate; infinite beyond the plausible size. For an effect of either sign the larger of both
    sizes, if both are visible.
    """
    signs = (1.0,) if candidate.one_sided or candidate.angle is not None else (1.0, -1.0)
    sizes = [_size_in_direction(residuals, candidate, size, sign, needed, enough) for sign in signs]
    return max((one for one in sizes if one < math.inf), default=math.inf)


def _size_in_direction(
    residuals: Sequence[Residuals], candidate: Candidate, size: float, sign: float, needed: float, enough: float
) -> float:
    for _ in range(_ROUNDS):
        if size > candidate.implausible:
            break
        squares = noncentrality_of(residuals, candidate, sign * size)
        if squares >= enough * needed:
            return size
        size *= float(np.clip(math.sqrt(needed / max(squares, 1e-9)), _LEAST, _MOST))
    return math.inf


def noncentrality_of(residuals: Sequence[Residuals], candidate: Candidate, size: float) -> float:
    """Noncentrality of an effect of ``size``, nuisances marginalised; infinite where the reducer has no equilibrium."""
    effect = candidate.effect([size, 0.0])
    assert effect is not None
    total = 0.0
    try:
        for before in residuals:
            after = Residuals(before.recording, effect.apply(before.reducer), before.flank_grid)
            block = Whitened(before)
            z = block.white(np.nan_to_num(after.residual - before.residual))
            total += float(block.product(z, z))
    except CycloidError:
        return math.inf
    return total
