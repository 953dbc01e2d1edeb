"""First touch and backlash: what must hold for every drive and modification."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.mesh import (
    Backlash,
    backlash,
    first_order_backlash,
    first_touch,
    input_locked_factor,
    mesh,
    mesh_cycle,
)
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid, undercut_limit
from cycloid_profile.modification import (
    DeformationCompensation,
    Equidistant,
    FlankRotation,
    MeasuredDeviation,
    NormalDeviation,
    RadialMoving,
    modify,
)


@st.composite
def drives(draw):
    pins, K1, r_p = draw(st.integers(8, 80)), draw(st.floats(0.1, 0.85)), draw(st.floats(20.0, 200.0))
    trochoid = Trochoid(pins, r_p, K1 * r_p / pins)
    limit = min(undercut_limit(trochoid), r_p * math.sin(math.pi / pins))
    return Drive(trochoid, draw(st.floats(0.2, 0.8)) * limit, 10.0, 1, CentralEccentric(1e5))


@given(drives(), st.floats(1e-6, 1e-4), st.sampled_from([1.0, -1.0]))
def test_disc_touches_and_overlaps_nowhere(drive, share, direction):
    r_p = drive.trochoid.pin_circle_radius
    tooth = modify(drive.theoretical_profile, Equidistant(share * r_p))
    touch = first_touch(tooth, drive.pin_radius, mesh(drive.trochoid, mesh_cycle(drive.trochoid, 4)), direction)
    assert touch.settled.shape == (4, 1)
    assert np.all(touch.settled)
    # Zero at the touching pin of every pose, positive at the others.
    np.testing.assert_allclose(np.min(touch.gaps.gap, axis=-1), 0.0, atol=1e-14 * r_p)
    assert np.all(direction * touch.rotation > 0.0)


@given(drives(), st.floats(1e-5, 1e-4))
def test_backlash_is_at_least_the_first_order_one(drive, share):
    # Only a pin exactly at ψ0 reaches it; between poses the nearest pin stands next to ψ0.
    amount = share * drive.trochoid.pin_circle_radius
    found = backlash(drive, modify(drive.theoretical_profile, Equidistant(amount)), poses=6)
    expected = first_order_backlash(drive, amount, 0.0)
    assert found.least > 0.98 * expected
    assert found.worst < 1.2 * expected
    assert not found.binds


@given(drives())
def test_theoretical_tooth_has_no_backlash_and_does_not_bind(drive):
    found = backlash(drive, drive.theoretical_profile, poses=3)
    np.testing.assert_allclose(found.values, 0.0, atol=1e-11)
    assert not found.binds


@given(st.floats(2e-3, 20e-3), st.floats(0.0, 10e-3), st.floats(0.05, 0.9))
def test_compensation_takes_twice_delta_max_over_the_longest_lever(rv40e, equidistant, radial_moving, share):
    ground = modify(rv40e.theoretical_profile, Equidistant(equidistant), RadialMoving(radial_moving))
    delta = share * equidistant
    before = backlash(rv40e, ground, poses=4)
    after = backlash(rv40e, modify(ground, DeformationCompensation(delta)), poses=4)
    expected = 2.0 * delta / rv40e.trochoid.longest_lever
    np.testing.assert_allclose(before.values - after.values, expected, rtol=2e-3)


def test_compensation_takes_exactly_that_as_the_amount_vanishes(rv40e):
    ground = modify(rv40e.theoretical_profile, Equidistant(0.010))
    before = backlash(rv40e, ground, poses=3).values
    deltas = np.array([1e-3, 2e-3, 4e-3, 8e-3])
    errors = []
    for delta in deltas:
        after = backlash(rv40e, modify(ground, DeformationCompensation(delta)), poses=3).values
        exact = 2.0 * delta / rv40e.trochoid.longest_lever
        errors.append(np.max(np.abs(before - after - exact)) / exact)
    # Relative error of first order in δ: the statement is exact in the limit.
    assert errors[0] < 2e-4
    assert np.polyfit(np.log(deltas), np.log(errors), 1)[0] > 0.8


@pytest.mark.parametrize(("change", "order"), [(Equidistant, 3.0), (RadialMoving, 2.0)])
def test_first_order_backlash_errs_with_a_higher_power_of_the_amount(rv40e, change, order):
    trochoid = rv40e.trochoid
    pose = mesh(trochoid, [-trochoid.critical_phase])  # pin 0 stands at ψ0
    amounts = np.array([0.25e-3, 0.5e-3, 1e-3, 2e-3]) * (1.0 if change is RadialMoving else 8.0)
    errors = []
    for amount in amounts:
        half = 0.5 * first_order_backlash(rv40e, *((amount, 0.0) if change is Equidistant else (0.0, amount)))
        touch = first_touch(modify(rv40e.theoretical_profile, change(amount)), 3.0, pose, 1.0)
        errors.append(abs(touch.rotation[0, 0] - half))
    # The second-order term of the equidistant change vanishes where the lever is longest.
    assert np.polyfit(np.log(amounts), np.log(errors), 1)[0] == pytest.approx(order, abs=0.1)


def test_worst_backlash_is_found_with_few_poses(rv40e):
    tooth = modify(rv40e.theoretical_profile, Equidistant(0.010))
    fine = backlash(rv40e, tooth, poses=480).worst
    errors = [fine - backlash(rv40e, tooth, poses=n).worst for n in (6, 24, 96)]
    assert errors == sorted(errors, reverse=True)
    assert 0.0 <= errors[1] < 1e-3 * fine


def test_backlash_is_even_over_the_mesh_cycle(rv40e):
    # Turning the crank back mirrors the mesh: forward at φ is minus backward at −φ.
    found = backlash(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.01), RadialMoving(-0.004)), poses=8)
    np.testing.assert_allclose(found.forward[1:], -found.backward[1:][::-1], rtol=1e-9)
    assert found.forward[0] == pytest.approx(-found.backward[0], rel=1e-9)
    assert found.worst >= found.least > 0.0


@pytest.mark.parametrize(
    "change",
    [Equidistant(-0.002), DeformationCompensation(0.0016), FlankRotation(-3e-5)],
    ids=lambda c: type(c).__name__,
)
def test_added_material_binds(rv40e, change):
    found = backlash(rv40e, modify(rv40e.theoretical_profile, change), poses=6)
    assert found.binds
    assert found.least < 0.0
    assert found.least_gap < -1e-3


def test_least_gap_is_taken_midway_between_the_two_touches(rv40e):
    # There every pin has nearly the equidistant amount; at either touch the least gap would be zero.
    found = backlash(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.010)), poses=6)
    assert found.least_gap == pytest.approx(0.010, rel=2e-3)


def test_binding_is_distinguished_from_an_overlap_of_nanometres():
    turn = np.array([0.0])
    assert not Backlash(turn, turn, -5e-6).binds
    assert Backlash(turn, turn, -2e-5).binds


def test_input_lock_without_first_stage_is_the_crank_lock():
    drive = Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, CentralEccentric(4e5))
    assert input_locked_factor(drive) == 1.0


def test_each_disc_turns_until_it_touches_whatever_the_other_does(theoretical):
    # Wear of many micrometres on a single lobe: one disc needs more steps than the other.
    phase = np.linspace(0.0, 2.0 * math.pi * 39, 39 * 24, endpoint=False)
    curve = NormalDeviation(phase, np.where(np.abs(phase - 40.0) < 3.0, 0.02, 0.0), 39)
    tooth = modify(theoretical, Equidistant(0.01), MeasuredDeviation(curve))
    meshing = mesh(theoretical.trochoid, mesh_cycle(theoretical.trochoid, 40), 2)
    found = first_touch(tooth, 3.0, meshing, np.array([1.0, -1.0]))
    assert np.all(found.settled)
    np.testing.assert_allclose(np.min(found.gaps.gap, axis=-1), 0.0, atol=1e-10)


def test_touch_that_runs_out_of_steps_says_so(theoretical, monkeypatch):
    monkeypatch.setattr("cycloid_profile.contact.mesh.touch._MAX_STEPS", 1)
    tooth = modify(theoretical, Equidistant(0.01))
    assert not np.any(first_touch(tooth, 3.0, mesh(theoretical.trochoid, [0.0, 0.1]), 1.0).settled)
