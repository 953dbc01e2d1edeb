"""Derived laws: from a user-defined function, and a law in series with a spring."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.laws.compiled import STENCIL, TABLE, CompiledLaw
from cycloid_profile.contact.laws.contact_law import Compilable, ContactLaw, HertzBand
from cycloid_profile.contact.laws.hertz import LineContact
from cycloid_profile.errors import LoadError

Approach = Callable[[FloatArray, LineContact], FloatArray]

# Table of a law: ln δ from 1e-12 mm to 5 % of the pin radius r, curvatures of concave teeth up to 0.96/r. A disc of
# plastic under its rated load reaches 0.6 %.
_LEAST, _MOST, _COLUMN = math.log(1e-12), 0.05, 0.05
_CONFORMING, _ROW = 0.96, 0.08
# A logarithmic law stops rising where the band is as wide as the bodies. Table rows end where the slope of ln δ over
# ln F has fallen to this share of its first value, so that the interpolation stays away from the vertical tangent.
_LEAST_SLOPE = 0.5
_INVERSION_STEPS = 80
_LOG_STEP = 1e-5  # of the force; central differences then err by some 1e-11


@dataclass(frozen=True, slots=True)
class LawFromApproach(HertzBand):
    """Contact law from one function ``approach(force, contact)`` [N] → [mm]; all else is found numerically.

    ``function`` is called with arrays of forces > 0, shape of ``contact.curvature``, and must be smooth and rise
    with the force. The compiled solvers interpolate it with errors below 1e-9 up to an approach of 5 % of the pin
    radius, as long as the band is narrow (``within_range``), beyond that by a power law. A kink over the curvature must
    lie at ±1/``contact.radius_cap``. Band and stresses are those of Hertz.

    Raises
    ------
    LoadError
        When first used, if the approach does not rise with the force.
    """

    function: Approach
    name: str = "own"
    source: str = "a function of the user's"
    validity: str = "as far as its function holds"

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        F = np.asarray(force, dtype=np.float64) + np.zeros_like(contact.curvature)
        some = replace(contact, curvature=contact.curvature + np.zeros_like(F))
        delta: FloatArray = np.where(F > 0.0, self.function(np.where(F > 0.0, F, 1.0), some), 0.0)
        return delta

    def force(self, approach: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.force``; exact to rounding, not interpolated."""
        delta = np.asarray(approach, dtype=np.float64) + np.zeros_like(contact.curvature)
        some = replace(contact, curvature=contact.curvature + np.zeros_like(delta))
        found = np.exp(_log_force(self, np.log(np.where(delta > 0.0, delta, 1.0)), some))
        return np.where(delta > 0.0, found, 0.0)

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``; computed by central differences."""
        F = np.maximum(np.asarray(force, dtype=np.float64), 1e-300)
        rise = self.approach(F * (1.0 + _LOG_STEP), contact) - self.approach(F * (1.0 - _LOG_STEP), contact)
        k: FloatArray = 2.0 * _LOG_STEP * F / rise
        return k

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """See ``Compilable.compiled``."""
        return _tabulated(self, replace(contact, curvature=0.0))  # type: ignore[arg-type]


@dataclass(frozen=True, slots=True)
class OnSpring(HertzBand):
    """A law of approach in series with a linear spring of ``compliance`` c [mm/N]: δ(F) + c F."""

    law: ContactLaw
    compliance: float

    @property
    def name(self) -> str:
        """Name of the law with the suffix "on springs"."""
        return f"{self.law.name} on springs"

    @property
    def source(self) -> str:
        """Source of the law."""
        return self.law.source

    @property
    def validity(self) -> str:
        """Validity of the law."""
        return self.law.validity

    def approach(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.approach``."""
        both: FloatArray = self.law.approach(force, contact) + self.compliance * np.asarray(force, dtype=np.float64)
        return both

    def stiffness(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.stiffness``."""
        k = self.law.stiffness(force, contact)
        series: FloatArray = k / (1.0 + self.compliance * k)
        return series

    def compiled(self, contact: LineContact) -> CompiledLaw:
        """See ``Compilable.compiled``."""
        return compiled_law(self.law, contact).on_spring(self.compliance)

    def within_range(self, force: ArrayLike, contact: LineContact) -> BoolArray:
        """See ``ContactLaw.within_range``."""
        return self.law.within_range(force, contact)

    def half_width(self, force: ArrayLike, contact: LineContact) -> FloatArray:
        """See ``ContactLaw.half_width``."""
        return self.law.half_width(force, contact)


def compiled_law(law: ContactLaw, contact: LineContact) -> CompiledLaw:
    """The form of a law for the compiled kernels; a law without one is tabulated from its ``approach``."""
    if isinstance(law, Compilable):
        return law.compiled(contact)
    return LawFromApproach(law.approach).compiled(contact)


@lru_cache(maxsize=32)
def _tabulated(law: LawFromApproach, contact: LineContact) -> CompiledLaw:
    """Table of ln(energy) as a function of ln δ, a row for each curvature, under width and materials of ``contact``."""
    x = np.arange(_LEAST, math.log(_MOST * contact.pin_radius) + _COLUMN, _COLUMN)
    curvature = _curvatures(contact)[:, np.newaxis]
    some = replace(contact, curvature=curvature + np.zeros_like(x))
    end, start = _rising_range(law, x, contact, curvature)
    inside = np.minimum(x, end)
    y = _log_force(law, inside, some, start)
    # The complementary energy ∫δ dF = ∫δF d(ln F), a power law below the table, Gauss' rule between its columns.
    node, weight = np.polynomial.legendre.leggauss(6)
    step = np.diff(y)[..., np.newaxis]
    log_force = y[:, :-1, np.newaxis] + 0.5 * step * (1.0 + node)
    at = replace(contact, curvature=curvature[..., np.newaxis] + np.zeros_like(log_force))
    F = np.exp(log_force)
    between = 0.5 * step[..., 0] * np.sum(weight * law.function(F, at) * F, axis=-1)
    product = np.exp(inside + y)
    exponent = (x[1] - x[0]) / (y[:, 1] - y[:, 0])
    first = product[:, 0] / (1.0 + exponent)
    complementary = first[:, np.newaxis] + np.concatenate(
        [np.zeros_like(curvature), np.cumsum(between, axis=1)], axis=1
    )
    log_energy = _continued(np.log(product - complementary), x, end)
    return CompiledLaw(
        kind=TABLE,
        factor=0.0,
        exponent=0.0,
        tooth_radius_exponent=0.0,
        least_curvature=1.0 / contact.radius_cap,
        pin_curvature=1.0 / contact.pin_radius,
        rows=(len(curvature) - STENCIL) // 2,
        row_spacing=_ROW,
        first_column=_LEAST,
        column_spacing=_COLUMN,
        table=log_energy,
    )


def _rising_range(
    law: LawFromApproach, x: FloatArray, contact: LineContact, curvature: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Largest ln δ of each row up to which the law rises steeply enough, shape (rows, 1), and ln F near each ``x``,
    shape (rows, columns).
    """
    first = _log_force(law, x[:1] + np.zeros_like(curvature), replace(contact, curvature=curvature))
    climb = np.arange(0.0, (x[-1] - x[0]) / _LEAST_SLOPE + _COLUMN, _COLUMN)
    y = first + climb
    with np.errstate(invalid="ignore", divide="ignore"):
        height = np.log(law.function(np.exp(y), replace(contact, curvature=curvature + np.zeros_like(y))))
    slope = np.diff(height, axis=1) / _COLUMN
    steep = np.logical_and.accumulate(slope > _LEAST_SLOPE * slope[:, :1], axis=1)
    last = np.sum(steep, axis=1)
    end = np.take_along_axis(height, last[:, np.newaxis], axis=1)
    near = [np.interp(x, row[: n + 1], at[: n + 1]) for row, at, n in zip(height, y, last, strict=True)]
    return end, np.array(near)


def _continued(log_energy: FloatArray, x: FloatArray, end: FloatArray) -> FloatArray:
    """Rows of the table, each continued beyond its ``end`` as a power law."""
    last = np.maximum(np.sum(x <= end, axis=1) - 1, STENCIL)
    rows = np.arange(len(log_energy))
    slope = (log_energy[rows, last] - log_energy[rows, last - 1]) / _COLUMN
    beyond = log_energy[rows, last][:, np.newaxis] + slope[:, np.newaxis] * (x - x[last][:, np.newaxis])
    continued: FloatArray = np.where(x > x[last][:, np.newaxis], beyond, log_energy)
    return continued


def _curvatures(contact: LineContact) -> FloatArray:
    """Curvatures of the rows of a table, as ``_kernels`` looks them up [1/mm]."""
    cap, pin = 1.0 / contact.radius_cap, 1.0 / contact.pin_radius
    # Even in ln|κ| on convex teeth, in ln κ/(1/r − κ) on concave ones: the law is smooth over both.
    flattest = cap / (pin - cap)
    range_ = math.log(_CONFORMING / (1.0 - _CONFORMING) / flattest)
    ratio = np.exp(_ROW * np.arange(max(int(range_ / _ROW) + 2, STENCIL)))
    concave = flattest * ratio
    return np.concatenate([np.linspace(-cap, cap, STENCIL), -cap * ratio, pin * concave / (1.0 + concave)])


def _log_force(
    law: LawFromApproach, log_approach: FloatArray, contact: LineContact, start: FloatArray | None = None
) -> FloatArray:
    """ln F at ln δ, by the secant method from ``start``; ln δ is an almost linear function of ln F."""
    y = np.zeros_like(log_approach) if start is None else start
    value = np.log(law.function(np.exp(y), contact)) - log_approach
    slope = np.ones_like(y)
    # Downwards: a logarithmic law need not rise one step further up.
    before, value_before = y - 1.0, np.log(law.function(np.exp(y - 1.0), contact)) - log_approach
    for _ in range(_INVERSION_STEPS):
        # The last steps differ by rounding alone: they keep the slope before.
        far = np.abs(before - y) > 1e-7
        slope = np.where(far, (before - y) / np.where(far, value_before - value, 1.0), slope)
        if not np.all(slope > 0.0):
            break
        step = value * slope
        if not np.any(np.abs(step) > 1e-15 * (1.0 + np.abs(log_approach))):
            return y
        before, value_before = y, value
        y = y - step
        value = np.log(law.function(np.exp(y), contact)) - log_approach
    raise LoadError("contact law", law.name, "has an approach that does not rise with the force", "check its function")
