"""The tooth follows docs/theory.md: formulas implemented a second time, in real coordinates.

The package computes with complex numbers and the half-angle form of S; here are the textbook formulas
x(ψ), y(ψ) with i_H = z_p/z_c, so that a slip in either shows.
"""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.geometry import ToothProfile, Trochoid, flank_side, undercut_limit
from cycloid_profile.modification import (
    DeformationCompensation,
    FlankRemoval,
    FlankRotation,
    MeasuredDeviation,
    NormalDeviation,
    modify,
)

RNG = np.random.default_rng(1)
PHASES = RNG.uniform(0.0, 78.0 * math.pi, 400)


@st.composite
def teeth(draw):
    """Any tooth that can exist: 3 to 120 pins, K1 from 0.1 to 0.95, pin below the undercut limit."""
    pins = draw(st.integers(3, 120))
    K1 = draw(st.floats(0.1, 0.95))
    r_p = draw(st.floats(10.0, 300.0))
    trochoid = Trochoid(pins, r_p, K1 * r_p / pins)
    return ToothProfile(trochoid, draw(st.floats(0.02, 0.9)) * min(undercut_limit(trochoid), 0.5 * r_p))


def textbook(trochoid, pin_radius, psi):
    """x + iy and normal by Eq. 7 written in cosines."""
    z_p, r_p, a = trochoid.pins, trochoid.pin_circle_radius, trochoid.eccentricity
    i_H, K1 = z_p / (z_p - 1), a * z_p / r_p
    S = 1.0 / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(psi))
    u, v = (1.0 - i_H) * psi, i_H * psi
    x = (r_p - pin_radius * S) * np.cos(u) - (a - K1 * pin_radius * S) * np.cos(v)
    y = (r_p - pin_radius * S) * np.sin(u) + (a - K1 * pin_radius * S) * np.sin(v)
    return x + 1j * y, S * (np.cos(u) - K1 * np.cos(v) + 1j * (np.sin(u) + K1 * np.sin(v)))


def exact(trochoid, pin_radius, psi, amount=0.0, side=1):
    """The same point by mpmath, with a flank removal of ``amount`` on the flank ``side``."""
    z_p, r_p, a = trochoid.pins, mp.mpf(trochoid.pin_circle_radius), mp.mpf(trochoid.eccentricity)
    z_c, K1 = z_p - 1, a * z_p / r_p
    S = 1 / mp.sqrt(1 + K1**2 - 2 * K1 * mp.cos(psi))
    centre = r_p * mp.expj(-psi / z_c) - a * mp.expj(-psi * z_p / z_c)
    normal = S * (mp.expj(-psi / z_c) - K1 * mp.expj(-psi * z_p / z_c))
    return centre - (pin_radius + amount * side * mp.sin(psi) * S) * normal


def test_coordinates_and_normal_are_the_textbook_ones(theoretical):
    position, normal = textbook(theoretical.trochoid, 3.0, PHASES)
    points = theoretical.at(PHASES)
    # Phases up to 245 rad carry a rounding of 3e-14 rad, times the 13 mm/rad of the root.
    np.testing.assert_allclose(points.position, position, atol=2e-12, rtol=0.0)
    np.testing.assert_allclose(points.normal, normal, atol=1e-12, rtol=0.0)
    np.testing.assert_allclose(theoretical.trochoid.derivatives(PHASES).normal, normal, atol=1e-12, rtol=0.0)
    np.testing.assert_array_equal(points.xy[:, 0], points.position.real)
    np.testing.assert_array_equal(points.xy[:, 1], points.position.imag)
    np.testing.assert_array_equal(theoretical.at(PHASES.reshape(20, 20)).xy, points.xy.reshape(20, 20, 2))


@given(teeth(), st.floats(-math.pi, math.pi))
def test_tooth_is_the_parallel_curve_of_the_trochoid(tooth, psi):
    trochoid, r = tooth.trochoid, tooth.pin_radius
    point = tooth.at(psi).position
    # In units of the pin circle: 1e-12 mm on the 64 mm of an RV-40E.
    rounding = 1.6e-14 * trochoid.pin_circle_radius
    assert abs(point - trochoid.derivatives(psi).centre) == pytest.approx(r, abs=rounding)
    around = np.linspace(psi - 1.0, psi + 1.0, 2001)
    assert np.min(np.abs(point - trochoid.derivatives(around).centre)) >= r - rounding


