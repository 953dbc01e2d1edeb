"""Pictures of every design and of the formats its spec asks for; loads no room but that of designs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from cycloid_profile.design import DesignRecord
from cycloid_profile.plot import design


class Picture(NamedTuple):
    """A picture's file name, caption and drawing function; ``format`` it belongs to, None for every design; ``sliced``
    for designs with slices over the face width alone.
    """

    name: str
    caption: str
    draw: Callable[[DesignRecord], Any]
    format: str | None = None
    sliced: bool = False


PICTURES = (
    Picture(
        "disc_in_pins", "The disc among its pins; colour shows the force on each pin at rated torque.", design.disc
    ),
    Picture(
        "profile_comparison", "Theoretical, modified and compensated tooth along one lobe.", design.profile_comparison
    ),
    Picture("gap_and_force", "Gap of each pin before load, and its force under load.", design.load_sharing),
    Picture("deformation", "Deformation under load, as it is added back to the tooth.", design.deformation),
    Picture(
        "under_load",
        "The whole stage at rated torque: force and pressure of the pins, sliding, bearings.",
        design.stage_load,
    ),
    Picture("load_map", "Force and pressure of every pin over one turn of the crank.", design.load_map),
    Picture(
        "pressure_over_width", "Pressure on the pins over the face width.", design.pressure_over_width, sliced=True
    ),
    Picture("convergence", "How the iterations end.", design.convergence),
    Picture("accuracy", "Torque against twist, and transmission error over one cycle.", design.accuracy),
    Picture(
        "polar_path",
        "Polar grinding: the wheel in the roots, the path of C and X, its feed, its distance from tangency.",
        design.polar_path,
        "gcode-polar",
    ),
)


def pictures(record: DesignRecord) -> tuple[Picture, ...]:
    """The pictures of every design, and those of the formats and slices its spec asks for."""
    formats, sliced = record.spec.export.formats, record.case.width is not None
    return tuple(
        one for one in PICTURES if (one.format is None or one.format in formats) and (sliced or not one.sliced)
    )
