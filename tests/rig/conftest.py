"""The reducer on the rig: RV-40E with 6 µm of equidistant clearance, and samples measured of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.design.ground import built_reducer
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.registry import build, effect
from cycloid_profile.spec.read import read_spec

MEASURED = Path(__file__).parent / "measured"


@pytest.fixture(scope="session")
def measured() -> Path:
    """Folder of the samples."""
    return MEASURED


@pytest.fixture(scope="session")
def drawn() -> Built:
    """The reducer of the drawing."""
    return built_reducer(read_spec(MEASURED / "spec.toml"))


@pytest.fixture(scope="session")
def built_with(drawn: Built) -> Callable[..., Built]:
    """Builds the reducer with effects given as tables of a spec file."""

    def built(*tables: dict[str, Any]) -> Built:
        return build(drawn.case, [effect(table) for table in tables])

    return built
