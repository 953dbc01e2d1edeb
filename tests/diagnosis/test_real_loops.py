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


def loop(name: str, altered: Callable[[np.ndarray], np.ndarray]) -> Measurement:
    measured = read_measurement(FOLDER / name)
    return replace(measured, columns={key: altered(column) for key, column in measured.columns.items()})


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "altered"),
    [
        ("stiff_initial.csv", as_measured),
        ("play_initial.csv", as_measured),
        ("play_initial.csv", mirrored),
        ("play_initial.csv", from_another_row),
    ],
)
def test_friction_and_a_compliance_or_play_are_named(name: str, altered: Callable[[np.ndarray], np.ndarray]) -> None:
    found = diagnose(as_built_reducer(read_spec(FOLDER / "spec.toml")), [loop(name, altered)])
    names = {one.candidate.name for one in found.effects}
    assert any("friction" in one for one in names)
    assert names & GIVES_WAY
    (gap,) = found.gaps
    assert 1.0 - gap.held_out_after / gap.held_out_before > 0.8
