"""Properties every line-contact law must have, and what is refused."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.laws import (
    LAWS,
    STEEL,
    ArticleLogarithm,
    Braendlein,
    Johnson,
    LineContact,
    Logarithmic,
    Material,
    Palmgren,
    Roark,
    WeberBanaschek,
)
from cycloid_profile.contact.laws._kernels import response
from cycloid_profile.contact.laws.compiled import LOGARITHM, CompiledLaw
from cycloid_profile.contact.laws.library import PowerLaw
from cycloid_profile.errors import LoadError

LOGARITHMIC = [Roark(), Johnson(), ArticleLogarithm(), WeberBanaschek()]
# Of δ = A·F^n, A ∝ b^(−m): the law with its n and m.
POWER = [(Palmgren(), 0.9, 0.8), (Braendlein(), 0.925, 0.85)]
PLASTIC = Material(2_400.0, 0.38)  # polyoxymethylene

laws = st.sampled_from(list(LAWS.values()))
logarithmic = st.sampled_from(LOGARITHMIC)
power = st.sampled_from(POWER)
materials = st.builds(Material, st.floats(1e3, 6e5), st.floats(0.0, 0.49))


@st.composite
def contacts(draw, disc=materials, pin=materials):
    """Pins from 0.5 to 30 mm against anything from a sharp tip to a root that almost fits the pin."""
    r = draw(st.floats(0.5, 30.0))
    curvature = draw(st.floats(-2.0, 0.97)) / r
    return LineContact(draw(st.floats(2.0, 100.0)), r, np.asarray(curvature), draw(disc), draw(pin), 20.0 * r)


def force_of_band(contact, share):
    """Force whose band is ``share`` of the smaller radius to either side [N]."""
    half = share * np.minimum(contact.pin_radius, contact.tooth_radius)
    return math.pi * contact.width * half**2 / (4.0 * contact.relative_radius * contact.compliance)


@st.composite
def loads(draw):
    """A contact and a force on it: bands from a millionth of the radius to twice what the laws are meant for."""
    here = draw(contacts())
    return here, float(force_of_band(here, 0.2 * 10.0 ** draw(st.floats(-6.0, 0.0))))


@given(laws, loads())
def test_force_undoes_approach(law, load):
    contact, force = load
    delta = law.approach(force, contact)
    assert delta > 0.0
    assert float(law.force(delta, contact)) == pytest.approx(force, rel=1e-11)


@given(laws, loads(), st.floats(-9.0, 0.0).map(lambda exponent: 10.0**exponent))
def test_approach_undoes_force(law, load, share):
    contact, force = load
    delta = share * float(law.approach(force, contact))
    assert float(law.approach(law.force(delta, contact), contact)) == pytest.approx(delta, rel=1e-11)


@given(laws, loads(), st.floats(1.001, 3.0))
def test_force_rises_with_approach_and_stiffens(law, load, factor):
    contact, force = load
    delta = law.approach(force, contact)
    more = law.force(factor * delta, contact)
    # A line contact stiffens: factor times the approach takes more than factor times the force.
    assert float(more) > factor * force
    assert law.stiffness(more, contact) > law.stiffness(force, contact) > 0.0


@given(laws, loads())
def test_stiffness_is_the_slope_of_the_force(law, load):
    contact, force = load
    delta, h = float(law.approach(force, contact)), 1e-4
    slope = (law.force(delta * (1 + h), contact) - law.force(delta * (1 - h), contact)) / (2.0 * h * delta)
    assert float(law.stiffness(force, contact)) == pytest.approx(float(slope), rel=1e-6)


@given(laws, loads())
def test_response_is_force_stiffness_and_stored_work_in_one(law, load):
    contact, force = load
    delta = law.approach(force, contact)
    found, stiffness, energy = law.response(delta, contact)
    assert float(found) == pytest.approx(float(law.force(delta, contact)), rel=1e-13)
    assert float(stiffness) == pytest.approx(float(law.stiffness(found, contact)), rel=1e-11)
    work, error = quad(lambda d: float(law.force(d, contact)), 0.0, float(delta), epsabs=0.0, epsrel=1e-10)
    assert error < 1e-9 * work
    assert float(energy) == pytest.approx(work, rel=1e-9)


@given(laws, contacts())
def test_no_force_without_contact(law, contact):
    np.testing.assert_array_equal(law.approach([0.0, 0.0], contact), 0.0)
    np.testing.assert_array_equal(law.force([0.0, -1e-3], contact), 0.0)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_row_of_pins_is_answered_as_pin_by_pin(law):
    curvature = np.array([[-0.3, -0.03, 0.0], [1e-9, 0.1, 0.3]])
    row = LineContact(10.0, 3.0, curvature, STEEL, STEEL, 64.0)
    for ask, value in ((law.approach, 500.0), (law.force, 2e-3), (law.stiffness, 500.0), (law.half_width, 500.0)):
        found = ask(value, row)
        assert found.shape == curvature.shape
        for place in np.ndindex(curvature.shape):
            alone = ask(value, replace(row, curvature=curvature[place]))
            assert found[place] == pytest.approx(float(alone), rel=1e-14)


@given(logarithmic, loads(), st.floats(0.2, 5.0))
def test_approach_depends_on_force_per_width_and_compliance_alone(law, load, factor):
    # Of the logarithmic laws only: a power law's dimensions close with the constants of steel in its factor.
    contact, force = load
    wide = replace(contact, width=factor * contact.width)
    softer = [replace(m, youngs_modulus=m.youngs_modulus / factor) for m in (contact.disc, contact.pin)]
    soft = replace(contact, disc=softer[0], pin=softer[1])
    delta = float(law.approach(force, contact))
    assert float(law.approach(factor * force, wide)) == pytest.approx(delta, rel=1e-12)
    assert float(law.approach(force / factor, soft)) == pytest.approx(delta, rel=1e-12)


@given(power, loads(), contacts(), st.floats(0.2, 5.0))
def test_power_law_sees_force_and_width_and_nothing_else(law, load, other, factor):
    law, n, m = law
    contact, force = load
    delta = float(law.approach(force, contact))
    # Any radii, any materials: the same number, not a near one.
    elsewhere = replace(other, width=contact.width)
    assert float(law.approach(force, elsewhere)) == delta
    assert float(law.force(delta, elsewhere)) == float(law.force(delta, contact))
    assert float(law.stiffness(force, elsewhere)) == float(law.stiffness(force, contact))
    assert float(law.approach(factor * force, contact)) == pytest.approx(factor**n * delta, rel=1e-12)
    wide = replace(contact, width=factor * contact.width)
    assert float(law.approach(force, wide)) == pytest.approx(factor**-m * delta, rel=1e-12)


@given(laws, loads(), st.floats(0.2, 5.0))
def test_all_lengths_scaled_scale_the_approach_and_keep_the_pressure(law, load, k):
    # Also of the power laws, whose exponents are 2n − m = 1: it is their constant that is not free of units.
    contact, force = load
    scaled = replace(
        contact,
        width=k * contact.width,
        pin_radius=k * contact.pin_radius,
        curvature=contact.curvature / k,
        radius_cap=k * contact.radius_cap,
    )
    delta = float(law.approach(force, contact))
    assert float(law.approach(k**2 * force, scaled)) == pytest.approx(k * delta, rel=1e-12)
    assert float(law.half_width(k**2 * force, scaled)) == pytest.approx(
        k * float(law.half_width(force, contact)), rel=1e-12
    )
    for stress in ("peak_pressure", "subsurface_shear"):
        here, there = getattr(law, stress)(force, contact), getattr(law, stress)(k**2 * force, scaled)
        assert float(there) == pytest.approx(float(here), rel=1e-12)


@given(st.sampled_from([Roark(), ArticleLogarithm(), WeberBanaschek()]), loads())
def test_disc_and_pin_may_change_their_materials(law, load):
    # Both are pressed by the same force on the same band; only the sum of their approaches is asked for. These laws
    # count both bodies to the same depth.
    contact, force = load
    swapped = replace(contact, disc=contact.pin, pin=contact.disc)
    assert float(law.approach(force, swapped)) == pytest.approx(float(law.approach(force, contact)), rel=1e-13)


@given(loads())
def test_each_body_of_johnsons_law_keeps_its_own_depth(load):
    # Pin and convex tooth may change places, each with its radius and its material.
    contact, force = load
    tooth = float(contact.tooth_radius)
    here = replace(contact, curvature=np.asarray(-1.0 / tooth))
    there = LineContact(
        contact.width, tooth, np.asarray(-1.0 / contact.pin_radius), contact.pin, contact.disc, contact.radius_cap
    )
    assert float(Johnson().approach(force, there)) == pytest.approx(float(Johnson().approach(force, here)), rel=1e-12)


@given(laws, loads())
def test_peak_pressure_and_half_width_carry_the_force(law, load):
    # A semi-elliptic pressure: F = ½ π a b p0. Roark's width is printed with two digits, 1.60 for 1.596, so that
    # it carries 0.3 % too much; the pressure is Hertz's in every law.
    contact, force = load
    rounded = isinstance(law, Roark | ArticleLogarithm)
    carried = 0.5 * math.pi * law.half_width(force, contact) * contact.width * law.peak_pressure(force, contact)
    assert float(carried) == pytest.approx(force, rel=3e-3 if rounded else 1e-12)
    assert (float(carried) > 1.002 * force) == rounded
    assert float(law.peak_pressure(force, contact)) == float(contact.peak_pressure(force))
    assert float(law.subsurface_shear(force, contact)) == float(contact.subsurface_shear(force))


@given(loads())
def test_band_is_where_hertz_lets_the_surfaces_meet(load):
    # Both surfaces together sink by C_E p0 x²/a against the parabola x²/(2R) they fill: p0 = a/(2 R C_E).
    contact, force = load
    met = contact.half_width(force) / (2.0 * contact.relative_radius * contact.compliance)
    assert float(contact.peak_pressure(force)) == pytest.approx(float(met), rel=1e-12)


@given(contacts())
def test_relative_radius_is_the_textbook_one(contact):
    kappa, r = float(contact.curvature), contact.pin_radius
    if abs(kappa) < 1e-6:
        assert float(contact.relative_radius) == pytest.approx(r, rel=1e-4)
    else:
        rho = 1.0 / kappa
        assert float(contact.relative_radius) == pytest.approx(abs(rho * r / (rho - r)), rel=1e-9)


def test_flat_tooth_counts_with_the_radius_cap():
    contact = LineContact(10.0, 3.0, np.array([0.0, -1e-9, 1e-9, -0.1]), STEEL, STEEL, 64.0)
    np.testing.assert_allclose(contact.tooth_radius, [64.0, 64.0, 64.0, 10.0])
    for law in LAWS.values():
        assert np.all(np.isfinite(law.approach(500.0, contact)))


@given(laws, contacts(st.just(STEEL), st.just(STEEL)))
def test_range_ends_where_the_band_is_a_tenth_of_the_smaller_radius(law, contact):
    # Half a per cent to either side: Roark's own band is 0.3 % wider.
    assert bool(law.within_range(force_of_band(contact, 0.0995), contact))
    assert not bool(law.within_range(force_of_band(contact, 0.1005), contact))


def test_smaller_radius_is_that_of_a_sharp_tooth_too():
    contact = LineContact(10.0, 3.0, np.array([-1.0, -0.1]), STEEL, STEEL, 64.0)
    # A band 0.15 mm to either side: 15 % of a tip of 1 mm, 5 % of the pin.
    force = math.pi * 10.0 * 0.15**2 / (4.0 * contact.relative_radius * contact.compliance)
    for law in LAWS.values():
        np.testing.assert_array_equal(law.within_range(force, contact), [False, True])


@pytest.mark.parametrize("bodies", [(PLASTIC, PLASTIC), (PLASTIC, STEEL), (STEEL, PLASTIC)])
def test_roller_laws_are_for_steel_on_steel(bodies):
    contact = LineContact(10.0, 3.0, np.asarray(-0.03), *bodies, 64.0)
    for law in (Johnson(), WeberBanaschek()):
        assert bool(law.within_range(1.0, contact))
    # Printed for bodies of one material.
    for law in (Roark(), ArticleLogarithm()):
        assert bool(law.within_range(1.0, contact)) == (bodies[0] == bodies[1])
    for law, _, _ in POWER:
        assert not bool(law.within_range(1.0, contact))


@pytest.mark.parametrize(("modulus", "good"), [(200e3, True), (212e3, True), (180e3, False), (230e3, False)])
def test_roller_laws_take_every_steel_and_no_other_metal(modulus, good):
    # Bearing steels lie between 200 and 212 GPa; nodular iron at 180 and cemented carbides above 400 do not count.
    metal = Material(modulus, 0.3)
    contact = LineContact(10.0, 3.0, np.asarray(-0.03), metal, metal, 64.0)
    assert [bool(law.within_range(1.0, contact)) for law, _, _ in POWER] == [good, good]


def test_laws_are_named_apart():
    assert set(LAWS) == {"roark", "johnson", "article", "weber-banaschek", "palmgren", "braendlein"}
    for name, law in LAWS.items():
        assert law.name == name
    # Two entries of one kind would be one law under two names.
    assert len({type(law) for law in LAWS.values()}) == len(LAWS)


def test_laws_say_where_they_come_from_and_what_they_are_made_for():
    for law in LAWS.values():
        assert law.source.strip()
        assert law.validity.strip()
    sources = [law.source for law in LAWS.values()]
    assert len(set(sources)) == len(sources)


def test_laws_differ_by_convention_not_by_magnitude(rv40e_ten):
    # Every pair of laws differs, and the depths they count make no more than 40 % of it.
    tooth = rv40e_ten.theoretical_profile
    contact = LoadCase(rv40e_ten, tooth, 1.0).line_contact(tooth.at(tooth.trochoid.critical_phase).curvature)
    found = sorted(float(law.approach(600.0, contact)) for law in LAWS.values())
    assert all(b > a * (1.0 + 1e-5) for a, b in itertools.pairwise(found))
    assert found[-1] < 1.4 * found[0]


def root(constant, approach=1.0):
    """v = K − ln F of the logarithm δ = F v."""
    return approach / response(CompiledLaw(LOGARITHM, 1.0, 0.0, 0.0, 0.0, 0.0), constant, approach)[0]


@pytest.mark.parametrize("c", [1.2, 1.25, 1.3, 1.5, 2.0, 3.0, 5.0, 8.0, 13.0, 25.0, 60.0, 150.0, 400.0, 700.0])
def test_inverse_logarithm_is_the_lower_branch_of_lambert(c):
    # v − ln v = c above 1 is v = −W₋₁(−e^(−c)); from 40 digits, some units of the last place allowed. At c = 1.2 the
    # approach is 0.82 of that at which the laws end, at 700 it is 1e-304 of it.
    with mp.workdps(40):
        exact = float(mp.re(-mp.lambertw(-mp.exp(-mp.mpf(c)), -1)))
    assert root(c) == pytest.approx(exact, rel=2e-15)
    # Only K − ln y counts.
    assert root(c + 1.0, math.e) == pytest.approx(exact, rel=4e-15)


@given(st.floats(math.log(1.2), math.log(700.0)).map(math.exp))
def test_inverse_logarithm_solves_its_equation(c):
    v = root(c)
    with mp.workdps(40):
        left = float(mp.mpf(v) - mp.log(v) - mp.mpf(c))
    assert v > 1.0
    assert abs(left) < 1e-15 * v


@pytest.mark.parametrize("base", [Logarithmic, PowerLaw])
def test_base_of_a_family_has_no_constants_of_its_own(base):
    with pytest.raises(NotImplementedError):
        base().approach(1.0, LineContact(10.0, 3.0, np.asarray(-0.1), STEEL, STEEL, 64.0))


@pytest.mark.parametrize(
    ("build", "what", "limit"),
    [
        (lambda: Material(0.0, 0.3), "youngs_modulus", "not positive"),
        (lambda: Material(math.inf, 0.3), "youngs_modulus", "not positive"),
        (lambda: Material(206e3, 0.5), "poisson_ratio", "outside [0, 0.5)"),
        (lambda: Material(206e3, -0.1), "poisson_ratio", "outside [0, 0.5)"),
        (lambda: LineContact(0.0, 3.0, np.zeros(1), STEEL, STEEL, 64.0), "disc_width", "not a positive length"),
        (lambda: LineContact(math.nan, 3.0, np.zeros(1), STEEL, STEEL, 64.0), "disc_width", "not a positive length"),
    ],
)
def test_meaningless_contact_is_refused(build, what, limit):
    with pytest.raises(LoadError) as caught:
        build()
    assert caught.value.what == what
    assert limit in caught.value.limit
    assert caught.value.remedy in str(caught.value)


@pytest.mark.parametrize(
    ("change", "what", "limit"),
    [
        ({"torque": 0.0}, "torque", "zero or not finite"),
        ({"torque": math.nan}, "torque", "zero or not finite"),
        ({"torque": math.inf}, "torque", "zero or not finite"),
        ({"disc_share": 0.0}, "disc_share", "outside (0, 1]"),
        ({"disc_share": 1.01}, "disc_share", "outside (0, 1]"),
    ],
)
def test_meaningless_load_is_refused(rv40e, theoretical, change, what, limit):
    with pytest.raises(LoadError) as caught:
        LoadCase(rv40e, theoretical, **{"torque": 412e3, **change})
    assert caught.value.what == what
    assert limit in caught.value.limit
    assert str(caught.value.value) in str(caught.value)
    assert caught.value.exit_code == 2


def test_load_case_hands_both_bodies_to_the_contact(rv40e, theoretical):
    disc, pin = Material(100e3, 0.2), Material(200e3, 0.4)
    case = LoadCase(rv40e, theoretical, 1.0, disc, pin)
    contact = case.line_contact(np.zeros(2))
    assert case.compliance == contact.compliance == pytest.approx(0.96 / 100e3 + 0.84 / 200e3)
    assert (contact.disc, contact.pin) == (disc, pin)
    assert (contact.width, contact.pin_radius) == (11.5, 3.0)


def test_contacts_of_some_pins_keep_all_but_the_curvature():
    contact = LineContact(10.0, 3.0, np.array([[-0.3, -0.1], [0.0, 0.2]]), STEEL, PLASTIC, 64.0)
    some = contact.at(np.array([[True, False], [False, True]]))
    np.testing.assert_array_equal(some.curvature, [-0.3, 0.2])
    for name in ("width", "pin_radius", "disc", "pin", "radius_cap"):
        assert getattr(some, name) == getattr(contact, name)
    np.testing.assert_array_equal(contact.at((np.array([1, 0]), np.array([0, 1]))).curvature, [0.0, -0.1])
