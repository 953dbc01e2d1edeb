"""The compiled moment balance against its readable reference, law by law and near its limits."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.contact import equilibrium
from cycloid_profile.contact.backlash import first_touch
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.law_forms import Logarithmic
from cycloid_profile.contact.laws import LAWS
from cycloid_profile.contact.meshing import mesh, output_turn
from cycloid_profile.modification.setup import DeformationCompensation, Equidistant, RadialMoving, modify

pytest.importorskip("numba")
LOGARITHMIC = [name for name, law in LAWS.items() if isinstance(law, Logarithmic)]
CHANGES = {
    "unmodified": (),
    "equidistant": (Equidistant(0.006),),
    "wide": (Equidistant(0.08),),
    "compensated pair": (Equidistant(0.02), RadialMoving(-0.004), DeformationCompensation(0.002)),
}


def given(drive, law, changes, poses=80):
    case = LoadCase(drive, modify(drive.theoretical_profile, *changes), 412e3, law=LAWS[law])
    touch = first_touch(case.profile, drive.pin_radius, mesh(drive.trochoid, output_turn(drive.trochoid, poses)), 1.0)
    gap, lever = np.maximum(touch.gaps.gap[:, 0], 0.0), touch.gaps.lever[:, 0]
    return case.law, case.line_contact(touch.gaps.curvature[:, 0]), gap, lever


@pytest.mark.parametrize("changes", CHANGES)
@pytest.mark.parametrize("law", LOGARITHMIC)
def test_compiled_and_plain_agree(rv40e, law, changes):
    from cycloid_profile.contact.compiled import balanced

    problem = given(rv40e, law, CHANGES[changes])
    for torque in (np.geomspace(1.0, 1e6, 80), np.full(80, 206e3)):
        plain = equilibrium.balance_moments_plainly(*problem, torque)
        rotation, approach, force, stiffness, residual, settled = balanced(*problem, torque, 1e-12)
        assert np.all(settled)
        assert np.max(residual) < 1e-12
        np.testing.assert_allclose(rotation, plain.rotation, rtol=1e-11)
        largest = np.max(plain.force, axis=-1, keepdims=True)
        np.testing.assert_allclose(force / largest, plain.force / largest, atol=1e-9)
        np.testing.assert_allclose(approach, plain.approach, atol=1e-15)
        carrying = plain.force > 1e-6 * largest
        np.testing.assert_allclose(stiffness[carrying], plain.stiffness[carrying], rtol=1e-8)


def test_large_batches_take_the_compiled_way_and_small_ones_do_not(rv40e, monkeypatch):
    problem, torque = given(rv40e, "roark", CHANGES["equidistant"]), np.full(80, 206e3)
    small = equilibrium.balance_moments(*problem, torque)
    assert len(small.history) > 1
    monkeypatch.setattr(equilibrium, "_WORTH_COMPILING", 1)
    large = equilibrium.balance_moments(*problem, torque)
    assert len(large.history) == 1
    np.testing.assert_allclose(large.rotation, small.rotation, rtol=1e-11)
    monkeypatch.setattr(equilibrium, "_NUMBA", False)
    assert len(equilibrium.balance_moments(*problem, torque).history) > 1


def test_a_load_no_law_covers_falls_back_to_the_reference(rv40e, monkeypatch):
    problem, torque = given(rv40e, "roark", CHANGES["equidistant"]), np.full(80, 206e3)
    torque[7] = 1e12
    monkeypatch.setattr(equilibrium, "_WORTH_COMPILING", 1)
    found = equilibrium.balance_moments(*problem, torque)
    assert not found.residual[7] < 1e-12
    others = np.delete(np.arange(80), 7)
    assert np.all(found.residual[others] < 1e-12)
