"""Checks of a design: value, limit, remedy and status."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from cycloid_profile._display import figure_text
from cycloid_profile.contact import LoadSharing
from cycloid_profile.contact.mesh import OVERLAP_TOLERANCE, Backlash
from cycloid_profile.design.from_spec import flank_relief, output_sizes, pin_relief
from cycloid_profile.design.strength import Strength
from cycloid_profile.geometry import Drive, ToothProfile, modification_sizes, undercut_limit
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import ARCMIN, DEGREE, UM

THIN_WEB = 1.0  # mm; a thinner one distorts in hardening
# Share of the largest force below which a contact at an edge is harmless.
ACTIVE = 0.01
EDGE_DEGREES = 3.0  # of ψ from root or tip, where a form error of the edge decides the contact
# Share of the pins on the loaded flank; with fewer, the error of one pin determines the load of all.
LEAST_SHARING = 0.2


class CheckStatus(Enum):
    """How a check ended; the value is the word shown."""

    PASSED = "passed"
    ESTIMATED = "passed on assumed data"
    ADVISED_AGAINST = "advised against"
    FAILED = "failed"
    NOT_CHECKED = "not checked"


@dataclass(frozen=True, slots=True)
class Check:
    """One check with its ``value``, ``limit`` and ``remedy``; a failed ``severe`` check means the disc cannot work.

    ``assumed`` names the data behind it that the spec does not give: such a check is never severe. A check for which
    the spec must give more has a ``missing`` key, its remedy says which, and it has not passed.
    """

    name: str
    passed: bool
    value: str
    limit: str
    remedy: str
    severe: bool = True
    assumed: str = ""
    missing: str = ""

    @property
    def status(self) -> CheckStatus:
        """How the check ended."""
        if self.missing:
            return CheckStatus.NOT_CHECKED
        if self.passed:
            return CheckStatus.ESTIMATED if self.assumed else CheckStatus.PASSED
        return CheckStatus.FAILED if self.severe else CheckStatus.ADVISED_AGAINST

    @property
    def sentence(self) -> str:
        """The check in one sentence."""
        basis = f" (estimated: {self.assumed})" if self.assumed else ""
        if self.missing:
            return f"{self.name} = {self.value}{basis}, {self.status.value}: {self.remedy}"
        ending = "" if self.passed else f": {self.remedy}"
        return f"{self.name} = {self.value}{basis}, limit {self.limit}{ending}"


_advice = partial(Check, severe=False)


def shape_checks(drive: Drive, profile: ToothProfile, backlash: Backlash, wall: tuple[float, str]) -> tuple[Check, ...]:
    """Checks of the final tooth without load; ``wall``, thickness [mm] and place of the thinnest web."""
    clearance = sum(modification_sizes(drive, profile))
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
            f"{backlash.least_gap / UM:z.3f} µm",
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
        _advice(
            f"thinnest web ({place})",
            thickness >= THIN_WEB,
            f"{thickness:.3f} mm",
            f"at least {THIN_WEB:g} mm",
            "make the holes smaller",
        ),
    )


def output_hole_checks(spec: Spec) -> tuple[Check, ...]:
    """Check of the clearance left between output holes and rollers; nothing without output holes."""
    sizes, holes = output_sizes(spec), spec.disc.output_holes
    if sizes is None or holes is None:
        return ()
    clearance = (sizes[0] - sizes[1] - spec.drive.eccentricity_mm) / UM
    return (
        Check(
            "clearance of the output rollers",
            clearance >= holes.clearance_um - 1e-6,
            f"{clearance:z.3f} µm",
            f"at least {holes.clearance_um:g} µm",
            "the rollers would bind, make the holes larger or the rollers smaller",
        ),
    )


def load_checks(under_load: LoadSharing) -> tuple[Check, ...]:
    """Checks of the load sharing at rated torque, none of them severe."""
    flank = under_load.phase[under_load.force > ACTIVE * under_load.max_force] / DEGREE
    low, high = float(np.min(flank, initial=180.0)), float(np.max(flank, initial=0.0))
    pins = (under_load.case.drive.trochoid.pins - 1) // 2
    wanted = max(2, math.ceil(LEAST_SHARING * pins))
    law = under_load.case.law
    contact = under_load.case.line_contact(under_load.curvature)
    outside = under_load.loaded & ~law.within_range(under_load.force, contact)
    return (
        _advice(
            "active flank",
            low >= EDGE_DEGREES and high <= 180.0 - EDGE_DEGREES,
            f"ψ = {low:.1f}° to {high:.1f}°",
            f"{EDGE_DEGREES:g}° to {180.0 - EDGE_DEGREES:g}°",
            "pins press on the edge of the flank at root or tip, raise the radial clearance",
        ),
        _advice(
            "pins of a disc that share the load",
            under_load.fewest_loaded_pins >= wanted,
            f"{under_load.fewest_loaded_pins} to {under_load.loaded_pins} of {pins}, "
            f"{pins - under_load.loaded_pins} idle at best",
            f"at least {wanted} at every pose",
            "lower the radial clearance, or take the conjugate pair of modifications",
        ),
        _advice(
            f"contact law ({law.name})",
            not np.any(outside),
            f"{np.count_nonzero(outside)} of {np.count_nonzero(under_load.loaded)} contacts outside its range",
            f"made for {law.validity}",
            "take another contact_law, johnson for unlike bodies, or lower the torque",
        ),
    )


def strength_checks(strength: Strength) -> tuple[Check, ...]:
    """Checks of stresses and life at rated torque; severe where the spec gives torque, limit and all other data."""
    return (
        _pressure_check(strength),
        *_relief_check(strength),
        _pin_shear_check(strength),
        _pin_bending_check(strength),
        _life_check(strength),
        _lubrication_check(strength),
    )


def _pressure_check(strength: Strength) -> Check:
    loaded, limit = strength.under_load, strength.pressure_limit
    pressure = loaded.max_edge_pressure
    value = f"{pressure:.0f} MPa"
    if loaded.case.width is not None:
        value += f" over the face width, {loaded.max_pressure:.0f} MPa under an even load"
    if limit is None:
        return _not_checked("peak pressure", value, "load.allowable_pressure_mpa")
    given = strength.spec.load.allowable_pressure_mpa is not None
    return _of_given_data(
        strength,
        "" if given else "limit of hardened bearing steel",
        "peak pressure",
        pressure <= limit,
        value,
        f"at most {limit:.0f} MPa",
        "widen the disc, lower the torque, or let more pins share",
    )


def _relief_check(strength: Strength) -> tuple[Check, ...]:
    """States that the load ignores a relief; nothing where there is none, or slices count it."""
    spec = strength.spec
    if strength.under_load.case.width is not None or not (flank_relief(spec) or pin_relief(spec)):
        return ()
    return (_not_checked("relief along the face width", "not in the load", "load.width_slices (8 are enough)"),)


def _pin_shear_check(strength: Strength) -> Check:
    pin, limit = strength.pin, strength.spec.load.allowable_pin_stress_mpa
    name, value = "pin shear, von Mises", f"{pin.equivalent_shear:.0f} MPa"
    if limit is None:
        return _not_checked(name, value, "load.allowable_pin_stress_mpa")
    remedy = "take thicker pins or lower the torque"
    return _of_given_data(strength, "", name, pin.equivalent_shear <= limit, value, f"at most {limit:.0f} MPa", remedy)


def _pin_bending_check(strength: Strength) -> Check:
    pin, limit, seat = strength.pin, strength.spec.load.allowable_pin_stress_mpa, strength.spec.drive.pin_seat
    name, value = "pin bending", f"{pin.bending:.0f} MPa"
    if seat is None:
        key = "drive.pin_seat.span_mm (0 for a whole groove)"
        return _not_checked(name, value, key, "pins seated along their length")
    if limit is None:
        return _not_checked(name, value, "load.allowable_pin_stress_mpa")
    remedy = "shorten drive.pin_seat.span_mm or overhang_mm, or take thicker pins"
    return _of_given_data(strength, "", name, pin.bending <= limit, value, f"at most {limit:.0f} MPa", remedy)


def _life_check(strength: Strength) -> Check:
    name, life, required = "life of a crank bearing", strength.life, strength.spec.load.required_life_h
    if life is None:
        return _not_checked(name, figure_text(None), "drive.crank_bearing.dynamic_load_rating_n")
    if life.speed_rpm == 0.0:
        return _not_checked(name, "at rest", "load.output_speed_rpm")
    value = f"{life.least_life_h:.0f} h"
    held = strength.crank_rollers
    sizes = "" if held is None or not strength.rating_estimated else held.assumption or "C by ISO 281 from the rollers"
    if required is None:
        return _not_checked(name, value, "load.required_life_h", sizes)
    return _of_given_data(
        strength,
        sizes,
        name,
        life.least_life_h >= required,
        value,
        f"at least {required:.0f} h",
        "take a bearing of larger drive.crank_bearing.dynamic_load_rating_n, or lower torque or speed",
    )


def _lubrication_check(strength: Strength) -> Check:
    name, kappa = "viscosity ratio κ, crank bearings", strength.viscosity_ratio
    if strength.spec.load.lubricant_viscosity_mm2_per_s is None:
        return _not_checked(name, figure_text(None), "load.lubricant_viscosity_mm2_per_s")
    if not math.isfinite(kappa):
        at_rest = strength.spec.load.output_speed_rpm == 0.0
        key = "load.output_speed_rpm" if at_rest else "disc.crank_hole_radius_mm"
        return _not_checked(name, figure_text(None), key)
    # A film of mixed friction is common in grease: never severe.
    return _advice(
        name,
        kappa >= 1.0,
        f"{kappa:.2f}, modified life {figure_text(strength.modified_life_h, 'h')}",
        "at least 1",
        "take a thicker oil, or one with additives against wear",
        assumed=strength.crank_rollers.assumption if strength.crank_rollers else "",
    )


def _not_checked(name: str, value: str, key: str, assumed: str = "") -> Check:
    return _advice(name, False, value, "none given", f"give {key}", assumed=assumed, missing=key)


def _of_given_data(
    strength: Strength, assumed: str, name: str, passed: bool, value: str, limit: str, remedy: str
) -> Check:
    """A check that is severe unless something behind it is ``assumed``, or the torque is."""
    torque = "" if strength.spec.load.rated_torque_nm is not None else "rated torque from the size"
    basis = ", ".join(each for each in (assumed, torque) if each)
    return Check(name, passed, value, limit, remedy, severe=not basis, assumed=basis)
