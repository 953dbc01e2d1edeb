"""Six laws of approach for a pin pressed on a tooth, compared in docs/theory.md, "Line contact".

The approach of two parallel cylinders is no local quantity, so every law carries a convention about the
depth of the bodies, or was fitted to bodies of one kind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.laws.compiled import HALLEY_STEPS, LOGARITHM, POWER, CompiledLaw
from cycloid_profile.contact.laws.contact_law import HertzBand
from cycloid_profile.contact.laws.hertz import STEEL, LineContact

# Two steels differ by less. At this limit the laws for like bodies are wrong by 0.5 %, as each radius counts half.
_LIKE = 0.05


class LogarithmScale(NamedTuple):
    """Constants of δ = G F (K − ln F): ``G`` [mm/N]; K = ``K0`` + ln(|ρ|^x/R), x the ``tooth_radius_exponent``."""

    G: float
    K0: float
    tooth_radius_exponent: float


class Logarithmic(HertzBand):
    """Laws of the form δ = G·F·(K − ln F), which hold up to ln F = K − 1, far beyond any pin's load."""

    def scale(self, contact: LineContact) -> LogarithmScale:
        """Constants that do not depend on the curvature of the tooth."""
        raise NotImplementedError

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """See ``Compilable.compiled``."""
        return CompiledLaw(LOGARITHM, *self.scale(contact), 1.0 / contact.radius_cap, 1.0 / contact.pin_radius)

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See ``ContactLaw.response``."""
        # F v = δ/G with v = K − ln F, the root above 1 of v − ln v = c; each step of Halley triples the digits.
        G, K = self._constants(contact)
        c = np.maximum(K + math.log(G) - np.log(approach), 1.0 + 1e-9)
        v = c + np.log(c) * c / (c - 1.0)
        for _ in range(HALLEY_STEPS):
            error, slope = v - np.log(v) - c, 1.0 - 1.0 / v
            v = v - error / (slope - 0.5 * error / (v * v * slope))
        F = approach / (G * v)
        return F, 1.0 / (G * (v - 1.0)), 0.5 * G * F * F * (v - 0.5)

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        """G [mm/N] and K."""
        scale = self.scale(contact)
        size = contact.tooth_radius**scale.tooth_radius_exponent
        return scale.G, scale.K0 + np.log(size / contact.relative_radius)

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        G, K = self._constants(contact)
        F = np.asarray(force, dtype=np.float64)
        log = np.log(np.where(F > 0.0, F, 1.0))
        delta: FloatArray = np.where(F > 0.0, G * F * (K - log), 0.0)
        return delta

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        G, K = self._constants(contact)
        F = np.maximum(np.asarray(force, dtype=np.float64), 1e-300)
        k: FloatArray = 1.0 / (G * (K - np.log(F) - 1.0))
        return k


class LikeBodies(Logarithmic):
    """Logarithmic laws printed for two bodies of one material, extended by the sum of both compliances."""

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``: a narrow band between bodies of equal compliance."""
        like = abs(contact.disc.compliance / contact.pin.compliance - 1.0) <= _LIKE
        return super().within_range(force, contact) & like


class PowerLaw(HertzBand):
    """Laws of the form δ = A·F^n, fitted to steel."""

    exponent: ClassVar[float]

    def _factor(self, contact: LineContact) -> float:
        """A [mm/N^n]."""
        raise NotImplementedError

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """See ``Compilable.compiled``."""
        factor, radii = self._factor(contact), (1.0 / contact.radius_cap, 1.0 / contact.pin_radius)
        return CompiledLaw(POWER, factor, self.exponent, 0.0, *radii)

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See ``ContactLaw.response``."""
        n = self.exponent
        F = (approach / self._factor(contact)) ** (1.0 / n)
        return F, F / (n * approach), n / (n + 1.0) * F * approach

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        F = np.maximum(np.asarray(force, dtype=np.float64), 0.0)
        delta: FloatArray = self._factor(contact) * F**self.exponent + np.zeros_like(contact.curvature)
        return delta

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        F, n = np.maximum(np.asarray(force, dtype=np.float64), 1e-300), self.exponent
        k: FloatArray = F ** (1.0 - n) / (n * self._factor(contact)) + np.zeros_like(contact.curvature)
        return k

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``: a narrow band between steel bodies."""
        steel = abs(contact.compliance / (2.0 * STEEL.compliance) - 1.0) <= _LIKE
        return super().within_range(force, contact) & steel


@dataclass(frozen=True, slots=True)
class Roark(LikeBodies):
    """δ = F C_E/(π b)·[2/3 + ln(16 r|ρ|/c²)], c = 1.60 √(2 F R C_E/b) the full width (Eq. 25)."""

    name: ClassVar[str] = "roark"
    source: ClassVar[str] = "Young & Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), Table 14.1 case 2"
    validity: ClassVar[str] = "two cylinders of like material, band up to a tenth of the smaller radius"

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        K0 = 2.0 / 3.0 + math.log(16.0 * contact.pin_radius / _c2_per_force_and_radius(contact))
        return LogarithmScale(_G(contact), K0, 1.0)

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """c/2 with the rounded constant of the table [mm]."""
        half: FloatArray = 0.5 * np.sqrt(
            np.asarray(force, dtype=np.float64) * contact.relative_radius * _c2_per_force_and_radius(contact)
        )
        return half


