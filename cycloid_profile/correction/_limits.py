"""Limits of a grinding program: deviation from the drawing, slope, and concave radius."""

from __future__ import annotations

from cycloid_profile.correction._deviation import DeviationFigures
from cycloid_profile.errors import GeometryError
from cycloid_profile.units import UM

LARGEST = 10.0 * UM  # first-order removals are exact to 0.03 µm up to here
# Beyond this slope, path and wheel no longer touch at the intended points.
MAX_SLOPE = 0.03  # mm of removal per mm of path


def check_limits(shape: DeviationFigures, limit: float, wheel_radius: float) -> None:
    """Check that a program is manufacturable: deviation within ``limit`` [mm], slope, and concave radius of the wheel
    [mm].

    Raises
    ------
    GeometryError
        With the value, the limit and the remedy.
    """
    if not shape.largest <= limit:
        raise GeometryError(
            "largest correction",
            f"{shape.largest / UM:.2f} µm",
            f"is more than the limit of {limit / UM:g} µm",
            "correct the machine first, or raise --limit-um",
        )
    if not shape.max_slope <= MAX_SLOPE:
        raise GeometryError(
            "slope of the correction",
            f"{shape.max_slope / UM:.1f} µm/mm",
            f"is more than {MAX_SLOPE / UM:g} µm/mm",
            "no wheel follows that: remove the cause of the short waves",
        )
    if not shape.least_concave_radius >= wheel_radius:
        raise GeometryError(
            "least concave radius of the corrected tooth",
            f"{shape.least_concave_radius:.4f} mm",
            f"is below the wheel radius {wheel_radius:.4f} mm",
            "use a smaller wheel and give its radius with --wheel-radius-mm, or correct the machine",
        )
