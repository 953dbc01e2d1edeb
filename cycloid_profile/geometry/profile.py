"""The tooth curve: the parallel curve of the trochoid, with further normal removal on the flanks."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.removal import NormalRemoval, RemovalJet, flank_side
from cycloid_profile.geometry.trochoid import Trochoid

_REVERSAL_GRID = 721


@dataclass(frozen=True, slots=True)
class ToothPoints:
    """Points of a tooth curve with their direction and bending.

    ``position`` [mm] and ``normal`` (outward, unit) are complex numbers x + iy in the shape of
    ``phase`` [rad]; ``first`` and ``second`` are the derivatives of the position by phase.
    """

    phase: FloatArray
    position: ComplexArray
    first: ComplexArray
    second: ComplexArray

    @property
    def normal(self) -> ComplexArray:
        """Outward unit normal (Eq. 9)."""
        n: ComplexArray = 1j * self.first / np.abs(self.first)
        return n

    @property
    def curvature(self) -> FloatArray:
        """Signed curvature, negative where the tooth is convex [1/mm] (Eq. 10)."""
        kappa: FloatArray = (np.conj(self.first) * self.second).imag / np.abs(self.first) ** 3
        return kappa

    @property
    def xy(self) -> FloatArray:
        """Coordinates, shape (…, 2) [mm]."""
        return np.stack([self.position.real, self.position.imag], axis=-1)


@dataclass(frozen=True, slots=True)
class ToothProfile:
    """A disc's tooth curve (docs/theory.md, Eq. 7): P(ψ) = C(ψ) − (r + h(ψ)) n(ψ), ψ ∈ [0, 2π z_c).

    Parameters
    ----------
    trochoid : path of the *generating* pin centre (after a radial-moving modification)
    pin_radius : radius r of the *generating* pin (after an equidistant modification) [mm]
    removals : further material taken off along the normal, summed

    Raises
    ------
    GeometryError
        If the pin radius is not positive or undercuts the tooth.
    """

    trochoid: Trochoid
    pin_radius: float
    removals: tuple[NormalRemoval, ...] = ()

    def __post_init__(self) -> None:
        if not (math.isfinite(self.pin_radius) and self.pin_radius > 0.0):
            raise GeometryError(
                "pin_radius",
                f"{self.pin_radius:.7g} mm",
                "is not a positive length",
                "give a pin radius above zero, and an equidistant modification smaller than it",
            )
        limit = undercut_limit(self.trochoid)
        if self.pin_radius >= limit:
            raise GeometryError(
                "pin_radius",
                f"{self.pin_radius:.7g} mm",
                f"is not below the undercut limit {limit:.4f} mm",
                "take thinner pins or a smaller eccentricity",
            )
        if self.removals:
            self._refuse_reversal()

    def _refuse_reversal(self) -> None:
        """A removal can turn the curve back on itself like an undercut, which the pin radius cannot tell."""
        psi = np.linspace(0.0, 2.0 * math.pi, _REVERSAL_GRID)
        forward = -(np.conj(self.trochoid.normal(psi)) * self.at(psi).first).imag
        if not float(np.min(forward)) > 0.0:
            worst = self.pin_radius + float(self.removal(psi).value[int(np.argmin(forward))])
            raise GeometryError(
                "pin_radius with removal",
                f"{worst:.4f} mm",
                "makes the tooth curve run backwards like an undercut",
                "take smaller modification amounts",
            )

    @property
    def corners(self) -> tuple[float, ...]:
        """Phases in [0, 2π) where the tangent turns suddenly [rad]; the same on every lobe."""
        return tuple(sorted({c for removal in self.removals for c in removal.corners}))

    def removal(self, phase: ArrayLike, side: FloatArray | None = None) -> RemovalJet:
        """Sum of all removals beyond the parallel curve, in the shape of ``phase``."""
        psi = np.asarray(phase, dtype=np.float64)
        flank = flank_side(psi) if side is None else side
        h, dh, ddh = np.zeros_like(psi), np.zeros_like(psi), np.zeros_like(psi)
        for removal in self.removals:
            jet = removal.jet(psi, flank, self.trochoid)
            h, dh, ddh = h + jet.value, dh + jet.first, ddh + jet.second
        return RemovalJet(h, dh, ddh)

    def at(self, phase: ArrayLike, side: FloatArray | None = None) -> ToothPoints:
        """Points of the curve at the given phases [rad] (Eqs. 7–8).

        ``side`` (±1, in the shape of ``phase``) overrides which flank's smooth branch is used, which
        matters only at a corner.
        """
        psi = np.asarray(phase, dtype=np.float64)
        path = self.trochoid.jet(psi)
        n, turn = path.normal, path.turn
        c = self.trochoid.pin_circle_radius / self.trochoid.lobes
        h = self.removal(psi, side)
        q, dq, ddq = self.pin_radius + h.value, h.first, h.second
        g = c * path.speed + q * turn
        dg = c * path.speed_rate + dq * turn + q * path.turn_rate
        return ToothPoints(
            phase=psi,
            position=path.centre - q * n,
            first=n * (-dq - 1j * g),
            second=n * (turn * g - ddq - 1j * (dg + turn * dq)),
        )


def undercut_limit(trochoid: Trochoid) -> float:
    """Largest pin radius that does not undercut: the least convex radius of the trochoid [mm].

    Closed form of the stationary point, Eq. 11.
    """
    K1, z_p, r_p = trochoid.short_width_ratio, trochoid.pins, trochoid.pin_circle_radius
    # |ρ| = r_p w³ / |B| with both w² and B linear in cosψ is stationary at one cosψ inside (−1, 1)
    # or least at the tip, cosψ = −1.
    inner = ((2 * z_p - 1) * K1**2 + 2 - z_p) / (K1 * (z_p + 1))
    candidates = [-1.0] + ([inner] if -1.0 < inner < 1.0 else [])
    limit = math.inf
    for cos_psi in candidates:
        w2 = 1.0 + K1**2 - 2.0 * K1 * cos_psi
        bend = (1.0 + z_p * K1**2) - K1 * (z_p + 1) * cos_psi
        limit = min(limit, r_p * w2**1.5 / bend)
    return limit
