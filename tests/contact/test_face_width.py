"""Slices over the face width: line contact as their limit, closed forms, derivatives, tilt and edge pressure."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase, Palmgren, WeberBanaschek
from cycloid_profile.contact.bodies import (
    NO_DEVIATIONS,
    AxialRelief,
    FaceWidth,
    PartDeviations,
    disc_compliance,
    support_model,
)
from cycloid_profile.contact.disc import Classical, Equilibrium
from cycloid_profile.contact.mesh import gaps
from cycloid_profile.contact.stage import (
    ContactChange,
    StageEnergy,
    StageEquilibrium,
    StageTangent,
    energy_about,
    minimise,
)
from cycloid_profile.contact.stage.loaded_contacts import curved_contacts
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import DiscOutline, circular_contour, ring_of_holes
from cycloid_profile.modification import Equidistant, modify
from tests.contact.plain_search import plain_search

CRANK = -np.array([0.0, 0.03, 0.4, 2.0, 50.0])
STIFF = 2.5e6  # N·mm/rad, a needle bearing of an RV-40E
LAWS = [WeberBanaschek(), Palmgren()]


def case_of(drive, law=LAWS[0], **width):
    case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006)), 412e3, law=law)
    if not width:
        return case
    return replace(case, width=FaceWidth(**{"width": drive.disc_width, "slices": 8, "tilt_stiffness": STIFF} | width))


@pytest.fixture(scope="module")
def elastic_case(rv40e):
    """RV-40E with elastic discs, crank holes of 13 mm."""
    holes = (circular_contour("bore", 0j, 16.0), *ring_of_holes("crank hole", 3, 36.0, 13.0))
    outline, turned = DiscOutline(rv40e.theoretical_profile, holes), 2.0 * np.pi / 78.0
    discs = tuple(disc_compliance(outline, 206e3, 0.3, rv40e.disc_width, j * turned) for j in range(2))
    return replace(case_of(rv40e), disc_bodies=discs)


def solved(case, crank=CRANK, **how):
    found = StageEquilibrium(tolerance=1e-13, **how).at(case, crank)
    assert found.converged
    return found


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("slices", [2, 5, 8])
def test_slices_without_relief_are_a_line_contact(rv40e, law, slices):
    plane, sliced = solved(case_of(rv40e, law)), solved(case_of(rv40e, law, slices=slices))
    np.testing.assert_allclose(sliced.force, plane.force, rtol=0.0, atol=1e-11 * plane.max_force)
    np.testing.assert_allclose(sliced.rotation, plane.rotation, rtol=1e-12)
    np.testing.assert_allclose(sliced.torsional_stiffness, plane.torsional_stiffness, rtol=1e-10)
    np.testing.assert_allclose(sliced.edge_pressure, plane.pressure, rtol=1e-8, atol=1e-3)
    np.testing.assert_array_equal(sliced.stage.tilt, 0.0)


def test_elastic_discs_without_relief_are_those_of_a_line_contact(elastic_case):
    plane = solved(elastic_case)
    sliced = solved(replace(elastic_case, width=FaceWidth(elastic_case.drive.disc_width, 9, tilt_stiffness=STIFF)))
    np.testing.assert_allclose(sliced.force, plane.force, rtol=0.0, atol=1e-10 * plane.max_force)
    np.testing.assert_allclose(sliced.torsional_stiffness, plane.torsional_stiffness, rtol=1e-9)


def test_one_disc_on_a_held_crank_takes_slices_as_well(rv40e):
    plane, sliced = (Equilibrium().at(case_of(rv40e, **how), CRANK) for how in ({}, {"slices": 7}))
    np.testing.assert_allclose(sliced.force, plane.force, rtol=0.0, atol=1e-9 * plane.max_force)
    crowned = Equilibrium().at(case_of(rv40e, tooth=AxialRelief(crowning=0.005)), CRANK)
    assert crowned.max_edge_pressure > crowned.max_pressure
    assert np.all(np.abs(crowned.rotation) > np.abs(plane.rotation))
    np.testing.assert_array_equal(crowned.slope, 0.0)
    for one in (plane, sliced, crowned):
        np.testing.assert_array_equal(one.approach[one.force == 0.0], 0.0)
        np.testing.assert_array_equal(one.receded, 0.0)


def test_the_force_of_a_tilted_disc_by_the_curvature_is_that_of_its_slices(rv40e):
    # Discs that may tilt under a taper: every slice has an approach of its own, and their forces are that of the pin.
    case = case_of(rv40e, tooth=AxialRelief(taper=0.006), tilt_stiffness=1e5)
    sharing = solved(case)
    at = curved_contacts(sharing, NO_DEVIATIONS)
    some, sums = (at.pose, at.disc, at.pin), []
    assert np.max(np.abs(sharing.slope[some])) * rv40e.disc_width > 1e-4
    for change in (0.0, 1e-5, -1e-5):
        contact = case.line_contact(at.curvature + change)
        total = np.zeros(at.force.size)
        for z, weight in zip(*case.width.rule, strict=True):
            sunk = sharing.approach[some] + z * sharing.slope[some] - case.width.relief(z)
            total += weight * case.law.force(sunk, contact)
        sums.append(total)
    np.testing.assert_allclose(sums[0], at.force, rtol=1e-6, atol=1e-3)
    slope = (sums[1] - sums[2]) / 2e-5
    np.testing.assert_allclose(at.force_by_curvature, slope, rtol=0.0, atol=1e-5 * np.max(np.abs(slope)))


def test_the_classical_scheme_knows_no_width(rv40e):
    found = Classical().solve(case_of(rv40e, tooth=AxialRelief(crowning=0.005)))
    assert found.max_edge_pressure == found.max_pressure


def test_relief_has_its_amounts_at_the_edges_and_its_slope_between():
    relief, width = AxialRelief(crowning=0.004, edge_relief=0.01, edge_length=2.0, taper=0.003), 12.0
    np.testing.assert_allclose(relief.at([0.0, 6.0, -6.0], width), [0.0, 0.014 + 0.0015, 0.014 - 0.0015], atol=1e-15)
    # A parabola each: the edge relief begins 2 mm before the edge, and is a quarter of its amount half-way.
    assert AxialRelief(edge_relief=0.01, edge_length=2.0).at(5.0, width) == pytest.approx(0.0025)
    z, step = np.array([-5.5, -4.5, -3.0, -1.0, 0.5, 3.9, 4.2, 5.8]), 0.1
    difference = (relief.at(z + step, width) - relief.at(z - step, width)) / (2.0 * step)
    np.testing.assert_allclose(relief.slope(z, width), difference, rtol=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
@pytest.mark.parametrize("crowning", [0.0005, 0.003, 0.02])
def test_force_of_a_crowned_tooth_is_the_integral_over_its_width(rv40e, law, crowning):
    # Winkler slices: F(δ) = 1/b ∫ f(δ − c (2z/b)²) dz, the band as wide as the crown lets it be.
    case, b = case_of(rv40e, law, slices=50, tooth=AxialRelief(crowning=crowning)), rv40e.disc_width
    found = solved(case, CRANK[:1])
    some = np.nonzero(found.force > 0.05 * found.max_force)
    contact, delta = case.line_contact(found.curvature[some]), found.approach[some]
    # Substitute z = edge·sin t: smooth where the band ends within the width.
    edge = 0.5 * b * np.minimum(np.sqrt(delta / crowning), 1.0)
    node, weight = np.polynomial.legendre.leggauss(60)
    angle, expected = 0.25 * np.pi * (1.0 + node), np.zeros_like(delta)
    for t, w in zip(angle, weight, strict=True):
        z = edge * np.sin(t)
        expected += 0.5 * np.pi / b * w * edge * np.cos(t) * law.force(delta - crowning * (2.0 * z / b) ** 2, contact)
    np.testing.assert_allclose(found.force[some], expected, rtol=2e-3 if crowning > 0.001 else 2e-4)


def test_slices_converge_with_the_square_of_their_number(rv40e):
    found = solved(case_of(rv40e, slices=8), CRANK[:2])
    about = energy_about(found)

    def error(slices, crowning):
        def force(n):
            face = FaceWidth(rv40e.disc_width, n, AxialRelief(crowning=crowning, taper=0.001))
            there = replace(about, width=replace(about.width, face=face)).at(np.zeros((2, 11)))
            return there.force[found.force > 0.5 * found.max_force]

        exact = force(200)
        return float(np.sqrt(np.mean((force(slices) / exact - 1.0) ** 2)))

    # A band across the whole width: fourth order; one that ends within it: second order, with some scatter.
    assert error(8, 1e-4) < 1e-4
    assert error(16, 1e-4) < 0.2 * error(8, 1e-4)
    assert error(8, 0.006) < 0.02
    assert error(32, 0.006) < 0.15 * error(8, 0.006)


def test_even_reliefs_leave_the_discs_upright(rv40e):
    relief = AxialRelief(0.004, 0.01, 2.0)
    found = solved(case_of(rv40e, tooth=relief, pin=AxialRelief(crowning=0.001)))
    np.testing.assert_array_equal(found.stage.tilt, 0.0)


def test_opposite_tapers_of_tooth_and_pin_cancel(rv40e):
    plane = solved(case_of(rv40e))
    found = solved(case_of(rv40e, tooth=AxialRelief(taper=0.005), pin=AxialRelief(taper=-0.005)))
    np.testing.assert_allclose(found.force, plane.force, atol=1e-9 * plane.max_force)
    np.testing.assert_array_equal(found.stage.tilt, 0.0)


def test_a_disc_that_may_tilt_follows_a_taper(rv40e):
    plane, relief = solved(case_of(rv40e)), AxialRelief(taper=0.004)
    free, held = (solved(case_of(rv40e, tooth=relief, tilt_stiffness=each)) for each in (0.0, 1e15))
    tilt = np.hypot(free.stage.tilt[..., 0], free.stage.tilt[..., 1])
    # The normals of the loaded pins lie in a fan: one slope meets the taper of nearly all.
    np.testing.assert_allclose(tilt, 0.004 / 11.5, rtol=0.35)
    assert np.max(np.hypot(held.stage.tilt[..., 0], held.stage.tilt[..., 1])) < 1e-9
    excess_free, excess_held = (one.max_edge_pressure / plane.max_pressure - 1.0 for one in (free, held))
    assert excess_free < 0.5 * excess_held
    # Pins at root and tip, with other normals, take a little more; the loaded ones share as on an even tooth.
    heavy = plane.force > 0.1 * plane.max_force
    np.testing.assert_allclose(free.force[heavy], plane.force[heavy], atol=0.02 * plane.max_force)
    assert np.mean(np.abs(held.pressure_at(5.75) - held.pressure_at(-5.75))) > np.mean(
        np.abs(free.pressure_at(5.75) - free.pressure_at(-5.75))
    )


def test_a_disc_in_balance_has_no_moment_left(rv40e):
    case = case_of(rv40e, tooth=AxialRelief(0.002, taper=0.005), bearing_offset=1.5)
    found = solved(case)
    about = energy_about(found)
    point = about.at(np.zeros((len(CRANK), about.arm.size)))
    np.testing.assert_allclose(point.gradient, 0.0, atol=1e-4)
    # Moments of pins, bearings off the mid-plane and their tilt, each on its own.
    normal, tilt = found.stage.normal, found.stage.tilt
    moment = np.sum(point.tilt.moment * normal, axis=2)
    bearings = np.sum(found.stage.bearing_force, axis=2) * 1.5
    left = moment - bearings + 3.0 * STIFF * (tilt[..., 0] + 1j * tilt[..., 1])
    np.testing.assert_allclose(np.abs(left), 0.0, atol=1e-3)
    assert np.max(np.abs(moment)) > 100.0


def test_edge_pressure_rises_with_the_taper(rv40e):
    peaks = [
        solved(case_of(rv40e, tooth=AxialRelief(taper=each), tilt_stiffness=1e15)).max_edge_pressure
        for each in (0.0, 1e-3, 2e-3, 4e-3, 8e-3)
    ]
    assert np.all(np.diff(peaks) > 0.0)


def test_edge_relief_takes_the_load_off_the_edges(rv40e):
    found = solved(case_of(rv40e, tooth=AxialRelief(0.0, 0.02, 2.0)))
    loaded = found.force > 0.3 * found.max_force
    middle, edge = found.pressure_at(0.0)[loaded], found.pressure_at(5.75)[loaded]
    np.testing.assert_array_equal(edge, 0.0)
    assert np.all(middle > found.pressure[loaded])
    np.testing.assert_allclose(found.edge_pressure[loaded], middle)


def energies(case):
    """An energy about its minimum, and steps away from there."""
    found = StageEquilibrium(tolerance=1e-12).at(case, CRANK)
    problem = energy_about(found)
    rng = np.random.default_rng(3)
    return problem, 1e-5 * rng.normal(size=(len(CRANK), problem.arm.size)) / problem.arm * 3.0


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.name)
def test_derivatives_of_the_energy(rv40e, law):
    case = case_of(
        rv40e, law, tooth=AxialRelief(0.001, taper=0.006), pin=AxialRelief(0.0, 0.004, 3.0), bearing_offset=2.0
    )
    problem, step = energies(case)
    point = problem.at(step)
    assert np.any(point.force > 0.0)
    for a in range(problem.arm.size):
        h = np.zeros(problem.arm.size)
        h[a] = 1e-7 * (50.0 if problem.arm[a] > 1.0 else 1.0)
        ahead, behind = problem.at(step + h), problem.at(step - h)
        numeric = (ahead.energy - behind.energy) / (2.0 * h[a])
        np.testing.assert_allclose(
            numeric, point.gradient[:, a], rtol=1e-5, atol=1e-3 * np.max(np.abs(point.gradient[:, a]))
        )
        # Slices come into contact one by one: only a small step keeps their number.
        h *= 0.02
        ahead, behind = problem.at(step + h), problem.at(step - h)
        hessian = (ahead.gradient - behind.gradient) / (2.0 * h[a])
        exact = problem.hessian(point)
        np.testing.assert_allclose(hessian, exact[:, a], atol=2e-4 * np.max(np.abs(exact[:, a])))


def test_the_compiled_search_ends_where_the_plain_one_does(rv40e):
    case = case_of(rv40e, tooth=AxialRelief(0.001, taper=0.006), bearing_offset=2.0)
    problem, step = energies(case)
    compiled, _ = minimise(problem, step, 1e-13)
    np.testing.assert_allclose(compiled, plain_search(problem, step, 1e-13), atol=1e-12)


def test_the_compiled_search_agrees_with_exact_gaps(rv40e):
    case = case_of(rv40e, tooth=AxialRelief(0.001, taper=0.006), bearing_offset=2.0)
    crank = -np.linspace(0.0, 6.0, 60)
    found = solved(case, crank)
    near = StageEquilibrium(tolerance=1e-12).at(case, crank, near=solved(case, crank + 1e-3).place)
    np.testing.assert_allclose(near.force, found.force, atol=1e-6 * found.max_force)
    np.testing.assert_allclose(near.stage.tilt, found.stage.tilt, atol=1e-11)


@pytest.mark.parametrize("geometric", [False, True])
def test_the_tangent_predicts_a_new_solve(rv40e, geometric):
    case = case_of(rv40e, tooth=AxialRelief(0.001, taper=0.006), bearing_offset=2.0)
    nominal = solved(case)
    bigger = np.random.default_rng(5).normal(size=40) * 2e-6
    ahead, behind = (solved(case, deviations=PartDeviations(pin_oversize=sign * bigger)) for sign in (1.0, -1.0))
    exact = 0.5 * (ahead.rotation - behind.rotation)
    tangent = StageTangent(nominal, geometric=geometric)
    at, none = tangent.contacts, np.zeros(tangent.contacts.force.shape)
    found = tangent.response([ContactChange(-bigger[at.pin], none, none, none, none)], [None]).motion[:, 0, 0]
    # A slice comes into contact at once, so that no derivative holds closer.
    np.testing.assert_allclose(found, exact, atol=0.005 * np.max(np.abs(exact)))
    summed = tangent.rotation(np.broadcast_to(-bigger, nominal.force.shape))
    np.testing.assert_allclose(summed, exact, atol=0.005 * np.max(np.abs(exact)))


def test_stiffness_is_the_slope_of_torque_over_twist(rv40e):
    case = case_of(rv40e, tooth=AxialRelief(0.002, taper=0.004))
    found, more, less = (StageEquilibrium(tolerance=1e-13).at(case, CRANK, 412e3 * s) for s in (1.0, 1.0005, 0.9995))
    slope = (more.torque - less.torque) / (more.rotation - less.rotation)
    np.testing.assert_allclose(slope, found.torsional_stiffness, rtol=2e-3)


def test_elastic_discs_tilt_and_balance(elastic_case):
    width = FaceWidth(elastic_case.drive.disc_width, 8, AxialRelief(0.003, taper=0.005), tilt_stiffness=STIFF)
    case = replace(elastic_case, width=width)
    found, more, less = (StageEquilibrium(tolerance=1e-13).at(case, CRANK, 412e3 * s) for s in (1.0, 1.0005, 0.9995))
    assert found.converged
    assert np.max(np.abs(found.stage.tilt)) > 1e-5
    slope = (more.torque - less.torque) / (more.rotation - less.rotation)
    np.testing.assert_allclose(slope, found.torsional_stiffness, rtol=3e-3)


def test_supports_without_a_width_have_no_tilt(rv40e):
    assert support_model(rv40e, np.zeros((1, 2))).tilt_unknowns.size == 0
    tilting = support_model(rv40e, np.zeros((1, 2)), width=FaceWidth(11.5, 5, tilt_stiffness=2.0, bearing_offset=1.0))
    np.testing.assert_array_equal(tilting.tilt_unknowns, [[7, 8], [9, 10]])
    assert tilting.tilt_stiffness == 6.0


def test_the_energy_counts_gaps_at_mid_height(rv40e):
    case = case_of(rv40e, tooth=AxialRelief(taper=0.004))
    found = solved(case)
    motion = found.stage.motion
    there = gaps(case.profile, 3.0, found.stage.meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])
    loaded = found.force > 0.0
    np.testing.assert_allclose(-there.gap[loaded], found.approach[loaded], atol=1e-12)
    assert isinstance(energy_about(found), StageEnergy)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"slices": 1}, "below 2"),
        ({"tooth": AxialRelief(0.0, 0.01, 6.0)}, "longer than half the face width"),
        ({"tilt_stiffness": -1.0}, "is negative"),
        ({"bearing_offset": 12.0}, "beyond the disc"),
        ({"width": 11.0}, "is not the face width"),
    ],
)
def test_impossible_widths_are_refused(rv40e, wrong, words):
    with pytest.raises(LoadError, match=words):
        case_of(rv40e, **wrong)


@pytest.mark.parametrize("wrong", [{"crowning": -1e-3}, {"edge_relief": 0.01}, {"taper": float("nan")}])
def test_impossible_reliefs_are_refused(wrong):
    with pytest.raises(LoadError):
        AxialRelief(**wrong)
