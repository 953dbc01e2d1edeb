"""Measuring noise: coloured along the rows, with outliers, of two classes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

Array = np.ndarray


@dataclass(frozen=True)
class Noise:
    """``sigma`` in the unit of the column; ``rho`` from row to row; a share of ``outliers`` of ``outlier_size`` sigmas.

    ``kind`` is "normal" or "t5", Student's t with 5 degrees of freedom scaled to the same sigma. ``declare``
    writes sigma into the file.
    """

    sigma: float = 0.0
    rho: float = 0.0
    outliers: float = 0.0
    outlier_size: float = 10.0
    kind: str = "normal"
    declare: bool = False

    def draw(self, rows: int, draw: np.random.Generator) -> Array:
        """One column of noise, its standard deviation ``sigma`` apart from the outliers."""
        if self.sigma == 0.0:
            return np.zeros(rows)
        warm = 200
        if self.kind == "normal":
            white = draw.normal(size=rows + warm)
        elif self.kind == "t5":
            white = draw.standard_t(5, size=rows + warm) / math.sqrt(5.0 / 3.0)
        else:
            raise ValueError(f"noise of kind '{self.kind}' is not known; choose normal or t5")
        coloured = lfilter([math.sqrt(1.0 - self.rho**2)], [1.0, -self.rho], white)[warm:]
        hit = draw.random(rows) < self.outliers
        coloured[hit] += self.outlier_size * draw.choice([-1.0, 1.0], size=int(np.count_nonzero(hit)))
        return self.sigma * coloured