def test_rv40e_lies_one_pin_radius_inside_the_pin_centres_path_to_a_femtometre(theoretical):
    distance = np.abs(theoretical.at(PHASES).position - theoretical.trochoid.derivatives(PHASES).centre)
    np.testing.assert_allclose(distance, 3.0, atol=1e-12, rtol=0.0)


@pytest.mark.parametrize("amount", [0.0, -0.004, 0.003])
@pytest.mark.parametrize("psi", [0.3, 0.622, 1.7, 2.9, 3.6, 5.8])
def test_derivatives_agree_with_mpmath(theoretical, amount, psi):
    tooth = modify(theoretical, DeformationCompensation(-amount))
    side = 1 if psi < math.pi else -1
    with mp.workdps(40):
        first, second = (
            complex(mp.diff(lambda t: exact(tooth.trochoid, 3, t, mp.mpf(amount), side), mp.mpf(psi), n))
            for n in (1, 2)
        )
    point = tooth.at(psi)
    assert complex(point.first) == pytest.approx(first, rel=1e-12)
    assert complex(point.second) == pytest.approx(second, rel=1e-11)
    # Textbook curvature and normal of a curve run clockwise, whose outward side is on the left.
    bend = (first.conjugate() * second).imag / abs(first) ** 3
    assert float(point.curvature) == pytest.approx(bend, rel=1e-9)
    assert complex(point.normal) == pytest.approx(1j * first / abs(first), rel=1e-12)


@given(teeth(), st.floats(-3.1, 3.1))
def test_curvature_radius_follows_the_published_formula_with_its_sign(tooth, psi):
    trochoid = tooth.trochoid
    K1, z_p = trochoid.short_width_ratio, trochoid.pins
    B = K1 * (z_p + 1) * math.cos(psi) - (1.0 + z_p * K1**2)
    rho_trochoid = trochoid.pin_circle_radius * (1.0 + K1**2 - 2.0 * K1 * math.cos(psi)) ** 1.5
    # 1/ρ with ρ = rho_trochoid/B + r, written without a division by zero at the inflection.
    expected = B / (rho_trochoid + B * tooth.pin_radius)
    assert float(tooth.at(psi).curvature) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_root_is_concave_and_tip_is_convex(theoretical):
    assert theoretical.at(0.0).curvature > 0.0 > theoretical.at(math.pi).curvature


@given(teeth(), st.floats(-3.1, 3.1))
def test_turning_of_the_normal_is_its_derivative(tooth, psi):
    trochoid, h = tooth.trochoid, 1e-5
    turn = np.angle(trochoid.derivatives(psi + h).normal / trochoid.derivatives(psi - h).normal) / (2.0 * h)
    # Central difference: the error is h²/6 times a third derivative that grows as (1 − K1)^−3.
    tolerance = 1e-9 + h**2 / (1.0 - trochoid.short_width_ratio) ** 3
    assert turn == pytest.approx(float(trochoid.derivatives(psi).turn), abs=tolerance)
    turn_rate = (trochoid.derivatives(psi + h).turn - trochoid.derivatives(psi - h).turn) / (2.0 * h)
    tolerance = 1e-8 + 10.0 * h**2 / (1.0 - trochoid.short_width_ratio) ** 4
    assert turn_rate == pytest.approx(float(trochoid.derivatives(psi).turn_rate), abs=tolerance, rel=1e-6)


@given(teeth())
def test_lever_is_longest_at_the_critical_phase(tooth):
    trochoid = tooth.trochoid
    psi = np.linspace(-math.pi, math.pi, 2001)
    lever = trochoid.lever_function(psi)
    assert float(trochoid.lever_function(trochoid.critical_phase)) == pytest.approx(1.0, abs=1e-12)
    assert np.max(np.abs(lever)) <= 1.0 + 1e-12
    assert math.cos(trochoid.critical_phase) == pytest.approx(trochoid.short_width_ratio)
    np.testing.assert_allclose(lever, -lever[::-1], atol=1e-12)


