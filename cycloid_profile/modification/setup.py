"""Changes of the grinding set-up, each turning one profile into another.

Positive removes material, except in ``DeformationCompensation``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import RemovalDerivatives, ToothProfile, Trochoid


@dataclass(frozen=True, slots=True)
class FlankRemoval:
    """h(ψ) = amount·|sinψ|·S: ``amount`` [mm] at ψ0, zero at root and tip (docs/theory.md, Eq. 15)."""

    amount: float
    whole_disc: ClassVar[bool] = False
    point_spacing: ClassVar[None] = None

    @property
    def corners(self) -> tuple[float, ...]:
        """Root and tip, where |sinψ| has a corner."""
        return (0.0, math.pi) if self.amount else ()

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """Removal and derivatives on the flank ``side``, in the shape of ``phase``."""
        value, first, second = trochoid.lever_jet(phase)
        A = self.amount * side
        return RemovalDerivatives(A * value, A * first, A * second)


@dataclass(frozen=True, slots=True)
class FlankStock:
    """Stock left on the working flank: removal −``amount`` [mm] where |sinψ|·S is at least ``root_reach`` on the root's
    side of ψ0 and ``tip_reach`` on the tip's, zero at root and tip.

    Between them it is −``amount``·[1 − (1 − t²)²] with t = |sinψ|·S/reach, without corners (docs/theory.md, Eq. 97).
    """

    amount: float
    root_reach: float
    tip_reach: float
    whole_disc: ClassVar[bool] = False
    point_spacing: ClassVar[None] = None
    corners: ClassVar[tuple[float, ...]] = ()

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """Removal and derivatives on the flank ``side``, in the shape of ``phase``."""
        reach = np.where(np.cos(phase) > trochoid.short_width_ratio, self.root_reach, self.tip_reach)
        t, first, second = (side * each / reach for each in trochoid.lever_jet(phase))
        rising = (t > 0.0) & (t < 1.0)
        t = np.clip(t, 0.0, 1.0)
        slope = 4.0 * t * (1.0 - t * t)
        bend = np.where(rising | (t == 0.0), 4.0 - 12.0 * t * t, 0.0)
        A = -self.amount
        return RemovalDerivatives(
            A * (1.0 - (1.0 - t * t) ** 2), A * slope * first, A * (bend * first**2 + slope * second)
        )


class Modification(Protocol):
    """One change of the set-up."""

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The profile ground with this change."""
        ...


@dataclass(frozen=True, slots=True)
class Equidistant:
    """Grinding wheel radius r_rp + ``amount`` [mm]: the same removal everywhere (Eq. 13)."""

    amount: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The parallel curve, offset inwards by ``amount``."""
        return replace(profile, pin_radius=profile.pin_radius + self.amount)


@dataclass(frozen=True, slots=True)
class RadialMoving:
    """Pin circle of generation r_p − ``amount`` [mm], exact, with K1' = a z_p/(r_p − amount) (Eq. 14)."""

    amount: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The profile generated on the smaller circle."""
        moved = replace(profile.trochoid, pin_circle_radius=profile.trochoid.pin_circle_radius - self.amount)
        return replace(profile, trochoid=moved)


@dataclass(frozen=True, slots=True)
class FlankRotation:
    """Each flank rotated about the disc's centre by ``angle`` [rad], away from its pin when positive (Eq. 15)."""

    angle: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The profile with each flank rotated by ``angle`` away from its pin: removal a z_c·angle·|sinψ|·S."""
        return _with_flank_removal(profile, profile.trochoid.longest_lever * self.angle)


@dataclass(frozen=True, slots=True)
class DeformationCompensation:
    """The contact deformation δ(ψ) = ``delta_max``·|sinψ|S [mm] added back on both flanks (Eq. 16).

    It ADDS material, hence the removal −δ(ψ): backlash falls by 2 delta_max/(a z_c) and the radial
    clearance stays, because δ vanishes at root and tip.
    """

    delta_max: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The compensated profile."""
        return _with_flank_removal(profile, -self.delta_max)


@dataclass(frozen=True, slots=True)
class RootAndTipRelief:
    """Equidistant removal by ``amount`` [mm] at root and tip alone: the working flank, where |sinψ|·S is at least
    ``root_reach`` or ``tip_reach``, keeps its material (Eq. 97).

    The radial clearance grows by ``amount``, the backlash does not. Raises ``GeometryError`` where applied, unless both
    reaches are between 0 and 1.
    """

    amount: float
    root_reach: float
    tip_reach: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The relieved profile."""
        for reach in (self.root_reach, self.tip_reach):
            if not 0.0 < reach < 1.0:
                remedy = "give the share of the longest lever at which the working flank begins"
                raise GeometryError("reach of the relief", reach, "is outside 0 to 1", remedy)
        ground = Equidistant(self.amount).apply(profile)
        stock = FlankStock(self.amount, self.root_reach, self.tip_reach)
        return replace(ground, removals=(*ground.removals, stock))


def modify(profile: ToothProfile, *modifications: Modification) -> ToothProfile:
    """Apply modifications in sequence; the result is independent of their order.

    Raises ``GeometryError`` if the modified tooth cannot exist (undercut, or a modification larger than the pin).
    """
    for modification in modifications:
        profile = modification.apply(profile)
    return profile


def _with_flank_removal(profile: ToothProfile, amount: float) -> ToothProfile:
    if not math.isfinite(amount):
        raise GeometryError(
            "flank removal", f"{amount} mm", "is not finite", "give an amount in mm, or an angle in rad"
        )
    if amount == 0.0:
        return profile
    return replace(profile, removals=(*profile.removals, FlankRemoval(amount)))


def conjugate_pair(trochoid: Trochoid, radial_clearance: float) -> tuple[Equidistant, RadialMoving]:
    """Pair that keeps the flank nearly conjugate: almost no gap after take-up, so that many pins share load (Eq. 17).

    It has backlash, which a flank rotation or deformation compensation reduces. ``radial_clearance`` Δj at root and
    tip [mm].
    """
    s = math.sqrt(1.0 - trochoid.short_width_ratio**2)
    return Equidistant(radial_clearance / (1.0 - s)), RadialMoving(-radial_clearance * s / (1.0 - s))


def zero_backlash_pair(trochoid: Trochoid, radial_clearance: float) -> tuple[Equidistant, RadialMoving]:
    """Pair with no backlash to first order; fewer pins share the load (Eq. 18). ``radial_clearance`` [mm]."""
    s = math.sqrt(1.0 - trochoid.short_width_ratio**2)
    return Equidistant(-radial_clearance * s / (1.0 - s)), RadialMoving(radial_clearance / (1.0 - s))


def pair_ratios(trochoid: Trochoid) -> tuple[float, float]:
    """Radial-moving over equidistant amount of the conjugate and the zero-backlash pair, −s and −1/s (Eqs. 17, 18)."""
    s = math.sqrt(1.0 - trochoid.short_width_ratio**2)
    return -s, -1.0 / s


def rotation_to_backlash(angle: float) -> float:
    """Backlash that a rotation of each flank by ``angle`` adds, crank locked, to first order: twice the angle [rad].

    A flank removal A at the longest lever is a rotation by A/(a z_c): the deformation compensation δmax takes
    2 δmax/(a z_c) off the backlash (Eq. 40). With the input locked multiply by ``contact.input_locked_factor``.
    """
    return 2.0 * angle
