"""Six laws of approach for a pin pressed on a tooth, compared in docs/theory.md, "Line contact".

The approach of two parallel cylinders is no local quantity, so every law carries a convention about the
depth of the bodies, or was fitted to bodies of one kind.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.contact.hertz import LineContact
from cycloid_profile.contact.law_forms import Logarithmic, LogarithmScale, PowerLaw


@dataclass(frozen=True, slots=True)
class Roark(Logarithmic):
    """δ = F C_E/(π b)·[2/3 + ln(16 r|ρ|/c²)], c = 1.60 √(2 F R C_E/b) the full width (Eq. 25)."""

    name: ClassVar[str] = "roark"
    source: ClassVar[str] = "Young & Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), Table 14.1 case 2"
    validity: ClassVar[str] = "two cylinders of like material, band up to a tenth of the smaller radius"

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        K0 = 2.0 / 3.0 + math.log(16.0 * contact.pin_radius / _c2_per_force_and_radius(contact))
        return LogarithmScale(_G(contact), K0, True)

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """c/2 with the rounded constant of the table [mm]."""
        half: FloatArray = 0.5 * np.sqrt(
            np.asarray(force, dtype=np.float64) * contact.relative_radius * _c2_per_force_and_radius(contact)
        )
        return half


@dataclass(frozen=True, slots=True)
class Johnson(Logarithmic):
    """δ = F C_E/(2π b)·Σ[2 ln(4 R_i/h) − 1], h the half-width (Eq. 26)."""

    name: ClassVar[str] = "johnson"
    source: ClassVar[str] = "after Johnson, Contact Mechanics (1985), §5.6, each body a cylinder pressed across"
    validity: ClassVar[str] = "two cylinders, band up to a tenth of the smaller radius"

    def scale(self, contact: LineContact) -> LogarithmScale:
        """See ``Logarithmic.scale``."""
        # h² = 4 G R F.
        return LogarithmScale(_G(contact), math.log(4.0 * contact.pin_radius / _G(contact)) - 1.0, True)


@dataclass(frozen=True, slots=True)
class ArticleLogarithm(Logarithmic):
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
        return LogarithmScale(_G(contact), K0, True)

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
        return LogarithmScale(_G(contact), K0, False)


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
