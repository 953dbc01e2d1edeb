"""Size over rollers, against rollers pressed in by hand: shapely's distance from a polygon of the textbook tooth."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from shapely import Point, Polygon

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import ToothProfile, Trochoid, least_radii, over_rollers
from cycloid_profile.modification import DeformationCompensation, Equidistant, modify


def tooth(pins: int, r_p: float, r_rp: float, a: float) -> Polygon:
    """Polygon of the unmodified disc, 20,000 points a lobe, by the textbook formula."""
    z_c, psi = pins - 1, np.linspace(0.0, 2.0 * math.pi * (pins - 1), (pins - 1) * 20_000, endpoint=False)
    K1, i_H = a * pins / r_p, pins / (pins - 1)
    S = (1.0 + K1**2 - 2.0 * K1 * np.cos(psi)) ** -0.5
    x = (r_p - r_rp * S) * np.cos((1 - i_H) * psi) - (a - K1 * r_rp * S) * np.cos(i_H * psi)
    y = (r_p - r_rp * S) * np.sin((1 - i_H) * psi) + (a - K1 * r_rp * S) * np.sin(i_H * psi)
    assert z_c >= 2
    return Polygon(np.stack([x, y], axis=-1))


@pytest.mark.parametrize("roller", [2.0, 3.0, 3.5, 4.5])
@pytest.mark.parametrize("pins", [11, 12])
def test_rollers_touch_the_tooth_and_do_not_cut_it(pins: int, roller: float) -> None:
    r_p, r_rp, a = 30.0, 3.0, 1.5
    found = over_rollers(ToothProfile(Trochoid(pins, r_p, a), r_rp), roller)
    disc = tooth(pins, r_p, r_rp, a)
    seated = brentq(lambda d: disc.distance(Point(d, 0.0)) - roller, r_p - a - r_rp + 1e-3, r_p + 20.0, xtol=1e-12)
    assert found.centre_radius == pytest.approx(seated, abs=1e-6)  # chords of the polygon: 2e-7 mm
    # The two roots farthest apart, found by going through all pairs.
    centres = seated * np.exp(2j * math.pi * np.arange(pins - 1) / (pins - 1))
    farthest = np.max(np.abs(centres[:, None] - centres[None, :]))
    assert found.size == pytest.approx(farthest + 2.0 * roller, abs=3e-6)


def test_a_pin_of_nominal_size_rests_where_the_exact_tooth_was_generated() -> None:
    found = over_rollers(ToothProfile(Trochoid(40, 64.0, 1.3), 3.0), 3.0)
    assert found.centre_radius == pytest.approx(64.0 - 1.3, abs=1e-12)
    assert found.size == pytest.approx(2.0 * (62.7 * math.cos(math.pi / 78.0) + 3.0), abs=1e-12)


@pytest.mark.parametrize("roller", [4.0, 4.5, 5.5])
def test_a_roller_on_both_flanks_lies_where_their_normals_meet(roller: float) -> None:
    profile = ToothProfile(Trochoid(12, 30.0, 1.5), 3.0)

    def axis(psi: float) -> complex:
        point = profile.at(np.array([psi]))
        return complex((point.position + roller * point.normal)[0])

    seat = brentq(lambda psi: axis(psi).imag, 0.05, 2.5, xtol=1e-14)
    found = over_rollers(profile, roller)
    assert found.centre_radius == pytest.approx(axis(seat).real, abs=1e-11)
    assert found.seat == pytest.approx(seat, abs=1e-6)  # the reach is flat at its largest


def test_removal_shows_over_the_rollers() -> None:
    theory = ToothProfile(Trochoid(40, 64.0, 1.3), 3.0)
    ground = modify(theory, Equidistant(0.006), DeformationCompensation(0.002))
    on_root = [over_rollers(p, 2.5).size for p in (theory, modify(theory, Equidistant(0.006)), ground)]
    share = math.cos(math.pi / 78.0)
    assert on_root[1] - on_root[0] == pytest.approx(-2.0 * 0.006 * share, abs=1e-12)
    # Material added to the flanks lifts a roller that rests on them, and leaves the bottom of the root alone.
    assert over_rollers(ground, 4.0).size > over_rollers(modify(theory, Equidistant(0.006)), 4.0).size
    # A small roller touches at the corner of the compensation: slopes ±α lift it by α²/2 over the curvature difference.
    alpha = 0.5 * least_radii(ground).largest_corner
    concave = float(modify(theory, Equidistant(0.006)).at(0.0).curvature)
    lift = share * alpha**2 / (1.0 / 2.5 - concave)
    assert on_root[2] - on_root[1] == pytest.approx(lift, rel=0.02)


def test_a_roller_without_size_is_refused() -> None:
    with pytest.raises(GeometryError, match="roller radius"):
        over_rollers(ToothProfile(Trochoid(40, 64.0, 1.3), 3.0), 0.0)
