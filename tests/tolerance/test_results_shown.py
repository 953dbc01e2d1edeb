"""Results of a study in a session: a short ``repr``, and a table for pandas."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import pytest

from cycloid_profile.tolerance import (
    Draws,
    Limit,
    Sobol,
    Study,
    Threads,
    WorkingPoint,
    allocate,
    contributions,
    run,
    sobol_shares,
    summarise,
    tolerances_of,
)
from cycloid_profile.tolerance.allocation import SampleSizes

PINS = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 4.0}},
    {"name": "equidistant_error", "each": "disc", "amount_um": {"plus_minus": 4.0}},
)


@pytest.fixture(scope="module")
def results(small, tmp_path_factory):
    study = Study(small, Draws(tolerances_of(PINS, (), small), sequence=Sobol()), ("backlash_arcmin",), 512, 256)
    limits = [Limit("backlash_arcmin", at_most=12.0)]
    point = WorkingPoint.of(small, study.tolerances)
    return {
        "summary": summarise(run(study, tmp_path_factory.mktemp("samples"), Threads(1)), limits),
        "contributions": contributions(study, limits, resamples=5),
        "shares": sobol_shares(study, 128, point.gradients, resamples=5),
        # A yield that the tolerances reach at once, and few reducers: the text is asked, not the optimum.
        "allocation": allocate(study.draws, study.quantity_model, limits, 0.9, SampleSizes(128, 256)),
    }


@pytest.mark.parametrize("name", ["summary", "contributions", "shares", "allocation"])
def test_a_result_fits_a_screen(results, name):
    lines = repr(results[name]).splitlines()
    assert 3 <= len(lines) <= 15
    assert lines[0] == type(results[name]).__name__
    assert all(len(line) < 140 for line in lines)


@pytest.mark.parametrize(("name", "rows"), [("summary", 2), ("contributions", 2), ("shares", 4), ("allocation", 2)])
def test_a_result_becomes_a_table(results, name, rows, monkeypatch):
    # Columns alone: pandas is not installed everywhere.
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    columns = results[name].to_frame()
    assert {len(column) for column in columns.values()} == {rows}
