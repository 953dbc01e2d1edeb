"""What a good workshop holds: the tolerances of a drive whose spec names none."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from cycloid_profile.effects.built import Built
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.scatter_tables import tolerances_of


def workshop_tolerances(built: Built) -> Tolerances:
    """What a good workshop holds, for every effect this drive can have: a start where a spec names no tolerances."""
    tables: list[dict[str, Any]] = [
        {"name": "equidistant_error", "each": "disc", "amount_um": {}},
        {"name": "radial_moving_error", "each": "disc", "amount_um": {}},
        {"name": "disc_runout", "each": "disc", "amplitude_um": {}},
        {"name": "cumulative_pitch_error", "each": "disc", "amplitude_um": {}},
        {"name": "single_tooth_error", "each": ["disc", "lobe"], "amount_um": {"plus_minus": 1.0}},
        {"name": "pin_radius_error", "amount_um": {}},
        {"name": "single_pin_error", "each": "pin", "amount_um": {}},
        {"name": "pin_position_error", "each": "pin", "amplitude_um": {}},
        {"name": "pin_circle_radius_error", "amount_um": {}},
        {"name": "pin_ring_runout", "amplitude_um": {}},
        {"name": "pin_ring_cumulative_pitch", "amplitude_um": {}},
    ]
    if built.cranks:
        tables += [
            {"name": "crank_eccentricity_error", "each": ["crank", "disc"], "amount_um": {}},
            {"name": "crank_hole_error", "each": ["crank", "disc"], "amplitude_um": {}},
            {"name": "crank_bearing_clearance", "radial_um": {"mean": 1.0, "plus_minus": 1.0}},
        ]
    return replace(tolerances_of(tables, (), built), assumed=True)
