"""The error of a turn where further pins bear depends on what effects add, not on how many rows show it."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data.noise import Noise
from cycloid_profile.diagnosis.model._model_error import CornerWaves
from tests.diagnosis.test_bad_files import reducer

QUIET = Noise(1e-9)


def spread(position: np.ndarray, added: np.ndarray) -> float:
    """Standard deviation of the error, root mean square over the rows."""
    columns = CornerWaves.of(reducer(), position).error(added[:, np.newaxis], QUIET)
    return float(np.sqrt(np.mean(np.sum(columns**2, axis=1)))) if columns.size else 0.0


def turn(rows: int) -> np.ndarray:
    return np.arange(rows) * 2.0 * np.pi / rows


@pytest.mark.parametrize("rows", [360, 720, 1200, 1437, 4001])
@pytest.mark.parametrize("family", ["lobes", "pins"])
def test_the_error_is_a_share_of_what_an_effect_adds(rows, family):
    trochoid = reducer().case.drive.trochoid
    count = getattr(trochoid, family)
    added = np.cos(2 * count * turn(rows))
    assert spread(turn(rows), added) == pytest.approx(tuned.PINS_OF_TURN, rel=0.5)


@pytest.mark.parametrize("rows", [240, 720, 1437])
def test_forms_of_parts_and_the_ripple_of_equal_parts_add_no_corners(rows):
    trochoid = reducer().case.drive.trochoid
    for order in (0, 1, 3, trochoid.lobes * trochoid.pins):
        assert spread(turn(rows), np.cos(order * turn(rows) + 0.3)) < 1e-6


def test_a_part_of_a_turn_shows_no_corners_of_a_runout():
    part = 0.75 * turn(1200)
    assert spread(part, np.cos(part)) < 0.01


def test_rows_at_nearly_equal_distances_give_the_same_error():
    even = turn(1200)
    jittered = np.sort(even + np.random.default_rng(2).normal(0.0, 1e-5, even.size))
    pins = reducer().case.drive.trochoid.pins
    assert spread(jittered, np.cos(2 * pins * jittered)) == pytest.approx(
        spread(even, np.cos(2 * pins * even)), rel=0.1
    )
