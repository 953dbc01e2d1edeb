"""Load sharing by true equilibrium: balance, symmetry, scaling, and limits with a closed form."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, SolveStatus
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import ArticleLogarithm, Johnson, Roark
from cycloid_profile.contact.mesh import first_touch, mesh, mesh_cycle
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid, undercut_limit
from cycloid_profile.modification import DeformationCompensation, Equidistant, RadialMoving, modify
from cycloid_profile.units import UM


def solved(drive, torque, *changes, poses=4, **options):
    case = LoadCase(drive, modify(drive.theoretical_profile, *changes), torque, **options)
    return Equilibrium(poses=poses).solve(case)


@given(
    st.floats(0.0, 0.03),
    st.floats(-0.005, 0.01),
    st.floats(1e3, 1.5e6),
    st.sampled_from([1.0, -1.0]),
    st.sampled_from([Roark(), Johnson(), ArticleLogarithm()]),
)
def test_moments_balance_at_every_pose(rv40e, equidistant, radial_moving, torque, sign, law):
    changes = (Equidistant(equidistant + 0.02), RadialMoving(radial_moving), DeformationCompensation(0.001))
    result = solved(rv40e, sign * torque, *changes, law=law)
    assert result.status is SolveStatus.CONVERGED
    np.testing.assert_allclose(np.sum(result.force * result.lever, axis=-1), 0.5 * torque, rtol=1e-11)
    # Force is the law's answer to the approach, at each pin's own curvature, and only where there is one.
    np.testing.assert_array_equal(result.force > 0.0, result.approach > 0.0)
    assert np.all(result.lever[result.force > 0.0] > 0.0)
    assert np.all(result.gap >= 0.0)
    assert np.all(np.min(result.gap, axis=-1) <= 1e-13)


@given(st.floats(1e3, 4e5), st.floats(1.05, 3.0))
def test_more_torque_means_more_of_everything(rv40e, torque, factor):
    less, more = (solved(rv40e, t, Equidistant(0.006)) for t in (torque, factor * torque))
    assert more.max_force > less.max_force
    assert more.delta_max > less.delta_max
    assert more.max_pressure > less.max_pressure
    assert more.loaded_pins >= less.loaded_pins
    # The gap leaves the load to more pins as they come in: force rises less than the torque.
    assert more.max_force < factor * less.max_force * (1.0 + 1e-12)


def test_reversed_torque_mirrors_the_load(rv40e, rated_torque):
    there, back = (solved(rv40e, s * rated_torque, Equidistant(0.006), RadialMoving(0.002), poses=6) for s in (1, -1))
    # Pose k mirrors into pose 6 − k; pose 0, with a pin in the root, into itself: ψ → −ψ.
    for mirrored, turn in ((back.twist, there.twist), (back.rotation, there.rotation)):
        np.testing.assert_allclose(mirrored[1:], -turn[1:][::-1], rtol=1e-10)
        assert mirrored[0] == pytest.approx(-turn[0], rel=1e-10)
    forces = []
    for result in (there, back):
        force = result.force[0, 0, np.argsort(result.phase[0, 0])]
        forces.append(force[force > 0.0])
    np.testing.assert_allclose(*forces, rtol=1e-9)
    # Phases of a reversed case are counted on the flank that works.
    assert np.all(there.phase[there.force > 0.0] > 0.0)
    assert np.all(back.phase[back.force > 0.0] > 0.0)


@given(st.floats(0.2, 5.0))
def test_scaled_drive_carries_force_with_the_square_of_its_size(rv40e, k):
    trochoid = Trochoid(40, 64.0 * k, 1.3 * k)
    scaled = Drive(trochoid, 3.0 * k, 11.5 * k, 2, CentralEccentric(1e5))
    small = solved(rv40e, 4e5, Equidistant(0.006))
    large = solved(scaled, 4e5 * k**3, Equidistant(0.006 * k))
    np.testing.assert_allclose(large.force, k**2 * small.force, rtol=1e-7, atol=1e-6 * k**2)
    np.testing.assert_allclose(large.twist, small.twist, rtol=1e-9)
    assert large.max_pressure == pytest.approx(small.max_pressure, rel=1e-7)


def check_single_contact(result, torque):
    """Force, approach, rotation and pressure of one loaded pin in closed form, at every pose."""
    case, r = result.case, result.case.drive.pin_radius
    poses, discs, pins = result.phase.shape
    assert (discs, pins) == (1, case.drive.trochoid.pins)
    meshing = mesh(case.drive.trochoid, mesh_cycle(case.drive.trochoid, poses))
    curvature = first_touch(case.profile, r, meshing, 1.0).gaps.curvature[:, 0]
    assert result.loaded_pins == 1
    for pose in range(poses):
        i = int(np.argmax(result.force[pose, 0]))
        lever, contact = result.lever[pose, 0, i], case.line_contact(curvature[pose, i : i + 1])
        force = torque / case.drive.discs / lever
        delta = float(case.law.approach(force, contact)[0])
        # The pin that touches first has no gap: rotation = approach/lever.
        assert result.force[pose, 0, i] == pytest.approx(force, rel=1e-9)
        assert result.approach[pose, 0, i] == pytest.approx(delta, rel=1e-9)
        assert result.twist[pose] == pytest.approx(delta / lever, rel=1e-9)
        assert result.pressure[pose, 0, i] == pytest.approx(float(contact.peak_pressure(force)[0]), rel=1e-9)
        assert np.count_nonzero(result.pressure[pose]) == 1


@pytest.mark.parametrize("torque", [100.0, 412.0])
def test_one_loaded_pin_is_a_hertz_contact(rv40e, torque):
    # A millimetre of clearance and a light load leave one pin in contact.
    check_single_contact(solved(rv40e, torque, Equidistant(1.0)), torque)


def test_three_pin_drive_carries_on_one_pin():
    drive = Drive(Trochoid(3, 40.0, 5.0), 4.0, 10.0, 1, CentralEccentric(1e5))
    # A hair of clearance frees the pin in the root, which could not help anyway.
    check_single_contact(solved(drive, 20_000.0, Equidistant(1e-3), poses=1), 20_000.0)


@given(st.integers(3, 120), st.floats(0.1, 0.95), st.floats(0.0, 1e-4), st.floats(0.1, 10.0))
def test_any_drive_finds_its_equilibrium(pins, K1, gap, load):
    r_p = 64.0
    trochoid = Trochoid(pins, r_p, K1 * r_p / pins)
    r_rp = 0.5 * min(undercut_limit(trochoid), r_p * np.sin(np.pi / pins))
    drive = Drive(trochoid, r_rp, 10.0, 1, CentralEccentric(1e5))
    torque = load * 100.0 * trochoid.longest_lever * r_rp  # of the order of 100 N per mm of pin radius
    result = solved(drive, torque, Equidistant(gap * r_rp), poses=3)
    assert result.status is SolveStatus.CONVERGED
    np.testing.assert_allclose(np.sum(result.force * result.lever, axis=-1), torque, rtol=1e-11)


def test_history_descends_to_the_answer(rv40e, rated_torque):
    result = solved(rv40e, rated_torque, Equidistant(0.006))
    deltas = [delta for _, delta in result.history]
    # Newton from above on a convex moment: δmax falls at every step.
    assert all(a >= b for a, b in itertools.pairwise(deltas))
    assert result.history[-1] == pytest.approx((result.max_force, result.delta_max))
    assert result.iterations == len(result.history) < 15
    assert result.solver == "equilibrium"


def test_regression_of_the_rated_load(rv40e, rated_torque):
    # Own results of 24 poses, pinned so that a change is noticed; no outside source.
    result = solved(rv40e, rated_torque, Equidistant(0.006), poses=24)
    assert result.max_force == pytest.approx(718.06, abs=0.01)
    assert result.delta_max / UM == pytest.approx(1.93136, abs=1e-5)
    assert result.max_pressure == pytest.approx(1293.35, abs=0.01)
    assert result.loaded_pins == 10


def test_disc_stiffness_is_of_the_size_known_for_contact_alone(rv40e, rated_torque):
    # Direct numerical geometry, computed independently: a disc's contacts alone are worth about
    # 2,400 N·m/′ between half and full load; the source does not say for which gap, so 2 µm and 6 µm,
    # the usual modifications, must bracket it.
    stiffness = []
    for gap in (0.006, 0.002):
        half, full = (solved(rv40e, t, Equidistant(gap), poses=12) for t in (0.5 * rated_torque, rated_torque))
        turn = np.mean(full.twist - half.twist) * 60.0 * 180.0 / np.pi
        stiffness.append(0.25 * rated_torque * 1e-3 / turn)
    assert stiffness[0] < 2400.0 < stiffness[1]
    assert stiffness == pytest.approx([2400.0, 2400.0], rel=0.15)


def test_step_limit_is_reported(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    result = Equilibrium(poses=2, max_iterations=1).solve(case)
    assert result.status is SolveStatus.NOT_CONVERGED
    assert result.residual.shape == (2,)
    assert np.all(result.residual > 1e-3)


def test_missing_touch_is_reported(rv40e, rated_torque, monkeypatch):
    monkeypatch.setattr("cycloid_profile.contact.mesh.touch._MAX_STEPS", 1)
    result = solved(rv40e, rated_torque, Equidistant(0.006))
    assert result.status is SolveStatus.NO_CONTACT
    assert "bring modification.equidistant_um and radial_moving_um nearer to zero" in result.status.value


def test_torque_no_contact_law_covers_does_not_pass_for_an_answer(rv40e):
    assert solved(rv40e, 1e10, Equidistant(0.006)).status is not SolveStatus.CONVERGED


@pytest.mark.parametrize("change", [Equidistant(-0.001), RadialMoving(-0.002)], ids=["equidistant", "radial-moving"])
def test_interference_is_reported(rv40e, rated_torque, change):
    result = solved(rv40e, rated_torque, change)
    assert result.status is SolveStatus.INTERFERENCE
    assert "raise the clearance" in result.status.value
