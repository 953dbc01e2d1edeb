"""Checks of a design: what was found, the limit, and what to do."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.contact.backlash import OVERLAP_TOLERANCE, Backlash
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.geometry.drive import Drive, set_up_amounts
from cycloid_profile.geometry.profile import ToothProfile, undercut_limit
from cycloid_profile.units import ARCMIN, DEGREE, UM

THIN_WEB = 1.0  # mm
# A contact with less than this share of the largest force does no harm at an edge.
ACTIVE = 0.01
EDGE_DEGREES = 3.0
# Of the pins on the loaded flank; with fewer, one pin's error decides the load of all.
LEAST_SHARING = 0.2


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


def shape_checks(drive: Drive, profile: ToothProfile, backlash: Backlash, wall: tuple[float, str]) -> tuple[Check, ...]:
    """Checks of the tooth that would be ground, before any load; ``wall`` as ``least_web`` finds it."""
    clearance = sum(set_up_amounts(drive, profile))
    thickness, place = wall
    limit = undercut_limit(profile.trochoid)
    return (
        Check(
            "backlash",
            not backlash.binds,
            f"{backlash.least / ARCMIN:.4f}′",
            "at least 0′",
            "the drive would bind, raise equidistant_um or lower the compensation",
        ),
        Check(
            "gap left midway between the flanks",
            backlash.least_gap >= -OVERLAP_TOLERANCE,
            f"{_no_minus_zero(backlash.least_gap / UM):.3f} µm",
            f"at least -{OVERLAP_TOLERANCE / UM:g} µm at every pose",
            "pin and disc overlap whatever the rotation, raise equidistant_um or lower the compensation",
        ),
        Check(
            "radial clearance",
            clearance >= -1e-9,
            f"{clearance / UM:.3f} µm",
            "at least 0 µm",
            "root and tip would press on the pins, raise equidistant_um + radial_moving_um",
        ),
        Check(
            "generating pin radius",
            profile.pin_radius < limit,
            f"{profile.pin_radius:.4f} mm",
            f"below {limit:.4f} mm, where the tooth is undercut",
            "take thinner pins or a smaller eccentricity",
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


def load_checks(under_load: LoadSharing, allowable_pressure: float | None) -> tuple[Check, ...]:
    """Checks at rated torque; all of them advice, for the disc turns all the same."""
    flank = under_load.phase[under_load.force > ACTIVE * under_load.max_force] / DEGREE
    low, high = float(np.min(flank, initial=180.0)), float(np.max(flank, initial=0.0))
    pins = (under_load.case.drive.trochoid.pins - 1) // 2
    wanted = max(2, math.ceil(LEAST_SHARING * pins))
    checks = [
        Check(
            "active flank",
            low >= EDGE_DEGREES and high <= 180.0 - EDGE_DEGREES,
            f"ψ = {low:.1f}° to {high:.1f}°",
            f"{EDGE_DEGREES:g}° to {180.0 - EDGE_DEGREES:g}°",
            "pins press on the edge of the flank at root or tip, raise the radial clearance",
            severe=False,
        ),
        Check(
            "pins of a disc that share the load",
            under_load.fewest_loaded_pins >= wanted,
            f"{under_load.fewest_loaded_pins} to {under_load.loaded_pins} of {pins}, "
            f"{pins - under_load.loaded_pins} idle at best",
            f"at least {wanted} at every pose",
            "lower the radial clearance, or take the conjugate pair of modifications",
            severe=False,
        ),
    ]
    law = under_load.case.law
    contact = under_load.case.line_contact(under_load.curvature)
    outside = under_load.loaded & ~law.within_range(under_load.force, contact)
    checks.append(
        Check(
            f"contact law ({law.name})",
            not np.any(outside),
            f"{np.count_nonzero(outside)} of {np.count_nonzero(under_load.loaded)} contacts outside its range",
            f"made for {law.validity}",
            "take another contact_law, or lower the torque",
            severe=False,
        )
    )
    if allowable_pressure is not None:
        checks.append(
            Check(
                "peak pressure",
                under_load.max_pressure <= allowable_pressure,
                f"{under_load.max_pressure:.0f} MPa",
                f"at most {allowable_pressure:.0f} MPa",
                "widen the disc, lower the torque, or let more pins share",
                severe=False,
            )
        )
    return tuple(checks)


def _no_minus_zero(value: float) -> float:
    """Rounding errors of a perfect fit as the zero they are."""
    return 0.0 if abs(value) < 5e-4 else value
