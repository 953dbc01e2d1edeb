"""The key figures of a design as rows of a table."""

from __future__ import annotations

from typing import Any

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


def accuracy_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, conventional, compensated."""
    return [
        (label, shown(figures["conventional"][key]), shown(figures["compensated"][key])) for label, key in _ACCURACY
    ]


def load_rows(figures: dict[str, Any]) -> list[tuple[str, ...]]:
    """Rows label, classical, equilibrium."""
    return [(label, shown(figures["classical"][key]), shown(figures["equilibrium"][key])) for label, key in _LOAD]


def shown(value: float | None) -> str:
    """Four significant digits, a dash for no number."""
    # Rounding errors of a perfect fit are shown as the zero they are.
    return "–" if value is None else f"{0.0 if abs(value) < 1e-9 else value:.4g}"


def remarks(figures: dict[str, Any]) -> list[str]:
    """What a reader must know about the figures: assumed torque, effects left out."""
    said = []
    if figures["rated_torque_assumed"]:
        said.append(f"load.rated_torque_nm is not given: {figures['rated_torque_nm']:.4g} N·m is assumed from the size")
    if figures["effects_not_simulated"]:
        said.append(f"kept in the spec but not simulated yet: {', '.join(figures['effects_not_simulated'])}")
    return said
