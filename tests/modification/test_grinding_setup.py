"""Changes of the grinding set-up: the removal of each, where it vanishes, and independence of order.

The normal removal h(ψ) is measured, not read from the package's own formulas: it is the gap of a nominal
pin on the nominal pin-centre path, found by exact contact.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from cycloid_profile.contact.mesh import backlash, gaps, mesh
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.modification import (
    DeformationCompensation,
    Equidistant,
    FlankRotation,
    FlankStock,
    NormalDeviation,
    RadialMoving,
    conjugate_pair,
    modify,
    pair_ratios,
    rotation_to_backlash,
    zero_backlash_pair,
)

MICROMETRES = st.floats(-20.0, 20.0).map(lambda um: um * 1e-3)


def eccentric(tooth, amount):
    """Ground with the generating eccentricity larger by ``amount``."""
    moved = replace(tooth.trochoid, eccentricity=tooth.trochoid.eccentricity + amount)
    return ToothProfile(moved, tooth.pin_radius)


K1 = 0.8125


def scale(psi):
    """The function S of the RV-40E, in its textbook form."""
    return 1.0 / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(psi))


def rotated(tooth, amount):
    """Flanks rotated for a removal of ``amount`` at ψ0."""
    return modify(tooth, FlankRotation(amount / tooth.trochoid.longest_lever))


# How a tooth is ground with an amount, and h/amount as a function of ψ (docs/theory.md, Eqs. 13–16).
REMOVALS = {
    "radial-moving": (lambda p, e: modify(p, RadialMoving(e)), lambda psi: (1.0 - K1 * np.cos(psi)) * scale(psi)),
    "eccentricity": (eccentric, lambda psi: (np.cos(psi) - K1) * scale(psi)),
    "compensation": (
        lambda p, e: modify(p, DeformationCompensation(e)),
        lambda psi: -np.abs(np.sin(psi)) * scale(psi),
    ),
    "flank rotation": (rotated, lambda psi: np.abs(np.sin(psi)) * scale(psi)),
}


def measured_removal(nominal, tooth):
    """Phases and gaps of pins on the nominal path; pins next to a corner left out."""
    meshing = mesh(nominal.trochoid, np.linspace(0.0, 0.15, 5))
    found = gaps(tooth, nominal.pin_radius, meshing).gap[:, 0]
    psi = meshing.phase[:, 0]
    clear = np.abs(np.sin(psi)) > 0.06
    return psi[clear], found[clear]


@pytest.mark.parametrize(("grind", "shape"), REMOVALS.values(), ids=REMOVALS)
def test_removal_has_the_tabled_shape_to_first_order(theoretical, grind, shape):
    amounts = np.array([1e-3, 2e-3, 4e-3, 8e-3])
    errors = []
    for amount in amounts:
        psi, removal = measured_removal(theoretical, grind(theoretical, amount))
        errors.append(np.max(np.abs(removal - amount * shape(psi))))
    # The residual falls with the square of the amount: the shape is right to first order, sign included.
    assert errors[0] < 0.02 * amounts[0]
    assert np.polyfit(np.log(amounts), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


def test_rigid_rotation_is_a_signed_removal(theoretical):
    meshing = mesh(theoretical.trochoid, np.linspace(0.0, 0.15, 5))
    lever = theoretical.trochoid.longest_lever * theoretical.trochoid.lever_function(meshing.phase)
    angles = np.array([1e-5, 2e-5, 4e-5, 8e-5])
    errors = [np.max(np.abs(gaps(theoretical, 3.0, meshing, rotation=b).gap + b * lever)) for b in angles]
    assert np.polyfit(np.log(angles), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


@given(MICROMETRES)
def test_equidistant_takes_the_same_everywhere(theoretical, amount):
    meshing = mesh(theoretical.trochoid, [0.0, 0.05])
    found = gaps(modify(theoretical, Equidistant(amount)), 3.0, meshing)
    np.testing.assert_allclose(found.gap, amount, atol=1e-13)


@given(MICROMETRES, MICROMETRES)
def test_positive_amounts_clear_root_and_tip_by_their_sum(theoretical, equidistant, radial_moving):
    tooth = modify(theoretical, Equidistant(equidistant), RadialMoving(radial_moving))
    for psi in (0.0, math.pi):
        clearance = abs(theoretical.at(psi).position) - abs(tooth.at(psi).position)
        assert clearance == pytest.approx(equidistant + radial_moving, abs=1e-13)


@given(MICROMETRES, MICROMETRES, st.floats(0.0, 10e-3), st.floats(-1e-4, 1e-4))
def test_order_of_modifications_does_not_matter(theoretical, equidistant, radial_moving, delta, angle):
    steps = [
        Equidistant(equidistant),
        RadialMoving(radial_moving),
        DeformationCompensation(delta),
        FlankRotation(angle),
    ]
    psi = np.linspace(0.0, 6.0, 40)
    reference = modify(theoretical, *steps).at(psi)
    for order in itertools.permutations(steps):
        points = modify(theoretical, *order).at(psi)
        # Removals are summed in another order: rounding only.
        np.testing.assert_allclose(points.position, reference.position, rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(points.second, reference.second, rtol=1e-13)


@given(st.floats(0.0, 20e-3), MICROMETRES)
def test_compensation_leaves_root_and_tip_and_lifts_both_flanks(theoretical, delta, equidistant):
    ground = modify(theoretical, Equidistant(equidistant))
    compensated = modify(ground, DeformationCompensation(delta))
    ends = np.array([0.0, math.pi])
    np.testing.assert_allclose(compensated.at(ends).position, ground.at(ends).position, atol=1e-14)
    for psi in (theoretical.trochoid.critical_phase, -theoretical.trochoid.critical_phase):
        normal = ground.trochoid.derivatives(psi).normal
        added = (np.conj(normal) * (compensated.at(psi).position - ground.at(psi).position)).real
        assert added == pytest.approx(delta, abs=1e-13)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("near", "reach"), [("root", 0.4), ("tip", 0.25)])
def test_relief_rises_by_its_quartic(theoretical, side, near, reach):
    # Eq. 97: nothing at root and tip, 7/16 of the stock at half the reach, all of it from the reach on.
    trochoid, amount = theoretical.trochoid, 5e-3
    low, high = (-0.1, trochoid.critical_phase) if near == "root" else (3.2, trochoid.critical_phase)
    shares = np.array([0.0, 0.5, 0.8, 1.0, 1.5])
    phase = np.array([brentq(lambda p, a=a: trochoid.lever_function(p) - a, low, high) for a in shares * reach])
    stock = FlankStock(amount, 0.4, 0.25).derivatives(side * phase, np.full(5, side), trochoid)
    expected = -amount * np.array([0.0, 7.0 / 16.0, 1.0 - 0.36**2, 1.0, 1.0])
    np.testing.assert_allclose(stock.value, expected, atol=1e-12)
    np.testing.assert_allclose(stock.first[[0, 4]], 0.0, atol=1e-9)
    # At the ends the stock begins as 2·amount·(slope·ψ/reach)².
    slope = float(trochoid.lever_jet(phase[:1])[1][0])
    assert stock.second[0] == pytest.approx(-4.0 * amount * (slope / reach) ** 2, rel=1e-9)


def test_flank_rotation_is_the_opposite_of_compensation(theoretical):
    angle = 4e-5
    rotated = modify(theoretical, FlankRotation(-angle))
    compensated = modify(theoretical, DeformationCompensation(angle * theoretical.trochoid.longest_lever))
    assert rotated == compensated


@pytest.mark.parametrize("nothing", [Equidistant(0.0), RadialMoving(0.0), FlankRotation(0.0)])
def test_zero_amount_changes_nothing(theoretical, nothing):
    assert modify(theoretical, nothing) == theoretical
    assert modify(theoretical, DeformationCompensation(0.0)).corners == ()


@pytest.mark.parametrize(
    ("too_much", "limit"),
    [
        (Equidistant(1.7), "undercut limit 4.6117 mm"),
        (Equidistant(-3.0), "is not positive"),
        (Equidistant(math.nan), "is not positive"),
        (RadialMoving(12.5), r"outside \(0, 1\)"),
        (RadialMoving(64.0), "is not positive"),
        (FlankRotation(math.nan), "not finite"),
        (DeformationCompensation(math.inf), "not finite"),
    ],
)
def test_tooth_that_cannot_exist_is_refused(theoretical, too_much, limit):
    with pytest.raises(GeometryError, match=limit):
        modify(theoretical, too_much)


def test_flank_removal_that_undercuts_is_refused(theoretical):
    # 1.9 mm exceed the remaining 1.61 mm: the curve runs backwards on the convex flank.
    psi = np.linspace(0.0, math.pi, 20_001)
    removed, point = 1.9 * np.sin(psi) * scale(psi), theoretical.at(psi)
    worst = 3.0 + removed[np.argmin(point.along + removed * point.turn)]
    with pytest.raises(GeometryError) as refused:
        modify(theoretical, FlankRotation(1.9 / theoretical.trochoid.longest_lever))
    # The radius that a pin would need there; the check looks at every half degree.
    assert float(re.search(r"(\d\.\d+) mm", str(refused.value))[1]) == pytest.approx(worst, abs=2e-3)


@given(st.floats(0.1, 0.95), st.floats(1e-3, 50e-3))
def test_both_pairs_give_the_wanted_radial_clearance(theoretical, ratio, clearance):
    trochoid = replace(theoretical.trochoid, eccentricity=1.6 * ratio)
    for pair in (conjugate_pair, zero_backlash_pair):
        equidistant, radial_moving = pair(trochoid, clearance)
        assert equidistant.amount + radial_moving.amount == pytest.approx(clearance, rel=1e-9)


@given(st.floats(0.1, 0.95))
def test_pairs_are_mirror_images_with_the_defining_ratio(theoretical, ratio):
    trochoid = replace(theoretical.trochoid, eccentricity=1.6 * ratio)
    s = math.sqrt(1.0 - ratio**2)
    conjugate, zero = conjugate_pair(trochoid, 0.01), zero_backlash_pair(trochoid, 0.01)
    assert conjugate[1].amount / conjugate[0].amount == pytest.approx(-s)
    assert zero[0].amount + zero[1].amount * s == pytest.approx(0.0, abs=1e-14)
    assert (zero[1].amount, zero[0].amount) == pytest.approx((conjugate[0].amount, conjugate[1].amount))


def test_article_pair_is_near_the_conjugate_one(rv40e):
    # The article's 0.5/−0.275 mm: ratio −0.55, against −0.583 of the conjugate pair for 0.225 mm.
    equidistant, radial_moving = conjugate_pair(rv40e.trochoid, 0.225)
    assert radial_moving.amount / equidistant.amount == pytest.approx(-0.583, abs=5e-4)
    assert equidistant.amount == pytest.approx(0.5, rel=0.08)


def test_rotation_to_backlash_is_that_of_exact_contact(rv40e):
    rotated = modify(rv40e.theoretical_profile, Equidistant(0.006), FlankRotation(1e-4))
    change = (
        backlash(rv40e, rotated).worst - backlash(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006))).worst
    )
    # 0.1 %: the exact gaps of a turned flank differ in second order.
    assert rotation_to_backlash(1e-4) == pytest.approx(change, rel=1e-3)


def test_pairs_have_their_ratios(rv40e):
    for pair, ratio in zip((conjugate_pair, zero_backlash_pair), pair_ratios(rv40e.trochoid), strict=True):
        equidistant, radial_moving = pair(rv40e.trochoid, 0.01)
        assert radial_moving.amount / equidistant.amount == pytest.approx(ratio)


@pytest.mark.parametrize("lobes", [1, 39])
@pytest.mark.parametrize("first", [-2.0, 0.0, 1.5])
def test_spacing_of_a_curve_counts_the_step_round_its_end(lobes, first):
    period = 2.0 * math.pi * lobes
    inner = first + period * np.array([0.0, 0.2, 0.5, 0.9])
    assert NormalDeviation(inner, np.zeros(4), lobes).point_spacing == pytest.approx(0.1 * period)
    even = first + period * np.array([0.0, 0.15, 0.5, 0.8])
    assert NormalDeviation(even, np.zeros(4), lobes).point_spacing == pytest.approx(0.15 * period)
