"""How one size scatters from reducer to reducer: from a standard normal number to a size.

Every size is computed from a standard normal number z with the rank u = Φ(z). Correlation, batches and low-discrepancy
sequences therefore apply to all distributions in the same manner.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from cycloid_profile.arrays import FloatArray

# Share of a normal distribution within ±3 σ: the definition of a limit at Cp = 1.
_WITHIN_LIMITS = 0.9973002039367398
_LEAST_TAIL = 1e-300


@dataclass(frozen=True, slots=True)
class Distribution:
    """Distribution of one size, in the unit of the size; every field but ``mean`` is a width."""

    def from_normal(self, z: FloatArray) -> FloatArray:
        """Sizes with the same quantiles as the standard normal numbers ``z``, in their shape; increasing."""
        raise NotImplementedError

    def scaled(self, factor: float) -> Self:
        """The same with its widths, limits of inspection included, times ``factor``; the mean is kept."""
        return replace(self, **{f.name: getattr(self, f.name) * factor for f in fields(self) if f.name != "mean"})

    @property
    def standard_deviation(self) -> float:
        """Standard deviation."""
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Normal(Distribution):
    """Normal with ``mean`` and ``sigma``; cut off ``limit`` from the mean on either side where it is inspected."""

    mean: float
    sigma: float
    limit: float = math.inf

    def from_normal(self, z: FloatArray) -> FloatArray:
        if math.isinf(self.limit) or self.sigma == 0.0:
            return self.mean + self.sigma * z
        from scipy.special import ndtr, ndtri

        low = ndtr(-self.limit / self.sigma)
        # The lower half alone: avoids cancellation near probability 1.
        lower = low + (1.0 - 2.0 * low) * ndtr(-np.abs(z))
        return np.asarray(self.mean + self.sigma * np.sign(z) * -ndtri(np.maximum(lower, _LEAST_TAIL)))

    @property
    def standard_deviation(self) -> float:
        if math.isinf(self.limit) or self.sigma == 0.0:
            return self.sigma
        from scipy.stats import truncnorm

        c = self.limit / self.sigma
        return float(self.sigma * truncnorm.std(-c, c))


@dataclass(frozen=True, slots=True)
class Uniform(Distribution):
    """Uniform between ``mean`` − ``half_width`` and ``mean`` + ``half_width``."""

    mean: float
    half_width: float

    def from_normal(self, z: FloatArray) -> FloatArray:
        from scipy.special import ndtr

        return np.asarray(self.mean + self.half_width * (2.0 * ndtr(z) - 1.0))

    @property
    def standard_deviation(self) -> float:
        return self.half_width / math.sqrt(3.0)


@dataclass(frozen=True, slots=True)
class Triangular(Distribution):
    """Likeliest at ``mean``, never further from it than ``half_width``."""

    mean: float
    half_width: float

    def from_normal(self, z: FloatArray) -> FloatArray:
        from scipy.special import ndtr

        off = 1.0 - np.sqrt(2.0 * ndtr(-np.abs(z)))
        return np.asarray(self.mean + self.half_width * np.sign(z) * off)

    @property
    def standard_deviation(self) -> float:
        return self.half_width / math.sqrt(6.0)


@dataclass(frozen=True, slots=True)
class Rayleigh(Distribution):
    """Length of a vector with two normal components of ``sigma``: an offset in any direction; cut off at ``limit``."""

    sigma: float
    limit: float = math.inf

    def from_normal(self, z: FloatArray) -> FloatArray:
        from scipy.special import ndtr

        if self.sigma == 0.0:
            return np.zeros_like(z)
        beyond = math.exp(-0.5 * (self.limit / self.sigma) ** 2)
        tail = beyond + (1.0 - beyond) * ndtr(-z)
        return np.asarray(self.sigma * np.sqrt(-2.0 * np.log(np.maximum(tail, _LEAST_TAIL))))

    @property
    def standard_deviation(self) -> float:
        return self.sigma * math.sqrt(2.0 - 0.5 * math.pi)


def rayleigh_within(limit: float, cp: float, inspected: bool) -> Rayleigh:
    """Rayleigh distribution with the same share beyond ``limit``/Cp as a normal distribution beyond ±3 σ."""
    sigma = limit / (cp * math.sqrt(-2.0 * math.log(1.0 - _WITHIN_LIMITS)))
    return Rayleigh(sigma, limit if inspected else math.inf)
