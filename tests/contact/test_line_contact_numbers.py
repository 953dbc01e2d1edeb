"""Line-contact approach of the RV-40E at one point, against published formulas and Johnson's book.

Sources: Young & Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), Table 14.1 case 2;
Johnson, Contact Mechanics (1985), §4.2(c), §5.6 and Eqs. (4.43)–(4.45); Brändlein et al., Die Wälzlagerpraxis,
3rd ed. (1995); Palmgren, Grundlagen der Wälzlagertechnik, 3rd ed. (1964); Weber & Banaschek (1953), depth r;
the tooth-profile article's logarithm.
Point: F = 600 N, b = 10 mm, RV-40E at ψ0 (ρ = −34.3095 mm, R = 2.75877 mm), steel on steel 206 GPa, 0.3.
Tolerance: half a unit of the source's last digit, 0.001 µm and 0.00001 mm: the formulas are closed, so nothing
but the rounding of the print may lie between.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import LAWS, STEEL, ArticleLogarithm, Johnson, LineContact, Material, Roark
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.units import UM

PLA = Material(3_000.0, 0.36)
PUBLISHED = {
    "roark": 2.188,
    "johnson": 2.142,
    "braendlein": 2.124,
    "palmgren": 1.926,
    "weber-banaschek": 1.593,
}


@pytest.fixture(scope="module")
def at_longest_lever(rv40e_ten):
    tooth = rv40e_ten.theoretical_profile
    curvature = np.asarray(tooth.at(tooth.trochoid.critical_phase).curvature)
    return LoadCase(rv40e_ten, tooth, 1.0).line_contact(curvature)


@pytest.mark.parametrize(("law", "published"), PUBLISHED.items())
def test_approach_at_600_newton(at_longest_lever, law, published):
    assert float(LAWS[law].approach(600.0, at_longest_lever)) / UM == pytest.approx(published, abs=5e-4)


def test_every_law_but_the_article_has_a_published_number():
    # The article prints no number for its logarithm; it is compared with Roark's instead.
    assert set(LAWS) == {*PUBLISHED, "article"}


def test_relative_radius_takes_a_convex_tooth_as_negative(at_longest_lever):
    assert float(at_longest_lever.relative_radius) == pytest.approx(2.75877, abs=5e-6)
    assert float(at_longest_lever.tooth_radius) == pytest.approx(34.3095, abs=5e-5)


def test_article_logarithm_is_roark_with_rounded_constants(at_longest_lever):
    # X = 5.58 for 4·e^(1/3) = 5.5825: 2 ln of it differs by 9e-4, in a bracket of 13.
    roark, article = (float(law.approach(600.0, at_longest_lever)) for law in (Roark(), ArticleLogarithm()))
    assert article == pytest.approx(roark, rel=1e-4)
    assert article != roark


def test_johnson_book_contact_of_equal_cylinders():
    # Johnson (1985), Eqs. (4.43)–(4.45) in his own symbols: E*, 1/R = 1/R1 + 1/R2, p0 = (P E*/(π R))^½.
    contact = LineContact(10.0, 5.0, np.asarray(-1.0 / 5.0), STEEL, STEEL, 1e3)
    E_star, R, P = 1.0 / (2.0 * STEEL.compliance), 2.5, 1000.0 / 10.0
    assert float(contact.half_width(1000.0)) == pytest.approx(math.sqrt(4.0 * P * R / (math.pi * E_star)), rel=1e-14)
    assert float(contact.peak_pressure(1000.0)) == pytest.approx(math.sqrt(P * E_star / (math.pi * R)), rel=1e-14)


def test_johnson_law_is_the_sum_of_two_diametral_compressions():
    # Johnson (1985) §5.6: a cylinder pressed across gives way by 2 P (1 − ν²)/(π E)·[2 ln(4R/a) − 1] on both sides
    # together; one side of each body is half of that, with its own elastic constants.
    soft, hard = Material(100_000.0, 0.35), Material(210_000.0, 0.3)
    contact = LineContact(8.0, 4.0, np.asarray(-1.0 / 9.0), soft, hard, 1e3)
    P, a = 500.0 / 8.0, float(contact.half_width(500.0))
    bodies = (((1.0 - 0.35**2) / 100_000.0, 9.0), ((1.0 - 0.3**2) / 210_000.0, 4.0))
    sides = sum(P * C / math.pi * (2.0 * math.log(4.0 * R / a) - 1.0) for C, R in bodies)
    assert float(LAWS["johnson"].approach(500.0, contact)) == pytest.approx(sides, rel=1e-14)


@pytest.mark.parametrize(("disc", "pin"), [(PLA, STEEL), (STEEL, PLA), (STEEL, STEEL)])
def test_johnson_law_is_the_strain_of_each_body_from_contact_to_centre(disc, pin):
    # Johnson (1985) Eqs. (5.55) and (5.56): stresses on the axis of a cylinder under a Hertzian band of half-width a
    # and its opposite reaction, integrated from the surface to the centre in plane strain. The law drops terms of
    # (a/R)², here below 1e-3.
    contact = LineContact(8.0, 4.0, np.asarray(-1.0 / 9.0), disc, pin, 1e3)
    P, a = 5.0, float(contact.half_width(40.0))

    def shortening(body, R):
        def strain(z):
            root = math.hypot(a, z)
            # 2(a² + 2z²)/root − 4z written without the difference of large numbers.
            across = P / math.pi * (1.0 / R - 2.0 * a**2 / (root * (root + z) ** 2))
            along = P / math.pi * (1.0 / R - 2.0 / (2.0 * R - z) - 2.0 / root)
            nu = body.poisson_ratio
            return -body.compliance * (along - nu / (1.0 - nu) * across)

        return quad(strain, 0.0, R, points=[a, 10.0 * a], epsrel=1e-10)[0]

    assert a < 0.02 * 4.0
    exact = shortening(disc, 9.0) + shortening(pin, 4.0)
    assert float(LAWS["johnson"].approach(40.0, contact)) == pytest.approx(exact, rel=2e-4)


def test_johnson_law_of_like_bodies_is_that_of_their_mean(at_longest_lever):
    # Regression, to the last digit: both radii count equally, δ = G F·(ln(4 r|ρ|/(G R F)) − 1).
    G = at_longest_lever.compliance / (math.pi * at_longest_lever.width)
    assert Johnson().scale(at_longest_lever) == (G, math.log(4.0 * at_longest_lever.pin_radius / G) - 1.0, 1.0)


def test_a_plastic_disc_is_softer_than_by_equal_weights(at_longest_lever):
    # With a rigid pin the radius of the pin no longer counts: δ = G F·(2 ln(4|ρ|/h) − 1). Equal weights took the
    # geometric mean of both radii and made a disc of PLA 21 % too stiff at this point.
    contact = replace(at_longest_lever, disc=PLA)
    h, r, rho = (float(each) for each in (contact.half_width(60.0), contact.pin_radius, contact.tooth_radius))
    equal = 60.0 * contact.compliance / (math.pi * 10.0) * (2.0 * math.log(4.0 * math.sqrt(r * rho) / h) - 1.0)
    found = float(LAWS["johnson"].approach(60.0, contact))
    assert equal / UM == pytest.approx(6.463, abs=5e-4)
    assert found / UM == pytest.approx(7.793, abs=5e-4)


def test_weber_banaschek_counts_each_body_with_its_own_material():
    # δ = P/π·Σ C_i [ln(4 t²/a²) − μ_i/(1 − μ_i)], both depths t the pin radius.
    soft, hard = Material(100_000.0, 0.4), Material(210_000.0, 0.25)
    contact = LineContact(8.0, 4.0, np.asarray(-1.0 / 9.0), soft, hard, 1e3)
    P, a = 500.0 / 8.0, float(contact.half_width(500.0))
    terms = [
        (1.0 - mu**2) / E * (math.log(4.0 * 4.0**2 / a**2) - mu / (1.0 - mu)) for E, mu in ((1e5, 0.4), (2.1e5, 0.25))
    ]
    assert float(LAWS["weber-banaschek"].approach(500.0, contact)) == pytest.approx(P / math.pi * sum(terms), rel=1e-14)


def half_space_stress(x, z):
    """σx, σz, τxz under a semi-elliptic pressure of unit peak on |s| ≤ 1, by superposing Flamant's line loads.

    Johnson (1985) Eqs. (2.23) with s = sinθ, which takes the root out of the pressure: Gauss's rule converges
    exponentially.
    """
    theta, weight = np.polynomial.legendre.leggauss(400)
    theta, weight = 0.5 * math.pi * theta, 0.5 * math.pi * weight
    x, z = np.asarray(x)[..., np.newaxis], np.asarray(z)[..., np.newaxis]
    load, away = weight * np.cos(theta) ** 2, x - np.sin(theta)
    kernel = -2.0 * z / math.pi * load / (away**2 + z**2) ** 2
    return tuple(np.sum(kernel * along, axis=-1) for along in (away**2, z**2, away * z))


def principal_shear(x, z):
    along, across, shear = half_space_stress(x, z)
    return np.hypot(0.5 * (along - across), shear)


def test_largest_shear_under_the_surface():
    # Johnson (1985) §4.2(c) prints 0.30 p0 at 0.78 a; the package has four digits of the same, of which the last
    # may be cut instead of rounded: one unit of it.
    found = minimize_scalar(lambda z: -float(principal_shear(0.0, z)), bounds=(0.3, 1.5), options={"xatol": 1e-6})
    contact = LineContact(10.0, 3.0, np.asarray(-0.1), STEEL, STEEL, 64.0)
    shear, depth = float(contact.subsurface_shear(700.0)), float(contact.shear_depth(700.0))
    assert shear / float(contact.peak_pressure(700.0)) == pytest.approx(-found.fun, abs=1e-4)
    assert depth / float(contact.half_width(700.0)) == pytest.approx(found.x, abs=1e-4)


def test_shear_is_largest_under_the_middle_of_the_band():
    x, z = np.meshgrid(np.linspace(0.0, 1.5, 31), np.linspace(0.1, 2.0, 39))
    assert np.max(principal_shear(x, z)) <= float(principal_shear(0.0, math.sqrt(0.5 * (math.sqrt(5.0) - 1.0)))) + 1e-12
    # The field itself: σz on the axis in closed form, and far below the line load 2P/(π z) with P = π/2.
    assert half_space_stress(0.0, 0.1)[1] == pytest.approx(-1.0 / math.hypot(1.0, 0.1), rel=1e-12)
    assert half_space_stress(0.0, 100.0)[1] == pytest.approx(-1.0 / 100.0, rel=1e-4)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_rated_load_of_the_rv40e_is_within_range_of_every_law(rv40e, rated_torque, law):
    tooth = modify(rv40e.theoretical_profile, Equidistant(0.006))
    result = Equilibrium(poses=4).solve(LoadCase(rv40e, tooth, rated_torque, law=law))
    assert result.converged
    contact = result.case.line_contact(tooth.at(result.phase).curvature)
    assert law.within_range(result.force, contact).shape == result.force.shape
    assert np.all(law.within_range(result.force, contact))
    # Not for want of load: the band is a tenth of a millimetre wide.
    assert 2.0 * np.max(law.half_width(result.force, contact)) > 0.08
