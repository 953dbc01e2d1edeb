"""Openings as lines and arcs: closed, tangent at round corners, with the area of the polygon shapely makes of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from shapely import Polygon

from cycloid_profile.design.from_spec import disc_outline, drive_of, thinnest_wall
from cycloid_profile.errors import CycloidError, GeometryError
from cycloid_profile.geometry import (
    Arc,
    Contour,
    DiscOutline,
    Line,
    circular_contour,
    keyed_bore,
    ring_of_windows,
    thinnest_web,
)
from cycloid_profile.spec import parse_spec

RV40E = (Path(__file__).parents[2] / "examples" / "rv40e.toml").read_text(encoding="utf-8")


def polygon(contour: Contour, chord_error: float = 1e-5) -> Polygon:
    points = contour.points(chord_error)
    return Polygon(np.stack([points.real, points.imag], axis=-1))


def directions(segment: Line | Arc) -> tuple[complex, complex]:
    """Unit tangents at start and end."""
    if isinstance(segment, Line):
        tangent = (segment.end - segment.start) / abs(segment.end - segment.start)
        return tangent, tangent
    sign = math.copysign(1.0, segment.sweep)
    spokes = ((end - segment.centre) / segment.radius for end in (segment.start, segment.end))
    first, last = (sign * 1j * spoke for spoke in spokes)
    return first, last


@given(
    count=st.integers(1, 8),
    inner=st.floats(5.0, 40.0),
    width=st.floats(1.0, 30.0),
    fill=st.floats(0.05, 0.95),
    corner=st.floats(0.0, 1.0),
    first_at=st.floats(-6.0, 6.0),
)
def test_windows_are_closed_tangent_and_between_their_radii(
    count: int, inner: float, width: float, fill: float, corner: float, first_at: float
) -> None:
    span = fill * 2.0 * math.pi / count
    half = math.sin(0.5 * min(span, math.pi * 0.999))
    outer = inner + width
    limit = min(0.5 * width, inner * half / (1.0 - half), outer * half / (1.0 + half))
    windows = ring_of_windows("window", count, (inner, outer), span, 0.999 * corner * limit, first_at)
    assert len(windows) == count
    for window in windows:
        shape = polygon(window)
        assert shape.is_valid
        assert shape.exterior.is_ccw
        assert window.area == pytest.approx(shape.area, rel=1e-4)
        assert window.area <= 0.5 * span * (outer**2 - inner**2) * (1.0 + 1e-12)
        radius = np.abs(window.points(1e-3))
        assert inner - 1e-9 <= np.min(radius) <= np.max(radius) <= outer + 1e-9
        if corner > 0.01:
            ends = [directions(segment) for segment in window.segments]
            kinks = [abs(after[0] - before[1]) for before, after in zip(ends, ends[1:] + ends[:1], strict=True)]
            assert max(kinks) < 1e-5
    assert sum(window.area for window in windows) == pytest.approx(count * windows[0].area)


def test_a_window_with_sharp_corners_has_its_textbook_area_and_a_slot_round_ends() -> None:
    (sharp,) = ring_of_windows("w", 1, (20.0, 30.0), 1.0, 0.0, 0.3)
    assert sharp.area == pytest.approx(0.5 * 1.0 * (30.0**2 - 20.0**2), rel=1e-14)
    (slot,) = ring_of_windows("w", 1, (20.0, 30.0), 1.0, 5.0, 0.3)
    # A band 10 wide along its middle circle, between the centres of two half circles.
    between = 1.0 - 2.0 * math.asin(5.0 / 25.0)
    assert slot.area == pytest.approx(25.0 * between * 10.0 + math.pi * 25.0, rel=1e-14)
    assert all(isinstance(segment, Arc) for segment in slot.segments)


@pytest.mark.parametrize(("inner", "outer", "span"), [(5.0, 40.0, 0.5), (20.0, 60.0, 1.2), (20.0, 30.0, 1.0)])
def test_the_largest_corner_touches_the_other_one(inner: float, outer: float, span: float) -> None:
    # A circle that touches the inner arc from outside, a side, and the axis: or one as wide as the window.
    half = math.sin(0.5 * span)
    largest = min(inner * half / (1.0 - half), 0.5 * (outer - inner))
    (window,) = ring_of_windows("w", 1, (inner, outer), span, (1.0 - 1e-12) * largest, 0.0)
    assert polygon(window).is_valid
    with pytest.raises(GeometryError, match=f"limit is {largest:.4g} mm"):
        ring_of_windows("w", 1, (inner, outer), span, (1.0 + 1e-6) * largest, 0.0)


@given(
    count=st.integers(1, 4),
    width=st.floats(1.0, 8.0),
    depth=st.floats(0.2, 6.0),
    corner=st.floats(0.0, 1.0),
    first_at=st.floats(-6.0, 6.0),
)
def test_keyways_have_their_width_depth_and_area(
    count: int, width: float, depth: float, corner: float, first_at: float
) -> None:
    radius = 10.0
    assume(width < 1.9 * radius * math.sin(math.pi / max(count, 2)))
    rounding = 0.99 * corner * min(0.5 * width, depth)
    bore = keyed_bore("bore", radius, count, width, depth, rounding, first_at)
    half = 0.5 * width
    shoulder = math.sqrt(radius**2 - half**2)
    # Beyond the circle: a rectangle less the circle's cap inside it, less the area outside the corners.
    cap = radius**2 * math.asin(half / radius) - half * shoulder
    each = width * (radius + depth - shoulder) - cap - (2.0 - 0.5 * math.pi) * rounding**2
    assert bore.area == pytest.approx(math.pi * radius**2 + count * each, rel=1e-12)
    assert bore.area == pytest.approx(polygon(bore).area, rel=1e-4)
    along = bore.points(1e-4) * np.exp(-1j * first_at)
    assert np.max(along.real) == pytest.approx(radius + depth, abs=1e-9)


def test_contours_must_close() -> None:
    with pytest.raises(ValueError, match="open by"):
        Contour("gap", (Line(0j, 1 + 0j), Line(1 + 0j, 0.5j)))


def windows(inner: float, outer: float, span: float, more: str = "") -> str:
    radii = f"inner_radius_mm = {inner}\nouter_radius_mm = {outer}"
    return f"[disc.windows]\ncount = 3\n{radii}\nspan_deg = {span}\n{more}"


def keyway(width: float, depth: float, more: str = "") -> str:
    return f"[disc.keyway]\nwidth_mm = {width}\ndepth_mm = {depth}\n{more}"


@pytest.mark.parametrize(
    ("table", "says"),
    [
        (windows(48, 26, 50), "outer_radius_mm = 26 mm is not above inner_radius_mm = 48"),
        (windows(26, 48, 120), "span_deg = 120° leaves no web between 3 windows"),
        (windows(26, 48, 50, "corner_radius_mm = 12"), "does not fit into the window, the limit is 11 mm"),
        (windows(26, 48, 80), "wall between crank hole"),
        (windows(26, 60, 40), "and teeth = -"),
        (windows(15, 40, 40), "wall between bore and window"),
        (keyway(33, 3), "disc.keyway.width_mm = 33 mm is not below the limit 32 mm"),
        (keyway(6, 3, "corner_radius_mm = 3.5"), "disc.keyway.corner_radius_mm = 3.5 mm does not fit"),
        (keyway(6, 8), "wall between bore and crank hole 1"),
    ],
)
def test_openings_that_cannot_be_are_refused_in_one_sentence(table: str, says: str) -> None:
    spec = parse_spec(f"{RV40E}\n{table}\n")
    drive = drive_of(spec)
    with pytest.raises(CycloidError) as refused:
        thinnest_wall(disc_outline(spec, drive, drive.theoretical_profile))
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_openings_of_a_spec_in_their_order() -> None:
    spec = parse_spec(
        RV40E
        + "[disc.keyway]\nwidth_mm = 6.0\ndepth_mm = 2.8\nfirst_at_deg = 90.0\n"
        + "[disc.windows]\ncount = 3\ninner_radius_mm = 26.0\nouter_radius_mm = 48.0\nspan_deg = 50.0\n"
    )
    drive = drive_of(spec)
    outline = disc_outline(spec, drive, drive.theoretical_profile)
    assert [contour.name for contour in outline.contours] == [
        "bore", "crank hole 1", "crank hole 2", "crank hole 3", "window 1", "window 2", "window 3",
    ]  # fmt: skip
    assert [hole.name for hole in outline.holes] == ["crank hole 1", "crank hole 2", "crank hole 3"]
    # Windows lie midway between crank holes.
    centre = polygon(outline.contours[4]).centroid
    assert math.degrees(math.atan2(centre.y, centre.x)) == pytest.approx(60.0, abs=1e-6)
    wall, place = thinnest_wall(outline)
    inner = thinnest_web(DiscOutline(outline.profile, tuple(c for c in outline.contours if c.name != "bore")))
    assert wall <= inner[0]
    assert place


@pytest.mark.parametrize(("inner", "wall"), [(26.0, 10.0), (14.0, -2.0)])
def test_walls_next_to_windows_are_measured(theoretical, inner: float, wall: float) -> None:
    windows = ring_of_windows("window", 2, (inner, 45.0), 1.0, 3.0, 0.5)
    found, place = thinnest_web(DiscOutline(theoretical, (circular_contour("bore", 0j, 16.0), *windows)))
    assert found == pytest.approx(wall, abs=2e-3)
    assert place == "bore and window 1"


def test_a_span_wider_than_a_pitch_is_refused() -> None:
    with pytest.raises(GeometryError, match="leaves no web"):
        ring_of_windows("w", 4, (10.0, 20.0), 0.5 * math.pi, 1.0, 0.0)
