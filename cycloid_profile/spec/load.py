"""Keys of `[load]`: torque, contact law, speed and what is allowed."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.table import Table, key


class LoadSpec(Table, frozen=True):
    """What the disc is designed for."""

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
    contact_law: Annotated[
        Literal["roark", "johnson", "article", "weber-banaschek", "palmgren", "braendlein"],
        key("Line-contact law, see docs/theory.md.", ""),
    ] = "roark"
    output_speed_rpm: Annotated[
        float, key("Speed of the output, for sliding and losses [rpm].", "give a speed", ge=0, le=1e5)
    ] = 15.0
    friction_coefficient: Annotated[
        float, key("Coefficient of friction between tooth and pin, for losses.", "grease on steel: 0.05", ge=0, le=1)
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
