"""Where pins stand on the discs: seen from the lobe and back again."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.mesh import mesh, mesh_cycle
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Trochoid


@given(st.integers(3, 120), st.floats(0.1, 0.95), st.floats(-10.0, 10.0), st.integers(1, 3))
def test_pins_stand_still_in_the_housing(pins, K1, crank, discs):
    trochoid = Trochoid(pins, 64.0, K1 * 64.0 / pins)
    meshing = mesh(trochoid, [crank], discs)
    # Out of the lobe's frame again: turn back and add the disc's centre at a·e^{iφ}.
    centre = trochoid.eccentricity * np.exp(1j * meshing.crank_angle)[..., np.newaxis]
    housing = centre + meshing.pin_in_lobe() * np.conj(meshing.into_lobe)
    expected = 64.0 * np.exp(2j * math.pi * np.arange(pins) / pins)
    np.testing.assert_allclose(housing, np.broadcast_to(expected, housing.shape), atol=1e-11)


@given(st.integers(3, 120), st.floats(-50.0, 50.0), st.integers(1, 3))
def test_phases_are_one_pitch_apart_on_the_nearest_lobe(pins, crank, discs):
    meshing = mesh(Trochoid(pins, 64.0, 32.0 / pins), [crank, crank + 0.1], discs)
    assert meshing.phase.shape == (2, discs, pins)
    assert np.all(np.abs(meshing.phase) <= math.pi + 1e-12)
    spacing = np.diff(np.sort(meshing.phase, axis=-1), axis=-1)
    np.testing.assert_allclose(spacing, 2.0 * math.pi / pins, atol=1e-11)
    np.testing.assert_allclose(np.abs(meshing.into_lobe), 1.0, atol=1e-14)


def test_discs_are_evenly_phased():
    meshing = mesh(Trochoid(40, 64.0, 1.3), [0.2], 3)
    np.testing.assert_allclose(meshing.crank_angle, [[0.2, 0.2 + 2 * math.pi / 3, 0.2 + 4 * math.pi / 3]])


def test_mesh_cycle_is_one_pin_pitch_from_a_pin_in_the_root():
    trochoid = Trochoid(40, 64.0, 1.3)
    crank = mesh_cycle(trochoid, 8)
    np.testing.assert_allclose(np.diff(crank), 2.0 * math.pi / 40 / 8)
    np.testing.assert_allclose(np.sort(mesh(trochoid, crank[:1]).phase[0, 0])[:3], np.radians([-171.0, -162.0, -153.0]))
    # One cycle on, the same phases recur on the next pin.
    after = mesh(trochoid, crank[:1] + 2.0 * math.pi / 40).phase[0, 0]
    np.testing.assert_allclose(np.sort(np.cos(after)), np.sort(np.cos(mesh(trochoid, [0.0]).phase[0, 0])), atol=1e-14)


def test_displacement_and_rotation_move_the_pin_seen_from_the_disc_the_other_way():
    meshing = mesh(Trochoid(40, 64.0, 1.3), [0.3])
    rest, shift, turn = meshing.pin_in_lobe(), 0.01 - 0.02j, 0.003
    moved = meshing.pin_in_lobe(np.full((1, 1), shift), np.full((1, 1), turn))
    np.testing.assert_allclose(moved, np.exp(-1j * turn) * (rest - shift * meshing.into_lobe), atol=1e-13)
    np.testing.assert_allclose(np.abs(moved[0, 0] - rest[0, 0]).max(), abs(shift) + 64.0 * turn, rtol=0.1)


def test_one_crank_angle_may_be_a_plain_number():
    assert mesh(Trochoid(40, 64.0, 1.3), 0.2).phase.shape == (1, 1, 40)
    with pytest.raises(ValueError, match="could not convert"):
        mesh(Trochoid(40, 64.0, 1.3), "north")
    for none in ([], [[0.1, 0.2]]):
        with pytest.raises(LoadError, match="is no row of poses"):
            mesh(Trochoid(40, 64.0, 1.3), none)
