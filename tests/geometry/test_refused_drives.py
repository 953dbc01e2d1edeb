"""Impossible drives are refused with value, limit and remedy."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.errors import CycloidError, GeometryError
from cycloid_profile.geometry import (
    CentralEccentric,
    Cranks,
    Drive,
    InvoluteStage,
    ToothProfile,
    Trochoid,
    undercut_limit,
)


def drive(pins=40, r_p=64.0, a=1.3, r_rp=3.0, width=11.5, discs=2):
    return Drive(Trochoid(pins, r_p, a), r_rp, width, discs, CentralEccentric(4e5))


REFUSED = [
    ({"pins": 2}, "pins", "below 3"),
    ({"r_p": 0.0}, "pin_circle_radius", "is not positive"),
    ({"r_p": math.inf}, "pin_circle_radius", "is not positive"),
    ({"a": -1.3}, "eccentricity", "is not positive"),
    ({"a": math.nan}, "eccentricity", "is not positive"),
    ({"a": 1.6}, "short-width ratio", "outside (0, 1)"),
    ({"a": 1.7}, "short-width ratio", "outside (0, 1)"),
    ({"r_rp": 0.0}, "pin_radius", "is not positive"),
    ({"r_rp": math.nan}, "pin_radius", "is not positive"),
    ({"r_rp": 4.62}, "pin_radius", "undercut limit 4.6117 mm"),
    ({"a": 0.5, "r_rp": 5.03}, "pin_radius", "overlap, the limit is 5.0214 mm"),
    ({"width": 0.0}, "disc_width", "is not positive"),
    ({"width": math.inf}, "disc_width", "is not positive"),
    ({"discs": 0}, "discs", "below 1"),
]


@pytest.mark.parametrize(("change", "what", "limit"), REFUSED, ids=[str(row[0]) for row in REFUSED])
def test_refusal_names_value_limit_and_remedy(change, what, limit):
    with pytest.raises(GeometryError) as caught:
        drive(**change)
    error = caught.value
    assert error.what.startswith(what)
    assert limit in error.limit
    # The sentence shown holds all four parts.
    for part in (error.what, str(error.value), error.limit, error.remedy):
        assert part
        assert part in str(error)
    assert isinstance(error, CycloidError)
    assert error.exit_code == 2


def test_value_in_the_message_is_the_offending_one():
    with pytest.raises(GeometryError, match=r"= 1\.0625 is outside \(0, 1\).*below 1\.6000 mm"):
        Trochoid(40, 64.0, 1.7)


@given(st.integers(3, 120), st.floats(0.1, 0.95), st.floats(0.05, 2.0), st.floats(10.0, 500.0))
def test_any_drive_is_built_or_refused_with_a_limit(pins, K1, share, r_p):
    trochoid = Trochoid(pins, r_p, K1 * r_p / pins)
    limit = min(undercut_limit(trochoid), r_p * math.sin(math.pi / pins))
    if share < 1.0:
        reducer = Drive(trochoid, share * limit, 10.0, 1, CentralEccentric(1e5))
        assert reducer.theoretical_profile.pin_radius == share * limit
    else:
        with pytest.raises(GeometryError) as caught:
            Drive(trochoid, share * limit, 10.0, 1, CentralEccentric(1e5))
        assert f"{share * limit:.7g} mm" == caught.value.value
        assert f"{limit:.4f} mm" in caught.value.limit or f"{undercut_limit(trochoid):.4f} mm" in caught.value.limit


def test_profile_alone_refuses_undercut_too():
    with pytest.raises(GeometryError, match="undercut"):
        ToothProfile(Trochoid(40, 64.0, 1.3), 4.7)


def test_first_stage_needs_cranks():
    with pytest.raises(
        GeometryError, match="first_stage = 12/36 teeth drives planets, which a central eccentric has not"
    ):
        Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, CentralEccentric(4e5), InvoluteStage(12, 36, 1.5))


def test_reduction_ratio_with_and_without_first_stage():
    trochoid, cranks = Trochoid(40, 64.0, 1.3), Cranks(3, 36.0, 4e5)
    assert Drive(trochoid, 3.0, 11.5, 2, cranks).reduction_ratio == 39.0
    assert Drive(trochoid, 3.0, 11.5, 2, cranks, InvoluteStage(10, 26, 1.25)).reduction_ratio == pytest.approx(105.0)
