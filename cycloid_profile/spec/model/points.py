"""Keys of `[export.points]` and `[export.form_wheel]`: point files of any layout, and the profile of a form wheel."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.model.checks._table import SIZE, Table, key

_LINE = {"max_length": 200, "pattern": r"^[\x20-\x7e]*$"}


class PointsSpec(Table, frozen=True):
    """A further point file, written with `csv`. Without a number of points they are as dense as chords need."""

    file: Annotated[
        str,
        key(
            "Name of the file.",
            "give a name that begins with points, such as points.txt",
            max_length=60,
            pattern=r"^points[A-Za-z0-9._-]*$",
        ),
    ] = "points.txt"
    total: Annotated[int, key("Number of all points.", "give 3 to 1000000", ge=3, le=1_000_000)] | None = None
    per_lobe: Annotated[int, key("Points on each lobe.", "give 3 to 20000", ge=3, le=20_000)] | None = None
    range: Annotated[Literal["disc", "gap"], key("Whole disc, or the gap at lobe 1 from tip to tip.", "")] = "disc"
    start: Annotated[Literal["root", "tip"], key("First point of a whole disc.", "")] = "root"
    sense: Annotated[Literal["clockwise", "anticlockwise"], key("Order of the points.", "")] = "clockwise"
    closed: Annotated[bool, key("Repeat the first point of a whole disc at the end.", "")] = False
    coordinates: Annotated[Literal["cartesian", "polar"], key("Columns x, y, z, or radius, angle [°], z.", "")] = (
        "cartesian"
    )
    z_mm: Annotated[float, key("Third coordinate of all points [mm].", "give a height", ge=-1e4, le=1e4)] = 0.0
    header: Annotated[bool, key("A first line with the names of the columns.", "")] = False
    separator: Annotated[
        Literal[",", ";", " ", "\t"], key("Between the columns: comma, semicolon, blank or tabulator.", "")
    ] = ","
    decimals: Annotated[int, key("Decimals of all numbers.", "give 3 to 12", ge=3, le=12)] = 6
    template: (
        Annotated[
            str,
            key(
                "Line of a point in place of columns, such as `N{n} X{x:.4f} Y{y:.4f}`, with n, x, y, z, r, angle, "
                "nx, ny.",
                "give a line in ASCII",
                **_LINE,
            ),
        ]
        | None
    ) = None


class FormWheelSpec(Table, frozen=True, kw_only=True):
    """Profile of a form wheel that grinds one gap, and path of its dresser; written with `csv`."""

    wheel_radius_mm: Annotated[float, key("Largest radius of the wheel, at the root [mm].", "give a radius", **SIZE)]
    inclination_deg: Annotated[
        float, key("Swivel of the wheel out of the transverse plane [°].", "give -30 to 30", ge=-45, le=45)
    ] = 0.0
    dresser_radius_mm: Annotated[
        float, key("Radius of the dresser's tip, 0 for a sharp one [mm].", "give 0 to 5", ge=0, le=100)
    ] = 0.0
    template: (
        Annotated[
            str,
            key(
                "Line of a point in place of columns, such as `N{n} X{x:.4f} Z{z:.4f}`: n, x radius and z along the "
                "axis of the dresser's centre.",
                "give a line in ASCII",
                **_LINE,
            ),
        ]
        | None
    ) = None
