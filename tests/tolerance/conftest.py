"""Reducers that tolerance studies are run on: a small one that is quick, and the RV-40E."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.geometry.drive import Cranks, Drive, InvoluteStage
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.setup import Equidistant, modify
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.scatter_tables import tolerances_of


@pytest.fixture(scope="session")
def small() -> Built:
    """Eleven pins, two discs on three cranks, 20 µm of clearance."""
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 2, Cranks(3, 14.0, 1e5), InvoluteStage(12, 36, 1.0))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 2e4))


@pytest.fixture(scope="session")
def large(rv40e: Drive, rated_torque: float) -> Built:
    """RV-40E with 6 µm of clearance."""
    return as_drawn(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque))


@pytest.fixture(scope="session")
def scattered(small: Built) -> Callable[..., Tolerances]:
    """Tolerances of the small reducer from tables of a spec file."""

    def made(*tables: dict[str, Any], correlations: tuple[Any, ...] = (), built: Built = small) -> Tolerances:
        return tolerances_of(tables, correlations, built)

    return made


@pytest.fixture(scope="session")
def made_with() -> Callable[[Built, Tolerances, np.ndarray], Built]:
    """One reducer made by its coordinates, effect by effect, for the exact model."""

    def made(built: Built, tolerances: Tolerances, x: np.ndarray) -> Built:
        columns = Draws(tolerances).columns
        for one, begin, end in zip(tolerances.scatters, columns, columns[1:], strict=False):
            for choice, own in zip(one.choices, x[begin:end].reshape(len(one.choices), -1), strict=True):
                if np.any(own):
                    built = one.axes.effect(own, choice).apply(built)
        return built

    return made
