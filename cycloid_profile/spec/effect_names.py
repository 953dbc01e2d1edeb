"""Names of the effects a spec file may hold under ``[[effects]]``."""

from __future__ import annotations

EFFECT_NAMES = frozenset(
    {
        # process
        "equidistant_error",
        "radial_moving_error",
        "generating_eccentricity_error",
        "thermal_growth",
        "disc_runout",
        "disc_oval",
        "cumulative_pitch_error",
        "wheel_wear_drift",
        "grinding_chatter",
        "missing_deformation_compensation",
        "flank_wear",
        "single_tooth_error",
        # ring
        "pin_radius_error",
        "pin_circle_radius_error",
        "pin_ring_runout",
        "pin_ring_oval",
        "pin_ring_cumulative_pitch",
        "single_pin_error",
        "pin_position_error",
        # crank and body
        "crank_eccentricity_error",
        "crank_phase_error",
        "crank_hole_error",
        "crank_bearing_clearance",
        "series_compliance",
        "crank_bearing_compliance",
        "pin_support_compliance",
        # friction, drive train and sensor
        "coulomb_friction",
        "load_proportional_friction",
        "planet_runout",
        "encoder_eccentricity",
    }
)
