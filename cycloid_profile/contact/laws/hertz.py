"""Line contact of a pin and a tooth: materials, geometry, and the band and stresses after Hertz."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray, IntArray
from cycloid_profile.errors import LoadError

# Johnson (1985) §4.2(c): the largest principal shear stress of a line contact and its depth.
SHEAR_PER_PRESSURE, SHEAR_DEPTH_PER_HALF_WIDTH = 0.3003, 0.7862


@dataclass(frozen=True, slots=True)
class Material:
    """Elastic material: ``youngs_modulus`` [MPa], ``poisson_ratio``."""

    youngs_modulus: float
    poisson_ratio: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.youngs_modulus) and self.youngs_modulus > 0.0):
            raise LoadError("youngs_modulus", f"{self.youngs_modulus} MPa", "is not positive", "steel has 206 000 MPa")
        if not 0.0 <= self.poisson_ratio < 0.5:
            raise LoadError("poisson_ratio", self.poisson_ratio, "is outside [0, 0.5)", "steel has 0.3")

    @property
    def compliance(self) -> float:
        """(1 − μ²)/E [1/MPa]."""
        return (1.0 - self.poisson_ratio**2) / self.youngs_modulus

    def contact_modulus(self, other: Material) -> float:
        """E* of a contact with another material, 1/E* = (1 − μ1²)/E1 + (1 − μ2²)/E2 [MPa]."""
        return 1.0 / (self.compliance + other.compliance)

    @property
    def is_steel(self) -> bool:
        """Whether the material is at least as stiff as the softest steels, 0.9 of 206 GPa."""
        return self.youngs_modulus > 0.9 * STEEL.youngs_modulus


STEEL = Material(206_000.0, 0.3)


@dataclass(frozen=True, eq=False, slots=True)
class LineContact:
    """Geometry and stiffness of pin against tooth (docs/theory.md, Eqs. 23–24).

    ``width`` of the contact [mm]; ``pin_radius`` [mm]; ``curvature`` of the tooth, convex negative, any
    shape [1/mm]; ``disc`` and ``pin`` materials; ``radius_cap``, the largest tooth radius that may enter a
    logarithm [mm] (at an inflection the radius is infinite, the body is not).
    """

    width: float
    pin_radius: float
    curvature: FloatArray
    disc: Material
    pin: Material
    radius_cap: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.width) and self.width > 0.0):
            raise LoadError(
                "disc_width", f"{self.width} mm", "is not a positive length", "give the face width of one disc"
            )

    @property
    def compliance(self) -> float:
        """C_E = Σ(1 − μ²)/E over both bodies [1/MPa]."""
        return self.disc.compliance + self.pin.compliance

    @property
    def relative_radius(self) -> FloatArray:
        """R = |ρ r/(ρ − r)| = 1/(1/r − κ), in the shape of ``curvature`` [mm] (Eq. 23)."""
        R: FloatArray = 1.0 / np.abs(1.0 / self.pin_radius - self.curvature)
        return R

    @property
    def tooth_radius(self) -> FloatArray:
        """|ρ|, at most ``radius_cap``, in the shape of ``curvature`` [mm]."""
        rho: FloatArray = 1.0 / np.maximum(np.abs(self.curvature), 1.0 / self.radius_cap)
        return rho

    def at(self, which: BoolArray | tuple[IntArray, ...]) -> LineContact:
        """The contacts where ``which`` is true, or at these indices, as one row."""
        return replace(self, curvature=self.curvature[which])

    def half_width(self, force: ArrayLike) -> FloatArray:
        """Half-width of the contact band, √(4 F R C_E/(π b)), Johnson (1985) Eq. (4.43) [mm]."""
        F = np.asarray(force, dtype=np.float64)
        a: FloatArray = np.sqrt(4.0 * F * self.relative_radius * self.compliance / (math.pi * self.width))
        return a

    def peak_pressure(self, force: ArrayLike) -> FloatArray:
        """Peak pressure √(F/(π b R C_E)), Johnson (1985) Eq. (4.45) [MPa]."""
        F = np.asarray(force, dtype=np.float64)
        p: FloatArray = np.sqrt(F / (math.pi * self.width * self.relative_radius * self.compliance))
        return p

    def subsurface_shear(self, force: ArrayLike) -> FloatArray:
        """Largest shear stress under the surface, 0.300 p0, Johnson (1985) §4.2(c) [MPa].

        Principal shear in the plane of the section; it does not depend on Poisson's ratio.
        """
        return SHEAR_PER_PRESSURE * self.peak_pressure(force)

    def shear_depth(self, force: ArrayLike) -> FloatArray:
        """Depth of the largest shear stress, 0.786 half-widths, Johnson (1985) §4.2(c) [mm]."""
        return SHEAR_DEPTH_PER_HALF_WIDTH * self.half_width(force)
