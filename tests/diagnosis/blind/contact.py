"""Contact of pin and tooth: laws of the approach [mm] of a pin pressed by a force [N], and the body behind the teeth.

A law is a small frozen object; ``of`` gives its coefficients for some pins. All laws are scaled to deflect like the
first one at the load of a rated reducer, times their ``softness``: they differ in form.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from .reducer import Reducer
from .units import NEWTON_METRE

Array = np.ndarray
_CARRYING = 0.3  # share of the pins of a disc that carry at rated torque


class Pressed(Protocol):
    """Coefficients of a law for some pins."""

    def answer(self, approach: Array) -> tuple[Array, Array, Array]:
        """Force [N], stiffness [N/mm], energy [N·mm] of an approach [mm]; nothing where it is not positive."""


class Law(Protocol):
    """A contact law."""

    def of(self, reducer: Reducer, curvature: Array, pin_radius: Array, seat: float) -> Pressed:
        """Its coefficients, for a tooth of ``curvature`` [1/mm] and further compliance ``seat`` of a pin [mm/N]."""


@dataclass(frozen=True)
class Line:
    """δ = G F (K − ln F), with ``slope`` G [mm/N] and ``constant`` K; ``relative_radius`` R [mm].

    The constant holds springs in series with the contact as well: δ + c F is the same law with K + c/G.
    """

    slope: float
    constant: Array
    relative_radius: Array

    def answer(self, approach: Array) -> tuple[Array, Array, Array]:
        """Force [N], stiffness [N/mm], energy [N·mm] of an approach [mm]; nothing where it is not positive."""
        pressed = approach > 0.0
        # v = K − ln F solves v − ln v = K − ln(δ/G); the larger root, from above.
        # Steel would yield long before the floor of the right side.
        right = np.maximum(self.constant - np.log(np.where(pressed, approach, 1e-12) / self.slope), 1.5)
        v = right + np.log(right) + 0.1
        for _ in range(4):
            v = v - (v - np.log(v) - right) / (1.0 - 1.0 / v)
        force = np.where(pressed, approach / (self.slope * v), 0.0)
        stiffness = np.where(pressed, 1.0 / (self.slope * (v - 1.0)), 0.0)
        return force, stiffness, 0.5 * self.slope * force * force * (v - 0.5)


@dataclass(frozen=True)
class Power:
    """F = F0 (δ/δ0)^n in series with a seat: δ = δ0 (F/F0)^(1/n) + c F."""

    load: float
    approach: Array
    exponent: float
    seat: float

    def answer(self, approach: Array) -> tuple[Array, Array, Array]:
        """Force [N], stiffness [N/mm], energy [N·mm] of an approach [mm]; nothing where it is not positive."""
        pressed = approach > 0.0
        wanted = np.where(pressed, approach, 1e-12)
        own = wanted / (1.0 + self.seat * self.load / self.approach)  # share of the contact itself
        for _ in range(5 if self.seat else 0):
            force = self._force(own)
            excess = own + self.seat * force - wanted
            own = np.maximum(own - excess / (1.0 + self.seat * self.exponent * force / own), 1e-3 * own)
        own = own if self.seat else wanted
        force = np.where(pressed, self._force(own), 0.0)
        give = own / (self.exponent * np.where(pressed, force, 1.0)) + self.seat
        energy = force * own / (self.exponent + 1.0) + 0.5 * self.seat * force * force
        return force, np.where(pressed, 1.0 / give, 0.0), energy

    def _force(self, own: Array) -> Array:
        return self.load * (own / self.approach) ** self.exponent


def line(curvature: Array, pin_radius: Array, width: float, compliance: float, cap: float, seat: float = 0.0) -> Line:
    """Contact after Roark of pins of ``pin_radius`` with a tooth of ``curvature``, convex negative [1/mm].

    ``compliance`` C_E of both [1/MPa]; ``cap``, the largest tooth radius in the logarithm [mm]; ``seat``, further
    compliance of each pin [mm/N].
    """
    slope = compliance / (math.pi * width)
    relative = relative_radius(curvature, pin_radius)
    tooth = 1.0 / np.maximum(np.abs(curvature), 1.0 / cap)
    band_squared = 1.6**2 * 2.0 * relative * compliance / width  # full width of the band, for 1 N
    constant = 2.0 / 3.0 + np.log(16.0 * pin_radius * tooth / band_squared) + seat / slope
    return Line(slope, constant, relative)


def relative_radius(curvature: Array, pin_radius: Array) -> Array:
    """R of pin and tooth [mm]."""
    return 1.0 / np.maximum(1.0 / pin_radius - curvature, 1e-3 / pin_radius)


@dataclass(frozen=True)
class Roark:
    """The law of the package's rigid discs, written again."""

    def of(self, reducer: Reducer, curvature: Array, pin_radius: Array, seat: float) -> Pressed:
        """Its coefficients."""
        r = reducer
        return line(curvature, pin_radius, r.disc_width_mm, r.contact_compliance, r.pin_circle_radius_mm, seat)


