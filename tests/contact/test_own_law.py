"""A law from one Python function against the same law with formulas for everything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import cycloid_profile as cp
from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import (
    LAWS,
    STEEL,
    LawFromApproach,
    LineContact,
    Material,
    OnSpring,
    compiled_law,
    response,
)
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.errors import LoadError
from cycloid_profile.modification import Equidistant, modify

CURVATURES = np.concatenate([np.linspace(-0.6, 0.28, 400), np.linspace(-0.03, 0.03, 101)])


def contact(curvature=CURVATURES, disc=STEEL):
    return LineContact(11.5, 3.0, np.asarray(curvature), disc, STEEL, 64.0)


@pytest.mark.parametrize("disc", [STEEL, Material(3_000.0, 0.36)], ids=["steel", "plastic"])
@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)
def test_everything_follows_from_the_approach(law, disc):
    own, at = LawFromApproach(law.approach), contact(disc=disc)
    for force in np.array([1e-3, 1.0, 600.0, 2e3]) * (STEEL.compliance / disc.compliance):
        delta = law.approach(force, at)
        np.testing.assert_allclose(own.approach(force, at), delta, rtol=1e-15)
        np.testing.assert_allclose(own.force(delta, at), force, rtol=1e-13)
        np.testing.assert_allclose(own.stiffness(force, at), law.stiffness(force, at), rtol=1e-9)
        expected = law.response(delta, at)
        for found, wanted, rtol in zip(own.response(delta, at), expected, (1e-9, 1e-7, 1e-9), strict=True):
            np.testing.assert_allclose(found, wanted, rtol=rtol)


@pytest.mark.parametrize("disc", [STEEL, Material(3_000.0, 0.36)], ids=["steel", "plastic"])
@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)
@pytest.mark.parametrize("share", [1e-4, 5e-3, 0.01, 0.02, 0.049])
def test_table_reaches_five_percent_of_the_pin_radius(law, disc, share):
    at = contact(disc=disc)
    delta = np.full(at.curvature.shape, share * at.pin_radius)
    found, wanted = (one.response(delta, at) for one in (LawFromApproach(law.approach), law))
    # Johnson's law is the one whose range is the width of the band alone.
    narrow = LAWS["johnson"].within_range(LAWS["johnson"].force(delta, at), at) & (wanted[0] > 0.0)
    assert np.any(narrow) or share > 0.02
    for each, exact, rtol in zip(found, wanted, (1e-9, 1e-7, 1e-9), strict=True):
        np.testing.assert_allclose(each[narrow], exact[narrow], rtol=rtol)
        # Convex teeth to the end of the table, whatever the width of the band.
        np.testing.assert_allclose(each[at.curvature < 0.0], exact[at.curvature < 0.0], rtol=10.0 * rtol)


def test_no_force_without_approach():
    own = LawFromApproach(LAWS["roark"].approach)
    np.testing.assert_array_equal(own.force([-1e-3, 0.0], contact([0.1, 0.1])), 0.0)
    np.testing.assert_array_equal(own.response(np.array([-1e-3, 0.0]), contact([0.1, 0.1]))[0], 0.0)
    np.testing.assert_array_equal(own.approach([-1.0, 0.0], contact([0.1, 0.1])), 0.0)


@pytest.mark.parametrize("delta", [1e-14, 0.2])
def test_force_is_the_slope_of_the_energy_beyond_the_table_too(delta):
    own, at, step = LawFromApproach(LAWS["roark"].approach), contact([-0.03]), 1e-5 * delta
    force, stiffness, _ = own.response(np.array([delta]), at)
    above, below = (own.response(np.array([delta + way * step]), at) for way in (1.0, -1.0))
    np.testing.assert_allclose((above[2] - below[2]) / (2.0 * step), force, rtol=1e-8)
    np.testing.assert_allclose((above[0] - below[0]) / (2.0 * step), stiffness, rtol=1e-8)
    np.testing.assert_allclose(force, LAWS["roark"].force(delta, at), rtol=0.1)


@pytest.mark.parametrize("solver", [Equilibrium(poses=6), StageEquilibrium(poses=6)], ids=["disc", "stage"])
def test_load_sharing_is_that_of_roark(rv40e, solver):
    roark = LAWS["roark"]
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3, law=roark)
    own = solver.solve(replace(case, law=cp.contact.LawFromApproach(roark.approach)))
    wanted = solver.solve(case)
    assert own.converged
    np.testing.assert_allclose(own.rotation, wanted.rotation, rtol=1e-8)
    np.testing.assert_allclose(own.force, wanted.force, rtol=0.0, atol=1e-8 * wanted.max_force)
    np.testing.assert_allclose(own.torsional_stiffness, wanted.torsional_stiffness, rtol=1e-6)


def test_a_law_in_series_with_a_spring():
    law = LawFromApproach(OnSpring(LAWS["roark"], 1e-6).approach)
    formulas = OnSpring(LAWS["roark"], 1e-6)
    delta = formulas.approach(600.0, contact())
    np.testing.assert_allclose(law.response(delta, contact())[0], formulas.response(delta, contact())[0], rtol=1e-9)


def test_a_law_without_a_compiled_form_is_tabulated():
    class Foreign:
        approach = staticmethod(LAWS["johnson"].approach)

    delta = LAWS["johnson"].approach(600.0, contact())
    np.testing.assert_allclose(response(compiled_law(Foreign(), contact()), delta, contact()).force, 600.0, rtol=1e-9)


def test_an_approach_that_does_not_rise_is_refused():
    with pytest.raises(LoadError, match="does not rise with the force"):
        LawFromApproach(lambda force, _: 1e-3 / force).force(1e-3, contact())
