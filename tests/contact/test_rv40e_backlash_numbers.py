"""Backlash of the RV-40E with the crank locked, against twice-computed numbers.

Source: direct numerical geometry, computed twice independently: the exact curve turned between 40 pins
until it touches. The tooth-profile article (RV-40E) gives the drive and the pair 50/−27.5 µm (a tenth of
its printed 0.5/−0.275 mm).
Symbols: equidistant = Δr_rp, radial-moving = Δr_p, positive removes material; docs/theory.md, Eqs. 17–18, 32–33.
Pose: a pin stands at ψ = 36°, 0.34° from the longest lever; the first pose of the mesh cycle.
Tolerances: 0.001′, the last digit of the source; 0.005′ where it gives two decimals.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.contact.mesh import (
    backlash,
    first_order_backlash,
    first_touch,
    input_locked_factor,
    mesh,
    mesh_cycle,
)
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.modification import (
    DeformationCompensation,
    Equidistant,
    RadialMoving,
    conjugate_pair,
    modify,
    zero_backlash_pair,
)
from cycloid_profile.units import ARCMIN


def at_first_pose(drive, *changes):
    return backlash(drive, modify(drive.theoretical_profile, *changes)).values[0] / ARCMIN


@pytest.mark.parametrize(
    ("changes", "published"),
    [
        ((Equidistant(0.010),), 1.356),
        ((RadialMoving(0.010),), 0.791),
        ((Equidistant(0.050), RadialMoving(-0.0275)), 4.606),
    ],
)
def test_backlash_of_the_exact_curve(rv40e, changes, published):
    assert at_first_pose(rv40e, *changes) == pytest.approx(published, abs=1e-3)


def test_theoretical_tooth_has_none(rv40e):
    assert at_first_pose(rv40e) == pytest.approx(0.0, abs=1e-9)


def test_sensitivities_of_the_first_order_formula(rv40e):
    # Per millimetre: 135.6113′ is the article's own value; 79.056′ is geometry, where it prints 46.0867′
    # (135.6113·(1 − K1²), a square root short).
    assert first_order_backlash(rv40e, 1.0, 0.0) / ARCMIN == pytest.approx(135.6113, abs=5e-5)
    # The last digit of 79.056 follows from s = 0.582961…; the source rounds s first.
    assert first_order_backlash(rv40e, 0.0, 1.0) / ARCMIN == pytest.approx(79.056, abs=2e-3)


def test_eccentricity_has_no_first_order_effect(rv40e):
    # Measured with a pin at ψ0, where h = δa(cosψ − K1)S vanishes; some clearance keeps that pin the first.
    pose = mesh(rv40e.trochoid, [-rv40e.trochoid.critical_phase])

    def slope(clearance):
        touch = []
        for error in (-1e-4, 1e-4):
            ground = replace(rv40e.trochoid, eccentricity=rv40e.trochoid.eccentricity + error)
            touch.append(first_touch(ToothProfile(ground, 3.0 + clearance), 3.0, pose, 1.0).rotation[0, 0])
        return abs(touch[1] - touch[0]) / 2e-4 * rv40e.trochoid.longest_lever

    # Against 1 for an equidistant amount. What is left comes from the clearance, which shifts the contact off ψ0.
    assert slope(4e-3) < 5e-3
    assert slope(8e-3) == pytest.approx(2.0 * slope(4e-3), rel=0.05)


def test_conjugate_pair_shares_among_many_pins_and_costs_backlash(rv40e):
    tooth = modify(rv40e.theoretical_profile, *conjugate_pair(rv40e.trochoid, 0.0225))
    meshing = mesh(rv40e.trochoid, mesh_cycle(rv40e.trochoid, 24))
    touch = first_touch(tooth, 3.0, meshing, 1.0)
    psi = np.degrees(meshing.phase)
    # "Almost zero": at most 0.8 µm over the working flank.
    flank = (psi >= 15.0) & (psi <= 75.0)
    assert np.max(touch.gaps.gap[flank]) <= 0.8e-3
    assert np.max(touch.gaps.gap[flank]) > 0.5e-3  # the bound is sharp, not idle
    assert at_first_pose(rv40e, *conjugate_pair(rv40e.trochoid, 0.0225)) == pytest.approx(4.83, abs=5e-3)


def test_zero_backlash_pair_is_zero_to_first_order_only(rv40e):
    pair = zero_backlash_pair(rv40e.trochoid, 0.0225)
    assert first_order_backlash(rv40e, pair[0].amount, pair[1].amount) == pytest.approx(0.0, abs=1e-15)
    # 0.00044′ by a direct search of the textbook curve between 40 pins, sampled every 35 µrad of phase.
    assert at_first_pose(rv40e, *pair) == pytest.approx(0.00044, abs=1e-5)


@pytest.mark.parametrize("clearance", [5e-3, 10e-3, 20e-3])
def test_zero_backlash_pair_costs_next_to_nothing_at_any_pose(rv40e, clearance):
    tooth = modify(rv40e.theoretical_profile, *zero_backlash_pair(rv40e.trochoid, clearance))
    # An equidistant modification of the same radial clearance costs this much.
    plain = first_order_backlash(rv40e, clearance, 0.0)
    # 1 %: between poses the touching pin stands up to 4.5° off ψ0, where the pair leaves a little.
    assert np.max(np.abs(backlash(rv40e, tooth).values)) < 0.01 * plain


def test_compensation_by_the_article_amount(rv40e):
    # 4.06 µm → 0.551′; the article reports 0.32′ simulated and 0.64′ measured for the same amount.
    pair = (Equidistant(0.050), RadialMoving(-0.0275))
    before, after = at_first_pose(rv40e, *pair), at_first_pose(rv40e, *pair, DeformationCompensation(4.06e-3))
    assert before - after == pytest.approx(0.551, abs=1e-3)


def test_locking_the_input_instead_of_the_crank_lowers_backlash(rv40e):
    # "3.3 % lower": z_c/(z_p + z1/z2) = 39/40.333.
    assert 1.0 - input_locked_factor(rv40e) == pytest.approx(0.033, abs=5e-4)
    assert input_locked_factor(rv40e) == pytest.approx(39.0 / (40.0 + 1.0 / 3.0), rel=1e-15)


def test_order_of_magnitude_of_the_printed_pair(rv40e):
    # 0.5/−0.275 mm as printed would be 46′ of rigid backlash; the article measured 1.30′.
    assert at_first_pose(rv40e, Equidistant(0.5), RadialMoving(-0.275)) == pytest.approx(46.0, abs=0.05)
