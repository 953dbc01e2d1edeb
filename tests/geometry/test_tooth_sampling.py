"""Sampling keeps its promise of chord error, equal arc or equal angle, and wastes few points."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import (
    ChordTolerance,
    EqualAngle,
    EqualArc,
    EqualNormalAngle,
    ToothProfile,
    Trochoid,
    chord_error,
    flank_of_interval,
    flank_side,
    sample,
    smooth_pieces,
    undercut_limit,
)
from cycloid_profile.modification import DeformationCompensation, Equidistant, modify

STRATEGIES = [ChordTolerance(1e-3), EqualArc(61), EqualAngle(61), EqualNormalAngle(61)]
GAUSS_X, GAUSS_W = np.polynomial.legendre.leggauss(12)


@pytest.fixture(scope="module")
def compensated(theoretical):
    return modify(theoretical, Equidistant(0.006), DeformationCompensation(0.004))


@st.composite
def teeth(draw):
    pins, K1 = draw(st.integers(3, 120)), draw(st.floats(0.1, 0.95))
    trochoid = Trochoid(pins, 64.0, K1 * 64.0 / pins)
    tooth = ToothProfile(trochoid, draw(st.floats(0.05, 0.9)) * undercut_limit(trochoid))
    return modify(tooth, DeformationCompensation(draw(st.sampled_from([0.0, 0.001, 0.003]))))


def one_lobe(tooth, sampling):
    """Phases with the end of the lobe."""
    return np.append(sampling.phases(tooth), 2.0 * math.pi)


def measured_chord_error(tooth, nodes):
    """Largest distance from chord to curve at 63 places between the nodes; the package looks at five."""
    ends = tooth.at(nodes).position
    along = np.diff(ends) / np.abs(np.diff(ends))
    psi = nodes[:-1] + np.linspace(0.0, 1.0, 65)[1:-1, np.newaxis] * np.diff(nodes)
    return float(np.max(np.abs((np.conj(along) * (tooth.at(psi).position - ends[:-1])).imag)))


def arcs(tooth, nodes):
    """Arc length between nodes by 12-point Gauss quadrature."""
    half = 0.5 * np.diff(nodes)
    psi = nodes[:-1] + half * (1.0 + GAUSS_X[:, np.newaxis])
    return half * (GAUSS_W @ np.abs(tooth.at(psi).first))


@given(teeth(), st.floats(-6.0, -2.0))
def test_chords_stay_within_the_tolerance(tooth, exponent):
    tolerance = 10.0**exponent
    nodes = one_lobe(tooth, ChordTolerance(tolerance))
    assert np.all(np.diff(nodes) > 0.0)
    # 1 %: on the S-shaped chord across an inflection the largest offset lies at 0.21, outside the five places.
    assert measured_chord_error(tooth, nodes) <= 1.01 * tolerance


@pytest.mark.parametrize("tolerance", [1e-4, 5e-5, 1e-6])
def test_chord_sampling_is_near_the_least_number_of_points(theoretical, tolerance):
    # No polyline does with fewer than ∫√(|κ|/(8 tol)) ds chords, as tol → 0.
    psi = np.linspace(0.0, 2.0 * math.pi, 100_001)
    points = theoretical.at(psi)
    least = np.trapezoid(np.sqrt(np.abs(points.curvature) / (8.0 * tolerance)) * np.abs(points.first), psi)
    count = ChordTolerance(tolerance).phases(theoretical).size
    assert least <= count <= 1.04 * least


def test_a_piece_of_a_lobe_has_the_flank_of_its_points(theoretical, compensated):
    for tooth in (theoretical, compensated):
        for low, high in smooth_pieces(tooth):
            inside = np.linspace(low, high, 12)[1:-1]
            np.testing.assert_array_equal(flank_of_interval(low, high, inside), flank_side(inside))
    # At a corner the branch is that of the piece.
    assert flank_of_interval(0.0, math.pi, np.array([math.pi])) == 1.0
    assert flank_of_interval(math.pi, 2.0 * math.pi, np.array([math.pi])) == -1.0


def test_chord_error_falls_with_the_square_of_the_number_of_points(theoretical):
    counts = np.array([50, 100, 200, 400, 800])
    errors = [chord_error(theoretical, one_lobe(theoretical, EqualArc(n))) for n in counts]
    assert -np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.05)


def test_points_needed_grow_with_the_inverse_root_of_the_tolerance(theoretical):
    tolerances = np.array([1e-3, 1e-4, 1e-5, 1e-6])
    counts = [ChordTolerance(t).phases(theoretical).size for t in tolerances]
    assert -np.polyfit(np.log(tolerances), np.log(counts), 1)[0] == pytest.approx(0.5, abs=0.02)


def test_reported_chord_error_is_the_measured_one(compensated):
    nodes = one_lobe(compensated, EqualArc(90))
    assert chord_error(compensated, nodes) == pytest.approx(measured_chord_error(compensated, nodes), rel=0.01)


@given(teeth(), st.integers(4, 200))
def test_equal_arc_is_equal_on_each_smooth_piece(tooth, count):
    nodes = one_lobe(tooth, EqualArc(count))
    assert nodes.size == count + 1
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    for low, high in smooth_pieces(tooth):
        piece = arcs(tooth, nodes)[(middle > low) & (middle < high)]
        # Phases come from linear interpolation in a table of 16 384 steps.
        np.testing.assert_allclose(piece, np.mean(piece), rtol=1e-4)


@given(teeth(), st.integers(4, 200))
def test_equal_angle_is_equal_on_each_smooth_piece(tooth, count):
    nodes = one_lobe(tooth, EqualAngle(count))
    position = tooth.at(nodes).position
    step = -np.angle(position[1:] / position[:-1])
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    for low, high in smooth_pieces(tooth):
        piece = step[(middle > low) & (middle < high)]
        np.testing.assert_allclose(piece, np.mean(piece), rtol=1e-4)
    assert np.sum(step) == pytest.approx(2.0 * math.pi / tooth.trochoid.lobes, rel=1e-9)


@given(teeth(), st.integers(8, 200))
def test_equal_normal_angle_turns_by_equal_angles_between_points(tooth, count):
    nodes = one_lobe(tooth, EqualNormalAngle(count))
    assert nodes.size == count + 1
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    # The turn to and fro over an inflection counts both ways: Gauss's rule on the rate of turning, in pieces.
    for low, high in smooth_pieces(tooth):
        piece = nodes[np.append((middle > low) & (middle < high), False) | (nodes == high) | (nodes == low)]
        turning = []
        for a, b in itertools.pairwise(piece):
            psi = np.linspace(a, b, 513)  # 65 points miss the sharp roots of K1 near 1 by 2e-3
            points = tooth.at(psi, np.where(psi < math.pi, 1.0, -1.0) if len(smooth_pieces(tooth)) == 1 else
                              np.full(psi.shape, 1.0 if low < 0.5 * math.pi else -1.0))  # fmt: skip
            turning.append(np.trapezoid(np.abs(points.curvature * points.first), psi))
        np.testing.assert_allclose(turning, np.mean(turning), rtol=2e-3)


def test_equal_angle_on_a_smooth_tooth_divides_the_circle(theoretical):
    points = sample(theoretical, EqualAngle(50))
    step = -np.angle(np.roll(points.position, -1) / points.position)
    np.testing.assert_allclose(step, 2.0 * math.pi / (39 * 50), rtol=1e-5)


@pytest.mark.parametrize("sampling", STRATEGIES, ids=lambda s: type(s).__name__)
def test_corners_are_always_sampled(compensated, sampling):
    phases = sampling.phases(compensated)
    assert phases[0] == 0.0
    assert np.any(phases == math.pi)
    assert phases[-1] < 2.0 * math.pi


@pytest.mark.parametrize("sampling", STRATEGIES, ids=lambda s: type(s).__name__)
def test_sample_goes_round_once_with_identical_lobes(compensated, sampling):
    points = sample(compensated, sampling)
    lobe = sampling.phases(compensated)
    assert points.phase.size == 39 * lobe.size
    assert np.all(np.diff(points.phase) > 0.0)
    assert points.phase[-1] < compensated.trochoid.phase_period
    # Clockwise, once round; the step from the last point to the first is a step like the others.
    step = -np.angle(np.roll(points.position, -1) / points.position)
    assert np.all(step > 0.0)
    assert np.sum(step) == pytest.approx(2.0 * math.pi, abs=1e-12)
    assert step[-1] == pytest.approx(step[lobe.size - 1], rel=1e-9)
    turn = np.exp(-2j * math.pi * np.arange(39) / 39)[:, np.newaxis]
    for field in ("position", "first", "second"):
        values = getattr(points, field).reshape(39, -1)
        np.testing.assert_allclose(values, values[0] * turn, rtol=1e-14)
    # A corner keeps its branch, so derivatives are compared on positions only.
    np.testing.assert_allclose(points.position, compensated.at(points.phase).position, atol=1e-11)


def test_smooth_tooth_is_one_piece_and_a_compensated_one_two(theoretical, compensated):
    assert smooth_pieces(theoretical) == [(0.0, 2.0 * math.pi)]
    assert smooth_pieces(compensated) == [(0.0, math.pi), (math.pi, 2.0 * math.pi)]


@pytest.mark.parametrize("tolerance", [0.0, -1e-3, math.nan])
def test_chord_tolerance_must_be_positive(theoretical, tolerance):
    with pytest.raises(GeometryError, match="chord tolerance") as caught:
        ChordTolerance(tolerance).phases(theoretical)
    assert caught.value.value == f"{tolerance} mm"
    assert caught.value.remedy


@pytest.mark.parametrize("sampling", [EqualArc, EqualAngle, EqualNormalAngle])
def test_too_few_points_are_refused(theoretical, compensated, sampling):
    assert sampling(2).phases(theoretical).size == 2
    for tooth, least in ((theoretical, 2), (compensated, 4)):
        with pytest.raises(GeometryError, match=f"points per lobe = {least - 1} is below {least}: ask for more"):
            sampling(least - 1).phases(tooth)


def test_odd_number_of_points_is_kept_with_corners(compensated):
    assert EqualArc(61).phases(compensated).size == 61
