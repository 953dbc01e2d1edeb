"""Elastic pin seats, ring and pillars: formulas against closed solutions, the equilibrium against its own equations.

Closed solutions: Timoshenko, Strength of Materials (pinched ring, beams); Hetényi, Beams on Elastic Foundation (1946).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import csc_array, eye_array

from cycloid_profile.contact import LoadCase, Material, Pillars, PinSeats, RingBody, Supports
from cycloid_profile.contact.bodies import PartDeviations, disc_compliance, pin_normals, stage_compliance
from cycloid_profile.contact.bodies.elastic_disc._elements import (
    _displacements,
    _inwards,
    _three_fixed,
    disc_basis,
    plane_stress,
)
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import LAWS, STEEL
from cycloid_profile.contact.mesh import gaps, mesh, mesh_cycle, output_turn
from cycloid_profile.contact.stage import ContactChange, StageEquilibrium, StageTangent
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import CentralEccentric, DiscOutline, circular_contour, ring_of_holes
from cycloid_profile.modification import Equidistant, modify

IRON = Material(170e3, 0.28)
SEATS = PinSeats(3.0, 24.15, (-6.325, 6.325), 11.5, STEEL, IRON, 0.006, 20.0, 35.0)
RING = RingBody(64.0, 67.0, 80.0, 29.0, IRON)
PILLARS = Pillars(3, 36.0, 9.0, 26.45, STEEL)
SUPPORTS = Supports(SEATS, RING, PILLARS)
SINGLE = {name: Supports(**{name: getattr(SUPPORTS, name)}) for name in ("seats", "ring", "pillars")}
STIFF = Material(1e15, 0.3)


@pytest.fixture(scope="module")
def rigid(rv40e) -> LoadCase:
    return LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3, law=LAWS["weber-banaschek"])


@pytest.fixture(scope="module")
def elastic(rigid) -> LoadCase:
    """Discs and all supports elastic."""
    holes = (circular_contour("bore", 0j, 16.0), *ring_of_holes("crank hole", 3, 36.0, 13.0))
    outline = DiscOutline(rigid.drive.theoretical_profile, holes)
    bodies = tuple(disc_compliance(outline, 206e3, 0.3, 11.5, j * math.pi / 39.0) for j in range(2))
    return replace(rigid, disc_bodies=bodies, supports=SUPPORTS)


def long_pin(**changes) -> PinSeats:
    return replace(PinSeats(3.0, 400.0, (0.0,), 20.0, STEEL, IRON, 0.006, 20.0, 35.0), **changes)


def test_the_seat_is_that_of_a_line_contact():
    # Eq. 86 by hand: h² = 4 q R C_E/π with 1/R = 1/3 − 1/3.006.
    R, C = 3.0 * 3.006 / 0.006, [(1.0 - nu**2) / E for E, nu in ((206e3, 0.3), (170e3, 0.28))]
    h = math.sqrt(4.0 * 35.0 * R * sum(C) / math.pi)
    assert SEATS.half_width == pytest.approx(h)
    pin = C[0] / math.pi * (math.log(4.0 * 9.0 / h**2) - 0.3 / 0.7)
    ring = C[1] / math.pi * (math.log(4.0 * 400.0 / h**2) - 0.28 / 0.72)
    assert SEATS.seat_compliance == pytest.approx(pin + ring)
    assert replace(SEATS, clearance=0.0).half_width == 3.0
    assert replace(SEATS, clearance=0.0).seat_compliance < SEATS.seat_compliance


def test_a_stiff_pin_shifts_and_tilts():
    # One even load: c/L (1 + 12 z_i z_j/L²).
    found = replace(SEATS, bending=False).compliance()
    z, L = np.array(SEATS.places), SEATS.length
    np.testing.assert_allclose(found, SEATS.seat_compliance / L * (1.0 + 12.0 * np.outer(z, z) / L**2), rtol=1e-9)


def test_a_long_pin_is_that_of_hetenyi():
    # Infinite beam under an even load, integrated from its point load, y = (λ c/2) e^{−λ|x|} (cos λx + sin λ|x|).
    # Weak seats make it slender: shear and the ends change it by less than 1 %.
    seats = long_pin(housing=Material(100.0, 0.3))
    c = seats.seat_compliance
    lam = (1.0 / (4.0 * c * STEEL.youngs_modulus * math.pi * 81.0 / 4.0)) ** 0.25
    x = np.linspace(-20.0, 20.0, 4001)
    at = np.abs(x)
    point = 0.5 * lam * c * np.exp(-lam * at) * (np.cos(lam * at) + np.sin(lam * at))
    share = (20.0 - at) / 400.0  # pairs of places x apart in a length of 20
    assert seats.compliance()[0, 0] == pytest.approx(np.trapezoid(point * share, x), rel=0.01)


def test_a_free_span_is_a_clamped_beam():
    # Even load over the span, ends held in rigid seats: mean deflection F L³/(720 EI) + F L/(12 κ G A).
    seats = long_pin(span=20.0, contact=False)
    EI, GA = 206e3 * math.pi * 81.0 / 4.0, 0.9 * 206e3 / 2.6 * math.pi * 9.0
    assert seats.compliance()[0, 0] == pytest.approx(20.0**3 / (720.0 * EI) + 20.0 / (12.0 * GA), rel=1e-3)
    assert long_pin(contact=False).compliance()[0, 0] == 0.0
    assert not np.any(long_pin(contact=False, bending=False).compliance())


def test_an_overhang_is_a_cantilever():
    # Load over the whole overhang a: mean deflection F a³/(20 EI) + F a/(3 κ G A).
    seats = long_pin(length=100.0, places=(40.0,), overhang=20.0, contact=False)
    EI, GA = 206e3 * math.pi * 81.0 / 4.0, 0.9 * 206e3 / 2.6 * math.pi * 9.0
    assert seats.compliance()[0, 0] == pytest.approx(20.0**3 / (20.0 * EI) + 20.0 / (3.0 * GA), rel=1e-4)


@pytest.mark.parametrize("powers", [(1.0,), (0.0, 1.0), (0.3, -0.2, 0.5), (0.1, 0.4, -0.3, 0.2)])
def test_seats_and_beam_store_the_energy_of_a_deflection(powers):
    # w, a cubic at most: ∫ w²/c over the seats, by shapes that are cubics. Bent to a parabola: E I ∫ w″².
    seats, node = replace(SEATS, span=8.0), np.array([-12.0, -9.0, -8.5, -5.0, 0.0, 2.0, 7.0, 12.0])
    w, found = np.polynomial.Polynomial(powers), np.zeros(2 * node.size)
    found[::2], found[1::2] = w(node), w.deriv()(node)
    seated = np.array([True, False, True, True, False, False, True])
    square = (w * w).integ()
    wanted = sum(square(b) - square(a) for a, b, there in zip(node[:-1], node[1:], seated, strict=True) if there)
    K = seats._foundation(node, seated)
    np.testing.assert_allclose(K, K.T, rtol=1e-12, atol=0.0)
    assert found @ K @ found == pytest.approx(wanted / seats.seat_compliance, rel=1e-12)
    B = seats._bending_stiffness(node)
    np.testing.assert_allclose(B, B.T, rtol=1e-12, atol=0.0)
    if len(powers) < 4:
        bent = (w.deriv(2) ** 2).integ()
        EI = 206e3 * math.pi * 81.0 / 4.0
        assert found @ B @ found == pytest.approx(EI * (bent(12.0) - bent(-12.0)), rel=1e-9, abs=1e-6 * np.max(B))
    # A unit force spread over a disc does the work of the mean deflection there.
    even, z = (
        seats._even_load(np.array([-12.0, -8.0, -1.0, 3.5, 12.0]), -2.25),
        np.array([-12.0, -8.0, -1.0, 3.5, 12.0]),
    )
    at = np.zeros(2 * z.size)
    at[::2], at[1::2] = w(z), w.deriv()(z)
    assert even @ at == pytest.approx((w.integ()(3.5) - w.integ()(-8.0)) / 11.5, rel=1e-12)


def test_spans_add_and_stiff_seats_clamp():
    # One span under each disc while they fit between the discs, else one for all.
    each, one = (replace(SEATS, span=span).compliance() for span in (8.0, 22.0))
    assert np.all(np.diag(SEATS.compliance()) < np.diag(each))
    assert np.all(np.diag(each) < np.diag(one))
    stiff = long_pin(span=20.0, housing=STIFF, pin=STEEL)
    # The half of the contact in the pin stays: softer than clamped, by less than the seat of a stiff pin.
    clamped = replace(stiff, contact=False).compliance()[0, 0]
    assert clamped < stiff.compliance()[0, 0]


def test_a_pinched_ring():
    # Two opposite forces on a thin ring: the diameter changes by (π/4 − 2/π) P R³/(E I).
    thin = RingBody(100.0, 100.0, 100.2, 10.0, Material(206e3, 0.0), waves=80)
    angle = np.array([0.0, math.pi])
    moved = thin.influence(angle)[0, :, 0] @ np.ones(2)
    R, inertia = thin.mean_radius, 10.0 * 0.2**3 / 12.0
    expected = (math.pi / 4.0 - 2.0 / math.pi) * R**3 / (206e3 * inertia)
    assert np.sum(moved) == pytest.approx(expected, rel=1e-3)


def test_a_stretched_ring():
    # Pressure p stretches a thin ring by p R²/(E h).
    thin = RingBody(100.0, 100.0, 100.2, 10.0, Material(206e3, 0.0), waves=6)
    pins = 40
    force = np.full(pins, 5.0)
    moved = thin.influence(2.0 * math.pi * np.arange(pins) / pins)[0, :, 0] @ force
    line = pins * 5.0 / (2.0 * math.pi * thin.mean_radius)
    np.testing.assert_allclose(moved, line * thin.mean_radius**2 / (206e3 * 10.0 * 0.2), rtol=1e-9)


@pytest.mark.parametrize("waves", [2, 3, 4])
def test_a_thick_ring_is_that_of_finite_elements(waves):
    # Waves of radial load on the outer edge of a ring in plane stress of unit width and modulus. The beam takes them at
    # its middle line; pins at the outer edge for once.
    a, b, points = 67.0, 80.0, 240
    angle = 2.0 * math.pi * np.arange(points) / points
    outer = b * np.exp(1j * angle)
    basis = disc_basis([outer, a * np.exp(1j * angle)], 6.0)
    normal = outer / b
    load = csc_array(_inwards(basis, normal) @ (-np.cos(waves * angle)[:, np.newaxis]))
    everything = eye_array(basis.N, format="csc")
    ((moved,),) = (one.T for one in _displacements(plane_stress(basis, 0.28), _three_fixed(basis), load, [everything]))
    some = basis.nodal_dofs[:, :points]
    at = (moved[some[0]] + 1j * moved[some[1]]) * np.conj(normal)
    radial = 2.0 * np.mean(at.real * np.cos(waves * angle))
    ring = RingBody(67.0, a, b, 1.0, Material(1.0, 0.28))
    # Σ cos² of the load is half the number of points.
    assert ring.wave_compliance(waves)[0, 0] * points / 2.0 == pytest.approx(radial, rel=0.05)


def test_a_mount_holds_shift_turn_and_waves():
    free, mounted = RING, replace(RING, mounting=1e3)
    R = RING.mean_radius
    for k in (0, 2, 3, 6):
        assert mounted.wave_compliance(k)[0, 0] < free.wave_compliance(k)[0, 0]
    # A stiff ring on the mount shifts by F/(2πR m), half of it by the radial, half by the tangential springs.
    stiff = replace(mounted, material=STIFF)
    np.testing.assert_allclose(
        stiff.wave_compliance(1), np.array([[1.0, -1.0], [-1.0, 1.0]]) / (2.0 * math.pi * R * 1e3), rtol=1e-4
    )
    turn = (64.0 / R) ** 2 / (2.0 * math.pi * R * 1e3)
    assert stiff.wave_compliance(0)[1, 1] == pytest.approx(turn)


def test_pillars_are_beams_between_flanges():
    inertia, area, G = math.pi * 9.0**4 / 4.0, math.pi * 81.0, 206e3 / 2.6
    L = 26.45
    for hinged, ends in ((False, 12.0), (True, 3.0)):
        across = L**3 / (ends * 206e3 * inertia) + L / (0.9 * G * area)
        twist = 0.0 if hinged else 2.0 * G * inertia / L
        found = replace(PILLARS, hinged=hinged)
        assert found.torsional_stiffness == pytest.approx(3.0 * (36.0**2 / across + twist))
        assert found.compliance == pytest.approx(0.25 / found.torsional_stiffness)


def test_normals_are_those_of_the_nominal_gaps(rv40e):
    # Of the theoretical tooth, which touches all pins.
    meshing = mesh(rv40e.trochoid, np.array([0.1, 0.9, 4.0]), 2)
    found = pin_normals(meshing) * np.exp(2j * math.pi * np.arange(40) / 40)
    np.testing.assert_allclose(found, gaps(rv40e.theoretical_profile, 3.0, meshing).normal, atol=1e-9)


@pytest.mark.parametrize("name", SINGLE)
def test_forces_and_displacements_are_reciprocal_and_store_energy(rv40e, name):
    meshing = mesh(rv40e.trochoid, output_turn(rv40e.trochoid, 7), 2)
    parts = SINGLE[name].matrices(rv40e, meshing)
    assert len(parts) == 1
    for one in next(iter(parts.values())):
        scale = np.max(np.abs(one))
        assert scale > 0.0
        np.testing.assert_allclose(one, one.T, rtol=0.0, atol=1e-12 * scale)
        assert np.min(np.linalg.eigvalsh(one)) > -1e-9 * scale


def test_stiff_supports_are_rigid_ones(rigid):
    stiff = Supports(
        replace(SEATS, pin=STIFF, housing=STIFF), replace(RING, material=STIFF), replace(PILLARS, material=STIFF)
    )
    angles = mesh_cycle(rigid.drive.trochoid, 7)
    found, expected = (StageEquilibrium().at(one, angles) for one in (replace(rigid, supports=stiff), rigid))
    np.testing.assert_allclose(found.force, expected.force, rtol=0.0, atol=1e-6 * expected.max_force)
    np.testing.assert_allclose(found.rotation, expected.rotation, rtol=1e-7)
    np.testing.assert_allclose(found.torsional_stiffness, expected.torsional_stiffness, rtol=1e-6)


def test_every_support_adds_to_the_twist(rigid):
    angles = mesh_cycle(rigid.drive.trochoid, 3)
    base = StageEquilibrium().at(rigid, angles)
    everything = StageEquilibrium().at(replace(rigid, supports=SUPPORTS), angles)
    for name, one in SINGLE.items():
        found = StageEquilibrium().at(replace(rigid, supports=one), angles)
        assert np.all(found.twist > base.twist), name
        assert np.all(everything.twist > found.twist), name
        assert np.all(found.torsional_stiffness < base.torsional_stiffness), name


def test_pillars_turn_by_the_torque_alone(rigid):
    soft = replace(rigid, supports=Supports(pillars=PILLARS))
    for torque in (412e3, -412e3, 12e3):
        found, expected = (StageEquilibrium(tolerance=1e-12).at(one, [0.3, 1.1], torque) for one in (soft, rigid))
        np.testing.assert_allclose(found.rotation - expected.rotation, PILLARS.compliance * torque, rtol=1e-4)
        # The carrier's own turn moves nothing at the pins, but through the kinematics of the cranks.
        np.testing.assert_allclose(found.force, expected.force, atol=1e-3 * expected.max_force)
        np.testing.assert_allclose(found.rotation_by_part["pillars"], PILLARS.compliance * torque, rtol=1e-8)
        series = 1.0 / (1.0 / expected.torsional_stiffness + PILLARS.compliance)
        np.testing.assert_allclose(found.torsional_stiffness, series, rtol=1e-4)


@pytest.mark.parametrize("poses", [3, 200], ids=["few", "compiled"])
def test_forces_balance_and_deform_as_they_say(elastic, poses):
    found = StageEquilibrium().at(elastic, output_turn(elastic.drive.trochoid, poses))
    drive, stage, loaded = elastic.drive, found.stage, found.force > 0.0
    shift = stage.motion[..., 0] + 1j * stage.motion[..., 1]
    here = gaps(elastic.profile, drive.pin_radius, stage.meshing, shift, stage.motion[..., 2])
    given = sum(found.receded_supports.values())
    disc = np.einsum("pij,pj->pi", stage_compliance(elastic.disc_bodies, stage.meshing), found.load)
    pins = found.force[0].size
    np.testing.assert_allclose(found.receded.reshape(poses, -1), disc[:, :pins], atol=1e-10)
    closed = (-here.gap - found.receded - given)[loaded]
    np.testing.assert_allclose(closed, found.approach[loaded], rtol=0.0, atol=1e-9)
    # δmax is contact and disc, not the supports.
    both = np.where(loaded, found.approach + found.receded, 0.0)
    np.testing.assert_allclose(found.deformation, np.max(both, axis=(1, 2)))
    # Each disc is in balance, and the bearings pass the torque on.
    inwards = -np.sum(found.force * stage.normal, axis=2)
    np.testing.assert_allclose(inwards + np.sum(stage.bearing_force, axis=2), 0.0, atol=1e-9 * 412e3)
    assert found.converged
    assert found.max_residual < 2e-10


def test_the_energy_falls_by_the_rotation(elastic):
    # Castigliano: at equilibrium dΠ/dT = −Θ, whatever is elastic; the change of curvature under load adds 1e-4.
    size = 50.0
    solver = StageEquilibrium(tolerance=1e-12)
    energy = [solver.at(elastic, [0.2, 0.7], 412e3 + sign * size).stage.energy for sign in (1.0, -1.0)]
    rotation = solver.at(elastic, [0.2, 0.7]).rotation
    np.testing.assert_allclose((energy[0] - energy[1]) / (2.0 * size), -rotation, rtol=3e-4)


def test_the_parts_turn_the_output_together(elastic):
    # Virtual work: forces times deflections of all parts, and of the gaps they close, are torque times rotation.
    found = StageEquilibrium().at(elastic, mesh_cycle(elastic.drive.trochoid, 5))
    parts = found.rotation_by_part
    names = ["clearance", "contact", "discs", "crank bearings", "pin seats", "ring", "pillars"]
    assert list(parts) == names
    np.testing.assert_allclose(sum(parts.values()), found.rotation, rtol=1e-12)
    assert all(np.all(each > 0.0) for each in parts.values())
    # The clearance by itself: gaps of the loaded pins at the nominal place, first order in the motion.
    meshing = found.stage.meshing
    nominal = gaps(elastic.profile, elastic.drive.pin_radius, meshing)
    closed = np.sum(found.force * nominal.gap, axis=(1, 2)) / 412e3
    np.testing.assert_allclose(parts["clearance"], closed, rtol=0.05)


def test_the_tangent_is_that_of_differences(elastic):
    # A larger pin closes the gaps of both discs.
    sharing = StageEquilibrium(tolerance=1e-12).at(elastic, [0.1, 0.9])
    pin, size = int(np.argmax(sharing.force[0, 0])), 2e-6
    oversize = np.zeros(elastic.drive.trochoid.pins)
    oversize[pin] = size
    turned = [
        StageEquilibrium(tolerance=1e-13, deviations=PartDeviations(pin_oversize=sign * oversize))
        .at(elastic, [0.1, 0.9])
        .rotation
        for sign in (1.0, -1.0)
    ]
    slope = (turned[0] - turned[1]) / (2.0 * size)
    exact = StageTangent(sharing, geometric=True)
    at, none = exact.contacts, np.zeros(exact.contacts.force.shape)
    change = ContactChange(np.where(at.pin == pin, -1.0, 0.0), none, none, none, none)
    response = exact.response([change], [None])
    np.testing.assert_allclose(response.motion[:, 0, 0], slope, rtol=1e-4)
    # With fixed normals: the ring loads pins near the root, where normals turn fast.
    fixed = -np.sum(StageTangent(sharing).pins[:, :, pin], axis=1)
    np.testing.assert_allclose(fixed, slope, rtol=0.02)


def test_the_stiffness_of_the_output_is_that_of_differences(elastic):
    stiffness = StageEquilibrium().at(elastic, [0.1, 0.9]).torsional_stiffness
    turned = [StageEquilibrium(tolerance=1e-12).at(elastic, [0.1, 0.9], 412e3 + d).rotation for d in (100.0, -100.0)]
    np.testing.assert_allclose(200.0 / (turned[0] - turned[1]), stiffness, rtol=3e-3)


def test_a_pin_pitch_further_everything_is_equal(rigid):
    case = replace(rigid, supports=SUPPORTS)
    angles = mesh_cycle(rigid.drive.trochoid, 3)
    first, second = (StageEquilibrium().at(case, each) for each in (angles, angles + 2.0 * math.pi / 40))
    np.testing.assert_allclose(first.rotation, second.rotation, rtol=1e-9)
    np.testing.assert_allclose(np.sort(first.force), np.sort(second.force), rtol=0.0, atol=1e-5)


def test_one_disc_on_a_rigid_crank_has_rigid_supports(rigid):
    found, expected = (Equilibrium(4).solve(one) for one in (replace(rigid, supports=SUPPORTS), rigid))
    np.testing.assert_array_equal(found.force, expected.force)
    assert found.receded_supports == {}


@pytest.mark.parametrize(
    ("make", "what"),
    [
        (lambda: replace(SEATS, length=20.0), "length"),
        (lambda: replace(SEATS, span=30.0), "span"),
        (lambda: replace(SEATS, clearance=-1.0), "clearance"),
        (lambda: replace(SEATS, depth=0.0), "depth"),
        (lambda: replace(RING, outer_radius=66.0), "outer_radius"),
        (lambda: replace(RING, width=0.0), "width"),
        (lambda: replace(RING, waves=-1), "waves"),
        (lambda: replace(RING, mounting=0.0), "mounting"),
        (lambda: replace(PILLARS, radius=0.0), "radius"),
        (lambda: replace(PILLARS, far_share=1.5), "far_share"),
    ],
)
def test_impossible_sizes_are_refused(make, what):
    with pytest.raises(LoadError, match=what):
        make()


def test_supports_of_another_drive_are_refused(rigid):
    central = replace(rigid.drive, support=CentralEccentric(4e5), first_stage=None)
    for drive, supports, what in (
        (rigid.drive, Supports(seats=replace(SEATS, places=(0.0,))), "pin seats"),
        (rigid.drive, Supports(ring=replace(RING, waves=21)), "waves"),
        (central, Supports(pillars=PILLARS), "central eccentric"),
    ):
        with pytest.raises(LoadError, match=what):
            replace(rigid, drive=drive, supports=supports)
    soft = replace(rigid, drive=central, supports=Supports(SEATS, RING))
    assert StageEquilibrium(3).solve(soft).converged
