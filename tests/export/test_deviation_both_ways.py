"""Both directions of the deviation: a file may lie on the tooth and yet leave a part of it out."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from cycloid_profile.export.curves import deviation_both_ways
from cycloid_profile.export.curves.audit import Deviation
from cycloid_profile.geometry import ToothProfile, Trochoid
from cycloid_profile.modification import DeformationCompensation, Equidistant, modify

THEORY = ToothProfile(Trochoid(40, 64.0, 1.3), 3.0)
COMPENSATED = modify(THEORY, Equidistant(0.006), DeformationCompensation(0.002))
ROWS, POINTS = 39 * 8, 24


def rows(profile: ToothProfile, offset: float = 0.0, wave: float = 0.0) -> np.ndarray:
    """Rows along the curve moved along its normal, eight a lobe, none across a corner."""
    edges = np.linspace(0.0, 2.0 * math.pi * 39, ROWS + 1)
    psi = edges[:-1, None] + np.diff(edges)[:, None] * np.linspace(0.0, 1.0, POINTS)
    inner = profile.at(psi, np.where(np.arange(ROWS) % 8 < 4, 1.0, -1.0)[:, None] * np.ones_like(psi))
    return inner.position + (offset + wave * np.sin(psi / 39.0)) * inner.normal


@pytest.mark.parametrize("profile", [THEORY, COMPENSATED], ids=["smooth", "with corners"])
@given(offset=st.floats(-0.01, 0.01), wave=st.floats(-0.01, 0.01), seed=st.integers(0, 99))
def test_both_ways_give_the_offset_in_any_order_of_the_rows(
    profile: ToothProfile, offset: float, wave: float, seed: int
) -> None:
    found = np.random.default_rng(seed).permutation(rows(profile, offset, wave))
    found[::3] = found[::3, ::-1]
    both = deviation_both_ways(profile, found)
    # The wave is at its height somewhere between two points.
    largest = abs(offset) + abs(wave)
    assert both.largest == pytest.approx(largest, rel=1e-4, abs=1e-11)
    assert both.from_curve == pytest.approx(largest, rel=1e-4, abs=1e-11)


def test_a_piece_left_out_shows_only_from_the_curve() -> None:
    whole = rows(THEORY)
    for left_out in (slice(17, 18), slice(100, 140)):
        found = deviation_both_ways(THEORY, np.delete(whole, left_out, axis=0))
        assert found.largest < 1e-11
        exact = THEORY.at(np.linspace(0.0, 2.0 * math.pi * 39, 39 * 2000)).position
        rest = np.delete(whole, left_out, axis=0).ravel()
        tree = cKDTree(np.stack([rest.real, rest.imag], axis=-1))
        far, _ = tree.query(np.stack([exact.real, exact.imag], axis=-1))
        # The chord across the gap is at most as far as its ends.
        assert found.from_curve is not None
        assert 0.01 < found.from_curve <= np.max(far)


def test_a_curve_that_cuts_a_corner_shows_from_the_curve() -> None:
    # One chord where a root should be: its ends lie on the curve, its middle does not.
    whole = rows(THEORY)
    whole[39] = np.linspace(whole[39, 0], whole[39, -1], POINTS)
    found = deviation_both_ways(THEORY, whole)
    assert found.from_curve == pytest.approx(found.largest, rel=0.02)
    assert found.largest > 0.05


def test_of_points_that_are_equally_far_the_greatest_angle_is_given():
    points = 80.0 * np.exp(1j * np.array([-2.8, 1.0, 2.8]))
    for rounding in (-1e-14, 0.0, 1e-14):
        assert Deviation.of(points, np.array([-0.05 + rounding, 0.01, 0.05])).worst_angle == pytest.approx(2.8)
    assert Deviation.of(points, np.array([-0.06, 0.01, 0.05])).worst_angle == pytest.approx(-2.8)
