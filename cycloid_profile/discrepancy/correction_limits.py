"""How far, how steeply and how sharply a grinding program may depart from the drawing."""

from __future__ import annotations

from cycloid_profile.discrepancy.departure import Shape
from cycloid_profile.errors import GeometryError
from cycloid_profile.units import UM

LARGEST = 10.0 * UM
# Steeper than this against the drawing, path and wheel no longer touch where they should.
STEEPEST = 0.03  # mm of removal per mm of path


def refuse_beyond(shape: Shape, limit: float, wheel_radius: float) -> None:
    """Refuse a program that departs further than ``limit`` [mm], too steeply, or more sharply than the wheel's radius.

    Raises
    ------
    GeometryError
        With what the program does, and what to do instead.
    """
    if not shape.largest <= limit:
        raise GeometryError(
            "largest correction",
            f"{shape.largest / UM:.2f} µm",
            f"is more than the limit of {limit / UM:g} µm",
            "set the machine right first, or raise --limit-um",
        )
    if not shape.steepest <= STEEPEST:
        raise GeometryError(
            "slope of the correction",
            f"{shape.steepest / UM:.1f} µm/mm",
            f"is more than {STEEPEST / UM:g} µm/mm",
            "no wheel follows that: take the short waves off at their source",
        )
    if not shape.concave >= wheel_radius:
        raise GeometryError(
            "least concave radius of the corrected tooth",
            f"{shape.concave:.4f} mm",
            f"is below the wheel radius {wheel_radius:.4f} mm",
            "take a smaller wheel and tell its radius with --wheel-radius-mm, or set the machine right",
        )
