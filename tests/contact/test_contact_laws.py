"""Properties every line-contact law must have, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.hertz import LineContact, Material
from cycloid_profile.contact.laws import ArticleLogarithm, Johnson, Roark, _Logarithmic
from cycloid_profile.errors import LoadError

LAWS = [Roark(), Johnson(), ArticleLogarithm()]
STEEL = Material(206_000.0, 0.3)

laws = st.sampled_from(LAWS)
forces = st.floats(-6.0, 5.0).map(lambda exponent: 10.0**exponent)


@st.composite
def contacts(draw):
    """Pins from 0.5 to 30 mm against anything from a sharp tip to a root that almost fits the pin."""
    r = draw(st.floats(0.5, 30.0))
    curvature = draw(st.floats(-2.0, 0.97)) / r
    return LineContact(draw(st.floats(2.0, 100.0)), r, np.asarray(curvature), STEEL, STEEL, 20.0 * r)


@given(laws, contacts(), forces)
def test_force_undoes_approach(law, contact, force):
    delta = law.approach(force, contact)
    assert delta > 0.0
    assert float(law.force(delta, contact)) == pytest.approx(force, rel=1e-11)


@given(laws, contacts(), st.floats(-9.0, -2.3).map(lambda exponent: 10.0**exponent))
def test_approach_undoes_force(law, contact, delta):
    assert float(law.approach(law.force(delta, contact), contact)) == pytest.approx(delta, rel=1e-11)


@given(laws, contacts(), forces, st.floats(1.001, 3.0))
def test_force_rises_with_approach_and_stiffens(law, contact, force, factor):
    delta = law.approach(force, contact)
    more = law.force(factor * delta, contact)
    # A line contact stiffens: factor times the approach takes more than factor times the force.
    assert float(more) > factor * force
    assert law.stiffness(more, contact) > law.stiffness(force, contact) > 0.0


@given(laws, contacts(), forces)
def test_stiffness_is_the_slope_of_the_force(law, contact, force):
    delta, h = float(law.approach(force, contact)), 1e-4
    slope = (law.force(delta * (1 + h), contact) - law.force(delta * (1 - h), contact)) / (2.0 * h * delta)
    assert float(law.stiffness(force, contact)) == pytest.approx(float(slope), rel=1e-6)


@given(laws, contacts())
def test_no_force_without_contact(law, contact):
    np.testing.assert_array_equal(law.approach([0.0, 0.0], contact), 0.0)
    np.testing.assert_array_equal(law.force([0.0, -1e-3], contact), 0.0)


@given(laws, contacts(), forces, st.floats(0.2, 5.0))
def test_approach_depends_on_force_per_width_and_compliance_alone(law, contact, force, factor):
    wide = LineContact(
        factor * contact.width, contact.pin_radius, contact.curvature, contact.compliance, contact.radius_cap
    )
    soft = LineContact(
        contact.width, contact.pin_radius, contact.curvature, factor * contact.compliance, contact.radius_cap
    )
    delta = float(law.approach(force, contact))
    assert float(law.approach(factor * force, wide)) == pytest.approx(delta, rel=1e-12)
    assert float(law.approach(force / factor, soft)) == pytest.approx(delta, rel=1e-12)


@given(laws, contacts(), forces, st.floats(0.2, 5.0))
def test_all_lengths_scaled_scale_the_approach_and_keep_the_pressure(law, contact, force, k):
    scaled = LineContact(
        k * contact.width,
        k * contact.pin_radius,
        contact.curvature / k,
        contact.compliance,
        k * contact.radius_cap,
    )
    assert float(law.approach(k**2 * force, scaled)) == pytest.approx(
        k * float(law.approach(force, contact)), rel=1e-12
    )
    assert scaled.peak_pressure(k**2 * force) == pytest.approx(contact.peak_pressure(force), rel=1e-12)


@given(contacts(), forces)
def test_peak_pressure_and_half_width_carry_the_force(contact, force):
    # A semi-elliptic pressure: F = ½ π a b p0.
    carried = 0.5 * math.pi * contact.half_width(force) * contact.width * contact.peak_pressure(force)
    assert float(carried) == pytest.approx(force, rel=1e-12)


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
    assert np.all(np.isfinite(Roark().approach(500.0, contact)))


def test_laws_are_named_apart():
    assert [law.name for law in LAWS] == ["roark", "johnson", "article"]


def test_logarithmic_base_has_no_constants_of_its_own():
    with pytest.raises(NotImplementedError):
        _Logarithmic().approach(1.0, LineContact(10.0, 3.0, np.asarray(-0.1), STEEL, STEEL, 64.0))


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


def test_load_case_adds_both_bodies_compliance(rv40e, theoretical):
    case = LoadCase(rv40e, theoretical, 1.0, Material(100e3, 0.2), Material(200e3, 0.4))
    assert case.compliance == pytest.approx(0.96 / 100e3 + 0.84 / 200e3)
    assert case.line_contact(np.zeros(2)).width == 11.5
