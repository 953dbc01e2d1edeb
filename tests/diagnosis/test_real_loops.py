"""Loops of a real printed reducer, whose true effects nobody knows.

Friction and a compliance or play explain most of it in plain least squares (docs/theory.md, "Loops of real reducers"):
Coulomb friction, series compliance and clearance leave 27.8′ of 187.7′ and 5.7′ of 22.8′.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.measurement import Measurement, read_measurement
from cycloid_profile.spec import read_spec

FOLDER = Path(__file__).parent / "real_printed_13to1"
GIVES_WAY = {"series_compliance", "nonlinear_series_compliance", "crank_bearing_clearance", "equidistant_error"}


def as_measured(column: np.ndarray) -> np.ndarray:
    return column


def mirrored(column: np.ndarray) -> np.ndarray:
    return -column


def from_another_row(column: np.ndarray) -> np.ndarray:
    return np.roll(column, -(column.size // 3))


def loop(name: str, altered: Callable[[np.ndarray], np.ndarray], angles: float) -> Measurement:
    """The loop with its rows ``altered`` and its angles that many times as large."""
    columns = {key: altered(column) for key, column in read_measurement(FOLDER / name).columns.items()}
    columns["angle_arcmin"] = angles * columns["angle_arcmin"]
    return replace(read_measurement(FOLDER / name), columns=columns)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "altered", "angles"),
    [
        ("stiff_initial.csv", as_measured, 1.0),
        ("play_initial.csv", as_measured, 1.0),
        ("play_initial.csv", mirrored, 1.0),
        ("play_initial.csv", from_another_row, 1.0),
        ("play_initial.csv", as_measured, 1.4),
    ],
)
def test_friction_and_a_compliance_or_play_are_named(
    name: str, altered: Callable[[np.ndarray], np.ndarray], angles: float
) -> None:
    found = diagnose(as_built_reducer(read_spec(FOLDER / "spec.toml")), [loop(name, altered, angles)])
    names = {one.candidate.name for one in found.effects}
    assert any("friction" in one for one in names)
    assert names & GIVES_WAY
    # No error of a pin or a tooth is as large as these parts give way.
    assert {one for one in names if "friction" not in one and "creep" not in one} <= GIVES_WAY
    (gap,) = found.gaps
    assert 1.0 - gap.held_out_after / gap.held_out_before > 0.8
    # Minutes of arc above a noise of 0.1′ to 2′ have a place, though a printed reducer may err by as much.
    assert found.within_model_error
    assert found.remainder is not None
    assert found.remainder.coordinate == "row"
    assert found.remainder.file == name
