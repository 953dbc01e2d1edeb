"""Changes of the grinding set-up, each turning one profile into another. Positive removes material."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Protocol

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.modification.flank import FlankRemoval


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
        """The parallel curve ``amount`` further in."""
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
    """Each flank turned about the disc's centre by ``angle`` [rad], away from its pin when positive (Eq. 15)."""

    angle: float

    def apply(self, profile: ToothProfile) -> ToothProfile:
        """The profile with both flanks turned: removal a z_c·angle·|sinψ|S."""
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


def modify(profile: ToothProfile, *modifications: Modification) -> ToothProfile:
    """Apply modifications one after the other; their order does not matter.

    Raises
    ------
    GeometryError
        If the modified tooth cannot exist (undercut, or a modification larger than the pin).
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
