"""Reducers that tolerance studies are run on: a small one that is quick, and the RV-40E."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.geometry import Cranks, Drive, InvoluteStage, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import Tolerances, tolerances_of
from cycloid_profile.tolerance.model._crank_locked import CrankLockedBacklash
from cycloid_profile.tolerance.study import Draws


@pytest.fixture(scope="session")
def small() -> AsBuiltReducer:
    """Eleven pins, two discs on three cranks, 20 µm of clearance."""
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 2, Cranks(3, 14.0, 1e5), InvoluteStage(12, 36, 1.0))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 2e4))


@pytest.fixture(scope="session")
def large(rv40e: Drive, rated_torque: float) -> AsBuiltReducer:
    """RV-40E with 6 µm of clearance."""
    return as_drawn(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque))


@pytest.fixture(scope="session")
def scattered(small: AsBuiltReducer) -> Callable[..., Tolerances]:
    """Tolerances of the small reducer from tables of a spec file."""

    def made(
        *tables: dict[str, Any], correlations: tuple[Any, ...] = (), reducer: AsBuiltReducer = small
    ) -> Tolerances:
        return tolerances_of(tables, correlations, reducer)

    return made


@pytest.fixture(scope="session")
def made_with() -> Callable[[AsBuiltReducer, Tolerances, np.ndarray], AsBuiltReducer]:
    """One reducer made by its coordinates, effect by effect, for the exact model."""

    def made(reducer: AsBuiltReducer, tolerances: Tolerances, x: np.ndarray) -> AsBuiltReducer:
        columns = Draws(tolerances).columns
        for one, begin, end in zip(tolerances.scatters, columns, columns[1:], strict=False):
            for choice, own in zip(one.choices, x[begin:end].reshape(len(one.choices), -1), strict=True):
                if np.any(own):
                    reducer = one.axes.effect(own, choice).apply(reducer)
        return reducer

    return made


@pytest.fixture(scope="session")
def backlash_gradient() -> Callable[[CrankLockedBacklash, np.ndarray], np.ndarray]:
    """Derivative of the largest backlash by every coordinate, shape (reducers, coordinates) [rad per unit].

    Exact wherever one contact alone is the first on its flank (Danskin's theorem).
    """

    def gradient(stage: CrankLockedBacklash, x: np.ndarray) -> np.ndarray:
        matrix = stage.by_unit.toarray().reshape(*stage.base.shape, -1)
        found = np.empty((len(x), matrix.shape[-1]))
        for i, one in enumerate(x):
            turn = stage.base + matrix @ one
            first = np.min(turn, axis=0)
            pose = int(np.argmax(first[: stage.poses] + first[stage.poses :]))
            found[i] = sum(matrix[np.argmin(turn[:, flank]), flank] for flank in (pose, stage.poses + pose))
        return found

    return gradient
