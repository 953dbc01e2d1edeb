"""Stresses of the pins and life of the crank bearings of a design, with the limits and assumptions of its spec."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile._display import Described, figure_text, finite
from cycloid_profile.contact import (
    BearingLife,
    LoadSharing,
    PinStress,
    RollerSet,
    crank_bearing_life,
    life_factor,
    pin_stress,
    reference_viscosity,
)
from cycloid_profile.design.from_spec import allowable_pressure, bearing_radius, output_speed
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import DiscOutline
from cycloid_profile.spec.model import Spec

# Proportions of needle roller and cage assemblies of medium load, such as 20 × 26 × 13 mm with rollers of 3 mm.
ROLLER_DIAMETER_PER_HOLE_RADIUS = 0.23
ROLLER_LENGTH_PER_WIDTH = 0.75
ROLLER_PITCH_PER_DIAMETER = 1.5

_KEYS = {
    "rollers: count": "drive.crank_bearing.roller_count",
    "rollers: diameter": "drive.crank_bearing.roller_diameter_mm",
    "rollers: length": "drive.crank_bearing.roller_length_mm",
}


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


@dataclass(frozen=True, slots=True, repr=False)
class Strength(Described):
    """Stresses and life under rated torque, with what limits them.

    ``pin`` stresses of the most loaded pin; ``crank_rollers`` None without a seat in the disc; ``life`` None where
    neither a load rating is given nor one can be estimated, and ``rating_estimated`` where it is; ``viscosity_ratio`` κ
    and ``modified_life_h`` [h] NaN without lubricant; ``pressure_limit`` [MPa], None where neither given nor known.
    """

    spec: Spec
    under_load: LoadSharing
    pin: PinStress
    crank_rollers: CrankRollers | None
    life: BearingLife | None
    rating_estimated: bool
    viscosity_ratio: float
    modified_life_h: float
    pressure_limit: float | None

    def figures(self) -> dict[str, Any]:
        """Key figures by JSON key; None where there is no data."""
        rollers = None if self.crank_rollers is None else self.crank_rollers.rollers
        life = self.life
        return {
            "pin_force_n": finite(self.pin.force),
            "pin_shear_mpa": finite(self.pin.shear),
            "pin_bending_mpa": None if self.spec.drive.pin_seat is None else finite(self.pin.bending),
            "crank_bearing": None
            if rollers is None
            else {
                "roller_count": rollers.count,
                "roller_diameter_mm": rollers.diameter,
                "roller_length_mm": rollers.length,
                "pitch_diameter_mm": rollers.pitch_diameter,
                "assumed": list(self.crank_rollers.assumed) if self.crank_rollers else [],
            },
            "dynamic_load_rating_n": None if life is None else life.load_rating,
            "dynamic_load_rating_estimated": self.rating_estimated,
            "equivalent_load_n": None if life is None else finite(float(np.max(life.equivalent_load))),
            "crank_speed_rpm": None if life is None else life.speed_rpm,
            "crank_bearing_life_h": None if life is None else finite(life.least_life_h),
            "all_crank_bearings_life_h": None if life is None else finite(life.life_of_all_h),
            "viscosity_ratio": finite(self.viscosity_ratio),
            "crank_bearing_modified_life_h": finite(self.modified_life_h),
        }

    def _key_figures(self) -> dict[str, str]:
        life = self.life
        return {
            "shear of a pin": figure_text(self.pin.shear, "MPa"),
            "bending of a pin": figure_text(self.pin.bending, "MPa"),
            "dynamic load rating": figure_text(None if life is None else life.load_rating, "N"),
            "life of a crank bearing": figure_text(None if life is None else life.least_life_h, "h"),
            "life of all crank bearings": figure_text(None if life is None else life.life_of_all_h, "h"),
            "assumed": self.crank_rollers.assumption if self.crank_rollers else "no rollers",
        }


def strength_under_load(spec: Spec, under_load: LoadSharing, outline: DiscOutline) -> Strength:
    """Stresses and life of a whole stage ``under_load`` over one turn of the crank.

    Raises ``LoadError`` with the key's name where the rollers of the spec cannot exist.
    """
    seat = spec.drive.pin_seat
    held = crank_rollers(spec, outline)
    given = spec.drive.crank_bearing.dynamic_load_rating_n
    # The rollers run in the disc: ISO 281 rates hardened steel.
    steel = under_load.case.disc_material.is_steel
    estimated = None if held is None or not steel else held.rollers.dynamic_load_rating
    rating = estimated if given is None else given
    life = None if rating is None else crank_bearing_life(under_load, output_speed(spec), rating, equal_bearings=True)
    kappa = math.nan if held is None else _viscosity_ratio(spec, held.rollers)
    factor = math.nan if held is None or life is None else _life_factor(spec, held.rollers, life, kappa)
    return Strength(
        spec=spec,
        under_load=under_load,
        pin=pin_stress(under_load, *((0.0, 0.0) if seat is None else (seat.span_mm, seat.overhang_mm))),
        crank_rollers=held,
        life=life,
        rating_estimated=life is not None and given is None,
        viscosity_ratio=kappa,
        modified_life_h=math.nan if life is None else factor * life.least_life_h,
        pressure_limit=allowable_pressure(spec),
    )


def crank_rollers(spec: Spec, outline: DiscOutline) -> CrankRollers | None:
    """Rollers between crank and disc; sizes that the spec leaves out are assumed. None without a round seat."""
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


def _viscosity_ratio(spec: Spec, rollers: RollerSet) -> float:
    """Viscosity ratio κ; NaN without a lubricant, or at rest."""
    viscosity, speed_rpm = spec.load.lubricant_viscosity_mm2_per_s, spec.load.output_speed_rpm * spec.drive.pins
    if viscosity is None or speed_rpm == 0.0:
        return math.nan
    return viscosity / reference_viscosity(speed_rpm, rollers.pitch_diameter)


def _life_factor(spec: Spec, rollers: RollerSet, life: BearingLife, viscosity_ratio: float) -> float:
    """Life factor a_ISO of the most loaded bearing; NaN without a lubricant."""
    if math.isnan(viscosity_ratio):
        return math.nan
    load_ratio = spec.load.contamination_factor * rollers.fatigue_load_limit / float(np.max(life.equivalent_load))
    return life_factor(viscosity_ratio, load_ratio)


@contextmanager
def _key_names() -> Iterator[None]:
    """Name an impossible roller by the key of the spec file."""
    try:
        yield
    except LoadError as error:
        raise error.renamed(_KEYS.get(error.what, error.what)) from None
