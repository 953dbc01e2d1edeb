"""Kinematics of the supports: rigid motion stretches nothing, and virtual work closes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.bodies import (
    LinearBearing,
    PartDeviations,
    crank_turn_per_carrier_turn,
    support_model,
)
from cycloid_profile.contact.mesh import mesh
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive, InvoluteStage, Trochoid

SUPPORTS = [Cranks(3, 36.0, 4e5), Cranks(2, 20.0, 1e5), CentralEccentric(2e5)]
STAGES = [None, InvoluteStage(12, 36, 1.5), InvoluteStage(10, 26, 1.25)]


@st.composite
def drives(draw):
    support = draw(st.sampled_from(SUPPORTS))
    stage = draw(st.sampled_from(STAGES)) if isinstance(support, Cranks) else None
    return Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, draw(st.integers(1, 3)), support, stage)


@given(drives(), st.floats(-3.0, 3.0))
def test_rigid_motion_stretches_no_bearing_and_turns_every_disc(drive, crank):
    model = support_model(drive, mesh(drive.trochoid, [crank, crank + 1.0], drive.discs).crank_angle)
    stretch = np.einsum("psdu,pu->psd", model.spring_stretch, model.rigid_motion)
    np.testing.assert_allclose(stretch, 0.0, atol=1e-12)
    turn = model.motion(model.rigid_motion)[..., 2]
    assert turn.shape == (2, drive.discs)
    np.testing.assert_array_equal(turn, 1.0)
    assert model.bearing == LinearBearing(drive.support.bearing_stiffness)


@given(drives(), st.floats(-3.0, 3.0))
def test_springs_leave_the_common_turn_alone_free(drive, crank):
    model = support_model(drive, mesh(drive.trochoid, [crank], drive.discs).crank_angle)
    stiffness = np.einsum("psdu,psdv->puv", model.spring_stretch, model.spring_stretch)[0]
    # The one motion that stretches nothing is the common turn, which the pins hold.
    assert np.linalg.matrix_rank(stiffness) == stiffness.shape[0] - 1


def test_every_crank_has_two_springs_on_every_disc(rv40e):
    model = support_model(rv40e, np.array([[0.0, np.pi]]))
    assert model.spring_stretch.shape == (1, 6, 2, 7)
    # Every unknown but the carrier's turn belongs to one disc.
    np.testing.assert_array_equal(model.disc_unknowns, [[1, 2, 3], [4, 5, 6]])


def test_crank_turns_with_the_carrier_and_through_the_first_stage(rv40e):
    assert crank_turn_per_carrier_turn(rv40e) == pytest.approx(1.0 + 12.0 / 36.0)
    bare = Drive(rv40e.trochoid, 3.0, 11.5, 2, rv40e.support)
    assert crank_turn_per_carrier_turn(bare) == 0.0


def test_eccentric_swings_across_its_own_radius(rv40e):
    # Input held: a carrier turn of 1 rad turns the crank 4/3 rad and moves the disc's centre by that times a.
    angle = np.array([[0.3, 0.3 + np.pi]])
    rigid = support_model(rv40e, angle).rigid_motion[0]
    moved = rigid[1:].reshape(2, 3)
    np.testing.assert_allclose(moved[:, 0] + 1j * moved[:, 1], 1j * 1.3 * 4.0 / 3.0 * np.exp(1j * angle[0]), rtol=1e-12)


@pytest.mark.parametrize(("support", "per_disc"), [(SUPPORTS[0], 3), (SUPPORTS[2], 2)], ids=["cranks", "central"])
def test_shifts_are_weighed_with_the_pin_circle_and_turns_are_not(support, per_disc):
    drive = Drive(Trochoid(40, 64.0, 1.3), 3.0, 11.5, 2, support)
    arm = support_model(drive, np.array([[0.0, np.pi]])).arm
    disc = [64.0, 64.0, 1.0][:per_disc]
    np.testing.assert_array_equal(arm, [1.0, *disc, *disc])


def test_errors_of_parts_turn_with_their_parts(rv40e):
    # An eccentric's error turns with its crank, a bore's with the carrier, −φ/z_c; each is a stretch at rest.
    crank = mesh(rv40e.trochoid, [0.0, 0.4, 2.0], 2).crank_angle
    eccentric, bore = np.zeros((2, 3), dtype=complex), np.zeros((2, 3), dtype=complex)
    eccentric[1, 2], bore[0, 1] = 2e-3 + 1e-3j, 3e-3 - 1e-3j
    stretch = support_model(rv40e, crank, PartDeviations(eccentric_shift=eccentric, bore_shift=bore)).misfit
    found = (stretch[..., 0] + 1j * stretch[..., 1]).reshape(3, 2, 3)
    wanted = np.zeros_like(found)
    wanted[:, 1, 2] = eccentric[1, 2] * np.exp(1j * crank[:, 1])
    wanted[:, 0, 1] = -bore[0, 1] * np.exp(-1j * crank[:, 0] / 39.0)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-15)
    # A crank that runs ahead at its planet's angle swings its eccentric round, on both discs.
    lead = np.array([1e-4, 2e-4j, 0.0])
    stretch = support_model(rv40e, crank, PartDeviations(crank_lead=lead)).misfit
    ahead = (lead * np.exp(1j * crank[:, :1] * (1.0 + 1.0 / 39.0))).real[:, np.newaxis]
    swung = 1.3 * (np.exp(1j * (crank[..., np.newaxis] + ahead)) - np.exp(1j * crank)[..., np.newaxis])
    found = (stretch[..., 0] + 1j * stretch[..., 1]).reshape(3, 2, 3)
    np.testing.assert_allclose(found, swung, rtol=0.0, atol=1.3 * 2e-4**2)
