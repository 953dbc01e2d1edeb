"""Influence of single gaps and bearing fits on the output, against a new solve (physics properties)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import PartDeviations
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.mesh import gaps
from cycloid_profile.contact.stage import ContactChange, ContactPoints, StageEquilibrium, StageTangent
from cycloid_profile.effects import ReducerChange, apply_effects, effect_from_table
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import Cranks
from cycloid_profile.modification import Equidistant, modify

CRANK = -np.array([0.0, 0.03, 0.4, 2.0, 50.0, 200.0])
# Sizes of 0.02 µm and the like: larger ones bring further pins into contact, which no first order can know.
SMALL = [
    {"name": "pin_ring_oval", "amplitude_um": 0.02, "phase_deg": 12.0},
    {"name": "single_pin_error", "amount_um": 0.02, "pin": 3},
    {"name": "equidistant_error", "amount_um": 0.02},
    {"name": "disc_runout", "amplitude_um": 0.02, "disc": 1},
    {"name": "disc_oval", "amplitude_um": 0.02, "disc": 2},
    {"name": "crank_eccentricity_error", "amount_um": 0.02, "crank": 1, "disc": 1},
    {"name": "crank_phase_error", "angle_arcmin": 0.05, "crank": 2},
    {"name": "crank_hole_error", "amplitude_um": 0.02, "direction_deg": 70.0},
    {"name": "planet_runout", "amplitude_um": 0.2},
    {"name": "common_planet_runout", "amplitude_um": 0.2, "phase_deg": 10.0},
    {"name": "carrier_bore_error", "amplitude_um": 0.02, "direction_deg": 70.0},
    {"name": "ring_mounting_ovality", "amplitude_um": 0.02, "waves": 4},
    {"name": "tooth_form_error", "amplitude_um": 0.02, "phase_deg": 12.0, "waves": 1, "disc": 2},
]


def stage(drive, play):
    support = Cranks(3, 36.0, 4.0e5, play)
    loose = replace(drive, support=support)
    case = LoadCase(loose, modify(drive.theoretical_profile, Equidistant(0.006)), 412e3)
    found = StageEquilibrium(tolerance=1e-13).at(case, CRANK)
    motion = found.stage.motion
    there = gaps(case.profile, 3.0, found.stage.meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])
    return case, found, there


@pytest.mark.parametrize("play", [0.0, 0.004])
@pytest.mark.parametrize("table", SMALL, ids=lambda table: table["name"])
def test_one_product_replaces_a_solve(rv40e, table, play):
    case, nominal, there = stage(rv40e, play)
    drawn, changed = apply_effects(case, []), apply_effects(case, [effect_from_table(table)])
    change = ReducerChange(drawn, changed)
    meshing = nominal.stage.meshing
    gap = change.gap(ContactPoints.on_grid(there.foot, meshing.lobe, there.normal))
    misfit = change.misfit(meshing.crank_angle)
    predicted = StageTangent(nominal).rotation(0.0 if gap is None else gap, 0.0 if misfit is None else misfit)
    solved = StageEquilibrium(tolerance=1e-13, deviations=changed.deviations).at(case, CRANK)
    exact = solved.rotation - nominal.rotation
    assert np.max(np.abs(exact)) > 1e-10
    np.testing.assert_allclose(predicted, exact, atol=0.02 * np.max(np.abs(exact)))


def test_gaps_of_pins_that_carry_nothing_turn_nothing(rv40e):
    _, nominal, _ = stage(rv40e, 0.0)
    found = StageTangent(nominal)
    np.testing.assert_array_equal(found.pins[nominal.force == 0.0], 0.0)
    # A wider gap lets a positive torque turn further.
    assert np.all(found.pins[nominal.force > 0.0] > 0.0)


@pytest.mark.parametrize("play", [0.0, 0.004])
def test_forces_by_a_deformation_are_those_of_a_new_solve(rv40e, play):
    # A larger pin deforms its contacts with both discs, a displaced eccentric stretches its bearing.
    case, nominal, _ = stage(rv40e, play)
    tangent, pins = StageTangent(nominal), 40
    some = np.argsort(nominal.force.reshape(len(CRANK), -1), axis=1)[:, -6:]
    found = tangent.forces_per_deformation(some)
    pin, size = int(some[0, -1]) % pins, 1e-5

    def place(sharing):
        return np.column_stack([sharing.rotation, sharing.stage.motion.reshape(len(CRANK), -1)])

    changes, motions = {}, {}
    for name, change in (("pin_oversize", np.zeros(pins)), ("eccentric_shift", np.zeros((2, 3), dtype=complex))):
        change[pin if name == "pin_oversize" else (1, 2)] = size
        solved = StageEquilibrium(tolerance=1e-13, deviations=PartDeviations(**{name: change})).at(case, CRANK)
        changes[name] = np.take_along_axis((solved.force - nominal.force).reshape(len(CRANK), -1), some, axis=1) / size
        motions[name] = (place(solved) - place(nominal)) / size
    by_pin = found[:, :, pin] + found[:, :, pins + pin]
    # An eccentric displaced along its own throw, at the angle of its disc.
    along = np.exp(1j * tangent.crank_angle[:, 1])[:, np.newaxis]
    bearing = 2 * pins + 2 * (3 + 2)
    by_eccentric = along.real * found[:, :, bearing] + along.imag * found[:, :, bearing + 1]
    for predicted, exact in ((by_pin, changes["pin_oversize"]), (by_eccentric, changes["eccentric_shift"])):
        assert np.max(np.abs(exact)) > 1e3
        np.testing.assert_allclose(predicted, exact, atol=0.02 * np.max(np.abs(exact)))
    # Carrier and discs follow.
    motion = tangent.motion_per_deformation
    by_pin = motion[:, :, pin] + motion[:, :, pins + pin]
    by_eccentric = along.real * motion[:, :, bearing] + along.imag * motion[:, :, bearing + 1]
    for predicted, exact in ((by_pin, motions["pin_oversize"]), (by_eccentric, motions["eccentric_shift"])):
        largest = np.max(np.abs(exact), axis=0)
        assert np.all(largest > 1e-5)
        assert np.all(np.abs(predicted - exact) < 0.05 * largest)
    # Reciprocity: a deformation at one pin loads another as one there loads this.
    between = np.take_along_axis(found, some[:, np.newaxis], axis=2)
    np.testing.assert_allclose(between, np.swapaxes(between, 1, 2), rtol=0.0, atol=1e-9 * np.max(between))


@pytest.mark.parametrize(("geometric", "error"), [(True, 1e-4), (False, 0.02)])
def test_motions_and_pressures_of_several_changes_are_those_of_new_solves(rv40e, geometric, error):
    # Two pins, each a little larger.
    case, nominal, _ = stage(rv40e, 0.0)
    tangent, size = StageTangent(nominal, geometric=geometric), 1e-6
    at, pins = tangent.contacts, 40
    none = np.zeros(at.force.size)
    loaded = np.argsort(np.sum(nominal.force, axis=(0, 1)))[::-1][:2]
    changes = [ContactChange(np.where(at.pin == pin, -1.0, 0.0), none, none, none, none) for pin in loaded]
    found = tangent.response(changes, [None, None])
    assert found.pressure.shape == (at.force.size, 2)
    for number, pin in enumerate(loaded):
        both = [
            StageEquilibrium(
                tolerance=1e-13, deviations=PartDeviations(pin_oversize=sign * size * (np.arange(pins) == pin))
            ).at(case, CRANK)
            for sign in (1.0, -1.0)
        ]
        turned = (both[0].rotation - both[1].rotation) / (2.0 * size)
        moved = (both[0].stage.motion - both[1].stage.motion).reshape(len(CRANK), -1) / (2.0 * size)
        pressed = (both[0].pressure - both[1].pressure)[at.pose, at.disc, at.pin] / (2.0 * size)
        for predicted, exact in (
            (found.motion[:, 0, number], turned), (found.motion[:, 1:, number], moved),
            (found.pressure[:, number], pressed),
        ):  # fmt: skip
            np.testing.assert_allclose(predicted, exact, rtol=0.0, atol=error * np.max(np.abs(exact)))


def test_equal_gaps_turn_like_the_backlash(rv40e):
    # A removal of h everywhere is an angle of nearly h/(a(z_p + z1/z2)) with the input held.
    _, nominal, _ = stage(rv40e, 0.0)
    turned = StageTangent(nominal).rotation(np.full(nominal.force.shape, 1e-3))
    np.testing.assert_allclose(turned, 1e-3 / (1.3 * (40.0 + 1.0 / 3.0)), rtol=0.15)


def test_solvers_of_one_disc_have_none(rv40e, rated_torque):
    shared = Equilibrium(2).solve(LoadCase(rv40e, rv40e.theoretical_profile, rated_torque))
    with pytest.raises(LoadError, match="has no bearing model"):
        _ = StageTangent(shared).pins


def test_both_directions_of_the_linearisation_agree(rv40e):
    # The adjoint gives the turn of the output for all gaps at once, the direct solve the motion for one change.
    case, nominal, _ = stage(rv40e, 0.004)
    tangent = StageTangent(nominal)
    at = tangent.contacts
    for table in (SMALL[0], SMALL[3], SMALL[5]):
        change = ReducerChange(apply_effects(case, []), apply_effects(case, [effect_from_table(table)]))
        opened, misfit = change.gap(at), change.misfit(tangent.crank_angle)
        gap, none = np.zeros(at.force.shape) if opened is None else opened, np.zeros(at.force.shape)
        grid = np.zeros(nominal.force.shape)
        grid[at.pose, at.disc, at.pin] = gap
        turned = tangent.response([ContactChange(gap, none, none, none, none)], [misfit]).motion[:, 0, 0]
        wanted = tangent.rotation(grid, 0.0 if misfit is None else misfit)
        np.testing.assert_allclose(turned, wanted, rtol=1e-6, atol=1e-9 * np.max(np.abs(wanted)))
