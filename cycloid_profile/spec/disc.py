"""Keys of the disc's openings: bore, crank holes, output holes, windows, keyways."""

from __future__ import annotations

from typing import Annotated

from cycloid_profile.spec.table import LENGTH, SIZE, Table, key


class HolesSpec(Table, frozen=True):
    """A ring of equal holes through the disc, such as those of the output pins."""

    count: Annotated[int, key("Number of holes.", "give at least 1 hole", ge=1, le=100)]
    circle_radius_mm: Annotated[float, key("Radius of the circle the holes stand on [mm].", LENGTH, **SIZE)]
    radius_mm: Annotated[float, key("Radius of a hole [mm].", LENGTH, **SIZE)]


class WindowsSpec(Table, frozen=True):
    """A ring of equal windows between two radii, with radial sides; slots where the corners are round ends."""

    count: Annotated[int, key("Number of windows.", "give at least 1 window", ge=1, le=100)]
    inner_radius_mm: Annotated[float, key("Radius of the inner edge [mm].", LENGTH, **SIZE)]
    outer_radius_mm: Annotated[float, key("Radius of the outer edge [mm].", LENGTH, **SIZE)]
    span_deg: Annotated[float, key("Angle between the sides of a window [°].", "give an angle in °", gt=0, lt=360)]
    corner_radius_mm: (
        Annotated[
            float,
            key(
                "Radius of the corners [mm]; absent: a quarter of the width, or what fits; half the width makes slots.",
                "give a length in mm, 0 for sharp corners",
                ge=0,
                le=1e4,
            ),
        ]
        | None
    ) = None
    first_at_deg: (
        Annotated[
            float,
            key(
                "Angle of the first window's middle from the x axis [°]; absent: half a pitch, between crank holes.",
                "give an angle in °",
                ge=-360,
                le=360,
            ),
        ]
        | None
    ) = None


class KeywaySpec(Table, frozen=True):
    """Keyways of the bore, with parallel sides and a flat floor."""

    width_mm: Annotated[float, key("Width of the key [mm].", LENGTH, **SIZE)]
    depth_mm: Annotated[
        float, key("Depth from the circle of the bore to the floor, at the middle [mm].", LENGTH, **SIZE)
    ]
    count: Annotated[int, key("Number of keyways, evenly round the bore.", "give 1 keyway", ge=1, le=100)] = 1
    corner_radius_mm: Annotated[
        float,
        key("Radius between floor and sides [mm].", "give a length in mm, 0 for sharp corners", ge=0, le=1e4),
    ] = 0.0
    first_at_deg: Annotated[
        float, key("Angle of the first keyway from the x axis [°].", "give an angle in °", ge=-360, le=360)
    ] = 0.0


class DiscSpec(Table, frozen=True):
    """Openings of the disc; sizes are estimated where absent."""

    bore_radius_mm: Annotated[float, key("Radius of the central bore [mm].", LENGTH, **SIZE)] | None = None
    crank_hole_radius_mm: Annotated[float, key("Radius of the crank holes [mm].", LENGTH, **SIZE)] | None = None
    output_holes: HolesSpec | None = None
    windows: WindowsSpec | None = None
    keyway: KeywaySpec | None = None
