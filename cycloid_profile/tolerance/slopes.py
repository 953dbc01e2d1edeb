"""Directional derivatives of sums, maxima and minima, kinks included (docs/tolerance.md, Eq. 60).

Where one pin, pose or disc alone decides, a maximum has the derivative of that one (Danskin, SIAM J. Appl. Math. 14
(1966) 641). Where several tie it has a kink: a derivative along each direction, that of whichever takes over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray

ALL = slice(None)


class Slope(Protocol):
    """Derivative of one number by many coordinates."""

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """One-sided derivatives along the columns of ``directions``, shape (k, m) to (m,), k the coordinates ``at``."""
        ...


@dataclass(frozen=True, eq=False)
class Smooth:
    """A plain ``gradient``, shape (coordinates,)."""

    gradient: FloatArray

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """See ``Slope.along``."""
        found: FloatArray = self.gradient[at] @ directions
        return found


@dataclass(frozen=True)
class Weighted:
    """``factor`` times the sum ``of`` others."""

    of: tuple[Slope, ...]
    factor: float = 1.0

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """See ``Slope.along``."""
        found: FloatArray = self.factor * np.sum([one.along(directions, at) for one in self.of], axis=0)
        return found


@dataclass(frozen=True)
class Largest:
    """The largest ``of`` some that are equal here."""

    of: tuple[Slope, ...]

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """See ``Slope.along``."""
        found: FloatArray = np.max([one.along(directions, at) for one in self.of], axis=0)
        return found


@dataclass(frozen=True)
class Least:
    """The least ``of`` some that are equal here."""

    of: tuple[Slope, ...]

    def along(self, directions: FloatArray, at: slice = ALL) -> FloatArray:
        """See ``Slope.along``."""
        found: FloatArray = np.min([one.along(directions, at) for one in self.of], axis=0)
        return found


def largest(values: FloatArray, slopes: Sequence[Slope], tie: float) -> Slope:
    """Slope of the maximum of ``values``, each with its own slope; those within ``tie`` of it are equal."""
    return Largest(tuple(slopes[int(i)] for i in np.flatnonzero(values >= np.max(values) - tie)))


def least(values: FloatArray, slopes: Sequence[Slope], tie: float) -> Slope:
    """Slope of the minimum of ``values``, as ``largest``."""
    return Least(tuple(slopes[int(i)] for i in np.flatnonzero(values <= np.min(values) + tie)))
