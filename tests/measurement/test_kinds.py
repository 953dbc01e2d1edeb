"""Kinds of measurement: one object each, found by name, the same object after a transfer."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import HYSTERESIS, KINDS, Measurement, kind_named
from cycloid_profile.units import ARCMIN, ARCSEC, UM

every_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=str)


@every_kind
def test_a_kind_is_found_by_its_name_and_stays_itself(kind):
    assert kind_named(kind.name) is kind
    assert pickle.loads(pickle.dumps(kind)) is kind
    assert str(kind) == kind.name


@every_kind
def test_unit_and_its_size_belong_together(kind):
    assert kind.unit_size == {"um": UM, "arcmin": ARCMIN, "arcsec": ARCSEC}[kind.unit]
    assert kind.noise_key == f"noise_{kind.unit}"
    assert kind.value_column.endswith(kind.unit) is kind.is_curve


def test_a_misspelt_kind_brings_the_nearest():
    with pytest.raises(MeasurementError, match="did you mean hysteresis"):
        kind_named("hysterisis")


@every_kind
def test_a_measurement_introduces_itself_in_few_lines(kind):
    columns = {name: np.arange(5.0) for name in kind.columns}
    measured = Measurement(kind, columns, {"specimen": "A"}, "file.csv")
    shown = repr(measured)
    assert shown.count("\n") < 15
    assert kind.title in shown
    assert "file.csv" in shown


def test_a_measurement_becomes_a_table():
    pytest.importorskip("pandas")
    columns = {name: np.arange(5.0) for name in HYSTERESIS.columns}
    table = Measurement(HYSTERESIS, columns).to_frame()
    assert list(table.columns) == list(HYSTERESIS.columns)
    assert len(table) == 5
