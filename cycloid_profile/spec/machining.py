"""The spec's tables of the machines: grinding in C and X, wire cutting, and inspection."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.table import Table, key

Dialect = Literal["linuxcnc", "fanuc", "siemens", "heidenhain"]
Compensation = Literal["none", "G41", "G42"]
Spacing = Literal["chord-error", "equal-arc", "equal-normal-angle"]
EqualSpacing = Literal["equal-arc", "equal-normal-angle"]

_FEED = {"ge": 1e-3, "le": 1e6}


class GrindingSpec(Table, frozen=True):
    """Polar grinding: the disc turns in C, the wheel moves in X. The surface speed is `feed_mm_per_min`."""

    stock_um: Annotated[
        float, key("Stock to grind off, along X [µm].", "give the stock left for grinding", ge=0, le=5000)
    ] = 20.0
    infeed_um: Annotated[float, key("Infeed along X before each turn [µm].", "give 1 to 20 µm", gt=0, le=1000)] = 5.0
    spark_out_turns: Annotated[int, key("Turns without infeed at the end.", "give 1 to 3 turns", ge=0, le=100)] = 2
    infeed_feed_mm_per_min: Annotated[
        float, key("Feed of the infeed along X [mm/min].", "give a slow feed", **_FEED)
    ] = 5.0
    safe_distance_mm: Annotated[
        float, key("Way between wheel and tip before and after [mm].", "give some mm", ge=0.1, le=1000)
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
    c_speed_limit_deg_per_s: Annotated[float, key("Fastest turn of C [°/s].", "give the axis limit", gt=0, le=1e6)] = (
        180.0
    )
    c_acceleration_limit_deg_per_s2: Annotated[
        float, key("Largest angular acceleration of C [°/s²].", "give the axis limit", gt=0, le=1e7)
    ] = 1000.0
    x_speed_limit_mm_per_min: Annotated[float, key("Fastest move of X [mm/min].", "give the axis limit", **_FEED)] = (
        5000.0
    )
    x_acceleration_limit_mm_per_s2: Annotated[
        float, key("Largest acceleration of X [mm/s²].", "give the axis limit", gt=0, le=1e6)
    ] = 1000.0


class WireSpec(Table, frozen=True):
    """Wire cutting of the disc with its openings, a full cut and skim cuts."""

    wire_diameter_mm: Annotated[float, key("Diameter of the wire [mm].", "give 0.1 to 0.3 mm", ge=0.01, le=1)] = 0.25
    spark_gap_um: Annotated[
        float, key("Gap the spark burns beside the wire [µm].", "give 5 to 30 µm", ge=0, le=500)
    ] = 15.0
    skim_stock_um: Annotated[
        tuple[float, ...],
        key("Stock left by each cut but the last, falling [µm]; empty for one cut.", "give a list such as [40, 10]"),
    ] = (40.0, 10.0)
    feed_mm_per_min: Annotated[float, key("Feed of the wire [mm/min].", "give a feed", **_FEED)] = 5.0
    start_distance_mm: Annotated[
        float, key("From the tip to the start hole outside the disc [mm].", "give some mm", ge=0.5, le=1000)
    ] = 3.0


class InspectionSpec(Table, frozen=True):
    """Measuring plan. A tolerance that is absent is computed from the play of the drive, to be agreed."""

    probe_radius_mm: Annotated[float, key("Radius of the probe's ball [mm].", "give 0.25 to 1.5 mm", gt=0, le=50)] = 0.5
    bore_points: Annotated[int, key("Points on the bore, the datum.", "give 4 to 50 points", ge=3, le=1000)] = 8
    profile_tolerance_um: (
        Annotated[float, key("Allowed deviation of the flank, ± [µm].", "give a tolerance in µm", gt=0, le=1e4)] | None
    ) = None
    pitch_tolerance_um: (
        Annotated[float, key("Allowed single pitch deviation, ± [µm].", "give a tolerance in µm", gt=0, le=1e4)] | None
    ) = None
    cumulative_pitch_tolerance_um: (
        Annotated[float, key("Allowed cumulative pitch deviation [µm].", "give a tolerance in µm", gt=0, le=1e4)] | None
    ) = None
    runout_tolerance_um: (
        Annotated[
            float, key("Allowed runout of the teeth about the bore [µm].", "give a tolerance in µm", gt=0, le=1e4)
        ]
        | None
    ) = None
