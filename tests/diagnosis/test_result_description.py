"""A diagnosis has a short repr, and gives its effects as a table."""

from __future__ import annotations

import math
import sys
from types import SimpleNamespace

import pytest

from cycloid_profile.diagnosis import Diagnosis, diagnose
from cycloid_profile.effects import effect_from_table
from tests.diagnosis.correcting import drawn, scan_of


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    error = effect_from_table({"name": "disc_oval", "amplitude_um": 2.0, "phase_deg": 30.0, "disc": 1})
    return diagnose(drawn(), [scan_of(error.apply(drawn()), 5)])


def test_repr_names_verdict_effect_and_gap(found: Diagnosis) -> None:
    lines = repr(found).splitlines()
    assert lines[0] == "Diagnosis"
    assert len(lines) <= 15
    assert "effects_found" in lines[1]
    assert "disc_oval" in lines[2]
    assert "±" in lines[2]
    assert "noise" in lines[-1]


def test_table_has_a_row_for_each_parameter(found: Diagnosis, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    table = found.to_frame()
    assert table["effect"] == ["disc_oval"] * 3
    sizes = dict(zip(table["parameter"], zip(table["value"], table["uncertainty"], strict=True), strict=True))
    assert sizes["amplitude_um"][0] == pytest.approx(2.0, abs=0.1)
    assert 0.0 < sizes["amplitude_um"][1] < 0.1
    assert math.isnan(sizes["disc"][1])


def test_a_choice_with_a_name_is_shown_and_tabulated(monkeypatch: pytest.MonkeyPatch) -> None:
    # Wear is by pressure and sliding or by lever: its cause is a word among numbers.
    worn = effect_from_table({"name": "flank_wear", "amount_um": 3.0, "flank": 1, "disc": 1})
    found = diagnose(drawn(), [scan_of(worn.apply(drawn()), 5)])
    assert "by = pressure_sliding" in repr(found)
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=dict))
    assert "pressure_sliding" in found.to_frame()["value"]
