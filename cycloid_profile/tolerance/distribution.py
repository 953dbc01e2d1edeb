"""How one size scatters from reducer to reducer: from a standard normal number to a size.

Every size is drawn by way of a standard normal number z, its rank u = Φ(z), so that correlation, batches and
low-discrepancy sequences act on all distributions alike.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray

# Share of a normal distribution within ±3 σ: what a limit means at Cp = 1.
_WITHIN_LIMITS = 0.9973002039367398
_LEAST_TAIL = 1e-300


class Distribution(Protocol):
    """Distribution of one size, in the unit of the size."""

    def of(self, z: FloatArray) -> FloatArray:
        """Sizes with the ranks of the standard normal numbers ``z``, in their shape; increasing."""
        ...

    def scaled(self, factor: float) -> Distribution:
        """The same with its width times ``factor``, its mean left where it is."""
        ...

    @property
    def standard_deviation(self) -> float:
        """Standard deviation."""
        ...


@dataclass(frozen=True, slots=True)
class Normal:
    """Normal with ``mean`` and ``sigma``; cut off ``limit`` from the mean on either side where it is inspected."""

    mean: float
    sigma: float
    limit: float = math.inf

    def of(self, z: FloatArray) -> FloatArray:
        """See ``Distribution.of``."""
        if math.isinf(self.limit) or self.sigma == 0.0:
            return self.mean + self.sigma * z
        from scipy.special import ndtr, ndtri

        low = ndtr(-self.limit / self.sigma)
        # The lower half by itself: near rank 1 the digits of a rank run out.
        lower = low + (1.0 - 2.0 * low) * ndtr(-np.abs(z))
        return np.asarray(self.mean + self.sigma * np.sign(z) * -ndtri(np.maximum(lower, _LEAST_TAIL)))

    def scaled(self, factor: float) -> Normal:
        """See ``Distribution.scaled``; the limits of inspection move with the width."""
        return Normal(self.mean, self.sigma * factor, self.limit * factor)

    @property
    def standard_deviation(self) -> float:
        """See ``Distribution``."""
        if math.isinf(self.limit) or self.sigma == 0.0:
            return self.sigma
        from scipy.stats import truncnorm

        c = self.limit / self.sigma
        return float(self.sigma * truncnorm.std(-c, c))


@dataclass(frozen=True, slots=True)
class Uniform:
    """Evenly from ``mean`` − ``half_width`` to ``mean`` + ``half_width``."""

    mean: float
    half_width: float

    def of(self, z: FloatArray) -> FloatArray:
        """See ``Distribution.of``."""
        from scipy.special import ndtr

        return np.asarray(self.mean + self.half_width * (2.0 * ndtr(z) - 1.0))

    def scaled(self, factor: float) -> Uniform:
        """See ``Distribution.scaled``."""
        return Uniform(self.mean, self.half_width * factor)

    @property
    def standard_deviation(self) -> float:
        """See ``Distribution``."""
        return self.half_width / math.sqrt(3.0)


@dataclass(frozen=True, slots=True)
class Triangular:
    """Likeliest at ``mean``, never further from it than ``half_width``."""

    mean: float
    half_width: float

    def of(self, z: FloatArray) -> FloatArray:
        """See ``Distribution.of``."""
        from scipy.special import ndtr

        off = 1.0 - np.sqrt(2.0 * ndtr(-np.abs(z)))
        return np.asarray(self.mean + self.half_width * np.sign(z) * off)

    def scaled(self, factor: float) -> Triangular:
        """See ``Distribution.scaled``."""
        return Triangular(self.mean, self.half_width * factor)

    @property
    def standard_deviation(self) -> float:
        """See ``Distribution``."""
        return self.half_width / math.sqrt(6.0)


@dataclass(frozen=True, slots=True)
class Rayleigh:
    """Length of a vector with two normal components of ``sigma``: an offset in any direction; cut off at ``limit``."""

    sigma: float
    limit: float = math.inf

    def of(self, z: FloatArray) -> FloatArray:
        """See ``Distribution.of``."""
        from scipy.special import ndtr

        if self.sigma == 0.0:
            return np.zeros_like(z)
        beyond = math.exp(-0.5 * (self.limit / self.sigma) ** 2)
        tail = beyond + (1.0 - beyond) * ndtr(-z)
        return np.asarray(self.sigma * np.sqrt(-2.0 * np.log(np.maximum(tail, _LEAST_TAIL))))

    def scaled(self, factor: float) -> Rayleigh:
        """See ``Distribution.scaled``."""
        return Rayleigh(self.sigma * factor, self.limit * factor)

    @property
    def standard_deviation(self) -> float:
        """See ``Distribution``; of the length, untruncated."""
        return self.sigma * math.sqrt(2.0 - 0.5 * math.pi)


def rayleigh_within(limit: float, cp: float, inspected: bool) -> Rayleigh:
    """As many lengths beyond ``limit``/Cp as a normal distribution has beyond its limits at Cp = 1."""
    sigma = limit / (cp * math.sqrt(-2.0 * math.log(1.0 - _WITHIN_LIMITS)))
    return Rayleigh(sigma, limit if inspected else math.inf)
