"""Least radii, inflection and undercut limit against searches on a fine grid."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.geometry import ToothProfile, Trochoid, inflection_phase, least_radii, undercut_limit
from cycloid_profile.modification import DeformationCompensation, FlankRotation, modify


@given(st.integers(3, 120), st.floats(0.02, 0.97))
def test_undercut_limit_is_the_least_convex_radius_of_the_trochoid(pins, K1):
    trochoid = Trochoid(pins, 1.0, K1 / pins)
    # Dense towards the root, where sharp trochoids have the largest curvature.
    psi = math.pi * np.linspace(0.0, 1.0, 20001) ** 2
    curvature = -trochoid.derivatives(psi).turn * trochoid.lobes / trochoid.speed_ratio(psi)
    assert undercut_limit(trochoid) == pytest.approx(1.0 / np.max(curvature), rel=1e-5)


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_tooth_runs_backwards_only_beyond_the_undercut_limit(share):
    trochoid = Trochoid(40, 64.0, 1.3)
    psi = np.linspace(0.0, math.pi, 20001)
    # Speed of the parallel curve along the trochoid's direction: its zero is the cusp.
    speed = trochoid.pin_circle_radius / trochoid.lobes * trochoid.speed_ratio(psi)
    speed = speed + share * undercut_limit(trochoid) * trochoid.derivatives(psi).turn
    assert (np.min(speed) > 0.0) == (share < 1.0)


@given(st.integers(3, 120), st.floats(0.1, 0.95), st.floats(0.05, 0.9))
def test_curvature_changes_sign_at_the_inflection(pins, K1, share):
    trochoid = Trochoid(pins, 50.0, K1 * 50.0 / pins)
    tooth = ToothProfile(trochoid, share * undercut_limit(trochoid))
    psi = inflection_phase(tooth)
    if K1 * pins <= 1.0:
        assert math.isnan(psi)
        assert np.all(tooth.at(np.linspace(0.0, 6.28, 100)).curvature < 0.0)
    else:
        assert tooth.at(0.999 * psi).curvature > 0.0 > tooth.at(psi + 1e-3 * (math.pi - psi)).curvature


def test_tooth_without_concave_part_says_so():
    tooth = ToothProfile(Trochoid(3, 30.0, 2.0), 4.0)
    assert math.isnan(inflection_phase(tooth))
    assert math.isinf(least_radii(tooth).concave)


@pytest.mark.parametrize("amount", [0.0, 0.004, -0.004])
def test_least_radii_are_those_of_a_finer_grid(theoretical, amount):
    tooth = modify(theoretical, DeformationCompensation(amount))
    psi = np.linspace(1e-9, math.pi - 1e-9, 400_001)
    kappa = tooth.at(psi).curvature
    radii = least_radii(tooth)
    # Grid of 0.05° refined by a parabola; the largest curvature of a compensated tooth may lie next to a corner.
    assert radii.convex == pytest.approx(-1.0 / np.min(kappa), rel=1e-6)
    assert radii.concave == pytest.approx(1.0 / np.max(kappa), rel=1e-6)


@pytest.mark.parametrize(("pins", "radius", "eccentricity", "pin"), [(40, 64.0, 1.3, 3.0), (24, 50.0, 1.7, 2.0)])
def test_least_convex_radius_is_the_closed_form_less_the_pin(pins, radius, eccentricity, pin):
    tooth = ToothProfile(Trochoid(pins, radius, eccentricity), pin)
    # The stationary point lies between two points of the grid, whose best is off by some 1e-7.
    expected = undercut_limit(tooth.trochoid) - pin
    assert least_radii(tooth).convex == pytest.approx(expected, rel=2e-9)


def test_largest_corner_is_the_turn_of_the_tangent_in_closed_form(theoretical):
    # Across the root h' jumps from −A S³(1 − K1)² to +A S³(1 − K1)² = ±A/(1 − K1); the base curve runs at
    # |P'| there, so the tangent turns by 2 atan(A/((1 − K1)|P'|)).
    amount = 0.004
    tooth = modify(theoretical, DeformationCompensation(amount))
    turn = 2.0 * math.atan(amount / (1.0 - 0.8125) / abs(theoretical.at(0.0).first))
    assert least_radii(tooth).largest_corner == pytest.approx(turn, rel=1e-9)


def test_corner_grows_with_the_amount_and_not_with_its_sign(theoretical):
    lever = theoretical.trochoid.longest_lever
    corners = [least_radii(modify(theoretical, FlankRotation(a / lever))).largest_corner for a in (2e-3, -2e-3, 4e-3)]
    assert corners[0] == pytest.approx(corners[1], rel=1e-9)
    assert corners[2] == pytest.approx(2.0 * corners[0], rel=1e-5)
