"""The reducer on the rig: RV-40E with 6 µm of equidistant clearance, and samples measured of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer, apply_effects, effect_from_table
from cycloid_profile.spec import read_spec

MEASURED = Path(__file__).parent / "measured"


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the samples."""
    return MEASURED


@pytest.fixture(scope="session")
def drawn() -> AsBuiltReducer:
    """The reducer of the drawing."""
    return as_built_reducer(read_spec(MEASURED / "spec.toml"))


@pytest.fixture(scope="session")
def built_with(drawn: AsBuiltReducer) -> Callable[..., AsBuiltReducer]:
    """Builds the reducer with effects given as tables of a spec file."""

    def reducer(*tables: dict[str, Any]) -> AsBuiltReducer:
        return apply_effects(drawn.case, [effect_from_table(table) for table in tables])

    return reducer