@dataclass(frozen=True, slots=True)
class Johnson(Logarithmic):
    """δ = F/(π b)·Σ C_i [2 ln(4 R_i/h) − 1], C_i = (1 − μ_i²)/E_i, h the half-width (Eq. 26)."""

    name: ClassVar[str] = "johnson"
    source: ClassVar[str] = "after Johnson, Contact Mechanics (1985), §5.6, each body a cylinder pressed across"
    validity: ClassVar[str] = "two cylinders, band up to a tenth of the smaller radius"

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        # h² = 4 G R F. A body's own compression goes with its own compliance, so each radius counts by its share.
        tooth = 2.0 * contact.disc.compliance / contact.compliance
        K0 = math.log(4.0 * contact.pin_radius ** (2.0 - tooth) / _G(contact)) - 1.0
        return LogarithmScale(_G(contact), K0, tooth)


@dataclass(frozen=True, slots=True)
class ArticleLogarithm(LikeBodies):
    """δ = (2F C_E/π b)·ln(3.8/C) with C = 3.8 c/X, X = 5.58 √(r|ρ|), c the full width (Eq. 27).

    The tooth-profile article prints C as a "damping coefficient"; read as a width ratio it is Roark's
    formula with rounded constants (docs/articles.md).
    """

    name: ClassVar[str] = "article"
    source: ClassVar[str] = "the tooth-profile article, its C read as a ratio of widths (docs/articles.md)"
    validity: ClassVar[str] = Roark.validity

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        K0 = math.log(5.58**2 * contact.pin_radius / _c2_per_force_and_radius(contact))
        return LogarithmScale(_G(contact), K0, 1.0)

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """c/2, as in ``Roark`` [mm]."""
        return Roark().half_width(force, contact)


@dataclass(frozen=True, slots=True)
class WeberBanaschek(Logarithmic):
    """δ = F/(π b)·Σ C_i [ln(4 t²/h²) − μ_i/(1 − μ_i)] with the depth t = r of both bodies (Eq. 43).

    Counts the deformation down to the depth t only; C_i = (1 − μ_i²)/E_i, h the half-width.
    """

    name: ClassVar[str] = "weber-banaschek"
    source: ClassVar[str] = (
        "Weber & Banaschek, Formänderung und Profilrücknahme bei gerad- und schrägverzahnten Rädern (1953)"
    )
    validity: ClassVar[str] = (
        "bodies that are held at the depth of a pin radius, band up to a tenth of the smaller radius"
    )

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        bodies = (contact.disc, contact.pin)
        across = sum(body.compliance * body.poisson_ratio / (1.0 - body.poisson_ratio) for body in bodies)
        K0 = math.log(contact.pin_radius**2 / _G(contact)) - across / contact.compliance
        return LogarithmScale(_G(contact), K0, 0.0)


@dataclass(frozen=True, slots=True)
class Palmgren(PowerLaw):
    """δ = 3.84e-5 F^0.9/b^0.8 [mm, N, mm] (Eq. 44); a steel roller on a steel raceway."""

    name: ClassVar[str] = "palmgren"
    source: ClassVar[str] = "Palmgren, Grundlagen der Wälzlagertechnik, 3rd ed. (1964)"
    validity: ClassVar[str] = "steel rollers on raceways of roller bearings, whatever the radii"
    exponent: ClassVar[float] = 0.9

    def _factor(self, contact: LineContact) -> float:
        factor: float = 3.84e-5 / contact.width**0.8
        return factor


@dataclass(frozen=True, slots=True)
class Braendlein(PowerLaw):
    """δ = 4.05e-5 F^0.925/b^0.85 [mm, N, mm] (Eq. 44); a steel roller on a steel raceway."""

    name: ClassVar[str] = "braendlein"
    source: ClassVar[str] = "Brändlein, Eschmann, Hasbargen & Weigand, Die Wälzlagerpraxis, 3rd ed. (1995)"
    validity: ClassVar[str] = "steel rollers on raceways of roller bearings, whatever the radii"
    exponent: ClassVar[float] = 0.925

    def _factor(self, contact: LineContact) -> float:
        factor: float = 4.05e-5 / contact.width**0.85
        return factor


LAWS = {law.name: law for law in (Roark(), Johnson(), ArticleLogarithm(), WeberBanaschek(), Palmgren(), Braendlein())}


def _G(contact: LineContact) -> float:  # noqa: N802 - the symbol of the formulas
    """C_E/(π b) [mm/N]."""
    return contact.compliance / (math.pi * contact.width)


def _c2_per_force_and_radius(contact: LineContact) -> float:
    """c²/(F R) of the rounded full width c = 1.60 √(2 F R C_E/b) [mm/N]."""
    c2: float = 1.60**2 * 2.0 * contact.compliance / contact.width
    return c2
