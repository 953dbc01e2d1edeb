"""Sliding, bearing loads and losses: against the speed of the turning disc itself, and limits."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, Material, loss_range, losses, sliding_speed
from cycloid_profile.contact.disc import Classical, Equilibrium
from cycloid_profile.contact.mesh import gaps, mesh, mesh_cycle
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.errors import LoadError
from cycloid_profile.modification import Equidistant, modify

OMEGA = 15.0 * 2.0 * math.pi / 60.0


@given(st.floats(-7.0, 7.0), st.floats(0.1, 30.0))
def test_sliding_is_the_speed_of_the_disc_at_the_contact(rv40e, crank, omega):
    # The disc turns with the output about its own centre, which the crank carries round: the speed of its
    # material at each contact point, in the housing, along the tangent.
    trochoid = rv40e.trochoid
    meshing = mesh(trochoid, [crank])
    found = gaps(rv40e.theoretical_profile, 3.0, meshing)
    pin = 64.0 * np.exp(2j * math.pi * np.arange(40) / 40)
    contact = pin - 3.0 * found.normal[0, 0]
    centre = 1.3 * np.exp(1j * crank)
    crank_speed = -39.0 * omega
    velocity = 1j * crank_speed * centre + 1j * omega * (contact - centre)
    across = (np.conj(1j * found.normal[0, 0]) * velocity).real
    along = (np.conj(found.normal[0, 0]) * velocity).real
    np.testing.assert_allclose(np.abs(across), sliding_speed(rv40e, meshing.phase[0, 0], omega), rtol=1e-10)
    # Touching bodies neither part nor press into each other.
    np.testing.assert_allclose(along, 0.0, atol=1e-10 * omega * 64.0)


def test_mesh_loss_is_friction_times_force_times_speed(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    one, whole = Equilibrium(8).solve(case), StageEquilibrium(8).solve(case)
    found = losses(one, OMEGA, 0.05)
    by_hand = 0.0
    for force, psi in zip(one.force[:, 0], one.phase[:, 0], strict=True):
        for F, p in zip(force, psi, strict=True):
            S = 1.0 / math.sqrt(1.0 + 0.8125**2 - 2.0 * 0.8125 * math.cos(p))
            by_hand += 2.0 * 0.05 * F * OMEGA * (64.0 / S - 3.0) / 8 * 1e-3
    assert found.mesh == pytest.approx(by_hand, rel=1e-12)
    assert found.output == pytest.approx(412.0 * OMEGA, rel=1e-12)
    assert found.bearings == 0.0
    # The stage holds both discs itself. Its cranks take 3.3 % of the moment, and its bearings give way, which
    # moves load towards the root where sliding is slow.
    share = 39.0 / (40.0 + 1.0 / 3.0)
    assert 0.93 * share * found.mesh < losses(whole, OMEGA, 0.05).mesh < share * found.mesh


def test_losses_go_with_friction_and_speed(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    whole = StageEquilibrium(4).solve(case)
    base = losses(whole, OMEGA, 0.05, 12.0)
    assert base.bearings > 0.0
    assert base.efficiency == pytest.approx(base.output / (base.output + base.mesh + base.bearings))
    assert losses(whole, OMEGA, 0.1, 12.0).mesh == pytest.approx(2.0 * base.mesh)
    assert losses(whole, OMEGA, 0.05, 24.0).bearings == pytest.approx(2.0 * base.bearings)
    faster = losses(whole, 3.0 * OMEGA, 0.05, 12.0)
    assert faster.efficiency == pytest.approx(base.efficiency)
    assert losses(whole, OMEGA, 0.0).efficiency == 1.0
    assert losses(Classical().solve(case), OMEGA, 0.05, 12.0).bearings == 0.0


def test_range_of_losses_is_the_range_of_friction(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    whole = StageEquilibrium(4).solve(case)
    found = loss_range(whole, OMEGA, 0.05, 10.0)
    assert found.likely == losses(whole, OMEGA, 0.05, 10.0)
    assert found.low.mesh / found.likely.mesh == pytest.approx(0.03 / 0.05)
    assert found.high.mesh / found.likely.mesh == pytest.approx(0.12 / 0.05)
    assert found.low.bearings / found.likely.bearings == pytest.approx(0.8)
    assert found.high.bearings / found.likely.bearings == pytest.approx(1.2)
    assert found.high.heat == found.high.mesh + found.high.bearings
    # A friction outside the range of lubricated steel widens it.
    assert (loss_range(whole, OMEGA, 0.01).low.friction, loss_range(whole, OMEGA, 0.3).high.friction) == (0.01, 0.3)
    assert "crank bearings left out" in loss_range(whole, OMEGA, 0.05).assumption
    assert "not both steel" not in found.assumption
    plastic = StageEquilibrium(2).solve(replace(case, torque=20e3, disc_material=Material(3e3, 0.36)))
    assert "not both steel" in loss_range(plastic, OMEGA, 0.05).assumption


def test_bearing_forces_carry_the_torque_of_each_disc(rv40e, rated_torque):
    # The cranks hold the disc: its pins' moment is that of the bearing forces about its centre.
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    crank = mesh_cycle(rv40e.trochoid, 6)
    found = StageEquilibrium().at(case, crank)
    turned = np.exp(-1j * crank / 39.0)[:, np.newaxis]
    arm = 36.0 * np.exp(2j * math.pi * np.arange(3) / 3) * turned
    for j in range(2):
        bearings = np.sum((np.conj(arm) * found.stage.bearing_force[:, j]).imag, axis=-1)
        pins = np.sum(found.force[:, j] * found.lever[:, j], axis=-1)
        np.testing.assert_allclose(bearings, pins, rtol=1e-4)


def test_full_turn_of_the_output_repeats_each_mesh_cycle(rv40e, rated_torque):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    cycle = 2.0 * math.pi / 40.0
    here = 0.4 * cycle
    turns = here - cycle * np.array([0, 1, 39, 777, 1559])
    found = StageEquilibrium().at(case, turns)
    np.testing.assert_allclose(found.rotation, found.rotation[0], rtol=1e-9)
    np.testing.assert_allclose(
        np.sort(found.force, axis=-1)[:, 0], np.sort(found.force[0, 0])[np.newaxis].repeat(5, 0), atol=1e-4
    )


@pytest.mark.parametrize(
    ("change", "what"),
    [
        ({"output_speed": -1.0}, "output_speed"),
        ({"friction": math.nan}, "friction"),
        ({"needle_friction": -0.1}, "needle_friction"),
    ],
)
def test_meaningless_running_is_refused(rv40e, rated_torque, change, what):
    sharing = Equilibrium(2).solve(LoadCase(rv40e, replace(rv40e).theoretical_profile, rated_torque))
    with pytest.raises(LoadError) as caught:
        losses(sharing, **{"output_speed": OMEGA, "friction": 0.05, **change})
    assert caught.value.what == what
