"""The disc with its holes: location of the least wall, negative for intersections."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.geometry import DiscOutline, circular_contour, ring_of_holes, thinnest_web


def test_radii_of_the_outline_are_root_and_tip(theoretical):
    outline = DiscOutline(theoretical, ())
    assert outline.root_radius == pytest.approx(59.7, abs=1e-12)
    assert outline.tip_radius == pytest.approx(62.3, abs=1e-12)


def test_disc_without_holes_has_no_wall(theoretical):
    assert thinnest_web(DiscOutline(theoretical, ())) == (math.inf, "no holes")


@given(st.integers(1, 12), st.floats(10.0, 50.0), st.floats(0.5, 8.0))
def test_ring_of_holes_is_even_and_starts_on_the_x_axis(theoretical, count, circle_radius, radius):
    holes = DiscOutline(theoretical, ring_of_holes("crank", count, circle_radius, radius)).holes
    assert [hole.name for hole in holes] == [f"crank {i + 1}" for i in range(count)]
    assert holes[0].centre == pytest.approx(circle_radius)
    assert sum(hole.centre for hole in holes) == pytest.approx(circle_radius if count == 1 else 0.0, abs=1e-10)
    # Counted anticlockwise, as the discs and their cranks are (docs/conventions.md).
    around = [circle_radius * complex(math.cos(a), math.sin(a)) for a in np.arange(count) * 2.0 * math.pi / count]
    assert [hole.centre for hole in holes] == pytest.approx(around, abs=1e-12 * circle_radius)
    assert all(hole.radius == radius for hole in holes)


def test_wall_to_the_teeth_is_measured_at_the_nearest_root(theoretical):
    # Phase 0 of the tooth curve, a root, lies on the x axis.
    hole = circular_contour("bore", 50.0 + 0j, 5.0)
    wall, place = thinnest_web(DiscOutline(theoretical, (hole,)))
    assert wall == pytest.approx(59.7 - 50.0 - 5.0, abs=3e-3)
    assert place == "bore and teeth"


def test_wall_between_holes_names_both(theoretical):
    holes = ring_of_holes("crank", 6, 30.0, 14.0)
    wall, place = thinnest_web(DiscOutline(theoretical, holes))
    assert wall == pytest.approx(30.0 - 28.0, abs=1e-9)
    assert place in {f"crank {i + 1} and crank {(i + 1) % 6 + 1}" for i in range(6)} | {"crank 1 and crank 6"}


@pytest.mark.parametrize(
    ("holes", "wall"),
    [
        ((circular_contour("a", 10.0 + 0j, 6.0), circular_contour("b", 20.0 + 0j, 6.0)), -2.0),
        ((circular_contour("a", 58.0 + 0j, 5.0),), -3.3),
        ((circular_contour("a", 90.0 + 0j, 5.0),), -5.0),
    ],
    ids=["into each other", "through the teeth", "outside the disc"],
)
def test_cuts_are_negative(theoretical, holes, wall):
    assert thinnest_web(DiscOutline(theoretical, holes))[0] == pytest.approx(wall, abs=3e-3)
