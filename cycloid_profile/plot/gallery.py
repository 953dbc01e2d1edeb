"""All pictures of a design, by file name, with the caption the report prints."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from cycloid_profile.design.record import DesignRecord
from cycloid_profile.plot.accuracy import accuracy_plot
from cycloid_profile.plot.comparison import profile_comparison
from cycloid_profile.plot.convergence import convergence
from cycloid_profile.plot.deformation import deformation
from cycloid_profile.plot.disc import disc_in_pins
from cycloid_profile.plot.load_map import load_map
from cycloid_profile.plot.polar_path import polar_path_plot
from cycloid_profile.plot.sharing import gap_and_force
from cycloid_profile.plot.under_load import under_load

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Picture(NamedTuple):
    """A picture's file name, caption and drawing function; ``format`` it belongs to, None for every design."""

    name: str
    caption: str
    draw: Callable[[DesignRecord], Figure]
    format: str | None = None


PICTURES = (
    Picture(
        "disc_in_pins", "The disc among its pins; colour shows the force on each pin at rated torque.", disc_in_pins
    ),
    Picture("profile_comparison", "Theoretical, modified and compensated tooth along one lobe.", profile_comparison),
    Picture("gap_and_force", "Gap of each pin before load, and its force under load.", gap_and_force),
    Picture("deformation", "Deformation under load, as it is added back to the tooth.", deformation),
    Picture(
        "under_load", "The whole stage at rated torque: force and pressure of the pins, sliding, bearings.", under_load
    ),
    Picture("load_map", "Force and pressure of every pin over one turn of the crank.", load_map),
    Picture("convergence", "How the iterations end.", convergence),
    Picture("accuracy", "Torque against twist, and transmission error over one mesh cycle.", accuracy_plot),
)

FORMAT_PICTURES = (
    Picture(
        "polar_path",
        "Polar grinding: the wheel in the roots, the path of C and X, its feed, its distance from tangency.",
        polar_path_plot,
        "gcode-polar",
    ),
)


def pictures(record: DesignRecord) -> tuple[Picture, ...]:
    """The pictures of a design: all that every one has, and those of the formats its spec asks for."""
    return (*PICTURES, *(picture for picture in FORMAT_PICTURES if picture.format in record.spec.export.formats))
