"""Properties of the wheel's path in C and X, and of its feed, over drives of 3 to 300 lobes and K1 from 0.1 to 0.95."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from cycloid_profile.errors import ExportError
from cycloid_profile.export.nc import (
    AxisLimits,
    feed_profile,
    groove_stock,
    least_concave_radius,
    polar_path,
    wheel_radius,
)
from cycloid_profile.geometry import ToothProfile, Trochoid, undercut_limit
from cycloid_profile.modification import (
    DeformationCompensation,
    Equidistant,
    FlankRotation,
    MeasuredDeviation,
    NormalDeviation,
    modify,
)

THEORY = ToothProfile(Trochoid(40, 64.0, 1.3), 3.0)
TOLERANCE = 1e-3
FREE = AxisLimits(1e9, 1e9, 1e9, 1e9)


@st.composite
def teeth(draw: st.DrawFn) -> ToothProfile:
    """Smooth teeth, teeth with grooves, and teeth with ridges at root and tip."""
    pins, K1 = draw(st.sampled_from([4, 5, 7, 12, 40, 120, 301])), draw(st.floats(0.1, 0.95))
    trochoid = Trochoid(pins, 64.0, K1 * 64.0 / pins)
    room = min(undercut_limit(trochoid), 64.0 * math.sin(math.pi / pins))
    tooth = ToothProfile(trochoid, draw(st.floats(0.2, 0.9)) * room)
    small = 1e-3 * tooth.pin_radius
    change = draw(
        st.sampled_from([None, DeformationCompensation(small), FlankRotation(small / trochoid.longest_lever)])
    )
    return modify(tooth, change) if change else tooth


def distance_all_round(tooth: ToothProfile, places: np.ndarray, radius: float) -> tuple[np.ndarray, float]:
    """Least distance of wheel centres from a fine row of points on the whole tooth, by brute force, and by how
    much that can be more than from the tooth itself [mm].
    """
    lobes = tooth.trochoid.lobes
    per_lobe = 2 * max(200, 10_000 // lobes)  # even: roots and tips, with their corners, are among the points
    psi = np.linspace(0.0, tooth.trochoid.phase_period, lobes * per_lobe, endpoint=False)
    points = tooth.at(psi)
    row = points.position
    half_step = 0.51 * float(np.max(np.abs(np.diff(row))))
    curvature = 1.0 / radius + float(np.max(np.abs(points.curvature)))
    return np.array([np.min(np.abs(row - place)) for place in places]), 0.5 * half_step**2 * curvature


@settings(max_examples=10, phases=[Phase.generate])
@given(tooth=teeth(), share=st.floats(0.1, 0.95), seed=st.integers(0, 1000))
def test_wheel_touches_everywhere_and_gouges_nowhere(tooth: ToothProfile, share: float, seed: int) -> None:
    limit = least_concave_radius(tooth)
    radius = share * (limit if math.isfinite(limit) else 20.0)
    path = polar_path(tooth, radius, TOLERANCE)
    # C rises from step to step, by one turn; the path closes.
    assert np.all(np.diff(path.c) > 0.0)
    assert path.c[-1] - path.c[0] == pytest.approx(2.0 * math.pi, abs=1e-12)
    assert path.x[-1] == pytest.approx(path.x[0], abs=1e-9)
    # Started at a tip: no node is further out, except while the wheel rolls about a ridge there.
    assert path.x[0] >= np.max(path.x) - 1e-3
    # At the steps the wheel touches and does not overlap, between them it strays by the tolerance: measured against
    # the whole tooth, neighbouring lobes included, by a search that knows nothing of the path.
    rng = np.random.default_rng(seed)
    at = rng.integers(0, path.c.size - 1, 12)
    share_on = rng.uniform(0.0, 1.0, 12)
    c, x = (v[at] + share_on * (v[at + 1] - v[at]) for v in (path.c, path.x))
    for places, tolerance in ((path.centre[at], 1e-9), (x * np.exp(-1j * c), TOLERANCE)):
        found, more = distance_all_round(tooth, places, radius)
        assert np.min(found - radius) >= -tolerance
        assert np.max(found - radius) <= tolerance + more


@settings(max_examples=6)
@given(amount=st.floats(0.0, 0.004), share=st.floats(0.3, 0.97))
def test_the_stock_in_a_groove_follows_from_its_angle(amount: float, share: float) -> None:
    # Flanks that meet at the angle 2α leave α²/(2(1/R − κ)) below a wheel that touches both.
    tooth = modify(THEORY, DeformationCompensation(amount)) if amount else THEORY
    radius = share * least_concave_radius(tooth)
    path = polar_path(tooth, radius, TOLERANCE)
    left = groove_stock(tooth, path.centre, radius)
    if not amount:
        assert left == 0.0
        return
    worst = 0.0
    for phase in (0.0, math.pi):
        before, after = (
            tooth.at(np.array([phase]), np.array([s])) for s in ((-1.0, 1.0) if phase == 0.0 else (1.0, -1.0))
        )
        half = 0.5 * abs(float(np.angle(after.first[0] / before.first[0])))
        worst = max(worst, half**2 / (2.0 * (1.0 / radius - float(before.curvature[0]))))
    # κ changes along the flank as far as the wheel stays away from the corner, the more the nearer R comes to 1/κ.
    assert left == pytest.approx(worst, rel=0.15, abs=1e-10)


def test_a_ridge_is_rolled_about() -> None:
    tooth = modify(THEORY, FlankRotation(2e-4))
    path = polar_path(tooth, 2.0, 5e-5)
    # The wheel rolls about the corner: its contact is fixed while the normal rotates.
    still = np.flatnonzero(np.abs(np.diff(path.contact)) < 1e-12)
    rotated = np.angle(path.normal[still] / path.normal[still + 1])
    corner = tooth.at(np.array([0.0, 0.0]), np.array([-1.0, 1.0])).first
    assert np.sum(rotated) > 39 * abs(np.angle(corner[0] / corner[1]))
    assert np.all(rotated > 0.0)


@pytest.mark.parametrize("radius", [3.0715, 3.2])
def test_published_least_concave_radius_is_the_limit(radius: float) -> None:
    assert wheel_radius(THEORY, 3.0713) == 3.0713
    with pytest.raises(ExportError, match=r"least concave radius of the tooth, 3\.0714 mm"):
        wheel_radius(THEORY, radius)


def test_default_wheel_goes_into_the_root_and_stays_a_wheel() -> None:
    assert wheel_radius(THEORY, None) == 2.4
    convex = ToothProfile(Trochoid(4, 64.0, 1.6), 3.0)
    assert math.isinf(least_concave_radius(convex))
    assert 20.0 < wheel_radius(convex, None) < 32.0


def test_lobes_that_differ_are_followed_each() -> None:
    drive = Trochoid(12, 64.0, 4.0)
    lobes = drive.lobes
    psi = np.linspace(0.0, 2.0 * math.pi * lobes, 20 * lobes, endpoint=False)
    runout = NormalDeviation(psi, 0.03 * np.cos(psi / lobes), lobes)
    tooth = modify(ToothProfile(drive, 10.0), Equidistant(0.006), MeasuredDeviation(runout))
    path = polar_path(tooth, 5.0, 1e-3)
    found, more = distance_all_round(tooth, path.centre[::40], 5.0)
    assert np.min(found) >= 5.0 - 1e-9
    assert np.max(found) <= 5.0 + more
    # Tips differ by the runout, between that of the lobes nearest to its ends; the program begins at the highest.
    tips = path.x[np.flatnonzero(np.diff(np.sign(np.diff(path.x))) < 0) + 1]
    at_tips = 0.03 * np.cos((2.0 * np.arange(lobes) + 1.0) * math.pi / lobes)
    assert np.ptp([*tips, path.x[0]]) == pytest.approx(np.ptp(at_tips), abs=2e-4)
    assert path.x[0] >= np.max(tips)


@given(tooth=teeth(), speed=st.floats(0.1, 100.0))
@settings(max_examples=4)
def test_without_limits_the_contact_speed_is_constant(tooth: ToothProfile, speed: float) -> None:
    path = polar_path(tooth, wheel_radius(tooth, None), TOLERANCE)
    feed = feed_profile(path, speed, FREE, tooth.trochoid.lobes)
    assert feed.speed == pytest.approx(speed, rel=1e-12)
    assert np.sum(feed.time) == pytest.approx(path.arc_length[-1] / speed, rel=1e-9)


@given(
    tooth=teeth(),
    speed=st.floats(5.0, 200.0),
    tightness=st.tuples(*(4 * [st.floats(0.2, 3.0)])),
)
@settings(max_examples=7)
def test_feed_is_as_fast_as_the_limits_allow(tooth: ToothProfile, speed: float, tightness: tuple[float, ...]) -> None:
    path = polar_path(tooth, wheel_radius(tooth, None), TOLERANCE)
    # Limits as shares of what the full speed would need.
    rates, seconds = (path.c_rate, path.x_rate), (path.c_second, path.x_second)
    need = [np.max(np.abs(v)) * speed for v in rates] + [np.max(np.abs(v)) * speed**2 for v in seconds]
    limits = AxisLimits(tightness[0] * need[0], tightness[1] * need[2], tightness[2] * need[1], tightness[3] * need[3])
    lobes = tooth.trochoid.lobes
    feed = feed_profile(path, speed, limits, lobes)
    steps = (path.c.size - 1) // lobes
    v2 = feed.speed[: steps + 1] ** 2
    pull = 0.5 * np.diff(v2) / np.diff(path.arc_length[: steps + 1])
    used = [np.full(steps, 0.0)]
    for rate, curvature, fastest, largest in (
        (path.c_rate[:steps], path.c_second[:steps], limits.c_speed, limits.c_acceleration),
        (path.x_rate[:steps], path.x_second[:steps], limits.x_speed, limits.x_acceleration),
    ):
        for end, at in ((0, v2[:-1]), (1, v2[1:])):
            used.append(np.abs(rate[:, end]) * np.sqrt(at) / fastest)
            used.append(np.abs(curvature[:, end] * at + rate[:, end] * pull) / largest)
    share = np.max(used, axis=0)
    assert np.max(share) <= 1.0 + 1e-6
    # Wherever the contact is slower than asked for, an axis is at its limit in the step before or after.
    slow = feed.speed[:steps] < speed * (1.0 - 1e-6)
    assert np.all(np.maximum(share, np.roll(share, 1))[slow] >= 1.0 - 1e-4)
