"""Rollers of a bearing: published load distribution, quadrature, single rollers, and the stage that runs on them.

Source: Harris, Rolling Bearing Analysis, table of the Sjövall integral J_r(ε) of line contact and Q_max = 4.08 F/Z,
5 F/Z. The table is computed with the exponent 1.1 and printed with four digits; ISO/TS 16281 has 10/9. Symbols:
ε = ½(1 − play/r), load zone; δ_max = r − play.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from cycloid_profile.contact import LoadCase, Palmgren, clearance_range, roller_constant
from cycloid_profile.contact.bodies import LinearBearing, RollerBearing, bearing_law
from cycloid_profile.contact.laws import LAWS, STEEL, LineContact, Material
from cycloid_profile.contact.stage import StageEquilibrium, StageTangent, energy_about, minimise
from cycloid_profile.design import bearing_stiffness, drive_of
from cycloid_profile.effects import ReducerChange, apply_effects, effect_from_table
from cycloid_profile.errors import LoadError, SpecError
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.spec import Spec, validated
from tests.contact.plain_search import plain_search
from tests.contact.test_elastic_disc import bodies

HARRIS = {
    0.1: 0.1268, 0.2: 0.1737, 0.3: 0.2055, 0.4: 0.2286, 0.5: 0.2453, 0.6: 0.2568, 0.7: 0.2636, 0.8: 0.2658, 0.9: 0.2628,
    1.0: 0.2523, 1.25: 0.2078, 1.67: 0.1589, 2.5: 0.1075, 5.0: 0.0544,
}  # fmt: skip
N = 10.0 / 9.0
ROLLERS = RollerBearing(14, roller_constant(8.625))
ONE = RollerBearing(1, 1.0)
PLAYS = (0.004, 0.0, -0.002, -0.010)
CRANK = -np.array([0.0, 0.03, 0.4, 2.0, 50.0, 200.0])


def sjoevall(eps, exponent):
    """J_r(ε) by quadrature."""
    end = math.pi if eps >= 1.0 else math.acos(1.0 - 2.0 * eps)
    loaded = lambda psi: max(1.0 - (1.0 - math.cos(psi)) / (2.0 * eps), 0.0) ** exponent * math.cos(psi)  # noqa: E731
    return quad(loaded, 0.0, end, epsabs=1e-13, epsrel=1e-12, limit=400)[0] / math.pi


def harris_integral(eps):
    """J_r(ε) of our law: F = Z c δ_max^n J_r."""
    r = 0.5 / eps
    return float(ONE.response(r, r - 1.0).secant) * r


@pytest.mark.parametrize(("eps", "printed"), HARRIS.items())
def test_load_distribution_is_that_of_harris(eps, printed):
    # One unit of the last printed digit; 1.67 stands for 5/3.
    exact = 5.0 / 3.0 if eps == 1.67 else eps
    assert sjoevall(exact, 1.1) == pytest.approx(printed, abs=1e-4)
    assert harris_integral(eps) == pytest.approx(sjoevall(eps, N), rel=1e-10)
    assert harris_integral(eps) == pytest.approx(printed, rel=0.011)


def test_most_loaded_roller():
    # Without clearance Q_max = 4.08 F/Z; 5 F/Z holds for a load zone of a little more than a quarter of the diameter.
    assert 1.0 / harris_integral(0.5) == pytest.approx(4.08, abs=0.01)
    assert 1.0 / harris_integral(0.33) < 5.0 < 1.0 / harris_integral(0.25)
    # The roller under the load carries Q_max, by single rollers.
    force = float(ROLLERS.response(0.01, 0.0).secant) * 0.01
    assert ROLLERS.roller_forces(0.01, 0.0, 0.0)[0] == pytest.approx(4.08 * force / 14, rel=2e-3)


@given(st.floats(1e-4, 0.05), st.floats(-1.0, 1.0), st.booleans())
def test_closed_form_is_the_quadrature(r, share, strong):
    play = share * r * (3.0 if strong and share < 0.0 else 1.0)
    found = ONE.response(r, play)
    end = math.pi if play <= -r else math.acos(play / r)

    def averaged(exponent, power):
        at = lambda psi: max(r * math.cos(psi) - play, 0.0) ** exponent * math.cos(psi) ** power  # noqa: E731
        return quad(at, 0.0, end, epsabs=0.0, epsrel=1e-11, limit=400)[0] / math.pi

    assert float(found.secant) * r == pytest.approx(averaged(N, 1), rel=1e-8, abs=1e-14)
    assert float(found.tangent) == pytest.approx(N * averaged(N - 1.0, 2), rel=1e-6, abs=1e-9)
    assert float(found.energy) == pytest.approx(averaged(N + 1.0, 0) / (N + 1.0), rel=1e-8, abs=1e-16)


@pytest.mark.parametrize("play", [*PLAYS, -1e-9, 1e-9])
@pytest.mark.parametrize("compliance", [0.0, 2e-6])
def test_force_and_stiffness_are_the_derivatives_of_the_energy(play, compliance):
    law = ROLLERS.softened(compliance)
    # Around |play| as well, where the last roller becomes loaded.
    r = np.array([2e-4, 1e-3, abs(play) + 3e-6, 0.0041, 0.0065, 0.0101, 0.02])
    r = r[r > play]
    step = 2e-3 * (r - max(play, 0.0))
    low, at, high = (law.response(r + shift, play) for shift in (-step, 0.0, step))
    np.testing.assert_allclose((high.energy - low.energy) / (2.0 * step), at.secant * r, rtol=1e-4)
    force = (high.secant * (r + step) - low.secant * (r - step)) / (2.0 * step)
    np.testing.assert_allclose(force, at.tangent, rtol=2e-3)


def test_a_series_whose_last_coefficient_rounds_to_zero_keeps_its_length():
    from cycloid_profile.contact.bodies._bearing_kernels import powers_of

    # T₀/2 + T₂ = 2x² − ½; processors differ in whether the last coefficient of a fit is zero.
    powers = powers_of(np.array([0.5, 0.0, 1.0, 0.0, 0.0]))
    assert powers.shape == powers_of(np.ones(5)).shape
    assert powers[:3] == pytest.approx([-0.5, 0.0, 2.0])
    assert not np.any(powers[3:])


def test_large_loads_forget_the_play():
    whole = float(ROLLERS.response(1.0, 0.0).secant)
    for play in PLAYS:
        assert float(ROLLERS.response(1e3, play).secant) * 1e3 == pytest.approx(whole * 1e3**N, rel=1e-4)
    r = np.array([1.0, 10.0])
    force = ROLLERS.response(r, 0.0).secant * r
    assert math.log10(force[1] / force[0]) == pytest.approx(N, rel=1e-12)


def test_at_rest():
    # Preload: half the rollers' tangent stiffness in every direction. Clearance: nothing up to the play.
    for play in (-0.002, -0.010):
        rest = ROLLERS.response(0.0, play)
        wanted = 0.5 * 14 * ROLLERS.constant * N * (-play) ** (N - 1.0)
        assert float(rest.secant) == pytest.approx(wanted, rel=1e-12)
        assert float(rest.tangent) == pytest.approx(wanted, rel=1e-12)
    assert float(ROLLERS.response(0.0, -0.010).secant) > float(ROLLERS.response(0.0, -0.002).secant)
    for r, play in ((0.0, 0.0), (0.0, 0.004), (0.004, 0.004)):
        assert [float(one) for one in ROLLERS.response(r, play)] == [0.0, 0.0, 0.0]


@given(st.floats(1.0, 2e4), st.floats(-0.02, 0.02), st.floats(1e-5, 0.02))
def test_looser_bearings_give_way_more(force, play, looser):
    tight, loose = ROLLERS.displacement(force, play), ROLLERS.displacement(force, play + looser)
    assert 0.0 < float(tight) < float(loose)
    if play >= 0.0:  # fewer rollers carry the load: more than the play is lost
        assert float(loose - tight) >= looser * (1.0 - 1e-9)


@given(st.floats(0.0, 2e4), st.floats(-0.02, 0.02), st.sampled_from([0.0, 1e-6, 2e-5]))
def test_displacement_inverts_the_force(force, play, compliance):
    law = ROLLERS.softened(compliance)
    moved = float(law.displacement(force, play))
    assert float(law.response(moved, play).secant) * moved == pytest.approx(force, rel=1e-9, abs=1e-6)
    # A spring in series adds its own deflection, whatever the clearance.
    alone = float(ROLLERS.displacement(force, play))
    assert moved - alone == pytest.approx(compliance * force, rel=1e-6, abs=1e-12)


def test_rollers_one_by_one():
    # The passage of single rollers changes force and direction little; with more rollers, less.
    for play, most in ((-0.005, 2e-4), (0.0, 5e-3), (0.004, 2e-2)):
        shares = []
        for count in (10, 14, 20):
            law = RollerBearing(count, ROLLERS.constant)
            r = float(law.displacement(3000.0, play))
            cage = np.linspace(0.0, 2.0 * math.pi, 64 * count, endpoint=False)
            at = cage[:, np.newaxis] + 2.0 * math.pi * np.arange(count) / count
            each = law.roller_forces(r, play, cage)
            along, across = np.sum(each * np.cos(at), axis=1), np.sum(each * np.sin(at), axis=1)
            assert np.mean(along) == pytest.approx(3000.0, rel=1e-9 if play < 0.0 else 1e-5)
            assert np.max(np.abs(across)) < most * 3000.0 * 14 / count
            assert np.ptp(along) / np.mean(along) == pytest.approx(law.passage_variation(r, play), rel=0.05, abs=1e-6)
            shares.append(law.passage_variation(r, play))
        assert shares[1] < most
        assert shares[2] <= shares[0]


def test_constant_of_a_roller():
    # ISO/TS 16281 in N and mm; Palmgren's δ = 3.84e-5 Q^0.9/L^0.8 at both raceways (Harris) is 4 % stiffer.
    assert roller_constant(1.0) == pytest.approx(35_948.0, rel=1e-15)
    assert roller_constant(8.0) == pytest.approx(35_948.0 * 8.0 ** (8.0 / 9.0), rel=1e-15)
    force, L = 1000.0, 8.0
    both = 2.0 * 3.84e-5 * force**0.9 / L**0.8
    assert roller_constant(L) * both**N == pytest.approx(force, rel=0.04)
    contact = LineContact(L, 1.5, np.zeros(1), STEEL, STEEL, 1e3)
    assert 2.0 * Palmgren().approach(force, contact)[0] == pytest.approx((force / roller_constant(L)) ** 0.9, rel=0.05)


def test_softer_discs_soften_their_contact_alone():
    soft = Material(3_000.0, 0.38)
    assert roller_constant(8.0, STEEL, STEEL) == roller_constant(8.0)
    one, both = roller_constant(8.0, STEEL, soft), roller_constant(8.0, soft, soft)
    # Both contacts of the same material: proportional to the contact modulus.
    assert both / roller_constant(8.0) == pytest.approx(
        STEEL.contact_modulus(soft) / STEEL.contact_modulus(STEEL), rel=1e-12
    )
    assert both < one < roller_constant(8.0)


def test_clearance_classes():
    # ISO 5753-1, cylindrical roller bearings.
    assert clearance_range(20.0, "CN") == (20.0, 45.0)
    assert clearance_range(24.0, "C2") == (0.0, 25.0)
    assert clearance_range(45.0, "C3") == (50.0, 80.0)
    assert clearance_range(150.0, "CN") == (70.0, 120.0)
    with pytest.raises(LoadError, match="C2, CN, C3"):
        clearance_range(20.0, "C9")
    with pytest.raises(LoadError, match="above 200 mm"):
        clearance_range(300.0, "CN")


def on_rollers(drive, play, law=ROLLERS):
    return replace(drive, support=replace(drive.support, bearing_play=play, rollers=law))


def case_of(drive, play, rollers=ROLLERS, **changes):
    held = on_rollers(drive, play, rollers)
    return LoadCase(held, modify(drive.theoretical_profile, Equidistant(0.006)), 412e3, **changes)


@pytest.mark.parametrize("law", [ROLLERS, ROLLERS.softened(1e-6)], ids=["rollers", "on springs"])
@pytest.mark.parametrize("play", PLAYS)
def test_energy_of_the_stage_and_its_derivatives(rv40e, play, law):
    solved = StageEquilibrium(poses=3).solve(case_of(rv40e, play, law))
    problem = energy_about(solved)
    draw = np.random.default_rng(5)
    unit = 1e-4 / problem.arm * 1e2
    start = draw.normal(size=(3, problem.arm.size)) * np.where(problem.arm > 1.0, 1e-3, 1e-5)
    at = problem.at(start)
    hessian = problem.hessian(at)
    for a in range(problem.arm.size):
        step = np.zeros_like(start)
        step[:, a] = 1e-5 * unit[a]
        low, high = problem.at(start - step), problem.at(start + step)
        size = np.max(np.abs(at.gradient * problem.arm), axis=1) / problem.arm[a]
        slope = (high.energy - low.energy) / (2.0 * step[:, a])
        np.testing.assert_allclose(slope / size, at.gradient[:, a] / size, atol=2e-5)
        second = (high.gradient - low.gradient) / (2.0 * step)[:, a, np.newaxis]
        scale = np.sqrt(np.einsum("pu->pu", hessian[:, range(problem.arm.size), range(problem.arm.size)]))
        np.testing.assert_allclose(
            second / (scale * scale[:, [a]]), hessian[:, :, a] / (scale * scale[:, [a]]), atol=2e-3
        )


@pytest.mark.parametrize("play", PLAYS)
def test_compiled_and_plain_search_agree(rv40e, play):
    problem = energy_about(StageEquilibrium(poses=5).solve(case_of(rv40e, play)))
    pressed = np.zeros((5, problem.arm.size))
    pressed[:, 0] = 2e-5
    plain, (found, _) = plain_search(problem, pressed, 1e-10), minimise(problem, pressed, 1e-10)
    np.testing.assert_allclose(found / problem.arm, plain / problem.arm, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("play", PLAYS)
def test_many_poses_are_the_same_as_few(rv40e, play):
    # More than a block, so by the compiled search from nearby; over all loads of a lost-motion loop.
    case = case_of(rv40e, play)
    angle = -np.linspace(0.0, 2.0 * math.pi, 120)
    for torque in (412e3, -412e3, 12e3):
        many = StageEquilibrium().at(case, angle, np.full(120, torque))
        few = StageEquilibrium().at(case, angle[::40], np.full(3, torque))
        assert many.converged
        assert few.converged
        assert many.max_residual < 1e-8
        np.testing.assert_allclose(many.rotation[::40], few.rotation, rtol=0.0, atol=1e-11)


def test_twist_grows_with_the_clearance_and_falls_with_preload(rv40e):
    angle = np.zeros(1)
    loops = []
    for play in (-0.010, -0.002, 0.0, 0.002, 0.005):
        case = case_of(rv40e, play)
        turned = [StageEquilibrium().at(case, angle, np.full(1, T)).rotation[0] for T in (12.4e3, -12.4e3)]
        loops.append(turned[0] - turned[1])
    assert np.all(np.diff(loops) > 0.0)
    # Widely separated directions of the load: the play itself is lost, twice over the circle of the cranks.
    assert loops[4] - loops[3] == pytest.approx(2.0 * 0.003 / 36.0, rel=0.3)


def test_a_bearing_without_compliance_or_play_is_that_of_stiff_springs(rv40e):
    hard = RollerBearing(14, 1e3 * ROLLERS.constant)
    case = case_of(rv40e, -1e-3, hard)
    stiff = replace(case, drive=replace(rv40e, support=replace(rv40e.support, bearing_stiffness=1e12)))
    found, wanted = (StageEquilibrium(poses=4).solve(one) for one in (case, stiff))
    np.testing.assert_allclose(found.rotation, wanted.rotation, rtol=2e-3)


SMALL = [
    {"name": "crank_bearing_clearance", "radial_um": 0.02},
    {"name": "crank_bearing_compliance", "added_um_per_kn": 0.02},
    {"name": "crank_eccentricity_error", "amount_um": 0.02, "crank": 1, "disc": 1},
    {"name": "crank_phase_error", "angle_arcmin": 0.05, "crank": 2},
    {"name": "equidistant_error", "amount_um": 0.02},
]


@pytest.mark.parametrize("play", [0.004, 0.0, -0.004])
@pytest.mark.parametrize("table", SMALL, ids=lambda table: table["name"])
def test_tangent_against_a_new_solve(rv40e, play, table):
    case = case_of(rv40e, play)
    solver = StageEquilibrium(tolerance=1e-13)
    nominal = solver.at(case, CRANK)
    drawn, changed = apply_effects(case, []), apply_effects(case, [effect_from_table(table)])
    change, tangent = ReducerChange(drawn, changed), StageTangent(nominal)
    misfit, looser = change.misfit(tangent.crank_angle), change.bearing_deflection_change(tangent.point.bearing_force)
    fit = (0.0 if misfit is None else misfit) - (0.0 if looser is None else looser)
    at, grid = tangent.contacts, np.zeros(nominal.force.shape)
    opened = change.gap(at)
    grid[at.pose, at.disc, at.pin] = 0.0 if opened is None else opened
    exact = replace(solver, deviations=changed.deviations).at(changed.case, CRANK).rotation - nominal.rotation
    assert np.max(np.abs(exact)) > 1e-10
    np.testing.assert_allclose(tangent.rotation(grid, fit), exact, atol=0.02 * np.max(np.abs(exact)))


@pytest.fixture(scope="module")
def discs(rv40e):
    return bodies(rv40e)


@pytest.mark.parametrize("play", [0.004, -0.002])
@pytest.mark.parametrize("table", SMALL[:3], ids=lambda table: table["name"])
def test_tangent_with_elastic_discs(rv40e, discs, play, table):
    case = case_of(rv40e, play, disc_bodies=discs, law=LAWS["weber-banaschek"])
    solver = StageEquilibrium(tolerance=1e-13)
    nominal = solver.at(case, CRANK)
    assert nominal.max_residual < 1e-9
    drawn, changed = apply_effects(case, []), apply_effects(case, [effect_from_table(table)])
    change, tangent = ReducerChange(drawn, changed), StageTangent(nominal)
    misfit, looser = change.misfit(tangent.crank_angle), change.bearing_deflection_change(tangent.point.bearing_force)
    fit = (0.0 if misfit is None else misfit) - (0.0 if looser is None else looser)
    exact = replace(solver, deviations=changed.deviations).at(changed.case, CRANK).rotation - nominal.rotation
    np.testing.assert_allclose(tangent.rotation(0.0, fit), exact, atol=0.02 * np.max(np.abs(exact)))


@pytest.mark.filterwarnings("error")
def test_an_idle_bearing_with_a_force_of_rounding_is_deflected_along_it(rv40e):
    case = case_of(rv40e, 0.001)
    clearance = {"name": "crank_bearing_clearance", "radial_um": 3.0}
    change = ReducerChange(apply_effects(case, []), apply_effects(case, [effect_from_table(clearance)]), 3.0)
    force = 1e-310 * np.array([[[0.6, -0.8]], [[0.0, 0.0]]])
    moved, still = change.bearing_deflection_change(force)
    np.testing.assert_allclose(moved, [[0.6e-3, -0.8e-3]], rtol=1e-6)
    assert not np.any(still)


def test_effects_act_on_rollers(rv40e):
    case = case_of(rv40e, -0.002)
    looser = apply_effects(
        case, [effect_from_table({"name": "crank_bearing_clearance", "radial_um": 3.0})]
    ).case.drive.support
    assert looser.bearing_play == pytest.approx(0.001, abs=1e-15)
    softer = apply_effects(
        case, [effect_from_table({"name": "crank_bearing_compliance", "added_um_per_kn": 1.0})]
    ).case.drive.support
    assert softer.rollers.compliance == pytest.approx(1e-6)
    assert bearing_law(rv40e.support) == LinearBearing(4e5)
    # A force of 1 kN deflects the bearing by 1 µm more.
    more = bearing_stiffness(softer, 1000.0).displacement - bearing_stiffness(case.drive.support, 1000.0).displacement
    assert more == pytest.approx(1e-3, rel=1e-9)


BASE = {
    "name": "test",
    "drive": {
        "pins": 40, "pin_circle_radius_mm": 64.0, "pin_radius_mm": 3.0, "eccentricity_mm": 1.3, "disc_width_mm": 11.5,
        "discs": 2, "cranks": {"count": 3, "circle_radius_mm": 36.0},
    },
    "disc": {"bore_radius_mm": 16.0, "crank_hole_radius_mm": 13.0},
}  # fmt: skip


def support_of(crank_bearing, **cranks):
    drive = BASE["drive"] | {"crank_bearing": crank_bearing, "cranks": BASE["drive"]["cranks"] | cranks}
    return drive_of(validated(BASE | {"drive": drive}, Spec)).support


def test_the_spec_chooses_spring_or_rollers():
    assert support_of({}).rollers is None
    assert support_of({"roller_count": 14, "roller_length_mm": 9.0}).rollers is None  # life and losses alone
    held = support_of({"model": "rollers", "roller_count": 14, "roller_length_mm": 9.0})
    assert held.rollers == RollerBearing(14, roller_constant(9.0))
    assert held.bearing_play == 0.0
    # Clearances are diametral, the play is radial; the class by the crank of 20 mm.
    assert support_of({"radial_clearance_um": 8.0}).bearing_play == pytest.approx(0.004)
    assert support_of({"radial_clearance_um": 8.0}, bearing_play_um=1.0).bearing_play == pytest.approx(0.005)
    assert support_of({"preload_um": 6.0}).bearing_play == pytest.approx(-0.003)
    assert support_of({"clearance_class": "C2"}).bearing_play == pytest.approx(0.00625)
    with pytest.raises(SpecError, match="give one of them"):
        support_of({"preload_um": 6.0, "clearance_class": "CN"})
    with pytest.raises(SpecError, match="no meaning for a spring"):
        support_of({"preload_um": 6.0, "model": "spring"})


def test_impossible_rollers_are_refused():
    for changes in ({"count": 0}, {"constant": -1.0}, {"compliance": math.nan}):
        with pytest.raises(LoadError, match="out of range"):
            replace(ROLLERS, **changes)
