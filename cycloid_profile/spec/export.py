"""Keys of `[export]`: which files are written, and how finely."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.cad import PrintSpec, StepSpec
from cycloid_profile.spec.drawing import DrawingSpec
from cycloid_profile.spec.machining import (
    Compensation,
    Dialect,
    EqualSpacing,
    GrindingSpec,
    InspectionSpec,
    Spacing,
    WireSpec,
)
from cycloid_profile.spec.table import SIZE, Table, key

Format = Literal[
    "csv",
    "dxf",
    "dxf-arcs",
    "drawing",
    "step",
    "step-assembly",
    "3mf",
    "stl",
    "gcode",
    "gcode-path",
    "gcode-polar",
    "gcode-wire",
    "cmm",
    "dmis",
    "vdafs",
]
FORMATS: tuple[Format, ...] = ("csv", "dxf", "step", "gcode", "cmm")


class ExportSpec(Table, frozen=True):
    """What is written, and how finely."""

    formats: Annotated[tuple[Format, ...], key("Files to write.", "give a list of formats")] = FORMATS
    chord_tolerance_um: Annotated[
        float, key("Largest distance of chords and arcs from the tooth [µm].", "give 0.05 to 5", ge=0.01, le=100)
    ] = 0.05
    cmm_points_per_lobe: Annotated[
        int, key("Nominal measuring points on one lobe.", "give 8 to 400 points", ge=8, le=400)
    ] = 40
    feed_mm_per_min: Annotated[float, key("Feed of the contour program [mm/min].", "give a feed", ge=1, le=1e5)] = 200.0
    point_spacing: Annotated[Spacing, key("How the points of profile.csv are spread.", "")] = "chord-error"
    points_per_lobe: (
        Annotated[
            int,
            key(
                "Points of profile.csv on a lobe, equally spaced; absent: as many as the chord tolerance takes.",
                "give 8 to 20000 points",
                ge=8,
                le=20000,
            ),
        ]
        | None
    ) = None
    cmm_spacing: Annotated[EqualSpacing, key("How the nominal measuring points are spread.", "")] = "equal-arc"
    nc_dialect: Annotated[Dialect, key("Control the NC programs are written for.", "")] = "linuxcnc"
    nc_decimals: Annotated[
        int,
        key("Decimals of lengths in NC programs; C has one more.", "give what the control reads, 3 to 6", ge=3, le=6),
    ] = 5
    wheel_radius_mm: (
        Annotated[
            float,
            key(
                "Radius of the grinding wheel [mm]; absent: 0.8 of the least concave radius of the tooth.",
                "give a radius below the least concave radius",
                **SIZE,
            ),
        ]
        | None
    ) = None
    wheel_compensation: Annotated[
        Compensation, key("Wheel radius compensation of the contour program; G42 runs anticlockwise.", "")
    ] = "none"
    grinding: GrindingSpec = GrindingSpec()
    wire: WireSpec = WireSpec()
    inspection: InspectionSpec = InspectionSpec()
    drawing: DrawingSpec = DrawingSpec()
    step: StepSpec = StepSpec()
    print: PrintSpec = PrintSpec()
