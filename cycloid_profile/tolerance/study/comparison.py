"""Two designs with the same errors, reducer by reducer: ratio of their scatters."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray

_GROUPS = 50  # of the jackknife
_EQUIVALENCE_MARGIN = 0.01  # a 1 % wider scatter cannot be detected in production


@dataclass(frozen=True, slots=True)
class Comparison:
    """One ``quantity`` of two designs: ``mean`` and standard ``deviation`` of each, and the ``ratio`` of the second's
    deviation to the first's with its standard ``error``.
    """

    quantity: str
    mean: tuple[float, float]
    deviation: tuple[float, float]
    ratio: float
    error: float

    @property
    def verdict(self) -> str:
        """Verdict of the ratio: "less", "more" or "as" sensitive, "as" if the ratio is within two standard errors, or
        0.01, of 1."""
        if not abs(self.ratio - 1.0) > max(2.0 * self.error, _EQUIVALENCE_MARGIN):
            return "as"
        return "less" if self.ratio < 1.0 else "more"


def compare_designs(names: Sequence[str], first: FloatArray, second: FloatArray) -> tuple[Comparison, ...]:
    """Quantities ``names`` of two designs with the same errors, row by row, shape (reducers, quantities) both."""
    return tuple(_compared(name, first[:, j], second[:, j]) for j, name in enumerate(names))


def _compared(name: str, a: FloatArray, b: FloatArray) -> Comparison:
    whole = np.isfinite(a) & np.isfinite(b)
    a, b = a[whole], b[whole]
    ratio = _ratio(a, b)
    # Left out group by group: the errors are the same on both sides, and so the ratio is known better than either.
    group = np.arange(a.size) % _GROUPS
    left = np.array([_ratio(a[group != g], b[group != g]) for g in range(_GROUPS)])
    error = math.sqrt((_GROUPS - 1) / _GROUPS * float(np.sum((left - np.mean(left)) ** 2)))
    deviation = (float(np.std(a, ddof=1)), float(np.std(b, ddof=1)))
    return Comparison(name, (float(np.mean(a)), float(np.mean(b))), deviation, ratio, error)


def _ratio(a: FloatArray, b: FloatArray) -> float:
    below = float(np.std(a, ddof=1))
    return float(np.std(b, ddof=1)) / below if below > 0.0 else math.nan
