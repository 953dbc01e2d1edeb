"""The tooth curve: parallel curve of the trochoid with further normal removals on the flanks.

Positive removes material. A removal symmetric about the tooth's axis may have a corner at root and tip; ``side`` then
selects the smooth branch: +1 for the flank 0 < ψ < π, −1 for −π < ψ < 0.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.trochoid import Trochoid, require_positive

_REVERSAL_GRID = 721  # phases; a reversal of the curve spans many half degrees


class RemovalDerivatives(NamedTuple):
    """Normal removal h [mm] with its first and second derivative by phase [mm/rad, mm/rad²]."""

    value: FloatArray
    first: FloatArray
    second: FloatArray


class NormalRemoval(Protocol):
    """A removal h(ψ) along the outward normal of the trochoid."""

    @property
    def whole_disc(self) -> bool:
        """Whether the removal repeats once per revolution of the disc, 2π z_c, instead of on every lobe, 2π."""
        ...

    @property
    def point_spacing(self) -> float | None:
        """Phase between the points of a measured curve, which bounds its shortest wave; None for a formula [rad]."""
        ...

    @property
    def corners(self) -> tuple[float, ...]:
        """Phases in [0, 2π) where the slope of h jumps [rad]."""
        ...

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """Removal and derivatives on the flank ``side`` (±1), in the shape of ``phase``."""
        ...


def flank_side(phase: ArrayLike) -> FloatArray:
    """Flank of each phase: +1 for ψ in [0, π) modulo 2π, −1 for ψ in [π, 2π)."""
    half_turns = np.floor(np.asarray(phase, dtype=np.float64) / math.pi)
    return np.where(half_turns % 2 == 0, 1.0, -1.0)


def point_figures(phase: FloatArray, position: ComplexArray) -> dict[str, str]:
    """Number of points and their ranges of phase and radius, for a short ``repr``."""
    figures = {"points": f"{position.size}"}
    if position.size:
        radius = np.abs(position)
        figures["phase"] = f"{np.min(phase):.6g} to {np.max(phase):.6g} rad"
        figures["radius"] = f"{np.min(radius):.6g} to {np.max(radius):.6g} mm"
    return figures


def point_frame(points: ToothPoints | PointCloud) -> Any:
    """A ``pandas.DataFrame`` with one row per point: phase, coordinates, outward unit normal, curvature."""
    z, n = np.ravel(points.position), np.ravel(points.normal)
    phase, curvature = np.ravel(points.phase), np.ravel(points.curvature)
    return frame(
        {"psi_rad": phase, "x_mm": z.real, "y_mm": z.imag, "nx": n.real, "ny": n.imag, "curvature_per_mm": curvature}
    )


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class ToothPoints(Described):
    """Points of a tooth curve with derivatives, all in the shape of ``phase`` [rad].

    ``position`` is x + iy [mm]; ``frame`` is the unit normal n of the trochoid at the same phase. The derivative
    of the position by phase is (−i·``along`` − ``rise``)·n [mm/rad]. ``rise`` is None where the distance to the
    trochoid is constant. ``along_rate`` and ``rise_rate`` are the derivatives of ``along`` and ``rise`` by phase
    [mm/rad²]; ``turn`` is dθ/dψ, with θ the direction of n.
    """

    phase: FloatArray
    position: ComplexArray
    frame: ComplexArray
    turn: FloatArray
    along: FloatArray
    along_rate: FloatArray
    rise: FloatArray | None = None
    rise_rate: FloatArray | None = None

    def _key_figures(self) -> dict[str, str]:
        return point_figures(self.phase, self.position)

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
        second = self.turn * self.along - self.rise_rate - 1j * (self.along_rate + self.turn * self.rise)
        return np.multiply(self.frame, second)

    @property
    def normal(self) -> ComplexArray:
        """Outward unit normal (Eq. 9)."""
        if self.rise is None:
            return self.frame
        across: ComplexArray = np.multiply(self.frame, self.along - 1j * self.rise)
        return across / np.hypot(self.along, self.rise)

    @property
    def curvature(self) -> FloatArray:
        """Signed curvature, negative where the tooth is convex [1/mm] (Eq. 10)."""
        if self.rise is None or self.rise_rate is None:
            return self.turn / self.along
        g, dq = self.along, self.rise
        numerator = dq * (self.along_rate + self.turn * dq) + g * (self.turn * g - self.rise_rate)
        return numerator / (g * g + dq * dq) ** 1.5

    @property
    def xy(self) -> FloatArray:
        """Coordinates, shape (…, 2) [mm]."""
        return np.stack([self.position.real, self.position.imag], axis=-1)

    def to_frame(self) -> Any:
        """See ``point_frame``."""
        return point_frame(self)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class PointCloud(Described):
    """Points of a tooth curve, each array of shape (points,).

    ``phase`` [rad]; ``position`` x + iy [mm]; outward unit ``normal`` nx + i·ny; ``curvature``, negative where the
    tooth is convex [1/mm].
    """

    phase: FloatArray
    position: ComplexArray
    normal: ComplexArray
    curvature: FloatArray

    def _key_figures(self) -> dict[str, str]:
        return point_figures(self.phase, self.position)

    def to_frame(self) -> Any:
        """See ``point_frame``."""
        return point_frame(self)


@dataclass(frozen=True, slots=True, repr=False)
class ToothProfile(Described):
    """A disc's tooth curve (docs/theory.md, Eq. 7): P(ψ) = C(ψ) − (r + h(ψ)) n(ψ), ψ ∈ [0, 2π z_c).

    Parameters
    ----------
    trochoid : path of the *generating* pin centre (after a radial-moving modification)
    pin_radius : radius r of the *generating* pin (after an equidistant modification) [mm]
    removals : further removals along the normal, summed

    Raises ``GeometryError`` if the pin radius is not positive or undercuts the tooth.
    """

    trochoid: Trochoid
    pin_radius: float
    removals: tuple[NormalRemoval, ...] = ()

    def _key_figures(self) -> dict[str, str]:
        t = self.trochoid
        names = ", ".join(type(removal).__name__ for removal in self.removals)
        return {
            "pins, lobes": f"{t.pins}, {t.lobes}",
            "pin circle radius": f"{t.pin_circle_radius:.9g} mm",
            "eccentricity": f"{t.eccentricity:.9g} mm",
            "pin radius": f"{self.pin_radius:.9g} mm",
            "removals": names or "none",
        }

    def __post_init__(self) -> None:
        remedy = "give a pin radius above zero, and an equidistant modification smaller than it"
        require_positive("pin_radius", self.pin_radius, "mm", remedy)
        limit = undercut_limit(self.trochoid)
        if self.pin_radius >= limit:
            broken, remedy = (
                f"is not below the undercut limit {limit:.4f} mm",
                "take thinner pins or a smaller eccentricity",
            )
            raise GeometryError("pin_radius", f"{self.pin_radius:.7g} mm", broken, remedy)
        if self.removals:
            self._refuse_reversal()

    def _refuse_reversal(self) -> None:
        """Raise ``GeometryError`` where the removals reverse the curve, as an undercut does."""
        lobes = 1 if self.identical_lobes else self.trochoid.lobes
        psi = np.linspace(0.0, 2.0 * math.pi * lobes, lobes * _REVERSAL_GRID)
        forward = self.at(psi).along
        if not float(np.min(forward)) > 0.0:
            worst = self.pin_radius + float(self.removal(psi).value[int(np.argmin(forward))])
            limit = "makes the tooth curve run backwards like an undercut"
            remedy = "take smaller modification amounts"
            raise GeometryError("pin_radius with removal", f"{worst:.4f} mm", limit, remedy)

    @property
    def corners(self) -> tuple[float, ...]:
        """Phases in [0, 2π) of tangent discontinuities [rad]; the same on every lobe."""
        return tuple(sorted({c for removal in self.removals for c in removal.corners}))

    def removal(self, phase: ArrayLike, side: FloatArray | None = None) -> RemovalDerivatives:
        """Sum of all removals beyond the parallel curve, in the shape of ``phase``."""
        psi = np.asarray(phase, dtype=np.float64)
        flank = flank_side(psi) if side is None else side
        h, dh, ddh = np.zeros_like(psi), np.zeros_like(psi), np.zeros_like(psi)
        for removal in self.removals:
            jet = removal.derivatives(psi, flank, self.trochoid)
            h, dh, ddh = h + jet.value, dh + jet.first, ddh + jet.second
        return RemovalDerivatives(h, dh, ddh)

    @property
    def identical_lobes(self) -> bool:
        """Whether all lobes are identical; false with a removal that repeats once per turn of the disc."""
        return not any(removal.whole_disc for removal in self.removals)

    def at(self, phase: ArrayLike, side: FloatArray | None = None, lobe: FloatArray | None = None) -> ToothPoints:
        """Points of the curve at the given phases [rad] (Eqs. 7–8).

        ``side`` (±1, in the shape of ``phase``) overrides which flank's smooth branch is used, which
        matters only at a corner. With ``lobe``, a whole number in the shape of ``phase``, the points are
        those of phase + 2π·lobe, rotated from that lobe to lobe 0.
        """
        psi = np.asarray(phase, dtype=np.float64)
        path = self.trochoid.derivatives(psi)
        c = self.trochoid.pin_circle_radius / self.trochoid.lobes
        Q: float | FloatArray = self.pin_radius
        dh = ddh = None
        along_rate = c * path.speed_rate
        if self.removals:
            h = self.removal(psi if lobe is None else psi + 2.0 * math.pi * lobe, side)
            Q, dh, ddh = self.pin_radius + h.value, h.first, h.second
            along_rate = along_rate + dh * path.turn
        return ToothPoints(
            phase=psi,
            position=path.centre - Q * path.normal,
            frame=path.normal,
            turn=path.turn,
            along=c * path.speed + Q * path.turn,
            along_rate=along_rate + Q * path.turn_rate,
            rise=dh,
            rise_rate=ddh,
        )


def undercut_limit(trochoid: Trochoid) -> float:
    """Largest pin radius that does not undercut: the smallest radius of curvature on its convex part [mm].

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
        B = (1.0 + z_p * K1**2) - K1 * (z_p + 1) * cos_psi
        limit = min(limit, r_p * w2**1.5 / B)
    return limit
