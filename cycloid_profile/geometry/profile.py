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
    """Points of a tooth curve with their direction and bending, all in the shape of ``phase`` [rad].

    ``position`` is a complex number x + iy [mm]; ``frame`` the unit normal n of the trochoid there. In that
    frame the curve runs ``along`` −i·n by g and recedes against n by dq per unit of phase: ``rise``, None
    where the distance to the trochoid is constant. ``along_rate`` and ``rise_rate`` are their derivatives,
    ``turn`` is dθ/dψ of the frame.
    """

    phase: FloatArray
    position: ComplexArray
    frame: ComplexArray
    turn: FloatArray
    along: FloatArray
    along_rate: FloatArray
    rise: FloatArray | None = None
    rise_rate: FloatArray | None = None

    @property
    def first(self) -> ComplexArray:
        """Derivative of the position by phase [mm/rad] (Eq. 8)."""
        if self.rise is None:
            return -1j * self.along * self.frame
        return np.multiply(self.frame, -self.rise - 1j * self.along)

    @property
    def second(self) -> ComplexArray:
        """Second derivative of the position by phase [mm/rad²] (Eq. 8)."""
        if self.rise is None or self.rise_rate is None:
            return np.multiply(self.frame, self.turn * self.along - 1j * self.along_rate)
        bend = self.turn * self.along - self.rise_rate - 1j * (self.along_rate + self.turn * self.rise)
        return np.multiply(self.frame, bend)

    @property
    def normal(self) -> ComplexArray:
        """Outward unit normal (Eq. 9)."""
        if self.rise is None:
            return self.frame
        across: ComplexArray = np.multiply(self.frame, self.along - 1j * self.rise)
        n: ComplexArray = across / np.hypot(self.along, self.rise)
        return n

    @property
    def curvature(self) -> FloatArray:
        """Signed curvature, negative where the tooth is convex [1/mm] (Eq. 10)."""
        if self.rise is None or self.rise_rate is None:
            kappa: FloatArray = self.turn / self.along
            return kappa
        g, dq = self.along, self.rise
        bend = dq * (self.along_rate + self.turn * dq) + g * (self.turn * g - self.rise_rate)
        bent: FloatArray = bend / (g * g + dq * dq) ** 1.5
        return bent

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
        lobes = 1 if self.lobes_alike else self.trochoid.lobes
        psi = np.linspace(0.0, 2.0 * math.pi * lobes, lobes * _REVERSAL_GRID)
        forward = self.at(psi).along
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

    @property
    def lobes_alike(self) -> bool:
        """Whether every lobe is the same; false with a removal that goes once round the disc."""
        return not any(removal.whole_disc for removal in self.removals)

    def at(self, phase: ArrayLike, side: FloatArray | None = None, lobe: FloatArray | None = None) -> ToothPoints:
        """Points of the curve at the given phases [rad] (Eqs. 7–8).

        ``side`` (±1, in the shape of ``phase``) overrides which flank's smooth branch is used, which
        matters only at a corner. With ``lobe``, a whole number in the shape of ``phase``, the points are
        those of phase + 2π·lobe seen from that lobe, as if it were turned to where lobe 0 stands.
        """
        psi = np.asarray(phase, dtype=np.float64)
        path = self.trochoid.jet(psi)
        c = self.trochoid.pin_circle_radius / self.trochoid.lobes
        if not self.removals:
            q = self.pin_radius
            return ToothPoints(
                phase=psi,
                position=path.centre - q * path.normal,
                frame=path.normal,
                turn=path.turn,
                along=c * path.speed + q * path.turn,
                along_rate=c * path.speed_rate + q * path.turn_rate,
            )
        h = self.removal(psi if lobe is None else psi + 2.0 * math.pi * lobe, side)
        Q = self.pin_radius + h.value
        return ToothPoints(
            phase=psi,
            position=path.centre - Q * path.normal,
            frame=path.normal,
            turn=path.turn,
            along=c * path.speed + Q * path.turn,
            along_rate=c * path.speed_rate + h.first * path.turn + Q * path.turn_rate,
            rise=h.first,
            rise_rate=h.second,
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
