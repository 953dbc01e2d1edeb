"""The two forms of laws of approach, logarithm and power, with the band after Hertz that both share.

A law of ``contact.laws`` gives the constants of one of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.hertz import STEEL, LineContact, PreparedLaw, Response

# A band wider than this share of the smaller radius is no longer narrow; Hertz's own assumption.
_NARROW = 0.1
_HALLEY_STEPS = 3


class _HertzBand:
    """The contact band and its stresses after Hertz, whatever the law of approach."""

    def prepare(self, contact: LineContact) -> PreparedLaw:
        """See ``ContactLaw.prepare``."""
        raise NotImplementedError

    def response(self, approach: FloatArray, contact: LineContact) -> tuple[FloatArray, FloatArray, FloatArray]:
        """See ``ContactLaw.response``."""
        found = self.prepare(contact).response(approach)
        return found.force, found.stiffness, found.energy

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.half_width``."""
        return contact.half_width(force)

    def peak_pressure(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.peak_pressure``."""
        return contact.peak_pressure(force)

    def subsurface_shear(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.subsurface_shear``."""
        return contact.subsurface_shear(force)

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``: the band is narrow against both radii."""
        smaller = np.minimum(contact.pin_radius, contact.tooth_radius)
        narrow: BoolArray = contact.half_width(force) <= _NARROW * smaller
        return narrow


class LogarithmScale(NamedTuple):
    """Constants of δ = G F (K − ln F): ``G`` [mm/N]; K = ``K0`` + ln(|ρ|/R), without |ρ| unless ``by_tooth_radius``."""

    G: float
    K0: float
    by_tooth_radius: bool


class Logarithmic(_HertzBand):
    """Laws of the form δ = G·F·(K − ln F), which hold up to ln F = K − 1, far beyond any pin's load."""

    def scale(self, contact: LineContact) -> LogarithmScale:
        """What does not depend on the curvature of the tooth."""
        raise NotImplementedError

    def _constants(self, contact: LineContact) -> tuple[float, FloatArray]:
        """G [mm/N] and K."""
        scale = self.scale(contact)
        size = contact.tooth_radius if scale.by_tooth_radius else 1.0
        return scale.G, scale.K0 + np.log(size / contact.relative_radius)

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        G, K = self._constants(contact)
        F = np.asarray(force, dtype=np.float64)
        log = np.log(np.where(F > 0.0, F, 1.0))
        delta: FloatArray = np.where(F > 0.0, G * F * (K - log), 0.0)
        return delta

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``."""
        G, K = self._constants(contact)
        delta = np.asarray(approach, dtype=np.float64)
        y = np.where(delta > 0.0, delta, G) / G
        F: FloatArray = np.where(delta > 0.0, y / _slack(y, K), 0.0)
        return F

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        G, K = self._constants(contact)
        F = np.maximum(np.asarray(force, dtype=np.float64), 1e-300)
        k: FloatArray = 1.0 / (G * (K - np.log(F) - 1.0))
        return k

    def prepare(self, contact: LineContact) -> PreparedLaw:
        """See ``ContactLaw.prepare``."""
        G, K = self._constants(contact)
        return _PreparedLogarithm(G, K + math.log(G))


def _slack(y: FloatArray, K: FloatArray) -> FloatArray:
    """v = K − ln F where F v = y: the root above 1 of v − ln v = c, c = K − ln y."""
    return _halley(np.maximum(K - np.log(y), 1.0 + 1e-9), None)


def _halley(c: FloatArray, start: FloatArray | None) -> FloatArray:
    """Root above 1 of v − ln v = c by Halley's iteration, each step of which triples the digits."""
    # One Newton step from v = c is within a few hundredths; a start from an approach nearby does with one step less.
    v = c + np.log(c) * c / (c - 1.0) if start is None else start
    for _ in range(_HALLEY_STEPS if start is None else _HALLEY_STEPS - 1):
        error, slope = v - np.log(v) - c, 1.0 - 1.0 / v
        v = v - error / (slope - 0.5 * error / (v * v * slope))
    return v


@dataclass(frozen=True, slots=True)
class _PreparedLogarithm:
    """δ = G F (K − ln F); ``K_ln_G`` is K + ln G."""

    G: float
    K_ln_G: FloatArray

    def response(self, approach: FloatArray, start: FloatArray | None = None) -> Response:
        """See ``PreparedLaw.response``; ``start`` is v = K − ln F."""
        v = _halley(np.maximum(self.K_ln_G - np.log(approach), 1.0 + 1e-9), start)
        F = approach / (self.G * v)
        # ∫F dδ with δ = G F v.
        return Response(F, 1.0 / (self.G * (v - 1.0)), 0.5 * self.G * F * F * (v - 0.5), v)


class PowerLaw(_HertzBand):
    """Laws of the form δ = A·F^n, fitted to steel."""

    exponent: ClassVar[float]

    def _factor(self, contact: LineContact) -> float:
        """A [mm/N^n]."""
        raise NotImplementedError

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        F = np.maximum(np.asarray(force, dtype=np.float64), 0.0)
        delta: FloatArray = self._factor(contact) * F**self.exponent + np.zeros_like(contact.curvature)
        return delta

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``."""
        delta = np.maximum(np.asarray(approach, dtype=np.float64), 0.0)
        F: FloatArray = (delta / self._factor(contact)) ** (1.0 / self.exponent) + np.zeros_like(contact.curvature)
        return F

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        F, n = np.maximum(np.asarray(force, dtype=np.float64), 1e-300), self.exponent
        k: FloatArray = F ** (1.0 - n) / (n * self._factor(contact)) + np.zeros_like(contact.curvature)
        return k

    def prepare(self, contact: LineContact) -> PreparedLaw:
        """See ``ContactLaw.prepare``."""
        return _PreparedPower(self._factor(contact), self.exponent)

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``: a narrow band between steel bodies."""
        steel = abs(contact.compliance / (2.0 * STEEL.compliance) - 1.0) <= 0.05
        return super().within_range(force, contact) & steel


@dataclass(frozen=True, slots=True)
class _PreparedPower:
    """δ = A F^n."""

    factor: float
    exponent: float

    def response(self, approach: FloatArray, start: FloatArray | None = None) -> Response:
        """See ``PreparedLaw.response``; a power needs no start."""
        n = self.exponent
        F = (approach / self.factor) ** (1.0 / n)
        return Response(F, F / (n * approach), n / (n + 1.0) * F * approach, F if start is None else start)
