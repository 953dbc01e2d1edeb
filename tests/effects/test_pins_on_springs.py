"""Physics properties of a line contact in series with a linear spring, and of softer bearings."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import LAWS, STEEL, LineContact, OnSpring
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import apply_effects, effect_from_table

laws = st.sampled_from(sorted(LAWS))
forces = st.floats(0.5, 5000.0)
# From 0.01 µm/kN to 100 µm/kN; a steel contact has some 3 µm/kN.
compliances = st.floats(1e-8, 1e-4)
curvatures = st.floats(-0.5, 0.25)


def contact(curvature):
    return LineContact(11.5, 3.0, np.atleast_1d(np.float64(curvature)), STEEL, STEEL, 64.0)


@given(laws, forces, compliances, curvatures)
def test_approach_is_that_of_the_law_and_of_the_spring(law, force, compliance, curvature):
    at = contact(curvature)
    on_spring = OnSpring(LAWS[law], compliance)
    wanted = LAWS[law].approach(force, at) + compliance * force
    np.testing.assert_allclose(on_spring.approach(force, at), wanted, rtol=1e-14)


@given(laws, forces, compliances, curvatures)
def test_force_undoes_approach(law, force, compliance, curvature):
    at = contact(curvature)
    on_spring = OnSpring(LAWS[law], compliance)
    np.testing.assert_allclose(on_spring.force(on_spring.approach(force, at), at), force, rtol=1e-9)


@given(laws, forces, compliances, curvatures)
def test_stiffness_is_the_slope(law, force, compliance, curvature):
    at = contact(curvature)
    on_spring = OnSpring(LAWS[law], compliance)
    step = 1e-4 * force
    slope = 2.0 * step / (on_spring.approach(force + step, at) - on_spring.approach(force - step, at))
    np.testing.assert_allclose(on_spring.stiffness(force, at), slope, rtol=1e-6)
    _, stiffness, _ = on_spring.response(on_spring.approach(force, at), at)
    np.testing.assert_allclose(stiffness, slope, rtol=1e-6)


@given(laws, forces, compliances, curvatures)
def test_energy_is_the_integral_of_force(law, force, compliance, curvature):
    # ∫F dδ by parts, F δ − ∫δ dF, whose integrand is a formula.
    at = contact(curvature)
    on_spring = OnSpring(LAWS[law], compliance)
    below, _ = quad(lambda F: float(on_spring.approach(F, at)[0]), 0.0, force, epsrel=1e-11)
    delta = on_spring.approach(force, at)
    _, _, energy = on_spring.response(delta, at)
    np.testing.assert_allclose(energy, force * delta - below, rtol=1e-6)


def test_no_force_without_approach():
    on_spring = OnSpring(LAWS["roark"], 1e-6)
    assert np.all(on_spring.force(np.array([-1e-3, 0.0]), contact([0.0, 0.0])) == 0.0)


def test_band_and_pressure_are_those_of_the_contact():
    # A spring behind the pin changes how far it gives way, not how it is pressed.
    roark, at = LAWS["roark"], contact(-1.0 / 34.0)
    on_spring = OnSpring(roark, 1e-6)
    for asked in ("half_width", "peak_pressure", "subsurface_shear", "within_range"):
        np.testing.assert_array_equal(getattr(on_spring, asked)(600.0, at), getattr(roark, asked)(600.0, at))
    assert on_spring.name == "roark on springs"
    assert (on_spring.source, on_spring.validity) == (roark.source, roark.validity)


@pytest.mark.parametrize("solver", [Equilibrium(poses=6), StageEquilibrium(poses=6)], ids=["disc", "stage"])
def test_soft_seats_share_the_load_among_more_pins(case: LoadCase, solver):
    stiff = solver.solve(case)
    none, soft = (
        solver.solve(
            apply_effects(case, [effect_from_table({"name": "pin_support_compliance", "added_um_per_kn": c})]).case
        )
        for c in (0.0, 20.0)
    )
    assert soft.converged
    np.testing.assert_allclose(none.force, stiff.force, rtol=1e-6, atol=1e-6)
    assert soft.max_force < 0.8 * stiff.max_force
    assert soft.fewest_loaded_pins > stiff.fewest_loaded_pins
    # The moment is the same, the work that the load does is larger by what the springs hold.
    for found in (stiff, soft):
        moment = np.sum(found.force * found.lever, axis=-1)
        np.testing.assert_allclose(np.mean(moment), np.mean(np.sum(stiff.force * stiff.lever, axis=-1)), rtol=0.01)
    assert np.mean(soft.rotation - soft.touch) > 1.5 * np.mean(stiff.rotation - stiff.touch)


def test_bearing_compliance_grows_by_the_amount(case: LoadCase):
    soft = apply_effects(case, [effect_from_table({"name": "crank_bearing_compliance", "added_um_per_kn": 1.0})])
    # 2.5 µm/kN as drawn, 3.5 with it.
    assert soft.case.drive.support.bearing_stiffness == pytest.approx(1e6 / 3.5, rel=1e-12)
    stiff = StageEquilibrium(poses=6).solve(case)
    found = StageEquilibrium(poses=6).solve(soft.case)
    assert np.all(found.torsional_stiffness < stiff.torsional_stiffness)
