"""The key figures of a design as rows of a table."""

from __future__ import annotations

from typing import Any

from cycloid_profile.cli.terminal import warn
from cycloid_profile.design.summary import shown

_ACCURACY = (
    ("backlash, crank held [′]", "backlash_arcmin"),
    ("backlash, input held [′]", "backlash_input_locked_arcmin"),
    ("lost motion at ±3 % torque [′]", "lost_motion_arcmin"),
    ("torsional rigidity, 50–100 % [N·m/′]", "torsional_rigidity_nm_per_arcmin"),
    ("transmission error, rated torque [″]", "transmission_error_arcsec"),
)
_LOAD = (
    ("largest pin force [N]", "max_force_n"),
    ("deformation δmax [µm]", "delta_max_um"),
    ("loaded pins", "loaded_pins"),
    ("peak pressure [MPa]", "max_pressure_mpa"),
)
_AS_BUILT = (
    ("lost motion, largest of a turn [′]", "lost_motion_arcmin"),
    ("lost motion, mean [′]", "lost_motion_mean_arcmin"),
    ("hysteresis loss [′]", "hysteresis_loss_arcmin"),
    ("torsional rigidity, 50–100 % [N·m/′]", "torsional_rigidity_nm_per_arcmin"),
    ("transmission error, rated torque [″]", "transmission_error_arcsec"),
)
_STAGE = (
    ("largest pin force [N]", "max_force_n"),
    ("peak pressure [MPa]", "max_pressure_mpa"),
    ("shear under the surface [MPa]", "max_subsurface_shear_mpa"),
    ("fewest loaded pins of a disc", "fewest_loaded_pins"),
    ("largest crank bearing force [N]", "max_bearing_force_n"),
    ("tangent torsional stiffness [N·m/′]", "torsional_stiffness_nm_per_arcmin"),
    ("fastest sliding of a loaded pin [mm/s]", "max_sliding_speed_mm_per_s"),
    ("mesh loss, estimate [W]", "mesh_loss_w"),
    ("crank bearing loss, estimate [W]", "bearing_loss_w"),
    ("efficiency of this stage, estimate", "efficiency"),
)


def accuracy_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, conventional, compensated."""
    return [
        (label, shown(figures["conventional"][key]), shown(figures["compensated"][key])) for label, key in _ACCURACY
    ]


def load_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, classical, equilibrium."""
    return [(label, shown(figures["classical"][key]), shown(figures["equilibrium"][key])) for label, key in _LOAD]


def as_built_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, value of the reducer with its effects; none without."""
    found = figures["as_built"]
    return [] if found is None else [(label, shown(found[key])) for label, key in _AS_BUILT]


def stage_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, value of the whole stage under load."""
    return [(label, shown(figures["under_load"][key])) for label, key in _STAGE]


def closing_words(figures: dict[str, Any]) -> int:
    """Say on stderr what a reader must know and what failed; returns the exit status."""
    if figures["rated_torque_assumed"]:
        torque = shown(figures["rated_torque_nm"])
        warn(f"load.rated_torque_nm is not given: {torque} N·m is assumed from the size")
    for check in figures["checks"]:
        if not (check["passed"] or check["severe"]):
            warn(f"advice: {check['sentence']}")
    for failure in figures["failures"]:
        warn(failure)
    return 1 if figures["failures"] else 0
