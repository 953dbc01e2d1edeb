"""Keys of `[modification]`: how the ground tooth differs from the theoretical one."""

from __future__ import annotations

from typing import Annotated, Literal

from cycloid_profile.spec.table import Table, key

_AMOUNTS = {"ge": -1e4, "le": 1e4}  # µm
_AMOUNT = "give an amount in µm, positive removes material"


class ModificationSpec(Table, frozen=True):
    """How the ground tooth differs from the theoretical one. Positive removes material."""

    equidistant_um: Annotated[
        float, key("Wheel radius larger than the pin by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    radial_moving_um: Annotated[
        float, key("Pin circle of generation smaller by this much [µm].", _AMOUNT, **_AMOUNTS)
    ] = 0.0
    rotation_arcmin: Annotated[
        float,
        key("Turn of each flank away from its pin [arc minutes].", "give an angle in arc minutes", ge=-60, le=60),
    ] = 0.0
    deformation_compensation: Annotated[
        bool | float,
        key("true: from the load; false: none; a number: delta_max [µm].", "give true, false or delta_max in µm"),
    ] = False
    compensation_solver: Annotated[
        Literal["equilibrium", "classical", "stage"], key("Which load sharing finds delta_max.", "")
    ] = "equilibrium"
    compensation_load_share: Annotated[
        float,
        key("Share of the rated torque whose deformation is compensated.", "give 1 for the rated torque", gt=0, le=3),
    ] = 1.0
