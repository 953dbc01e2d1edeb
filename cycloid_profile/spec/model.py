"""The spec file as frozen values: its keys, units, defaults and limits. The one place that lists them.

Keys carry their unit, so values here are in the unit of their name; ``design.from_spec`` turns them
into geometry in base units.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

from cycloid_profile.spec.cad import PrintSpec, StepSpec
from cycloid_profile.spec.disc import DiscSpec as DiscSpec
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
from cycloid_profile.spec.table import Table as Table
from cycloid_profile.spec.table import key as _key

_LENGTH = "give a length above zero in mm"
_SIZE = {"ge": 1e-3, "le": 1e4}  # mm
_STIFFNESS = {"ge": 1.0, "le": 1e12}  # N/mm
_AMOUNTS = {"ge": -1e4, "le": 1e4}  # µm
_AMOUNT = "give an amount in µm, positive removes material"

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


class CranksSpec(Table, frozen=True):
    """Crank shafts of an RV reducer. Without this table one central eccentric carries the discs."""

    count: Annotated[int, _key("Number of crank shafts.", "give 2 or 3 crank shafts", ge=2, le=12)]
    circle_radius_mm: Annotated[float, _key("Radius of the circle the crank shafts stand on [mm].", _LENGTH, **_SIZE)]
    bearing_stiffness_n_per_mm: Annotated[
        float, _key("Radial stiffness of each crank bearing [N/mm].", "give a stiffness such as 4.0e5", **_STIFFNESS)
    ] = 4.0e5
    bearing_play_um: Annotated[
        float,
        _key(
            "Radial play of each crank bearing, half the diametral clearance [µm].",
            "give half the diametral clearance, 0 for none",
            ge=0,
            le=1000,
        ),
    ] = 0.0


class EccentricSpec(Table, frozen=True):
    """The central eccentric, where there are no crank shafts."""

    bearing_stiffness_n_per_mm: Annotated[
        float, _key("Radial stiffness of the eccentric bearing [N/mm].", "give a stiffness such as 4.0e5", **_STIFFNESS)
    ] = 4.0e5
    bearing_play_um: Annotated[
        float,
        _key(
            "Radial play of the eccentric bearing, half the diametral clearance [µm].",
            "give half the diametral clearance, 0 for none",
            ge=0,
            le=1000,
        ),
    ] = 0.0


class FirstStageSpec(Table, frozen=True):
    """Involute first stage. Without this table the eccentric is the input."""

    sun_teeth: Annotated[int, _key("Teeth of the sun z1.", "give the number of teeth of the sun", ge=3, le=1000)]
    planet_teeth: Annotated[int, _key("Teeth of a planet z2.", "give the number of teeth of a planet", ge=3, le=1000)]
    module_mm: Annotated[float, _key("Module of the first stage [mm].", _LENGTH, **_SIZE)]


class DriveSpec(Table, frozen=True):
    """Pins, disc and how the disc is held."""

    pins: Annotated[int, _key("Number of pins z_p; the disc has one lobe less.", "give 3 to 1000 pins", ge=3, le=1000)]
    pin_circle_radius_mm: Annotated[
        float, _key("Radius of the circle through the pin centres r_p [mm].", _LENGTH, **_SIZE)
    ]
    pin_radius_mm: Annotated[float, _key("Radius of a pin r_rp [mm].", _LENGTH, **_SIZE)]
    eccentricity_mm: Annotated[float, _key("Eccentricity a [mm].", _LENGTH, **_SIZE)]
    disc_width_mm: Annotated[float, _key("Face width b of one disc [mm].", "give the face width of one disc", **_SIZE)]
    discs: Annotated[int, _key("Number of discs, evenly phased.", "give 1, 2 or 3 discs", ge=1, le=6)]
    cranks: CranksSpec | None = None
    eccentric: EccentricSpec = EccentricSpec()
    first_stage: FirstStageSpec | None = None


class MaterialSpec(Table, frozen=True):
    """Elastic constants of one body."""

    youngs_modulus_gpa: Annotated[float, _key("Young's modulus [GPa].", "steel has 206", ge=1e-3, le=1e4)] = 206.0
    poisson_ratio: Annotated[float, _key("Poisson's ratio.", "steel has 0.3", ge=0, lt=0.5)] = 0.3
    name: Annotated[
        str,
        _key(
            "Name shown in drawings and STEP files; absent: steel, or its modulus.", "give a short name", max_length=40
        ),
    ] = ""


class MaterialsSpec(Table, frozen=True):
    """Materials of disc and pins; steel unless said otherwise."""

    disc: MaterialSpec = MaterialSpec()
    pin: MaterialSpec = MaterialSpec()


class LoadSpec(Table, frozen=True):
    """What the disc is designed for."""

    rated_torque_nm: (
        Annotated[
            float,
            _key(
                "Rated output torque [N·m]; estimated from the size if absent.",
                "give the rated torque",
                ge=1e-6,
                le=1e9,
            ),
        ]
        | None
    ) = None
    disc_share: (
        Annotated[
            float,
            _key(
                "Share of the torque on one disc, classical scheme only; 0.55 for two discs, 1.1 over their number.",
                "two discs: 0.5 to 0.55",
                gt=0,
                le=1,
            ),
        ]
        | None
    ) = None
    contact_law: Annotated[
        Literal["roark", "johnson", "article", "weber-banaschek", "palmgren", "braendlein"],
        _key("Line-contact law, see docs/theory.md.", ""),
    ] = "roark"
    output_speed_rpm: Annotated[
        float, _key("Speed of the output, for sliding and losses [rpm].", "give a speed", ge=0, le=1e5)
    ] = 15.0
    friction_coefficient: Annotated[
        float, _key("Coefficient of friction between tooth and pin, for losses.", "grease on steel: 0.05", ge=0, le=1)
    ] = 0.05
    allowable_pressure_mpa: (
        Annotated[
            float,
            _key(
                "Allowable peak pressure of the line contact [MPa]; 1500 for steel on steel, else not checked.",
                "give a pressure",
                gt=0,
                le=1e5,
            ),
        ]
        | None
    ) = None


class ModificationSpec(Table, frozen=True):
    """How the ground tooth differs from the theoretical one. Positive removes material."""

    equidistant_um: Annotated[
        float, _key("Wheel radius larger than the pin by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    radial_moving_um: Annotated[
        float, _key("Pin circle of generation smaller by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    rotation_arcmin: Annotated[
        float,
        _key("Turn of each flank away from its pin [arc minutes].", "give an angle in arc minutes", ge=-60, le=60),
    ] = 0.0
    deformation_compensation: Annotated[
        bool | float,
        _key("true: from the load; false: none; a number: delta_max [µm].", "give true, false or delta_max in µm"),
    ] = False
    compensation_solver: Annotated[
        Literal["equilibrium", "classical", "stage"], _key("Which load sharing finds delta_max.", "")
    ] = "equilibrium"
    compensation_load_share: Annotated[
        float,
        _key("Share of the rated torque whose deformation is compensated.", "give 1 for the rated torque", gt=0, le=3),
    ] = 1.0


class ExportSpec(Table, frozen=True):
    """What is written, and how finely."""

    formats: Annotated[tuple[Format, ...], _key("Files to write.", "give a list of formats")] = FORMATS
    chord_tolerance_um: Annotated[
        float, _key("Largest distance of chords and arcs from the tooth [µm].", "give 0.05 to 5", ge=0.01, le=100)
    ] = 0.05
    cmm_points_per_lobe: Annotated[
        int, _key("Nominal measuring points on one lobe.", "give 8 to 400 points", ge=8, le=400)
    ] = 40
    feed_mm_per_min: Annotated[float, _key("Feed of the contour program [mm/min].", "give a feed", ge=1, le=1e5)] = (
        200.0
    )
    point_spacing: Annotated[Spacing, _key("How the points of profile.csv are spread.", "")] = "chord-error"
    points_per_lobe: (
        Annotated[
            int,
            _key(
                "Points of profile.csv on a lobe, equally spaced; absent: as many as the chord tolerance takes.",
                "give 8 to 20000 points",
                ge=8,
                le=20000,
            ),
        ]
        | None
    ) = None
    cmm_spacing: Annotated[EqualSpacing, _key("How the nominal measuring points are spread.", "")] = "equal-arc"
    nc_dialect: Annotated[Dialect, _key("Control the NC programs are written for.", "")] = "linuxcnc"
    nc_decimals: Annotated[
        int,
        _key("Decimals of lengths in NC programs; C has one more.", "give what the control reads, 3 to 6", ge=3, le=6),
    ] = 5
    wheel_radius_mm: (
        Annotated[
            float,
            _key(
                "Radius of the grinding wheel [mm]; absent: 0.8 of the least concave radius of the tooth.",
                "give a radius below the least concave radius",
                **_SIZE,
            ),
        ]
        | None
    ) = None
    wheel_compensation: Annotated[
        Compensation, _key("Wheel radius compensation of the contour program; G42 runs anticlockwise.", "")
    ] = "none"
    grinding: GrindingSpec = GrindingSpec()
    wire: WireSpec = WireSpec()
    inspection: InspectionSpec = InspectionSpec()
    drawing: DrawingSpec = DrawingSpec()
    step: StepSpec = StepSpec()
    print: PrintSpec = PrintSpec()


Quantity = Literal["backlash_arcmin", "lost_motion_arcmin", "transmission_error_arcsec", "peak_pressure_mpa"]
_LIMIT: dict[str, Any] = {"gt": 0, "le": 1e6}


class LimitsSpec(Table, frozen=True):
    """What a reducer may not exceed to pass."""

    backlash_arcmin: (
        Annotated[float, _key("Backlash, crank locked, largest over a turn [arc minutes].", "give a limit", **_LIMIT)]
        | None
    ) = None
    least_backlash_arcmin: (
        Annotated[
            float,
            _key("Least backlash over a turn, 0 so that none binds [arc minutes].", "give a limit", ge=-1e6, le=1e6),
        ]
        | None
    ) = None
    lost_motion_arcmin: (
        Annotated[float, _key("Lost motion at 3 % of rated torque [arc minutes].", "give a limit", **_LIMIT)] | None
    ) = None
    transmission_error_arcsec: (
        Annotated[
            float, _key("Transmission error at rated torque, peak to peak [arc seconds].", "give a limit", **_LIMIT)
        ]
        | None
    ) = None
    peak_pressure_mpa: (
        Annotated[float, _key("Contact pressure at rated torque [MPa].", "give a limit", **_LIMIT)] | None
    ) = None


class ToleranceSpec(Table, frozen=True):
    """What scatters from reducer to reducer, and what passes; see docs/tolerance.md."""

    samples: Annotated[
        int, _key("Reducers whose backlash is computed.", "give 100 to 1000000000", ge=100, le=1_000_000_000)
    ] = 100_000
    loaded_samples: Annotated[
        int,
        _key(
            "Reducers that are loaded: lost motion, transmission error, pressure.",
            "give 0 to 100000000",
            ge=0,
            le=100_000_000,
        ),
    ] = 2_000
    seed: Annotated[int, _key("Start of the random numbers.", "give a whole number", ge=0, le=2**63 - 1)] = 1
    sequence: Annotated[
        Literal["random", "latin-hypercube", "sobol"], _key("How the samples fill the space of all errors.", "")
    ] = "random"
    batch_size: Annotated[
        int, _key("Reducers to a batch, for errors with a batch_share.", "give 1 to 1000000", ge=1, le=1_000_000)
    ] = 100
    yield_percent: Annotated[
        float, _key("Yield that the cheapest tolerances must reach [%].", "give 50 to 99.99", ge=1, le=99.99)
    ] = 99.0
    limits: LimitsSpec = LimitsSpec()
    effects: Annotated[
        tuple[dict[str, Any], ...],
        _key("Effects whose sizes scatter, as tables `[[tolerance.effects]]`.", "give [[tolerance.effects]]"),
    ] = ()
    correlations: Annotated[
        tuple[dict[str, Any], ...],
        _key("Sizes that go together, as tables `[[tolerance.correlations]]`.", "give [[tolerance.correlations]]"),
    ] = ()


class PublishedValue(Table, frozen=True):
    """A number that was published of this drive, to lay beside the computed one."""

    quantity: Annotated[str, _key("What was published.", "give a text")]
    value: Annotated[float, _key("Its value.", "give a number")]
    unit: Annotated[str, _key("Its unit.", "give a text")] = ""
    note: Annotated[str, _key("How it was found.", "give a text")] = ""


class SourceSpec(Table, frozen=True):
    """Where the numbers come from, and which of them are assumed."""

    reference: Annotated[str, _key("Publication or maker.", "give a text")] = ""
    assumed: Annotated[tuple[str, ...], _key("Keys whose values are assumed.", "give a list of texts")] = ()
    published: tuple[PublishedValue, ...] = ()


class Spec(Table, frozen=True, kw_only=True):
    """A whole spec file."""

    name: Annotated[
        str,
        _key("Name shown in pictures and reports.", "give a short name", max_length=80, pattern=r"^[^\x00-\x1f\x7f]*$"),
    ] = "cycloidal drive"
    drive: DriveSpec
    materials: MaterialsSpec = MaterialsSpec()
    load: LoadSpec = LoadSpec()
    modification: ModificationSpec = ModificationSpec()
    disc: DiscSpec = DiscSpec()
    export: ExportSpec = ExportSpec()
    source: SourceSpec = SourceSpec()
    tolerance: ToleranceSpec = ToleranceSpec()
    effects: Annotated[
        tuple[dict[str, Any], ...],
        _key("Imperfections as tables `[[effects]]`, each with a `name`, see docs/rig.md.", "give [[effects]]"),
    ] = ()
