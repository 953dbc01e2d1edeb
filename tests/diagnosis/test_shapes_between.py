"""Shapes between two of the library: foreign scans name one effect with its shape, not two that imitate it."""

from __future__ import annotations

from functools import lru_cache

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import Hidden, Noise, Reducer, scan, spec_text

LOBES = 39


@lru_cache(maxsize=1)
def reducer() -> AsBuiltReducer:
    return as_built_reducer(parse_spec(spec_text(Reducer())))


@lru_cache(maxsize=1)
def library() -> Library:
    return Library(candidates(reducer(), frozenset({0}), False), 2)


def named(*hidden: Hidden) -> dict[str, dict[str, float]]:
    """Parameters by name of what a scan by the independent generator is diagnosed to have."""
    file = parse_measurement(scan(Reducer(), hidden, noise=Noise(0.2), seed=4), "scan.csv")
    found = diagnose(reducer(), [file])
    assert found.remainder is None
    return {one.candidate.name: dict(one.parameters) for one in found.effects}


@pytest.mark.slow
@pytest.mark.parametrize("exponent", [1.2, 1.75])
def test_wear_by_a_power_of_the_lever_has_one_name(exponent):
    found = named(Hidden("flank_wear", {"amount_um": 4.0, "flank": 1, "disc": 1, "x_exponent": exponent}))
    assert set(found) == {"flank_wear"}
    assert found["flank_wear"]["by"] == "lever"
    assert found["flank_wear"]["exponent"] == pytest.approx(exponent, abs=0.1)
    assert found["flank_wear"]["amount_um"] == pytest.approx(4.0, rel=0.02)


# In pitches from the tip before lobe 7: between two shapes of the library, and before the next lobe.
@pytest.mark.parametrize("start", [pytest.param(0.37, marks=pytest.mark.slow), 0.92])
def test_wheel_wear_that_jumps_inside_a_lobe_has_one_name(start):
    jump = {"x_start_rad": 6.283185 * start, "x_blend_rad": 0.5}
    found = named(Hidden("wheel_wear_drift", {"amount_um": 1.5, "first_lobe": 7, "disc": 1} | jump))
    assert set(found) == {"wheel_wear_drift"}
    one = found["wheel_wear_drift"]
    assert one["first_lobe"] + one["start_in_lobe"] == pytest.approx(7.0 + start, abs=0.03)
    assert one["amount_um"] == pytest.approx(1.5, rel=0.03)


def test_neighbouring_shapes_differ_by_one_step():
    pairs = [one for one in library().neighbouring_shapes if one.name == "wheel_wear_drift"]
    along = [library().candidates[i].along for one in pairs for i in (one.first, one.second)]
    steps = {(after - before) % LOBES for before, after in zip(along[0::2], along[1::2], strict=True)}
    assert steps == {0.25}
    assert len(pairs) == 4 * LOBES  # the last start of the last lobe is next to the first of lobe 1


def test_a_shape_between_two_is_a_share_of_the_way():
    wear = {float(one.choice["exponent"]): one for one in library().candidates if one.name == "flank_wear"}
    assert wear[1.0].between("exponent", wear[1.5], 0.42).choice["exponent"] == pytest.approx(1.2)
    last, first = (library().where("wheel_wear_drift", place) for place in (place_of(LOBES, 0.75), place_of(1, 0.0)))
    assert last is not None
    assert first is not None
    between = last.between("start_in_lobe", first, 0.8)
    assert (between.choice["first_lobe"], between.choice["start_in_lobe"]) == (LOBES, pytest.approx(0.95))
    assert not between.listed


def place_of(lobe: int, start: float) -> dict[str, object]:
    return {"first_lobe": lobe, "start_in_lobe": start, "disc": 1}
