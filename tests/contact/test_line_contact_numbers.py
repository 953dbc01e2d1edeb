"""Line-contact approach of the RV-40E at one point, against twice-computed numbers and Johnson's book.

Sources: Young & Budynas, Roark's Formulas for Stress and Strain, 7th ed. (2002), Table 14.1 case 2;
Johnson, Contact Mechanics (1985), §5.6 and Eqs. (4.43)–(4.45); the tooth-profile article's logarithm.
Point: F = 600 N, b = 10 mm, RV-40E at ψ0 (ρ = −34.3095 mm, R = 2.75877 mm), steel on steel 206 GPa, 0.3.
Tolerance: half a unit of the source's last digit, 0.001 µm and 0.00001 mm.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.hertz import LineContact, Material
from cycloid_profile.contact.laws import ArticleLogarithm, Johnson, Roark
from cycloid_profile.units import UM


@pytest.fixture(scope="module")
def at_longest_lever(rv40e_ten):
    tooth = rv40e_ten.theoretical_profile
    curvature = np.asarray(tooth.at(tooth.trochoid.critical_phase).curvature)
    return LoadCase(rv40e_ten, tooth, 1.0).line_contact(curvature)


@pytest.mark.parametrize(("law", "published"), [(Roark(), 2.188), (Johnson(), 2.142)], ids=["roark", "johnson"])
def test_approach_at_600_newton(at_longest_lever, law, published):
    assert float(law.approach(600.0, at_longest_lever)) / UM == pytest.approx(published, abs=5e-4)


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
    steel = Material(206_000.0, 0.3)
    contact = LineContact(10.0, 5.0, np.asarray(-1.0 / 5.0), 2.0 * steel.compliance, 1e3)
    E_star, R, P = 1.0 / (2.0 * steel.compliance), 2.5, 1000.0 / 10.0
    assert float(contact.half_width(1000.0)) == pytest.approx(math.sqrt(4.0 * P * R / (math.pi * E_star)), rel=1e-14)
    assert float(contact.peak_pressure(1000.0)) == pytest.approx(math.sqrt(P * E_star / (math.pi * R)), rel=1e-14)
