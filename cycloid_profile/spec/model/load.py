"""Keys of `[load]` and `[materials]`: torque, contact law, speed, allowable stresses, life, elastic constants."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from cycloid_profile.spec.model.checks._table import Table, key
from cycloid_profile.spec.model.checks._validation import Alternative
from cycloid_profile.spec.model.materials import material_values

_MATERIAL = key(
    "Name of a material of docs/spec.md, such as steel, PLA; in place of `youngs_modulus_gpa`.", "give a name as text"
)


class MaterialSpec(Table, frozen=True):
    """Elastic constants of one body."""

    alternatives: ClassVar[tuple[Alternative, ...]] = (
        Alternative("material", Annotated[str, _MATERIAL], "youngs_modulus_gpa", material_values),
    )
    youngs_modulus_gpa: Annotated[float, key("Young's modulus [GPa].", "steel has 206", ge=1e-3, le=1e4)] = 206.0
    poisson_ratio: Annotated[float, key("Poisson's ratio.", "steel has 0.3", ge=0, lt=0.5)] = 0.3
    name: Annotated[
        str,
        key(
            "Name shown in drawings and STEP files; absent: steel, or its modulus.", "give a short name", max_length=40
        ),
    ] = ""
    density_kg_per_m3: (
        Annotated[
            float,
            key(
                "Density for the mass on the drawing [kg/m³]; absent: that of the material's name.",
                "steel has 7850",
                gt=0,
                le=3e4,
            ),
        ]
        | None
    ) = None


class MaterialsSpec(Table, frozen=True):
    """Materials of disc and pins; steel unless said otherwise."""

    disc: MaterialSpec = MaterialSpec()
    pin: MaterialSpec = MaterialSpec()


class LoadSpec(Table, frozen=True):
    """Rated load, contact law, friction, allowable stresses and required life."""

    rated_torque_nm: (
        Annotated[
            float,
            key(
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
            key(
                "Share of the torque on one disc, classical scheme only; 0.55 for two discs, 1.1 over their number.",
                "two discs: 0.5 to 0.55",
                gt=0,
                le=1,
            ),
        ]
        | None
    ) = None
    contact_law: (
        Annotated[
            Literal["roark", "johnson", "article", "weber-banaschek", "palmgren", "braendlein"],
            key(
                "Line-contact law, see docs/theory.md; absent: weber-banaschek, for rigid discs roark, which counts "
                "the deformation of the body as well.",
                "",
            ),
        ]
        | None
    ) = None
    disc_body: Annotated[
        Literal["elastic", "rigid", "file"],
        key(
            "Deformation of the disc beyond its contacts: elastic, from finite elements of its outline and openings; "
            "rigid; or from a file.",
            "choose elastic, rigid, or file with disc_body_file",
        ),
    ] = "elastic"
    disc_body_file: (
        Annotated[
            str,
            key(
                "Compliance matrix of the disc as .npz, relative to the spec file; see docs/elastic-disc.md.",
                "give the path of an .npz file",
            ),
        ]
        | None
    ) = None
    width_slices: Annotated[
        int,
        key(
            "Slices over the face width, with relief, tilt of the discs and edge pressure; 0: an even load over the "
            "width, whatever the relief.",
            "give 0 for none, or 2 to 100 slices, 8 are enough",
            ge=0,
            le=100,
        ),
    ] = 0
    output_speed_rpm: Annotated[
        float, key("Speed of the output, for sliding and losses [rpm].", "give a speed", ge=0, le=1e5)
    ] = 15.0
    friction_coefficient: Annotated[
        float,
        key("Likely coefficient of friction between tooth and pin, for losses.", "grease on steel: 0.05", ge=0, le=1),
    ] = 0.05
    allowable_pressure_mpa: (
        Annotated[
            float,
            key(
                "Allowable peak pressure of the line contact [MPa]; 1500 for steel on steel, else not checked.",
                "give a pressure",
                gt=0,
                le=1e5,
            ),
        ]
        | None
    ) = None
    allowable_pin_stress_mpa: (
        Annotated[
            float,
            key(
                "Allowable stress of a pin, von Mises, in bending and shear [MPa]; absent: not checked.",
                "give a stress with your safety against fatigue",
                gt=0,
                le=1e5,
            ),
        ]
        | None
    ) = None
    required_life_h: (
        Annotated[
            float,
            key(
                "Life that the crank bearings must reach at rated torque and output speed [h]; absent: not checked.",
                "give hours; makers of RV reducers state 6000",
                gt=0,
                le=1e7,
            ),
        ]
        | None
    ) = None
    lubricant_viscosity_mm2_per_s: (
        Annotated[
            float,
            key(
                "Kinematic viscosity of the oil, or of the grease's oil, at running temperature [mm²/s]; "
                "absent: lubrication not checked.",
                "give the viscosity at running temperature",
                ge=0.1,
                le=1e5,
            ),
        ]
        | None
    ) = None
    contamination_factor: Annotated[
        float,
        key("Contamination factor e_C of ISO 281: 1 clean, 0.5 normal, below 0.3 dirty.", "give 0.5", gt=0, le=1),
    ] = 0.5

    @property
    def law(self) -> str:
        """Name of the contact law: the one given, or the one that goes with the disc.

        With an elastic disc a law may count the deformation near the contact alone; with a rigid one it must count
        all.
        """
        return self.contact_law or ("roark" if self.disc_body == "rigid" else "weber-banaschek")
