"""Keys of `[export]`: the formats written, and the settings of machines, inspection, CAD, printing and drawing."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from msgspec import Meta

from cycloid_profile.spec.model.checks._table import PRINTABLE, SIZE, Table, key
from cycloid_profile.spec.model.points import FormWheelSpec, PointsSpec
from cycloid_profile.units import UM

Dialect = Literal["linuxcnc", "fanuc", "siemens", "heidenhain"]
Compensation = Literal["none", "G41", "G42"]
Spacing = Literal["chord-error", "equal-arc", "equal-normal-angle"]
EqualSpacing = Literal["equal-arc", "equal-normal-angle"]

FEED: dict[str, Any] = {"ge": 1e-3, "le": 1e6}
_TEXT = {"max_length": 60, "pattern": PRINTABLE}


def _text(description: str, remedy: str = "give a short text") -> Meta:
    return key(description, remedy, **_TEXT)


def _tolerance(description: str) -> Meta:
    return key(description, "give a tolerance in µm", gt=0, le=1e4)


def _fit(description: str) -> Meta:
    return key(description, "give a class such as H7", pattern=r"^[A-Za-z]{1,2}[0-9]{1,2}$")


class GrindingSpec(Table, frozen=True):
    """Grinding in passes. An absent key has the value of the machine; `feed_mm_per_min` is the surface speed."""

    stock_um: (
        Annotated[float, key("Stock to grind off, along X or the normal [µm].", "give the stock left", ge=0, le=5000)]
        | None
    ) = None
    infeed_um: Annotated[float, key("Infeed before each pass [µm].", "give 1 to 20 µm", gt=0, le=1000)] | None = None
    spark_out_turns: (
        Annotated[int, key("Passes without infeed at the end.", "give 1 to 3 turns", ge=0, le=100)] | None
    ) = None
    infeed_feed_mm_per_min: (
        Annotated[float, key("Feed of the infeed along X [mm/min].", "give a slow feed", **FEED)] | None
    ) = None
    safe_distance_mm: Annotated[
        float, key("Clearance between wheel and tip before and after grinding [mm].", "give some mm", ge=0.1, le=1000)
    ] = 5.0
    dressing_allowance_um: Annotated[
        float,
        key(
            "Taken off the wheel's radius by one dressing [µm]; a remark in the program.",
            "give an amount",
            ge=0,
            le=5000,
        ),
    ] = 20.0
    c_speed_limit_deg_per_s: (
        Annotated[float, key("Maximum speed of C [°/s].", "give the axis limit", gt=0, le=1e6)] | None
    ) = None
    c_acceleration_limit_deg_per_s2: (
        Annotated[float, key("Largest angular acceleration of C [°/s²].", "give the axis limit", gt=0, le=1e7)] | None
    ) = None
    x_speed_limit_mm_per_min: (
        Annotated[float, key("Maximum speed of X [mm/min].", "give the axis limit", **FEED)] | None
    ) = None
    x_acceleration_limit_mm_per_s2: (
        Annotated[float, key("Largest acceleration of X [mm/s²].", "give the axis limit", gt=0, le=1e6)] | None
    ) = None


class WireSpec(Table, frozen=True):
    """Wire cutting of the disc with its openings, a full cut and skim cuts."""

    wire_diameter_mm: Annotated[float, key("Diameter of the wire [mm].", "give 0.1 to 0.3 mm", ge=0.01, le=1)] = 0.25
    spark_gap_um: Annotated[float, key("Spark gap on each side of the wire [µm].", "give 5 to 30 µm", ge=0, le=500)] = (
        15.0
    )
    skim_stock_um: Annotated[
        tuple[float, ...],
        key("Stock left by each cut but the last, falling [µm]; empty for one cut.", "give a list such as [40, 10]"),
    ] = (40.0, 10.0)
    feed_mm_per_min: Annotated[float, key("Feed of the wire [mm/min].", "give a feed", **FEED)] = 5.0
    start_distance_mm: Annotated[
        float, key("From the tip to the start hole outside the disc [mm].", "give some mm", ge=0.5, le=1000)
    ] = 3.0
    overlap_mm: Annotated[
        float, key("Every cut runs this far past its start [mm].", "give 0.1 to 2 mm", ge=0, le=100)
    ] = 0.5
    slug_tab_mm: Annotated[
        float,
        key("Tab that holds the slug of an opening until the machine has stopped [mm].", "give 0.2 to 3", ge=0, le=100),
    ] = 0.5


class InspectionSpec(Table, frozen=True):
    """Measuring plan. A tolerance that is absent is that of the drawing, else a grade of ISO 286-1 by quality."""

    probe_radius_mm: Annotated[float, key("Radius of the probe's ball [mm].", "give 0.25 to 1.5 mm", gt=0, le=50)] = 0.5
    bore_points: Annotated[int, key("Points on each of datums B and C.", "give 4 to 50 points", ge=3, le=1000)] = 8
    profile_tolerance_um: Annotated[float, _tolerance("Allowed deviation of the flank, ± [µm].")] | None = None
    pitch_tolerance_um: Annotated[float, _tolerance("Allowed single pitch deviation, ± [µm].")] | None = None
    cumulative_pitch_tolerance_um: Annotated[float, _tolerance("Allowed cumulative pitch deviation [µm].")] | None = (
        None
    )
    runout_tolerance_um: Annotated[float, _tolerance("Allowed runout of the teeth about the bore [µm].")] | None = None


class DxfSpec(Table, frozen=True):
    """DXF files of the disc."""

    tooth: Annotated[
        Literal["flanks", "single"],
        key("Splines of the tooth: one a flank, or a single one, of which CAD kernels compute wrong areas.", ""),
    ] = "flanks"
    offset_mm: (
        Annotated[
            float,
            key(
                "From outline to cutter centre, its radius or half the kerf [mm]; absent: wire and spark gap.",
                "give the cutter's radius or half the kerf",
                ge=1e-3,
                le=100,
            ),
        ]
        | None
    ) = None


class StepSpec(Table, frozen=True):
    """STEP files of the disc and of the whole stage."""

    schema: Annotated[Literal["AP214", "AP242"], key("Application protocol of STEP files.", "")] = "AP214"
    degree: Annotated[
        Literal[3, 5], key("Degree of the tooth's splines: 5, or 3 for readers that take no more.", "give 3 or 5")
    ] = 5
    crank_angle_deg: Annotated[
        float, key("Crank angle of the assembly [°].", "give an angle in °", ge=-36000, le=36000)
    ] = 0.0


class PrintSpec(Table, frozen=True):
    """Meshes for 3D printers."""

    chord_um: Annotated[
        float, key("Largest distance of the mesh's chords from the tooth [µm].", "give 1 to 50", ge=0.1, le=1000)
    ] = 5.0
    flank_offset_um: Annotated[
        float,
        key(
            "Taken off the tooth all round, to compensate overextrusion [µm].",
            "give an amount in µm, positive removes material",
            ge=-1e4,
            le=1e4,
        ),
    ] = 0.0

    hole_offset_um: Annotated[
        float,
        key(
            "Taken off holes and openings all round [µm].",
            "give an amount in µm, positive removes material",
            ge=-1e4,
            le=1e4,
        ),
    ] = 0.0
    seat_offset_um: Annotated[
        float,
        key(
            "Taken off the seats of pins and shafts in ring and carrier plates [µm].",
            "give an amount in µm, positive removes material",
            ge=-1e4,
            le=1e4,
        ),
    ] = 0.0


class DrawingSpec(Table, frozen=True):
    """Fields, tolerances and notes of the drawing."""

    number: Annotated[str, _text("Number of the drawing.")] = ""
    revision: Annotated[str, key("Revision of the drawing.", "give a short text", max_length=10, pattern=PRINTABLE)] = (
        "0"
    )
    drawn_by: Annotated[str, _text("Who has drawn it.")] = ""
    date: Annotated[
        str, _text("Date field; empty unless given, so that files are reproducible.", "give a date as text")
    ] = ""
    heat_treatment: Annotated[str, _text("Heat treatment and hardness.")] = ""
    general_tolerance: Annotated[str, _text("General tolerance for untoleranced dimensions.", "give a standard")] = (
        "ISO 2768-mK"
    )
    tooth_roughness_ra_um: (
        Annotated[float, key("Roughness Ra of the tooth flanks [µm].", "give 0.1 to 12.5", gt=0, le=100)] | None
    ) = None
    roughness_ra_um: (
        Annotated[float, key("Roughness Ra of all other surfaces [µm].", "give 0.1 to 25", gt=0, le=100)] | None
    ) = None
    bore_fit: Annotated[str, _fit("Tolerance class of the bore.")] | None = None
    hole_fit: Annotated[str, _fit("Tolerance class of crank and output holes.")] | None = None
    keyway_fit: Annotated[str, _fit("Tolerance class of the keyway's width.")] | None = None
    hole_position_um: Annotated[float, _tolerance("Position tolerance of the holes, a diameter [µm].")] | None = None
    hole_angle_tolerance_arcmin: (
        Annotated[
            float, key("Tolerance of the angle from root 1 to the holes, ± [arcmin].", "give some arcmin", gt=0, le=600)
        ]
        | None
    ) = None
    perpendicularity_um: (
        Annotated[float, _tolerance("Perpendicularity of the bore to the upper face, whole zone [µm].")] | None
    ) = None
    parallelism_um: (
        Annotated[float, _tolerance("Parallelism of the lower to the upper face, whole zone [µm].")] | None
    ) = None
    width_tolerance_um: Annotated[float, _tolerance("Tolerance of the width, ± [µm].")] | None = None
    profile_tolerance_um: Annotated[float, _tolerance("Profile tolerance of the tooth, whole zone [µm].")] | None = None
    single_pitch_tolerance_um: Annotated[float, _tolerance("Single pitch deviation, ± [µm].")] | None = None
    cumulative_pitch_tolerance_um: (
        Annotated[float, _tolerance("Cumulative pitch deviation, whole range [µm].")] | None
    ) = None
    runout_tolerance_um: Annotated[float, _tolerance("Runout of the teeth about datum B [µm].")] | None = None
    datum: Annotated[str, _text("Name of datum B, the axis; empty for its own name, such as bore.")] = ""
    notes: Annotated[
        tuple[Annotated[str, _text("A note.")], ...],
        key("Further notes, one line each.", "give a list of short texts", max_length=6),
    ] = ()


Format = Literal[
    "csv",
    "dxf",
    "dxf-arcs",
    "dxf-offset",
    "svg",
    "drawing",
    "step",
    "step-assembly",
    "parts-step",
    "parts-dxf",
    "parts-3mf",
    "parts-stl",
    "bom",
    "3mf",
    "stl",
    "gcode",
    "gcode-path",
    "gcode-polar",
    "gcode-wire",
    "cmm",
    "dmis",
    "qif",
    "vdafs",
]
FORMATS: tuple[Format, ...] = ("csv", "dxf", "step", "gcode", "cmm")


class ExportSpec(Table, frozen=True):
    """Exported formats and their resolution."""

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
    nc_dialect: Annotated[Dialect, key("Control whose built-in machine the NC programs are for.", "")] = "linuxcnc"
    machine: (
        Annotated[
            str,
            key(
                "Machine file (TOML) in place of the built-in machine, relative to the spec file.",
                "give the path of a machine file",
                min_length=1,
                max_length=1000,
            ),
        ]
        | None
    ) = None
    nc_decimals: (
        Annotated[
            int,
            key(
                "Decimals of lengths in NC programs, C has one more; absent: those of the machine.",
                "give what the control reads, 3 to 6",
                ge=3,
                le=6,
            ),
        ]
        | None
    ) = None
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
    points: PointsSpec | None = None
    form_wheel: FormWheelSpec | None = None
    grinding: GrindingSpec = GrindingSpec()
    wire: WireSpec = WireSpec()
    inspection: InspectionSpec = InspectionSpec()
    drawing: DrawingSpec = DrawingSpec()
    dxf: DxfSpec = DxfSpec()
    step: StepSpec = StepSpec()
    print: PrintSpec = PrintSpec()

    @property
    def chord_tolerance(self) -> float:
        """Largest distance of chords, arcs and splines from the tooth [mm]."""
        return self.chord_tolerance_um * UM