@given(teeth(), st.floats(-3.0, 3.0))
def test_lever_is_the_arm_of_the_contact_normal(tooth, psi):
    arm = (np.conj(tooth.trochoid.derivatives(psi).centre) * tooth.trochoid.derivatives(psi).normal).imag
    lever = tooth.trochoid.longest_lever * tooth.trochoid.lever_function(psi)
    # The sign: positive ψ resists an anticlockwise disc (docs/conventions.md).
    assert float(arm) == pytest.approx(float(lever), abs=1e-12 * tooth.trochoid.pin_circle_radius)


def test_speed_ratio_keeps_its_digits_at_the_root_of_a_sharp_tooth():
    trochoid = Trochoid(40, 64.0, 1.6 * (1.0 - 1e-9))
    with mp.workdps(40):
        K1 = mp.mpf(trochoid.eccentricity) * 40 / 64
        expected = float(mp.sqrt(1 + K1**2 - 2 * K1 * mp.cos(mp.mpf(1e-8))))
    assert float(trochoid.speed_ratio(1e-8)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_flank_removal_and_its_derivatives_agree_with_mpmath(theoretical, side):
    psi = side * np.array([1e-3, 0.4, 0.622, 1.5, 3.1])
    jet = FlankRemoval(0.004).derivatives(psi, np.full_like(psi, side), theoretical.trochoid)
    with mp.workdps(30):
        K1 = mp.mpf(theoretical.trochoid.short_width_ratio)

        def removal(t):
            return mp.mpf(0.004) * side * mp.sin(t) / mp.sqrt(1 + K1**2 - 2 * K1 * mp.cos(t))

        for n, found in enumerate(jet):
            expected = [float(mp.diff(removal, mp.mpf(p), n)) for p in psi]
            np.testing.assert_allclose(found, expected, rtol=1e-11)
    assert np.all(jet.value > 0.0)  # the same sign on both flanks: |sinψ|


def test_removals_add_up(theoretical):
    both = modify(theoretical, FlankRotation(1e-5), DeformationCompensation(2e-3))
    lone = [modify(theoretical, one) for one in (FlankRotation(1e-5), DeformationCompensation(2e-3))]
    for order in range(3):
        total = sum(tooth.removal(PHASES)[order] for tooth in lone)
        np.testing.assert_allclose(both.removal(PHASES)[order], total, atol=1e-15)
    assert both.corners == (0.0, math.pi)


def test_a_lobe_turned_back_is_the_lobe_itself(theoretical):
    # A deviation that differs from lobe to lobe: lobe m is met at ψ + 2π m, and is turned back by m pitches.
    around = np.linspace(0.0, 78.0 * math.pi, 400, endpoint=False)
    tooth = modify(theoretical, MeasuredDeviation(NormalDeviation(around, 1e-3 * np.sin(around / 39.0), 39)))
    psi, lobe = np.array([0.4, 2.0, 5.0]), np.array([1.0, 7.0, 38.0])
    itself, turned = tooth.at(psi + 2.0 * math.pi * lobe), tooth.at(psi, lobe=lobe)
    back = np.exp(2j * math.pi * lobe / 39.0)
    np.testing.assert_allclose(turned.position, back * itself.position, atol=1e-11)
    np.testing.assert_allclose(turned.first, back * itself.first, atol=1e-10)
    np.testing.assert_allclose(turned.curvature, itself.curvature, rtol=1e-9)


def test_side_chooses_the_branch_at_a_corner_only(theoretical):
    tooth = modify(theoretical, DeformationCompensation(4e-3))
    tip = np.array([math.pi])
    before, after = tooth.at(tip, np.array([1.0])), tooth.at(tip, np.array([-1.0]))
    assert abs(before.position[0] - after.position[0]) < 1e-14
    assert abs(np.angle(after.first[0] / before.first[0])) > 1e-4
    np.testing.assert_array_equal(tooth.at(PHASES).first, tooth.at(PHASES, flank_side(PHASES)).first)


def test_flank_side_changes_at_root_and_tip():
    psi = np.array([0.0, 3.0, math.pi, 6.0, -0.1, -3.0, 6.3])
    np.testing.assert_array_equal(flank_side(psi), [1, 1, -1, -1, -1, -1, 1])
