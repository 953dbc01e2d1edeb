"""Keys of `[materials]`: the elastic constants of disc and pins."""

from __future__ import annotations

from typing import Annotated

from cycloid_profile.spec.table import Table, key


class MaterialSpec(Table, frozen=True):
    """Elastic constants of one body."""

    youngs_modulus_gpa: Annotated[float, key("Young's modulus [GPa].", "steel has 206", ge=1e-3, le=1e4)] = 206.0
    poisson_ratio: Annotated[float, key("Poisson's ratio.", "steel has 0.3", ge=0, lt=0.5)] = 0.3
    name: Annotated[
        str,
        key(
            "Name shown in drawings and STEP files; absent: steel, or its modulus.", "give a short name", max_length=40
        ),
    ] = ""


class MaterialsSpec(Table, frozen=True):
    """Materials of disc and pins; steel unless said otherwise."""

    disc: MaterialSpec = MaterialSpec()
    pin: MaterialSpec = MaterialSpec()
