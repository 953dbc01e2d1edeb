"""Planar reducer: limits with a known answer, balance by virtual work, symmetry, how it ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, SolveStatus
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.mesh import backlash, first_touch, gaps, input_locked_factor, mesh, mesh_cycle
from cycloid_profile.contact.stage import StageEquilibrium, minimise
from cycloid_profile.contact.stage import _block as stage_block
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive, Trochoid, undercut_limit
from cycloid_profile.modification import Equidistant, RadialMoving, modify

GROUND = (Equidistant(0.006), RadialMoving(0.001))


def solved(drive, torque, *changes, poses=4, tolerance=1e-9):
    case = LoadCase(drive, modify(drive.theoretical_profile, *changes), torque)
    return StageEquilibrium(poses, tolerance).solve(case)


@pytest.mark.parametrize("support", [Cranks(3, 36.0, 1e11), CentralEccentric(1e11)], ids=["cranks", "central"])
def test_stiff_bearings_and_a_held_eccentric_give_the_equilibrium_of_each_disc(rv40e, support):
    drive = replace(rv40e, support=support, first_stage=None)
    trochoid, errors = drive.trochoid, []
    torques = np.array([412e2, 412e3, 1648e3])
    for torque in torques:
        state = solved(drive, torque, *GROUND, tolerance=1e-6)
        assert state.converged
        alone = Equilibrium(poses=4).solve(state.case)
        touch = first_touch(state.case.profile, 3.0, mesh(trochoid, mesh_cycle(trochoid, 4)), 1.0)
        turn = state.rotation - touch.rotation[:, 0]
        np.testing.assert_allclose(turn, alone.twist, rtol=5e-3)
        errors.append(np.max(np.abs(state.force[:, 0] - alone.force[:, 0])) / alone.max_force)
        # 40 pins: the second disc, half a turn on, meets the same phases.
        np.testing.assert_allclose(np.max(state.force[:, 1]), np.max(state.force[:, 0]), rtol=1e-3)
    # Equilibrium keeps curvature and lever of the first touch, the reducer those under load: they differ by
    # 0.6 % of the largest force at the rated torque, and the difference goes with the load.
    assert errors[1] < 0.01
    assert errors == sorted(errors)
    assert errors[0] < 0.3 * errors[1]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_vanishing_torque_leaves_the_input_locked_backlash(rv40e, direction):
    # Sorted by torque: the angle between ±T falls to the geometric backlash.
    geometric = backlash(rv40e, modify(rv40e.theoretical_profile, *GROUND), poses=4).values * input_locked_factor(rv40e)
    excess = []
    for torque in (4e4, 4e2, 4.0):
        there, back = (solved(rv40e, s * direction * torque, *GROUND, tolerance=1e-5) for s in (1, -1))
        assert there.converged
        assert back.converged
        excess.append(np.max(np.abs(direction * (there.rotation - back.rotation) - geometric)) / np.max(geometric))
    assert excess == sorted(excess, reverse=True)
    # What remains is the factor's own approximation: it is exact for a pin at ψ0.
    assert excess[-1] < 1e-3


@given(st.floats(4e3, 1e6), st.floats(0.0, 0.157), st.sampled_from([1.0, -1.0]))
def test_pin_forces_do_the_work_of_the_torque(rv40e, torque, crank, sign):
    # Virtual turn of everything with the input held: a pin at lever l moves by l(z_p + z1/z2)/z_c, so the
    # carrier's torque is ΣF·l times that, whatever the bearings do.
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, *GROUND), sign * torque)
    state = StageEquilibrium().at(case, [crank])
    assert state.converged
    motion = state.stage.motion
    found = gaps(case.profile, 3.0, state.stage.meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])
    carried = float(np.sum(state.force * found.lever)) * (40.0 + 1.0 / 3.0) / 39.0
    # Levers of the displaced disc differ from the virtual ones by motion/size, some 1e-4.
    assert carried == pytest.approx(sign * torque, rel=1e-3)
    # Pins carry where they overlap and nowhere else.
    np.testing.assert_array_equal(state.force > 0.0, found.gap < 0.0)


def test_reversed_torque_mirrors_the_twist(rv40e, rated_torque):
    there, back = (solved(rv40e, s * rated_torque, *GROUND, poses=6) for s in (1.0, -1.0))
    np.testing.assert_allclose(back.rotation[1:], -there.rotation[1:][::-1], rtol=1e-7)
    assert back.rotation[0] == pytest.approx(-there.rotation[0], rel=1e-7)


def test_twist_rises_with_torque_and_stiffens(rv40e, rated_torque):
    fractions = np.array([0.1, 0.3, 0.5, 0.7, 0.9])
    twist = np.array([np.mean(solved(rv40e, f * rated_torque, *GROUND).rotation) for f in fractions])
    slopes = np.diff(fractions) / np.diff(twist)
    assert np.all(slopes > 0.0)
    assert np.all(np.diff(slopes) > 0.0)


def test_softer_bearings_twist_more_in_proportion(rv40e, rated_torque):
    # Series compliance: twist = contact + c/k, so three stiffnesses lie on one line in 1/k, nearly.
    stiffness = np.array([2e5, 4e5, 8e5])
    twist = []
    for k in stiffness:
        drive = replace(rv40e, support=Cranks(3, 36.0, k))
        full, half = (np.mean(solved(drive, f * rated_torque, *GROUND).rotation) for f in (1.0, 0.5))
        twist.append(full - half)
    steps = np.diff(twist) / np.diff(1.0 / stiffness)
    assert np.all(steps > 0.0)
    assert steps[0] == pytest.approx(steps[1], rel=0.1)


@given(st.integers(3, 60), st.floats(0.3, 0.9), st.integers(1, 3), st.booleans())
def test_any_reducer_finds_its_equilibrium(pins, K1, discs, cranks):
    trochoid = Trochoid(pins, 64.0, K1 * 64.0 / pins)
    r_rp = 0.5 * min(undercut_limit(trochoid), 64.0 * np.sin(np.pi / pins))
    support = Cranks(2, 20.0, 2e5) if cranks else CentralEccentric(2e5)
    drive = Drive(trochoid, r_rp, 10.0, discs, support)
    torque = 100.0 * discs * trochoid.longest_lever * r_rp
    state = solved(drive, torque, Equidistant(1e-3 * r_rp), poses=2, tolerance=1e-6)
    assert state.converged
    assert np.all(state.rotation > 0.0)
    assert np.all(np.any(state.force > 0.0, axis=-1))


@pytest.mark.slow
def test_unreachable_tolerance_is_reported_at_every_pose(rv40e, rated_torque):
    state = solved(rv40e, rated_torque, *GROUND, tolerance=0.0)
    assert state.statuses == (SolveStatus.NOT_CONVERGED,) * 4
    assert not state.converged
    assert not np.any(state.settled)
    assert np.all(state.residual > 0.0)


def test_missing_touch_is_reported_at_every_pose(rv40e, rated_torque, monkeypatch):
    monkeypatch.setattr("cycloid_profile.contact.stage._block._TOUCH_STEPS", 1)
    state = solved(rv40e, rated_torque, Equidistant(0.006))
    assert state.statuses == (SolveStatus.NO_CONTACT,) * 4


def test_a_lost_pose_does_not_stop_the_others(rv40e, monkeypatch, rated_torque):
    # One pose is thrown far away in the first refresh; the rest must end as they would alone.
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    poses = mesh_cycle(rv40e.trochoid, 5)
    alone = StageEquilibrium().at(case, poses)

    calls = []

    def thrown(*arguments):
        found, load = minimise(*arguments)
        # Later calls see the poses that are left: there the third is another one.
        if not calls:
            found[2] += 1e3
        calls.append(len(found))
        return found, load

    monkeypatch.setattr(stage_block, "minimise", thrown)
    state = StageEquilibrium().at(case, poses)
    assert state.statuses[2] is SolveStatus.LOST
    assert list(state.settled) == [True, True, False, True, True]
    assert calls[:2] == [5, 4]
    others = [0, 1, 3, 4]
    assert state.rotation[others] == pytest.approx(alone.rotation[others], rel=1e-9)