@dataclass(frozen=True)
class PowerLaw:
    """F ∝ δ^n: 10/9 after Palmgren, 1.0 a linear spring; equal at all curvatures, as such laws are."""

    exponent: float = 10.0 / 9.0
    softness: float = 1.0

    def of(self, reducer: Reducer, curvature: Array, pin_radius: Array, seat: float) -> Pressed:
        """Its coefficients."""
        load, approach = at_rated(reducer)
        return Power(load, np.full_like(curvature * pin_radius, self.softness * approach), self.exponent, seat)


@dataclass(frozen=True)
class ReferenceDepth:
    """Hertz with the approach of points at a ``depth`` [mm] in both bodies, after Weber and Banaschek.

    δ = (F C_E/(π B)) [ln(4 t²/b²) − ν/(1−ν)], b² = 4 F R C_E/(π B).
    """

    depth: float = 6.0

    def of(self, reducer: Reducer, curvature: Array, pin_radius: Array, seat: float) -> Pressed:
        """Its coefficients."""
        r = reducer
        slope = r.contact_compliance / (math.pi * r.disc_width_mm)
        relative = relative_radius(curvature, pin_radius)
        inside = math.pi * self.depth**2 * r.disc_width_mm / (relative * r.contact_compliance)
        constant = np.log(inside) - r.poisson_ratio / (1.0 - r.poisson_ratio) + seat / slope
        return Line(slope, constant, relative)


def at_rated(reducer: Reducer) -> tuple[float, float]:
    """Mean force of a carrying pin at rated torque [N], and its approach after Roark on a straight tooth [mm]."""
    r = reducer
    arm = 0.8 * r.eccentricity_mm * r.lobes
    force = r.rated_torque_nm * NEWTON_METRE / (r.discs * _CARRYING * r.pins * arm)
    law = line(np.zeros(1), np.array([r.pin_radius_mm]), r.disc_width_mm, r.contact_compliance, r.pin_circle_radius_mm)
    return force, float(law.slope * force * (law.constant[0] - math.log(force)))


@dataclass(frozen=True)
class Body:
    """The disc behind its teeth. A pin pushes its neighbours' teeth along: the ``influence`` decays along the ring.

    c_ij = c exp(−|i − j|/``reach``) n_i·n_j for pins i, j with contact normals n. ``own``: c, of a pin on its own tooth
    [mm/N]; 0 is the rigid disc.
    """

    own: float = 0.0
    reach: float = 2.0

    @property
    def rigid(self) -> bool:
        """Whether nothing gives."""
        return self.own == 0.0

    def push(self, pins: Array, count: int, normal: Array, force: Array) -> Array:
        """How far the other pins push the teeth of each away, (poses, pins) [mm].

        ``pins`` their numbers on a ring of ``count``, ``normal`` complex, ``force`` [N].
        """
        apart = np.abs(pins[:, :, None] - pins[:, None, :])
        apart = np.minimum(apart, count - apart)
        others = np.where(apart > 0, np.exp(-apart / self.reach), 0.0)
        along = (normal[:, :, None] * np.conj(normal[:, None, :])).real
        return self.own * np.matmul(others * along, force[:, :, None])[:, :, 0]


def peak_pressure(force: Array, relative_radius: Array, width: float, compliance: float) -> Array:
    """Pressure in the middle of the band, after Hertz [MPa]."""
    return np.sqrt(force / (math.pi * width * relative_radius * compliance))
