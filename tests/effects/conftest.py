"""The reducer that effects act on: RV-40E with 6 µm of equidistant clearance, at rated torque."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import AsBuiltReducer, apply_effects, effect_from_table
from cycloid_profile.geometry import Drive
from cycloid_profile.modification import Equidistant, modify


@pytest.fixture(scope="session")
def case(rv40e: Drive, rated_torque: float) -> LoadCase:
    """The load case of the drawing."""
    return LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)


@pytest.fixture(scope="session")
def built_with(case: LoadCase) -> Callable[..., AsBuiltReducer]:
    """Builds the reducer with effects given as tables of a spec file."""

    def reducer(*tables: dict[str, Any]) -> AsBuiltReducer:
        return apply_effects(case, [effect_from_table(table) for table in tables])

    return reducer
