"""Stresses of the pins and life of the crank bearings of a design, with the limits and assumptions of its spec."""

from __future__ import annotations

import math
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
from cycloid_profile.contact.bodies import RollerBearing, bearing_law
from cycloid_profile.design.crank_rollers import CrankRollers, crank_rollers
from cycloid_profile.design.from_spec import allowable_pressure, output_speed
from cycloid_profile.geometry import CentralEccentric, Cranks, DiscOutline
from cycloid_profile.spec.model import Spec
from cycloid_profile.units import UM


@dataclass(frozen=True, slots=True)
class BearingStiffness:
    """Crank bearing under a force [N]: ``model`` rollers or spring; ``play``, ``displacement`` [mm]; ``tangent`` dF/dr
    [N/mm]; ``passage`` of rollers, their change of force with the angle of the cage, None for a spring.
    """

    model: str
    force: float
    play: float
    displacement: float
    tangent: float
    passage: float | None

    def figures(self) -> dict[str, Any]:
        """Key figures by JSON key; the clearance is diametral, as in ISO 5753-1."""
        return {
            "crank_bearing_model": self.model,
            "crank_bearing_clearance_um": 2.0 * self.play / UM,
            "crank_bearing_displacement_um": finite(self.displacement / UM),
            "crank_bearing_stiffness_n_per_mm": finite(self.tangent),
            "roller_passage_variation": None if self.passage is None else finite(self.passage),
        }


def bearing_stiffness(support: Cranks | CentralEccentric, force: float) -> BearingStiffness:
    """The bearings of a support under a radial ``force`` ≥ 0 [N]."""
    law, play = bearing_law(support), support.bearing_play
    moved = float(law.displacement(force, play))
    tangent = float(law.response(moved, play).tangent)
    if not isinstance(law, RollerBearing):
        return BearingStiffness("spring", force, play, moved, tangent, None)
    # The spring in series carries the same force and is no part of the rollers' own displacement.
    passage = law.passage_variation(moved - law.compliance * force, play)
    return BearingStiffness("rollers", force, play, moved, tangent, passage)


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
