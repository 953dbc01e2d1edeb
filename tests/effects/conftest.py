"""The reducer that effects are laid on: RV-40E with 6 µm of equidistant clearance, at rated torque."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.registry import build, effect
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.modification.setup import Equidistant, modify


@pytest.fixture(scope="session")
def case(rv40e: Drive, rated_torque: float) -> LoadCase:
    """The load case of the drawing."""
    return LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)


@pytest.fixture(scope="session")
def built_with(case: LoadCase) -> Callable[..., Built]:
    """Builds the reducer with effects given as tables of a spec file."""

    def built(*tables: dict[str, Any]) -> Built:
        return build(case, [effect(table) for table in tables])

    return built
