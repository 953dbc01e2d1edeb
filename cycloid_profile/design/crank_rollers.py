"""Rollers between crank and disc: their sizes, their radial clearance, and the support of the discs that they make."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace

from cycloid_profile.contact import RollerSet
from cycloid_profile.contact.bodies import RollerBearing, clearance_range, roller_constant
from cycloid_profile.contact.laws import STEEL, Material
from cycloid_profile.errors import LoadError, SpecError
from cycloid_profile.geometry import Arc, CentralEccentric, Cranks, DiscOutline
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM

# Proportions of needle roller and cage assemblies of medium load, such as 20 × 26 × 13 mm with rollers of 3 mm.
ROLLER_DIAMETER_PER_HOLE_RADIUS = 0.23
ROLLER_LENGTH_PER_WIDTH = 0.75
ROLLER_PITCH_PER_DIAMETER = 1.5

_TABLE = "drive.crank_bearing"
_KEYS = {
    "rollers: count": f"{_TABLE}.roller_count",
    "rollers: diameter": f"{_TABLE}.roller_diameter_mm",
    "rollers: length": f"{_TABLE}.roller_length_mm",
    "clearance class: bore": f"{_TABLE}.clearance_class: bore",
}
_CLEARANCES = ("clearance_class", "radial_clearance_um", "preload_um")


@dataclass(frozen=True, slots=True)
class CrankRollers:
    """``rollers`` of a crank bearing, and which of their sizes the spec leaves open: ``assumed``, empty for none."""

    rollers: RollerSet
    assumed: tuple[str, ...]

    @property
    def assumption(self) -> str:
        """The assumed sizes as a clause, empty where all are given."""
        if not self.assumed:
            return ""
        r = self.rollers
        return f"{r.count} rollers of {r.diameter:.3g} mm × {r.length:.3g} mm ({', '.join(self.assumed)} assumed)"


def bearing_radius(outline: DiscOutline) -> float:
    """Seat radius of a crank bearing: that of a crank hole, or of the bore of a central eccentric [mm]."""
    held = [hole.radius for hole in outline.holes if hole.name.startswith("crank hole")]
    for contour in outline.contours:
        if contour.name == "bore":
            held += [arc.radius for arc in contour.segments if isinstance(arc, Arc) and arc.centre == 0j]
    return held[0] if held else 0.0


def crank_rollers(spec: Spec, outline: DiscOutline) -> CrankRollers | None:
    """Rollers between crank and disc; sizes that the spec leaves out are assumed. None without a round seat.

    Raises ``LoadError`` with the key's name where the rollers of the spec cannot exist.
    """
    given, hole = spec.drive.crank_bearing, bearing_radius(outline)
    if hole <= 0.0:
        return None
    sizes = {
        "diameter": given.roller_diameter_mm or ROLLER_DIAMETER_PER_HOLE_RADIUS * hole,
        "length": given.roller_length_mm or ROLLER_LENGTH_PER_WIDTH * spec.drive.disc_width_mm,
    }
    pitch_diameter = 2.0 * hole - sizes["diameter"]
    count = given.roller_count or int(math.pi * pitch_diameter / (ROLLER_PITCH_PER_DIAMETER * sizes["diameter"]))
    named = {"count": given.roller_count, "diameter": given.roller_diameter_mm, "length": given.roller_length_mm}
    with _key_names():
        rollers = RollerSet(count, sizes["diameter"], sizes["length"], pitch_diameter)
    return CrankRollers(rollers, tuple(name for name, value in named.items() if value is None))


def carried_by_rollers(spec: Spec) -> bool:
    """Whether the stage takes the crank bearings as rollers; a spring otherwise.

    Raises ``SpecError`` if more than one clearance is given, or one with a spring.
    """
    given = spec.drive.crank_bearing
    clearances = [name for name in _CLEARANCES if getattr(given, name) is not None]
    if len(clearances) > 1:
        next_to = f"stands next to {clearances[0]}"
        raise SpecError(f"{_TABLE}.{clearances[1]}", "given", next_to, "give one of them", " ")
    if clearances and given.model == "spring":
        remedy = "set model to rollers, or give drive.cranks.bearing_play_um"
        raise SpecError(f"{_TABLE}.{clearances[0]}", "given", "has no meaning for a spring", remedy, " ")
    return given.model == "rollers" or bool(clearances)


def on_rollers(
    spec: Spec, support: Cranks | CentralEccentric, outline: DiscOutline, disc: Material
) -> Cranks | CentralEccentric:
    """The support with its rollers and their clearance, which adds to the play that it has.

    The rollers run on a steel crank and in the disc. The clearance is diametral, half of it is play; the middle of
    its range for a class, by the diameter of the crank; zero where the spec leaves it out.

    Raises
    ------
    SpecError
        If the disc has no round seat for rollers.
    LoadError
        If the rollers or the clearance class cannot exist.
    """
    held = crank_rollers(spec, outline)
    if held is None:
        remedy = "give disc.crank_hole_radius_mm or disc.bore_radius_mm"
        raise SpecError(f"{_TABLE}.model", "rollers", "need a round seat in the disc", remedy, " ")
    rollers = held.rollers
    law = RollerBearing(rollers.count, roller_constant(rollers.length, STEEL, disc))
    with _key_names():
        clearance = radial_clearance(spec, rollers)
    return replace(support, rollers=law, bearing_play=support.bearing_play + 0.5 * clearance)


def radial_clearance(spec: Spec, rollers: RollerSet) -> float:
    """Radial internal clearance as ISO 5753-1 defines it, diametral; negative for a preload [mm]."""
    given = spec.drive.crank_bearing
    if given.clearance_class is not None:
        return 0.5 * sum(clearance_range(2.0 * rollers.inner_raceway_radius, given.clearance_class)) * UM
    return ((given.radial_clearance_um or 0.0) - (given.preload_um or 0.0)) * UM


@contextmanager
def _key_names() -> Iterator[None]:
    """Name an impossible roller by the key of the spec file."""
    try:
        yield
    except LoadError as error:
        raise error.renamed(_KEYS.get(error.what, error.what)) from None
