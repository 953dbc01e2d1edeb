"""Line contact of a pin and a tooth: approach, its inverse, half-width and pressure.

Each law is a small frozen object; all take the force on one pin and the ``LineContact`` it acts in.
Compared at one point in docs/theory.md, "Line contact".
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.errors import LoadError


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


@dataclass(frozen=True, slots=True)
class LineContact:
    """Geometry and stiffness of pin against tooth (docs/theory.md, Eqs. 23–24).

    ``width`` of the contact [mm]; ``pin_radius`` [mm]; ``curvature`` of the tooth, convex negative, any
    shape [1/mm]; ``compliance`` C_E, the sum over both bodies [1/MPa]; ``radius_cap``, the largest tooth
    radius that may enter a logarithm [mm] (at an inflection the radius is infinite, the body is not).
    """

    width: float
    pin_radius: float
    curvature: FloatArray
    compliance: float
    radius_cap: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.width) and self.width > 0.0):
            raise LoadError(
                "disc_width", f"{self.width} mm", "is not a positive length", "give the face width of one disc"
            )

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


class ContactLaw(Protocol):
    """Approach of pin and tooth under a force, and back."""

    @property
    def name(self) -> str:
        """Name shown to the user."""
        ...

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Approach δ [mm] under ``force`` ≥ 0 [N]."""
        ...

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """Force [N] at an ``approach`` [mm]; 0 where the approach is not positive."""
        ...

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """Tangent stiffness dF/dδ at ``force`` > 0 [N/mm]."""
        ...


class _Logarithmic:
    """Laws of the form δ = G·F·(K − ln F), which hold up to ln F = K − 1, far beyond any pin's load."""

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        """G [mm/N] and K."""
        raise NotImplementedError

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        G, K = self._constants(contact)
        F = np.asarray(force, dtype=np.float64)
        log = np.log(np.where(F > 0.0, F, 1.0))
        delta: FloatArray = np.where(F > 0.0, G * F * (K - log), 0.0)
        return delta

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``; Newton in ln F, which converges from below without a safeguard."""
        G, K = self._constants(contact)
        delta = np.asarray(approach, dtype=np.float64)
        y = np.where(delta > 0.0, delta, G) / G
        # ln F = x solves x + ln(K − x) = ln y; the left side is concave and rising for x < K − 1.
        x = np.minimum(np.log(y) - np.log(np.maximum(K, 2.0)), K - 1.5)
        for _ in range(12):
            step = (x + np.log(K - x) - np.log(y)) / (1.0 - 1.0 / (K - x))
            x = np.minimum(x - step, K - 1.0 - 1e-9)
            if float(np.max(np.abs(step), initial=0.0)) < 1e-14:
                break
        F: FloatArray = np.where(delta > 0.0, np.exp(x), 0.0)
        return F

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        G, K = self._constants(contact)
        F = np.maximum(np.asarray(force, dtype=np.float64), 1e-300)
        k: FloatArray = 1.0 / (G * (K - np.log(F) - 1.0))
        return k


@dataclass(frozen=True, slots=True)
class Roark(_Logarithmic):
    """δ = F C_E/(π b)·[2/3 + ln(16 r|ρ|/c²)], c = 1.60 √(2 F R C_E/b) the full width (Eq. 25).

    Young & Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), Table 14.1 case 2.
    """

    name: ClassVar[str] = "roark"

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        G = contact.compliance / (math.pi * contact.width)
        c2_per_force = 1.60**2 * 2.0 * contact.relative_radius * contact.compliance / contact.width
        K = 2.0 / 3.0 + np.log(16.0 * contact.pin_radius * contact.tooth_radius / c2_per_force)
        return G, K


@dataclass(frozen=True, slots=True)
class Johnson(_Logarithmic):
    """δ = F C_E/(2π b)·Σ[2 ln(4 R_i/h) − 1], h the half-width (Eq. 26).

    After Johnson, Contact Mechanics (1985), §5.6, each body a cylinder loaded across its diameter.
    """

    name: ClassVar[str] = "johnson"

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        G = contact.compliance / (math.pi * contact.width)
        h2_per_force = 4.0 * contact.relative_radius * contact.compliance / (math.pi * contact.width)
        K = np.log(16.0 * contact.pin_radius * contact.tooth_radius / h2_per_force) - 1.0
        return G, K


@dataclass(frozen=True, slots=True)
class ArticleLogarithm(_Logarithmic):
    """δ = (2F C_E/π b)·ln(3.8/C) with C = 3.8 c/X, X = 5.58 √(r|ρ|), c the full width (Eq. 27).

    The tooth-profile article prints C as a "damping coefficient"; read as a width ratio it is Roark's
    formula with rounded constants (docs/articles.md).
    """

    name: ClassVar[str] = "article"

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        G = contact.compliance / (math.pi * contact.width)
        c2_per_force = 1.60**2 * 2.0 * contact.relative_radius * contact.compliance / contact.width
        K = np.log(5.58**2 * contact.pin_radius * contact.tooth_radius / c2_per_force)
        return G, K
