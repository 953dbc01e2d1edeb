"""Reducers under load with gaps linear about the drawing, beside the exact equilibrium of the reducer as built.

Only where a contact lies is taken from the drawing: a foot on a relative radius R that has moved by s leaves s²/2R, so
that what is left is of second order. The bound is what an answer is used for: 0.1″ of rotation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.hertz import ContactLaw
from cycloid_profile.contact.laws import Palmgren
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.effects.registry import effect
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry.drive import CentralEccentric, Drive
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.setup import Equidistant, modify
from cycloid_profile.tolerance import loaded
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.loaded import LoadedStage, loaded_stage
from cycloid_profile.tolerance.patterns import unit_changes
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.workshop import workshop_tolerances
from cycloid_profile.units import ARCSEC

POSES = 3
compiled = pytest.mark.slow  # numba takes half a minute to compile the balance in a new checkout
PARTS = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 3.0}},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 3.0}},
    {"name": "equidistant_error", "each": "disc", "amount_um": {"plus_minus": 3.0}},
    {"name": "disc_runout", "each": "disc", "amplitude_um": {"plus_minus": 3.0}},
    {"name": "crank_hole_error", "each": ["disc", "crank"], "amplitude_um": {"plus_minus": 3.0}},
    {"name": "crank_eccentricity_error", "each": ["disc", "crank"], "amount_um": {"plus_minus": 3.0}},
    {"name": "planet_runout", "each": "planet", "amplitude_um": {"plus_minus": 3.0}},
)
READ = (
    {"name": "crank_bearing_clearance", "radial_um": {"mean": 4.0, "plus_minus": 2.0}},
    {"name": "series_compliance", "stiffness_nm_per_arcmin": {"mean": 20.0, "plus_minus": 2.0}},
    {"name": "encoder_eccentricity", "amplitude_arcsec": {"plus_minus": 5.0}},
)


def loads(built: Built, poses: int, *shares: float) -> tuple[np.ndarray, np.ndarray]:
    """Crank angles spread over the turn, and torques as shares of the rated one."""
    crank = output_turn(built.case.drive.trochoid, poses) - 0.3
    return np.tile(crank, len(shares)), np.repeat(np.array(shares) * built.case.torque, poses)


def by(stage: LoadedStage, law: ContactLaw, solver) -> LoadedStage:
    other = replace(stage, energy=replace(stage.energy, law=law))
    other.__dict__["_solver"] = solver
    return other


def of(built: Built, tolerances: Tolerances, poses: int = POSES, *shares: float) -> LoadedStage:
    """By the plain reference, which has nothing to compile."""
    stage = loaded_stage(built, unit_changes(built, tolerances), *loads(built, poses, *(shares or (0.03, -0.03, 1.0))))
    return by(stage, stage.energy.law, loaded.minimised_plainly)


def exact(built: Built, stage: LoadedStage) -> tuple[np.ndarray, np.ndarray]:
    """What a rig reads of the reducer as built, and its peak pressure."""
    torque = stage.energy.torque
    found = StageEquilibrium(as_built=built.parts).at(built.case, stage.crank_angle, torque)
    assert found.converged
    angle = -stage.crank_angle / built.case.drive.trochoid.lobes
    read = found.rotation + built.series_compliance * torque + (built.encoder * np.exp(-1j * angle)).real
    return read, np.max(found.pressure, axis=(1, 2))


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_answers_are_those_of_the_exact_equilibrium(small, scattered, made_with, seed):
    tolerances = scattered(*PARTS, *READ)
    stage = of(small, tolerances)
    x = Draws(tolerances, seed).coordinates(0, 1, 0)
    rotation, pressure = stage.answers(x)
    wanted, pressed = exact(made_with(small, tolerances, x[0]), stage)
    np.testing.assert_allclose(rotation[0], wanted, rtol=0.0, atol=0.1 * ARCSEC)
    np.testing.assert_allclose(pressure[0], pressed, rtol=2e-3)
    # Far more than that is there to be got right: play, compliance and encoder included.
    without, _ = stage.answers(np.zeros_like(x))
    assert np.min(np.abs(wanted - without[0])) > 5.0 * ARCSEC


# Beside a root the path of a pin's centre bends by 0.07 mm: there a contact moves by as much as its errors, and its
# lever with it. Such a pin carries only where a few do, under light load.
STEEP_ROOT = 0.4  # rad


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_rv40e_is_within_a_tenth_of_an_arcsecond(large, scattered, made_with, seed):
    tolerances = scattered(*PARTS, *READ, built=large)
    stage = of(large, tolerances, 9)
    x = Draws(tolerances, seed).coordinates(0, 2, 0)
    rotation, pressure = stage.answers(x)
    for one, own, peak in zip(x, rotation, pressure, strict=True):
        built = made_with(large, tolerances, one)
        wanted, pressed = exact(built, stage)
        found = StageEquilibrium(as_built=built.parts).at(built.case, stage.crank_angle, stage.energy.torque)
        steep = np.any((found.force > 0.0) & (np.abs(found.phase) < STEEP_ROOT), axis=(1, 2))
        np.testing.assert_allclose(own[~steep], wanted[~steep], rtol=0.0, atol=0.1 * ARCSEC)
        np.testing.assert_allclose(own[steep], wanted[steep], rtol=0.0, atol=1.0 * ARCSEC)
        np.testing.assert_allclose(peak[~steep], pressed[~steep], rtol=0.03)
        # At rated torque many pins carry: those of a root change nothing.
        rated = stage.energy.torque == large.case.torque
        np.testing.assert_allclose(own[rated], wanted[rated], rtol=0.0, atol=0.1 * ARCSEC)
        np.testing.assert_allclose(peak[rated], pressed[rated], rtol=0.005)
        assert np.count_nonzero(~steep) > 9


@pytest.mark.slow
def test_what_is_left_is_of_second_order(small, scattered, made_with):
    # Of errors and approach together: normals turn by approach over radius, so that an error under load leaves their
    # product. Half the errors at half the torque leave a quarter; an approach falls a little slower than its load.
    tolerances = scattered(*PARTS)
    x = Draws(tolerances, 4).coordinates(0, 2, 0)
    factors = np.array([1.0, 0.5, 0.25, 0.125])
    left = []
    for factor in factors:
        stage = of(small, tolerances, 5, 0.5 * factor)
        wanted = np.array([exact(made_with(small, tolerances, factor * one), stage)[0] for one in x])
        left.append(np.sqrt(np.mean((stage.answers(factor * x)[0] - wanted) ** 2)))
    assert np.polyfit(np.log(factors), np.log(left), 1)[0] == pytest.approx(2.0, abs=0.3)


def test_the_drawing_is_its_own_equilibrium(small, scattered):
    tolerances = scattered(PARTS[0])
    stage = of(small, tolerances)
    wanted, pressed = exact(small, stage)
    rotation, pressure = stage.answers(np.zeros((1, 11)))
    np.testing.assert_allclose(rotation[0], wanted, rtol=1e-6, atol=1e-5 * ARCSEC)
    np.testing.assert_allclose(pressure[0], pressed, rtol=1e-6)


def test_errors_of_the_spec_are_where_reducers_start_from(small, scattered):
    # A reducer with effects of its own, no scatter at all: to second order the exact one.
    given = (
        {"name": "disc_runout", "disc": 1, "amplitude_um": 3.0, "phase_deg": 40.0},
        {"name": "single_pin_error", "pin": 4, "amount_um": 2.0},
        {"name": "crank_hole_error", "amplitude_um": 3.0, "direction_deg": 220.0},
        {"name": "series_compliance", "stiffness_nm_per_arcmin": 20.0},
    )
    built = small
    for one in given:
        built = effect(one).apply(built)
    stage = of(built, scattered(PARTS[0], built=built))
    wanted, _ = exact(built, stage)
    rotation, _ = stage.answers(np.zeros((1, 11)))
    np.testing.assert_allclose(rotation[0], wanted, rtol=0.0, atol=0.1 * ARCSEC)
    drawn, _ = exact(small, stage)
    assert np.max(np.abs(wanted - drawn)) > 10.0 * ARCSEC


@compiled
@pytest.mark.parametrize("play", [False, True], ids=["no play", "play"])
def test_compiled_is_the_plain_reference(small, scattered, play):
    tolerances = scattered(*PARTS, *(READ if play else READ[1:]))
    stage = of(small, tolerances, 2)
    x = Draws(tolerances).coordinates(0, 5, 0)
    plain = by(stage, stage.energy.law, loaded.minimised_plainly).answers(x)
    compiled = by(stage, stage.energy.law, loaded.minimised_compiled).answers(x)
    for one, other in zip(compiled, plain, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-6)
    np.testing.assert_allclose(compiled[0], plain[0], rtol=1e-9)


def test_laws_without_a_logarithm_take_the_plain_way(small, scattered):
    stage = replace(of(small, scattered(PARTS[0]), 1))
    assert stage._solver is loaded.minimised_compiled
    other = replace(stage, energy=replace(stage.energy, law=Palmgren()))
    assert other._solver is loaded.minimised_plainly
    assert np.all(np.isfinite(other.answers(np.zeros((2, 11)))[0]))


solvers = pytest.mark.parametrize(
    "solver", [loaded.minimised_plainly, pytest.param(loaded.minimised_compiled, marks=compiled)]
)


@solvers
def test_a_reducer_has_its_answer_whatever_stands_beside_it(small, scattered, monkeypatch, solver):
    monkeypatch.setattr(loaded, "_BLOCK", 4)
    tolerances = scattered(*PARTS, *READ)
    stage = of(small, tolerances, 1)
    stage = by(stage, stage.energy.law, solver)
    x = Draws(tolerances).coordinates(0, 7, 0)
    whole = stage.answers(x)
    for cut in (slice(0, 2), slice(3, 7), slice(5, 6)):
        for one, all_of_them in zip(stage.answers(x[cut]), whole, strict=True):
            np.testing.assert_array_equal(one, all_of_them[cut])


@solvers
def test_what_finds_no_balance_is_nan_and_disturbs_nobody(small, scattered, solver):
    stage = of(small, scattered(PARTS[0]), 1)
    x = np.zeros((3, 11))
    x[1] = np.nan
    rotation, pressure = by(stage, stage.energy.law, solver).answers(x)
    assert np.all(np.isnan(rotation[1]))
    assert np.all(np.isnan(pressure[1]))
    np.testing.assert_array_equal(rotation[0], rotation[2])
    assert np.all(np.isfinite(rotation[0]))


def test_no_torque_is_refused(small, scattered):
    with pytest.raises(LoadError, match="torque"):
        of(small, scattered(PARTS[0]), 1, 0.0)


def test_one_disc_on_a_central_eccentric(made_with):
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    built = as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 5e3))
    tolerances = workshop_tolerances(built)
    stage = of(built, tolerances, 2)
    x = Draws(tolerances).coordinates(0, 1, 0)
    wanted, _ = exact(made_with(built, tolerances, x[0]), stage)
    # On a soft bearing the disc gives way by 25 µm, and errors turn their normals with it: 3·25 µm²/3 mm over 12 mm.
    np.testing.assert_allclose(stage.answers(x)[0][0], wanted, rtol=0.0, atol=0.5 * ARCSEC)
