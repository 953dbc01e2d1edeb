"""Measuring noise: coloured along the rows, drifting, with outliers, rounded, of two distributions."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

Array = np.ndarray
_WARM = 200


@dataclass(frozen=True)
class Noise:
    """``sigma`` in the unit of the column; a share of ``outliers`` of ``outlier_size`` sigmas.

    ``rho`` and ``rho2``: x_i = ρ x_{i−1} + ρ2 x_{i−2} + e_i. ``drift``: a slow wander over the file, its root mean
    square in sigmas. ``quantum``: step to which readings are rounded, in sigmas; 0 for none. ``kind`` is "normal" or
    "t5", Student's t with 5 degrees of freedom scaled to the same sigma. ``declare`` writes sigma into the file.
    """

    sigma: float = 0.0
    rho: float = 0.0
    outliers: float = 0.0
    outlier_size: float = 10.0
    kind: str = "normal"
    declare: bool = False
    rho2: float = 0.0
    drift: float = 0.0
    quantum: float = 0.0

    def draw(self, rows: int, draw: np.random.Generator) -> Array:
        """One column of noise, its standard deviation ``sigma`` apart from outliers and drift."""
        if self.sigma == 0.0:
            return np.zeros(rows)
        if self.kind == "normal":
            white = draw.normal(size=rows + _WARM)
        elif self.kind == "t5":
            white = draw.standard_t(5, size=rows + _WARM) / math.sqrt(5.0 / 3.0)
        else:
            raise ValueError(f"noise of kind '{self.kind}' is not known; choose normal or t5")
        # Variance of an AR(2) process over that of its innovations, inverted.
        gain = math.sqrt((1.0 + self.rho2) * ((1.0 - self.rho2) ** 2 - self.rho**2) / (1.0 - self.rho2))
        coloured = lfilter([gain], [1.0, -self.rho, -self.rho2] if self.rho2 else [1.0, -self.rho], white)[_WARM:]
        hit = draw.random(rows) < self.outliers
        coloured[hit] += self.outlier_size * draw.choice([-1.0, 1.0], size=int(np.count_nonzero(hit)))
        if self.drift:
            coloured = coloured + self.drift * _wander(rows, draw)
        return self.sigma * coloured

    def read(self, column: Array, draw: np.random.Generator, unit: float = 1.0) -> Array:
        """The column, in the unit of sigma over ``unit``, as it is read: with noise, then rounded to the quantum."""
        noisy: Array = column + unit * self.draw(column.size, draw)
        step = self.quantum * self.sigma * unit
        return step * np.round(noisy / step) if step else noisy


def _wander(rows: int, draw: np.random.Generator) -> Array:
    """A slope and half a wave of random signs, mean 0, root mean square 1."""
    t = np.linspace(-1.0, 1.0, rows)
    found = draw.normal() * t + draw.normal() * np.cos(0.5 * math.pi * (t + draw.uniform(-0.5, 0.5)))
    found = found - np.mean(found)
    return found / np.sqrt(np.mean(found**2))
