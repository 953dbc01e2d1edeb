"""How likely noise alone is to show as much."""

from __future__ import annotations

import math

from scipy.special import erfc


def tail(score: float) -> float:
    """Upper tail of the standard normal distribution."""
    return 0.5 * float(erfc(score / math.sqrt(2.0)))


def several(p: float, looks: int) -> float:
    """Chance that the least of so many looks is as small."""
    return float(-math.expm1(looks * math.log1p(-min(p, 1.0 - 1e-16))))
