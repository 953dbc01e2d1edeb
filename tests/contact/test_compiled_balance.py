"""The compiled kernels against their plain numpy references, law by law and near their limits."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc import equilibrium
from cycloid_profile.contact.disc.equilibrium import balance_moments, balance_moments_numpy
from cycloid_profile.contact.laws import LAWS, LawFromApproach, OnSpring
from cycloid_profile.contact.mesh import first_touch, mesh, output_turn
from cycloid_profile.contact.stage import StageEquilibrium, energy_about, minimise
from cycloid_profile.modification import DeformationCompensation, Equidistant, RadialMoving, modify
from tests.contact.plain_search import plain_search

CHANGES = {
    "unmodified": (),
    "equidistant": (Equidistant(0.006),),
    "wide": (Equidistant(0.08),),
    "compensated pair": (Equidistant(0.02), RadialMoving(-0.004), DeformationCompensation(0.002)),
}


def given(drive, law, changes, poses=80):
    case = LoadCase(drive, modify(drive.theoretical_profile, *changes), 412e3, law=law)
    touch = first_touch(case.profile, drive.pin_radius, mesh(drive.trochoid, output_turn(drive.trochoid, poses)), 1.0)
    gap, lever = np.maximum(touch.gaps.gap[:, 0], 0.0), touch.gaps.lever[:, 0]
    return case.law, case.line_contact(touch.gaps.curvature[:, 0]), gap, lever


@pytest.mark.parametrize("changes", CHANGES)
@pytest.mark.parametrize("law", LAWS)
def test_compiled_and_plain_agree(rv40e, law, changes, monkeypatch):
    monkeypatch.setattr(equilibrium, "_WORTH_COMPILING", 0)
    problem = given(rv40e, LAWS[law], CHANGES[changes])
    for torque in (np.geomspace(1.0, 1e6, 80), np.full(80, 206e3)):
        plain, found = balance_moments_numpy(*problem, torque), balance_moments(*problem, torque)
        rotation, approach, force, stiffness = found.rotation, found.approach, found.force, found.stiffness
        assert np.max(found.residual) < 1e-12
        np.testing.assert_allclose(found.history[-1], plain.history[-1], rtol=1e-9)
        np.testing.assert_allclose(rotation, plain.rotation, rtol=1e-11)
        for one in (plain, found):
            turned = np.sum(one.stiffness * problem[3] ** 2, axis=1)
            np.testing.assert_allclose(one.torsional_stiffness, turned, rtol=1e-12)
            np.testing.assert_array_equal(one.receded, 0.0)
        largest = np.max(plain.force, axis=-1, keepdims=True)
        np.testing.assert_allclose(force / largest, plain.force / largest, atol=1e-9)
        np.testing.assert_allclose(approach, plain.approach, atol=1e-15)
        carrying = plain.force > 1e-6 * largest
        np.testing.assert_allclose(stiffness[carrying], plain.stiffness[carrying], rtol=1e-8)


@pytest.mark.parametrize(
    "law",
    [OnSpring(LAWS["roark"], 1e-5), OnSpring(LAWS["palmgren"], 1e-5), LawFromApproach(LAWS["roark"].approach)],
    ids=["logarithm on springs", "power law on springs", "table"],
)
def test_moments_balance_under_every_kind_of_law(rv40e, law, monkeypatch):
    # Springs as soft as five contacts: with them a pin that carries all the torque sinks in six times as far.
    monkeypatch.setattr(equilibrium, "_WORTH_COMPILING", 0)
    _, contact, gap, lever = problem = given(rv40e, law, CHANGES["equidistant"], poses=8)
    torque = np.geomspace(1e2, 1e6, 8)
    found = balance_moments(*problem, torque)
    assert len(found.history) == 1  # compiled
    sunk = found.rotation[:, np.newaxis] * lever - gap
    np.testing.assert_array_equal(found.force > 0.0, sunk > 0.0)
    np.testing.assert_allclose(np.sum(found.force * lever, axis=1), torque, rtol=1e-12)
    np.testing.assert_allclose(law.approach(found.force, contact), np.maximum(sunk, 0.0), rtol=1e-8, atol=1e-14)


def test_a_load_no_law_covers_does_not_disturb_the_others(rv40e):
    problem, torque = given(rv40e, LAWS["roark"], CHANGES["equidistant"]), np.full(80, 206e3)
    torque[7] = 1e12
    found = balance_moments(*problem, torque)
    assert not found.residual[7] < 1e-12
    others = np.delete(np.arange(80), 7)
    assert np.all(found.residual[others] < 1e-12)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("play", [0.0, 0.004])
def test_least_energy_is_that_of_the_plain_search(rv40e, law, play):
    drive = replace(rv40e, support=replace(rv40e.support, bearing_play=play))
    case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006)), 412e3, law=LAWS[law])
    problem = energy_about(StageEquilibrium(poses=5).solve(case))
    pressed = np.zeros((5, problem.arm.size))
    pressed[:, 0] = 2e-5
    plain, (found, _) = plain_search(problem, pressed, 1e-10), minimise(problem, pressed, 1e-10)
    np.testing.assert_allclose(found / problem.arm, plain / problem.arm, rtol=0.0, atol=1e-12)
