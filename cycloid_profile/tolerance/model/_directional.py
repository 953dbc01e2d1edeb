"""Directional derivatives of sums, maxima and minima, kinks included (docs/tolerance.md, Eq. 60).

Where one pin, pose or disc alone decides, a maximum has the derivative of that one (Danskin, SIAM J. Appl. Math. 14
(1966) 641). Where several tie it has a kink: along each direction it has the derivative of the one that becomes the
extreme.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray

ALL = slice(None)


class DirectionalDerivative(Protocol):
    """Derivative of one number by many coordinates."""

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """One-sided derivatives along the columns of ``directions``, shape (k, m) to (m,), k the coordinates ``at``."""
        ...


@dataclass(frozen=True, eq=False)
class Gradient:
    """Derivative of a smooth number: its ``gradient``, shape (coordinates,)."""

    gradient: FloatArray

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        return np.asarray(self.gradient[at] @ directions)


@dataclass(frozen=True)
class Combined:
    """``factor`` times the sum, maximum or minimum of several derivatives by the numpy function ``combine``."""

    combine: Callable[..., Any]
    of: tuple[DirectionalDerivative, ...]
    factor: float = 1.0

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        return np.asarray(self.factor * self.combine([one.along(directions, at) for one in self.of], axis=0))


def weighted_sum(of: Sequence[DirectionalDerivative], factor: float = 1.0) -> Combined:
    """Derivative of ``factor`` times a sum."""
    return Combined(np.sum, tuple(of), factor)


def largest(values: FloatArray, derivatives: Sequence[DirectionalDerivative], tie: float) -> Combined:
    """Derivative of the maximum of ``values``, each with its own; those within ``tie`` of it count as equal."""
    return Combined(np.max, tuple(derivatives[int(i)] for i in np.flatnonzero(values >= np.max(values) - tie)))


def least(values: FloatArray, derivatives: Sequence[DirectionalDerivative], tie: float) -> Combined:
    """Derivative of the minimum of ``values``, as ``largest``."""
    return Combined(np.min, tuple(derivatives[int(i)] for i in np.flatnonzero(values <= np.min(values) + tie)))
