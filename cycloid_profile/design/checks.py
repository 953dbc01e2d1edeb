"""Checks of a design: what was found, the limit, and what to do."""

from __future__ import annotations

from dataclasses import dataclass

from cycloid_profile.contact.backlash import Backlash
from cycloid_profile.geometry.drive import Drive, set_up_amounts
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.units import ARCMIN, UM

THIN_WEB = 1.0  # mm


@dataclass(frozen=True, slots=True)
class Check:
    """One check: ``passed``, or the reason why not in ``value``, ``limit`` and ``remedy``.

    A failed ``severe`` check means the disc cannot work; any other is advice.
    """

    name: str
    passed: bool
    value: str
    limit: str
    remedy: str
    severe: bool = True

    @property
    def sentence(self) -> str:
        """The check in one sentence."""
        ending = "" if self.passed else f": {self.remedy}"
        return f"{self.name} = {self.value}, limit {self.limit}{ending}"


def design_checks(
    drive: Drive, profile: ToothProfile, backlash: Backlash, wall: tuple[float, str]
) -> tuple[Check, ...]:
    """All checks of the profile that would be ground; ``wall`` as ``least_web`` finds it."""
    clearance = sum(set_up_amounts(drive, profile))
    thickness, place = wall
    return (
        Check(
            "backlash",
            not backlash.binds,
            f"{backlash.least / ARCMIN:.4f}′",
            "at least 0′",
            "the drive would bind, raise equidistant_um or lower the compensation",
        ),
        Check(
            "radial clearance",
            clearance >= -1e-9,
            f"{clearance / UM:.3f} µm",
            "at least 0 µm",
            "root and tip would press on the pins, raise equidistant_um + radial_moving_um",
        ),
        Check(
            f"thinnest web ({place})",
            thickness >= THIN_WEB,
            f"{thickness:.3f} mm",
            f"at least {THIN_WEB:g} mm",
            "make the holes smaller",
            severe=False,
        ),
    )
