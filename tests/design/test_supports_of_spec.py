"""Elastic supports of a spec: switches, estimated sizes with their range, and their figures apart."""

from __future__ import annotations

from itertools import pairwise

import pytest

import cycloid_profile as cp
from cycloid_profile.contact import Supports
from cycloid_profile.design import drive_of, supports_of
from cycloid_profile.errors import CycloidError
from tests.spec_texts import PLAIN

SPEC = cp.catalog_drive("rv40e")
ON = {
    "drive.pin_seat.contact": True, "drive.pin_seat.bending": True, "drive.ring.elastic": True,
    "drive.pillars.elastic": True,
}  # fmt: skip


def supports(changes: dict) -> Supports:
    spec = SPEC.replace(changes)
    return supports_of(spec, drive_of(spec), 412e3)


def test_all_are_off_unless_switched_on():
    assert not supports({})
    assert not supports({"drive.pin_seat.span_mm": 4.0})
    assert not supports({"drive.ring.elastic": False, "drive.pillars.elastic": False})
    assert supports({"drive.pin_seat.bending": True}).names == ("pin seats",)
    assert supports({"drive.ring.outer_radius_mm": 80.0}).names == ("ring",)
    assert supports({"drive.pillars.radius_mm": 8.0}).names == ("pillars",)


def test_sizes_given_are_taken():
    found = supports({
        **ON, "drive.pin_seat.groove_clearance_um": 4.0, "drive.pin_seat.length_mm": 30.0, "drive.ring.width_mm": 40.0,
        "drive.ring.outer_radius_mm": 80.0, "drive.ring.waves": 3, "drive.ring.mounting_stiffness_n_per_mm2": 1e4,
        "drive.pillars.count": 6, "drive.pillars.length_mm": 20.0, "drive.pillars.far_share": 0.4,
    })  # fmt: skip
    seats, ring, pillars = found.seats, found.ring, found.pillars
    assert (seats.clearance, seats.length, seats.depth) == (0.004, 30.0, 13.0)
    assert (ring.width, ring.outer_radius, ring.waves, ring.mounting) == (40.0, 80.0, 3, 1e4)
    assert (pillars.count, pillars.length, pillars.far_share) == (6, 20.0, 0.4)


def test_estimates_lie_in_order():
    every = [
        supports({**ON, **{f"drive.{table}.estimate": name for table in ("pin_seat", "ring", "pillars")}})
        for name in ("stiff", "likely", "soft")
    ]
    for stiffer, softer in pairwise(every):
        assert stiffer.seats.seat_compliance < softer.seats.seat_compliance
        assert stiffer.ring.wave_compliance(2)[0, 0] < softer.ring.wave_compliance(2)[0, 0]
        assert stiffer.pillars.compliance < softer.pillars.compliance


def test_figures_list_supports_apart():
    plain = cp.parse_spec(PLAIN)
    rigid = cp.summary(cp.design_disc(plain))
    assert "supports" not in rigid
    found = cp.summary(cp.design_disc(plain.replace({key: ON[key] for key in list(ON)[:3]})))
    some = found["supports"]
    assert some["elastic"] == ["pin seats", "ring"]
    assert set(some["largest_recession_um"]) == {"pin seats", "ring"}
    assert min(some["largest_recession_um"].values()) > 0.0
    assert sum(some["rotation_arcmin"].values()) > rigid["under_load"]["twist_arcmin"]
    assert (
        found["compensated"]["torsional_rigidity_nm_per_arcmin"]
        < (rigid["compensated"]["torsional_rigidity_nm_per_arcmin"])
    )


@pytest.mark.parametrize(
    ("spec", "changes", "key"),
    [
        (SPEC, {"drive.ring.outer_radius_mm": 66.0}, "drive.ring.outer_radius_mm"),
        (SPEC, {**ON, "drive.pin_seat.length_mm": 20.0}, "drive.pin_seat.length_mm"),
        (SPEC, {**ON, "drive.pin_seat.span_mm": 40.0}, "drive.pin_seat.span_mm"),
        (cp.parse_spec(PLAIN), {"drive.pillars.elastic": True}, "drive.pillars"),
    ],
)
def test_impossible_supports_are_named_by_their_key(spec, changes, key):
    with pytest.raises(CycloidError, match=key):
        cp.design_disc(spec.replace(changes))
