"""A law of approach in the form that the compiled kernels evaluate."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray

LOGARITHM, POWER, TABLE = range(3)
HALLEY_STEPS = 3  # for v − ln v = c, in which a logarithm gives the force
STENCIL = 6  # nodes of the interpolating polynomial of a table, of degree five


class CompiledLaw(NamedTuple):
    """A law in all contacts of one width, pin and pair of materials, as the kernels evaluate it.

    ``kind`` is LOGARITHM, δ = G·F·(K − ln F), POWER, δ = A·F^n, or TABLE, ln(energy) by ln δ and curvature.
    ``factor`` is G or A; ``exponent`` n, or K without the share of the curvature, ln(|ρ|^x/R) with the
    ``tooth_radius_exponent`` x; ``spring``, compliance of a spring in series [mm/N]; ``least_curvature`` that enters a
    logarithm and ``pin_curvature`` [1/mm].

    ``table`` shape (6 + 2·``rows``, columns): ``STENCIL`` rows of almost flat teeth, then convex, then concave ones.
    """

    kind: int
    factor: float
    exponent: float
    tooth_radius_exponent: float
    least_curvature: float
    pin_curvature: float
    spring: float = 0.0
    rows: int = 0
    row_spacing: float = 0.0
    first_column: float = 0.0
    column_spacing: float = 0.0
    table: FloatArray = np.zeros((1, 1))

    def on_spring(self, compliance: float) -> CompiledLaw:
        """The law in series with a linear spring [mm/N]."""
        return self._replace(spring=self.spring + compliance)
