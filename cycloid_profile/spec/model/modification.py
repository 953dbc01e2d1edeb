"""Keys of `[modification]`, and the names of the effects under `[[effects]]`."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta

from cycloid_profile.spec.model.checks._table import Table, key, relief, relief_length, taper

_AMOUNTS = {"ge": -1e4, "le": 1e4}  # µm
_AMOUNT = "give an amount in µm, positive removes material"


class ModificationSpec(Table, frozen=True):
    """How the ground tooth differs from the theoretical one. Positive removes material."""

    equidistant_um: Annotated[
        float, key("Wheel radius larger than the pin by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    radial_moving_um: Annotated[
        float, key("Pin circle of generation smaller by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    rotation_arcmin: Annotated[
        float,
        key("Rotation of each flank away from its pin [arc minutes].", "give an angle in arc minutes", ge=-60, le=60),
    ] = 0.0
    deformation_compensation: Annotated[
        bool | float,
        key("true: from the load; false: none; a number: delta_max [µm].", "give true, false or delta_max in µm"),
    ] = False
    compensation_solver: (
        Annotated[
            Literal["equilibrium", "classical", "stage"],
            key("Which load sharing finds delta_max; absent: stage, for rigid discs equilibrium.", ""),
        ]
        | None
    ) = None
    compensation_load_share: Annotated[
        float,
        key("Share of the rated torque whose deformation is compensated.", "give 1 for the rated torque", gt=0, le=3),
    ] = 1.0
    crowning_um: Annotated[
        float, relief("Crowning of the flanks: removed at both edges, a parabola over the width [µm].")
    ] = 0.0
    edge_relief_um: Annotated[
        float, relief("Further removed at both edges of the flanks [µm]; over edge_relief_length_mm.")
    ] = 0.0
    edge_relief_length_mm: Annotated[
        float, relief_length("Length before each edge over which the edge relief of the flanks runs out [mm].")
    ] = 0.0
    flank_taper_um: Annotated[
        float, taper("Taper of the flanks over the width, more removed at the upper edge if positive [µm].")
    ] = 0.0


EFFECT_NAMES = frozenset({
    # process
    "equidistant_error", "radial_moving_error", "generating_eccentricity_error", "thermal_growth", "disc_runout",
    "disc_oval", "cumulative_pitch_error", "wheel_wear_drift", "grinding_chatter", "tooth_form_error",
    "missing_deformation_compensation", "flank_wear", "single_tooth_error",
    # ring
    "pin_radius_error", "pin_circle_radius_error", "pin_ring_runout", "pin_ring_oval", "pin_ring_three_lobed",
    "ring_mounting_ovality", "pin_ring_cumulative_pitch", "single_pin_error", "pin_position_error",
    # crank and body
    "crank_eccentricity_error", "crank_phase_error", "crank_hole_error", "crank_bearing_clearance",
    "carrier_bore_error", "series_compliance", "nonlinear_series_compliance", "viscoelastic_creep",
    "crank_bearing_compliance", "pin_support_compliance",
    # friction, drive train and sensor
    "coulomb_friction", "elastoslide_friction", "stribeck_friction", "load_proportional_friction", "planet_runout",
    "common_planet_runout", "sun_runout", "input_runout", "encoder_eccentricity",
})  # fmt: skip
# Editors complete the name from the schema; the parameters of each effect are checked when it is built.
_NAMED = {"properties": {"name": {"enum": sorted(EFFECT_NAMES)}}, "required": ["name"]}
EffectTable = Annotated[dict[str, Any], Meta(extra_json_schema=_NAMED)]
