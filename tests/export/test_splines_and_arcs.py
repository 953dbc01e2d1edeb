"""Approximations on any drive: within their tolerance, closed, and of the expected order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import deviation, disc_arcs, disc_splines, distances, joined, lobe_arcs, lobe_splines
from cycloid_profile.geometry import ToothProfile, Trochoid, undercut_limit
from cycloid_profile.modification import DeformationCompensation, Equidistant, modify

THEORY = ToothProfile(Trochoid(40, 64.0, 1.3), 3.0)
COMPENSATED = modify(THEORY, Equidistant(0.006), DeformationCompensation(0.002))


@st.composite
def profiles(draw: st.DrawFn) -> ToothProfile:
    pins = draw(st.integers(4, 120))
    trochoid = Trochoid(pins, 64.0, draw(st.floats(0.15, 0.92)) * 64.0 / pins)
    room = min(undercut_limit(trochoid), 64.0 * math.sin(math.pi / pins))
    profile = ToothProfile(trochoid, draw(st.floats(0.2, 0.9)) * room)
    delta = draw(st.sampled_from([0.0, 0.002]))
    return modify(profile, DeformationCompensation(delta)) if delta else profile


@settings(deadline=None, max_examples=25)
@given(profile=profiles(), degree=st.sampled_from([3, 5]))
def test_splines_of_any_tooth_keep_their_tolerance_and_close(profile: ToothProfile, degree: int) -> None:
    curve = joined(disc_splines(profile, degree, 1e-4))
    assert deviation(profile, curve.dense()).largest <= 1e-4
    ends = curve.at(np.array([0.0, curve.knots[-1]]))
    assert abs(ends[1] - ends[0]) < 1e-12


@pytest.mark.slow
@settings(deadline=None, max_examples=25)
@given(profile=profiles())
def test_arcs_of_any_tooth_keep_their_tolerance_and_close(profile: ToothProfile) -> None:
    arcs = disc_arcs(profile, 2e-4)
    assert deviation(profile, arcs.points()).largest <= 2e-4
    assert arcs.ends[0] == arcs.ends[-1]


@pytest.mark.parametrize(("degree", "order"), [(3, 4.0), (5, 6.0)])
def test_spline_error_falls_with_the_expected_order(degree: int, order: float) -> None:
    # Interpolation by degree p is of order p + 1; the asked tolerance sets the number of spans.
    tolerances = 10.0 ** -np.arange(5, 10) if degree == 5 else 10.0 ** -np.arange(4, 8)
    spans, errors = [], []
    for tolerance in tolerances:
        piece, _ = lobe_splines(THEORY, degree, tolerance)
        spans.append(len(np.unique(piece.knots)) - 1)
        errors.append(float(np.max(np.abs(distances(THEORY, piece.dense())))))
    slope = -np.polyfit(np.log(spans), np.log(errors), 1)[0]
    # A quintic still gains on its order at these sizes (6.9); less than the order would be a fault.
    assert slope >= order - 0.4


def test_arc_error_falls_with_the_third_order() -> None:
    tolerances = np.array([1e-5, 1e-6, 1e-7, 1e-8])  # coarser ones gain on the order, as the nodes move
    chains = [lobe_arcs(THEORY, tolerance) for tolerance in tolerances]
    errors = [float(np.max(np.abs(distances(THEORY, chain.points())))) for chain in chains]
    slope = -np.polyfit(np.log([chain.curvature.size for chain in chains]), np.log(errors), 1)[0]
    assert slope == pytest.approx(3.0, abs=0.3)


@pytest.mark.parametrize("profile", [THEORY, COMPENSATED], ids=["theory", "compensated"])
def test_splines_are_split_at_every_tip_and_root_and_chain_bitwise(profile: ToothProfile) -> None:
    pieces = disc_splines(profile, 3, 1e-4)
    assert len(pieces) == 2 * profile.trochoid.lobes
    starts = np.array([piece.control_points[0] for piece in pieces])
    ends = np.array([piece.control_points[-1] for piece in pieces])
    assert np.array_equal(starts, np.roll(ends, 1))
    at_root, at_tip = abs(profile.at(0.0).position), abs(profile.at(math.pi).position)
    assert np.allclose(np.abs(starts), np.tile([at_root, at_tip], profile.trochoid.lobes), atol=2e-9)


def test_bezier_curves_are_the_spline() -> None:
    piece, _ = lobe_splines(COMPENSATED, 3, 1e-4)
    edges = np.unique(piece.knots)
    t = 0.3
    basis = np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    assert np.allclose(piece.beziers() @ basis, piece.at(edges[:-1] + t * np.diff(edges)), atol=1e-12)


def test_a_tolerance_out_of_reach_is_refused() -> None:
    with pytest.raises(ExportError, match="needs more than"):
        lobe_splines(THEORY, 3, 1e-18)
    with pytest.raises(ExportError, match="needs more than"):
        lobe_arcs(THEORY, 1e-18)


@given(offset=st.floats(-0.05, 0.05), seed=st.integers(0, 100))
def test_distances_are_what_a_point_was_moved_by(offset: float, seed: int) -> None:
    psi = np.random.default_rng(seed).uniform(0.0, THEORY.trochoid.phase_period, 40)
    points = THEORY.at(psi)
    assert np.allclose(distances(THEORY, points.position + offset * points.normal), offset, atol=1e-11)
