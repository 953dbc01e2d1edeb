"""Keys of `[drive]` and `[disc]`: pins, disc, first stage, cranks, and the openings of the disc."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from msgspec import Meta

from cycloid_profile.spec.model.checks._table import SIZE, Table, key, length, relief, relief_length, taper
from cycloid_profile.spec.model.checks._validation import Alternative


def _stiffness_of(bearing: str) -> Meta:
    return key(f"Radial stiffness of {bearing} [N/mm].", "give a stiffness such as 4.0e5", ge=1.0, le=1e12)


def _play_of(bearing: str) -> Meta:
    return key(
        f"Radial play of {bearing}, half the diametral clearance [µm].",
        "give half the diametral clearance, 0 for none",
        ge=0,
        le=1000,
    )


class CranksSpec(Table, frozen=True):
    """Crank shafts of an RV reducer. Without this table one central eccentric carries the discs."""

    count: Annotated[int, key("Number of crank shafts.", "give 2 or 3 crank shafts", ge=2, le=12)]
    circle_radius_mm: Annotated[float, length("Pitch circle radius of the crank shafts [mm].")]
    bearing_stiffness_n_per_mm: Annotated[float, _stiffness_of("each crank bearing")] = 4.0e5
    bearing_play_um: Annotated[float, _play_of("each crank bearing")] = 0.0


class EccentricSpec(Table, frozen=True):
    """The central eccentric, where there are no crank shafts."""

    bearing_stiffness_n_per_mm: Annotated[float, _stiffness_of("the eccentric bearing")] = 4.0e5
    bearing_play_um: Annotated[float, _play_of("the eccentric bearing")] = 0.0


class FirstStageSpec(Table, frozen=True):
    """Involute first stage. Without this table the eccentric is the input."""

    sun_teeth: Annotated[int, key("Teeth of the sun z1.", "give the number of teeth of the sun", ge=3, le=1000)]
    planet_teeth: Annotated[int, key("Teeth of a planet z2.", "give the number of teeth of a planet", ge=3, le=1000)]
    module_mm: Annotated[float, length("Module of the first stage [mm].")]


class CrankBearingSpec(Table, frozen=True):
    """Rollers between crank, or central eccentric, and disc: stiffness, life, losses. Estimated where absent."""

    model: (
        Annotated[
            Literal["spring", "rollers"],
            Meta(
                description="Radial law of the bearing in the stage: a spring of `bearing_stiffness_n_per_mm`, or "
                "rollers in its place; absent: rollers where a clearance or preload is given."
            ),
        ]
        | None
    ) = None
    clearance_class: (
        Annotated[
            Literal["C2", "CN", "C3"],
            Meta(description="Radial clearance by ISO 5753-1 for the diameter of the crank, middle of its range."),
        ]
        | None
    ) = None
    radial_clearance_um: (
        Annotated[
            float,
            key(
                "Radial clearance as ISO 5753-1 measures it, twice the play [µm]; with rollers absent: 0, assumed.",
                "give the clearance in µm, or preload_um",
                ge=0,
                le=2000,
            ),
        ]
        | None
    ) = None
    preload_um: (
        Annotated[
            float,
            key(
                "Negative radial clearance: rollers thicker than their gap, twice the radial amount [µm].",
                "give the preload in µm",
                ge=0,
                le=200,
            ),
        ]
        | None
    ) = None

    dynamic_load_rating_n: (
        Annotated[
            float,
            key(
                "Dynamic load rating C of one bearing [N]; absent: from the rollers by ISO 281, steel discs only.",
                "give C of the catalogue in N",
                gt=0,
                le=1e9,
            ),
        ]
        | None
    ) = None
    roller_count: (
        Annotated[
            int,
            key(
                "Number of rollers; absent: one every 1.5 diameters of the pitch circle, assumed.",
                "give the number of rollers",
                ge=3,
                le=1000,
            ),
        ]
        | None
    ) = None
    roller_diameter_mm: (
        Annotated[float, length("Diameter of a roller [mm]; absent: 0.23 of the radius of the crank hole, assumed.")]
        | None
    ) = None
    roller_length_mm: (
        Annotated[float, length("Length of a roller without chamfers [mm]; absent: 0.75 of the face width, assumed.")]
        | None
    ) = None
    offset_mm: Annotated[
        float,
        key(
            "Height of the bearing's middle above the mid-plane of the disc [mm]; with width_slices.",
            "give a height in mm, 0 for a bearing in the middle",
            ge=-1e4,
            le=1e4,
        ),
    ] = 0.0
    tilt_stiffness_nm_per_mrad: (
        Annotated[
            float,
            key(
                "Stiffness of one bearing against a tilt of the disc [N·m/mrad], with width_slices; "
                "absent: radial stiffness × roller length² / 12.",
                "give a stiffness, 0 for a disc that tilts freely",
                ge=0,
                le=1e9,
            ),
        ]
        | None
    ) = None


Estimate = Annotated[
    Literal["stiff", "likely", "soft"],
    key("Which end of the range the sizes take that are left out; see docs/supports.md.", "choose stiff, likely, soft"),
]


class PinSeatSpec(Table, frozen=True):
    """Seats of the pins. Without this table pins count as seated along their length in rigid grooves."""

    span_mm: Annotated[
        float,
        key(
            "Length a pin bridges between two seats: a relief of the groove, or all between end plates [mm].",
            "give a length in mm, 0 for a whole groove",
            ge=0,
            le=1e4,
        ),
    ] = 0.0
    overhang_mm: Annotated[
        float,
        key(
            "Length of a pin beyond the end of its seat [mm].",
            "give a length in mm, 0 for a pin that is seated to its end",
            ge=0,
            le=1e4,
        ),
    ] = 0.0
    contact: Annotated[
        bool, key("Whether the contact of pin and groove is elastic, see docs/supports.md.", "choose true or false")
    ] = False
    bending: Annotated[
        bool, key("Whether the pins bend, in elastic grooves or where they are free.", "choose true or false")
    ] = False
    length_mm: (
        Annotated[float, length("Length of a pin [mm]; absent: all discs with a tenth of their width between them.")]
        | None
    ) = None
    groove_clearance_um: (
        Annotated[
            float,
            key(
                "Radius of the groove less that of the pin [µm]; absent: 0.002 of the pin radius, assumed.",
                "give a clearance in µm, 0 for a groove of the pin's radius",
                ge=0,
                le=1000,
            ),
        ]
        | None
    ) = None
    estimate: Estimate = "likely"


class RingSpec(Table, frozen=True):
    """The ring that holds the pins, as an elastic body. Without this table it is rigid."""

    elastic: Annotated[bool, key("Whether the ring is elastic.", "choose true or false")] = True
    outer_radius_mm: (
        Annotated[float, length("Outer radius [mm]; absent: 1.45 of the pin circle, with flange and frame, assumed.")]
        | None
    ) = None
    width_mm: (
        Annotated[float, length("Width along the axis [mm]; absent: 1.2 of the length of a pin, assumed.")] | None
    ) = None
    waves: Annotated[
        int, key("Highest number of waves round the ring that is counted.", "give 3 or more", ge=0, le=500)
    ] = 6
    mounting_stiffness_n_per_mm2: (
        Annotated[
            float,
            key(
                "Stiffness of the mount per length of the circumference, in both directions [N/mm²]; absent: rigid "
                "against shift and turn, free against waves.",
                "give a stiffness such as 1e4",
                gt=0,
                le=1e9,
            ),
        ]
        | None
    ) = None
    youngs_modulus_gpa: Annotated[
        float,
        key("Young's modulus, of the grooves as well [GPa]: ductile iron.", "steel has 206", ge=1e-3, le=1e4),
    ] = 170.0
    poisson_ratio: Annotated[float, key("Poisson's ratio.", "iron has 0.28", ge=0, lt=0.5)] = 0.28
    estimate: Estimate = "likely"


class PillarsSpec(Table, frozen=True):
    """Pillars between the flanges of the carrier, as elastic bodies. Without this table they are rigid."""

    elastic: Annotated[bool, key("Whether the pillars are elastic.", "choose true or false")] = True
    count: (
        Annotated[int, key("Number of pillars; absent: as many as cranks.", "give the number", ge=1, le=100)] | None
    ) = None
    circle_radius_mm: (
        Annotated[float, length("Radius of their pitch circle [mm]; absent: that of the cranks.")] | None
    ) = None
    radius_mm: (
        Annotated[
            float,
            length("Radius of a round pillar of equal bending [mm]; absent: 0.25 of the cranks' circle, assumed."),
        ]
        | None
    ) = None
    length_mm: (
        Annotated[
            float, length("Free length [mm]; absent: the discs, with a tenth of their width between and outside them.")
        ]
        | None
    ) = None
    far_share: Annotated[
        float,
        key(
            "Share of the torque that enters the carrier at the flange away from the output.",
            "cranks held in two flanges: 0.5",
            ge=0,
            le=1,
        ),
    ] = 0.5
    youngs_modulus_gpa: Annotated[float, key("Young's modulus [GPa].", "steel has 206", ge=1e-3, le=1e4)] = 206.0
    poisson_ratio: Annotated[float, key("Poisson's ratio.", "steel has 0.3", ge=0, lt=0.5)] = 0.3
    estimate: Estimate = "likely"


class PinReliefSpec(Table, frozen=True):
    """Relief of the pins along the axis, the same at every disc; counts in the load with `width_slices`."""

    crowning_um: Annotated[float, relief("Crowning: relief at both edges of a disc, a parabola [µm].")] = 0.0
    edge_relief_um: Annotated[
        float, relief("Further relief at both edges of a disc [µm]; over edge_relief_length_mm.")
    ] = 0.0
    edge_relief_length_mm: Annotated[
        float, relief_length("Length before each edge of a disc over which the edge relief runs out [mm].")
    ] = 0.0
    taper_um: Annotated[
        float, taper("Taper over the face width of a disc, thinner at the upper edge if positive [µm].")
    ] = 0.0


_RATIO = key(
    "Ratio of the cycloid stage with the housing fixed, the lobes of its disc; in place of `pins`, one more.",
    "give 2 to 999, without the first stage",
    ge=2,
    le=999,
)
_PIN_DIAMETER = key(
    "Diameter of a pin [mm]; in place of `pin_radius_mm`.",
    "give a length above zero in mm",
    ge=2 * SIZE["ge"],
    le=2 * SIZE["le"],
)


class DriveSpec(Table, frozen=True):
    """Pins, disc and how the disc is held."""

    alternatives: ClassVar[tuple[Alternative, ...]] = (
        Alternative("ratio", Annotated[int, _RATIO], "pins", lambda ratio: {"pins": ratio + 1}),
        Alternative(
            "pin_diameter_mm", Annotated[float, _PIN_DIAMETER], "pin_radius_mm", lambda d: {"pin_radius_mm": 0.5 * d}
        ),
    )
    pins: Annotated[int, key("Number of pins z_p; the disc has one lobe less.", "give 3 to 1000 pins", ge=3, le=1000)]
    pin_circle_radius_mm: Annotated[float, length("Radius of the circle through the pin centres r_p [mm].")]
    pin_radius_mm: Annotated[float, length("Radius of a pin r_rp [mm].")]
    eccentricity_mm: Annotated[float, length("Eccentricity a [mm].")]
    disc_width_mm: Annotated[float, key("Face width b of one disc [mm].", "give the face width of one disc", **SIZE)]
    discs: Annotated[int, key("Number of discs, evenly phased.", "give 1, 2 or 3 discs", ge=1, le=6)]
    cranks: CranksSpec | None = None
    eccentric: EccentricSpec = EccentricSpec()
    crank_bearing: CrankBearingSpec = CrankBearingSpec()
    pin_seat: PinSeatSpec | None = None
    pin_relief: PinReliefSpec = PinReliefSpec()
    ring: RingSpec | None = None
    pillars: PillarsSpec | None = None
    first_stage: FirstStageSpec | None = None


class HolesSpec(Table, frozen=True):
    """A ring of equal holes through the disc for output rollers or pins: radius = roller + eccentricity + clearance."""

    count: Annotated[int, key("Number of holes.", "give at least 1 hole", ge=1, le=100)]
    circle_radius_mm: Annotated[float, length("Pitch circle radius of the holes [mm].")]
    radius_mm: (
        Annotated[float, length("Radius of a hole [mm]; absent: roller, eccentricity and clearance together.")] | None
    ) = None
    roller_radius_mm: (
        Annotated[
            float,
            length("Radius of the roller or pin in a hole [mm]; absent: what hole, eccentricity, clearance leave."),
        ]
        | None
    ) = None
    clearance_um: Annotated[
        float, key("Least radial clearance of roller and hole [µm].", "give a clearance in µm", ge=0, le=1e4)
    ] = 0.0
    pin_radius_mm: (
        Annotated[float, length("Radius of the pin inside a roller [mm]; absent: plain pins without rollers.")] | None
    ) = None


class WindowsSpec(Table, frozen=True):
    """A ring of equal windows between two radii, with radial sides; slots where the corners are round ends."""

    count: Annotated[int, key("Number of windows.", "give at least 1 window", ge=1, le=100)]
    inner_radius_mm: Annotated[float, length("Radius of the inner edge [mm].")]
    outer_radius_mm: Annotated[float, length("Radius of the outer edge [mm].")]
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

    width_mm: Annotated[float, length("Width of the key [mm].")]
    depth_mm: Annotated[float, length("Depth from the circle of the bore to the floor, at the middle [mm].")]
    count: Annotated[int, key("Number of keyways, evenly round the bore.", "give 1 keyway", ge=1, le=100)] = 1
    corner_radius_mm: Annotated[
        float, key("Radius between floor and sides [mm].", "give a length in mm, 0 for sharp corners", ge=0, le=1e4)
    ] = 0.0
    first_at_deg: Annotated[
        float, key("Angle of the first keyway from the x axis [°].", "give an angle in °", ge=-360, le=360)
    ] = 0.0


class DiscSpec(Table, frozen=True):
    """Openings of the disc; sizes are estimated where absent."""

    bore_radius_mm: Annotated[float, length("Radius of the central bore [mm].")] | None = None
    crank_hole_radius_mm: Annotated[float, length("Radius of the crank holes [mm].")] | None = None
    output_holes: HolesSpec | None = None
    windows: WindowsSpec | None = None
    keyway: KeywaySpec | None = None
