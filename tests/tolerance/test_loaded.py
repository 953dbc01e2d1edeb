"""Reducers under load with gaps linear about the drawing, compared with the exact equilibrium of the reducer as built.

Only where a contact lies is taken from the drawing: a foot on a relative radius R that has moved by s leaves s²/2R, so
that what is left is of second order. The bound is what an answer is used for: 0.1″ of rotation.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.contact import AxialRelief, FaceWidth, LoadCase, RollerBearing
from cycloid_profile.contact.bodies import support_model
from cycloid_profile.contact.laws import Palmgren
from cycloid_profile.contact.mesh import mesh, output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design import conventional_profile, drive_of, load_case
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.effects import effect_from_table as effect
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import Tolerances, typical_tolerances
from cycloid_profile.tolerance.model import _loaded as loaded
from cycloid_profile.tolerance.model import unit_changes
from cycloid_profile.tolerance.model._loaded import LoadedStage, loaded_stage
from cycloid_profile.tolerance.study import Draws
from cycloid_profile.units import ARCSEC
from tests.contact.plain_search import plain_search

POSES = 3
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
# Forms of all teeth and pins, the carrier's bores, and the first stage.
FORMS = (
    {"name": "tooth_form_error", "each": "disc", "amplitude_um": {"plus_minus": 1.0}},
    {"name": "pin_ring_three_lobed", "amplitude_um": {"plus_minus": 3.0}},
    {"name": "ring_mounting_ovality", "amplitude_um": {"plus_minus": 3.0}},
    {"name": "carrier_bore_error", "each": "crank", "amplitude_um": {"plus_minus": 3.0}},
    {"name": "common_planet_runout", "amplitude_um": {"plus_minus": 10.0}},
    {"name": "sun_runout", "amplitude_um": {"plus_minus": 10.0}},
    {"name": "input_runout", "amplitude_arcsec": {"plus_minus": 600.0}},
)


def loads(reducer: AsBuiltReducer, poses: int, *shares: float) -> tuple[np.ndarray, np.ndarray]:
    """Crank angles spread over the turn, and torques as shares of the rated one."""
    crank = output_turn(reducer.case.drive.trochoid, poses) - 0.3
    return np.tile(crank, len(shares)), np.repeat(np.array(shares) * reducer.case.torque, poses)


def of(reducer: AsBuiltReducer, tolerances: Tolerances, poses: int = POSES, *shares: float) -> LoadedStage:
    """Poses spread over the turn at ``shares`` of the rated torque."""
    return loaded_stage(
        reducer, unit_changes(reducer, tolerances), *loads(reducer, poses, *(shares or (0.03, -0.03, 1.0)))
    )


def minimised(stage: LoadedStage, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rotation [rad] and peak pressure [MPa] without play, compliance and encoder; numpy, reducer by reducer."""
    drive = stage.reducer.case.drive
    crank = mesh(drive.trochoid, stage.crank_angle, drive.discs).crank_angle
    support = support_model(drive, crank, width=stage.reducer.case.width)
    found = []
    for gap, stretch, play in zip(*stage.errors(x), strict=True):
        energy = replace(stage.energy, gap=gap, stretch=stretch, play=float(play))
        # From discs that are turned with the carrier until pins are pressed, whatever the errors are.
        turn = np.sign(energy.torque) * 2.0 * np.max(np.abs(gap)) / drive.trochoid.longest_lever
        step = plain_search(energy, turn[:, np.newaxis] * support.rigid_motion, loaded.TOLERANCE)
        point = energy.at(step)
        assert np.all(energy.imbalance(point) < 1e-5)
        pressed = np.sqrt(point.force) * stage.pressure_per_root_force
        found.append((energy.rotation + step[:, 0], np.max(pressed, axis=(1, 2))))
    rotation, pressure = np.swapaxes(found, 0, 1)
    return rotation, pressure


def exact(reducer: AsBuiltReducer, stage: LoadedStage) -> tuple[np.ndarray, np.ndarray]:
    """What a rig reads of the reducer as built, and its peak pressure."""
    torque = stage.energy.torque
    found = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, stage.crank_angle, torque)
    assert found.converged
    angle = -stage.crank_angle / reducer.case.drive.trochoid.lobes
    read = found.rotation + reducer.series_compliance * torque + reducer.angle_error(angle)
    return read, np.max(found.pressure, axis=(1, 2))


@pytest.mark.parametrize(
    ("tables", "seed"),
    [
        ((*PARTS, *READ), 1),
        pytest.param((*PARTS, *READ), 2, marks=pytest.mark.slow),
        ((*FORMS, *READ), 3),
        pytest.param((*FORMS, *READ), 2, marks=pytest.mark.slow),
    ],
)
def test_answers_are_those_of_the_exact_equilibrium(small, scattered, made_with, tables, seed):
    tolerances = scattered(*tables)
    stage = of(small, tolerances)
    x = Draws(tolerances, seed).coordinates(0, 1, 0)
    rotation, pressure = stage.answers(x)
    wanted, pressed = exact(made_with(small, tolerances, x[0]), stage)
    np.testing.assert_allclose(rotation[0], wanted, rtol=0.0, atol=0.1 * ARCSEC)
    np.testing.assert_allclose(pressure[0], pressed, rtol=2e-3)
    # Far more than that is there to be got right: play, compliance and encoder included.
    without, _ = stage.answers(np.zeros_like(x))
    assert np.min(np.abs(wanted - without[0])) > 5.0 * ARCSEC


@pytest.mark.parametrize("play", [0.004, -0.004])
def test_clearance_of_rollers_scatters(small, scattered, made_with, play):
    drive = small.case.drive
    support = replace(drive.support, bearing_play=play, rollers=RollerBearing(10, 1e5))
    held = as_drawn(replace(small.case, drive=replace(drive, support=support)))
    tolerances = scattered(*PARTS[2:4], READ[0], reducer=held)
    stage = of(held, tolerances)
    x = Draws(tolerances, 1).coordinates(0, 1, 0)
    assert np.max(np.abs(stage.errors(x)[2] - play)) > 1e-3
    wanted, pressed = exact(made_with(held, tolerances, x[0]), stage)
    rotation, pressure = stage.answers(x)
    np.testing.assert_allclose(rotation[0], wanted, rtol=0.0, atol=0.1 * ARCSEC)
    np.testing.assert_allclose(pressure[0], pressed, rtol=2e-3)


def test_slices_over_the_width_count_in_every_reducer(small, scattered, made_with):
    face = FaceWidth(8.0, 4, AxialRelief(0.002, taper=0.002), tilt_stiffness=1e5, bearing_offset=0.5)
    sliced = as_drawn(replace(small.case, width=face))
    tolerances = scattered(*PARTS, reducer=sliced)
    stage = of(sliced, tolerances)
    x = Draws(tolerances, 1).coordinates(0, 2, 0)
    rotation, pressure = stage.answers(x)
    for one, turned, peak in zip(x, rotation, pressure, strict=True):
        wanted, pressed = exact(made_with(sliced, tolerances, one), stage)
        np.testing.assert_allclose(turned, wanted, rtol=0.0, atol=0.1 * ARCSEC)
        np.testing.assert_allclose(peak, pressed, rtol=5e-3)
    plain, _ = minimised(stage, x)
    np.testing.assert_allclose(rotation, plain, rtol=0.0, atol=1e-3 * ARCSEC)


# Next to a root the path of a pin's centre bends by 0.07 mm: there a contact moves by as much as its errors, and its
# lever with it. Such a pin carries only where a few do, under light load.
STEEP_ROOT = 0.4  # rad


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3))
def test_rv40e_is_within_a_tenth_of_an_arcsecond(large, scattered, made_with, seed):
    tolerances = scattered(*PARTS, *READ, reducer=large)
    stage = of(large, tolerances, 9)
    x = Draws(tolerances, seed).coordinates(0, 2, 0)
    rotation, pressure = stage.answers(x)
    for one, own, peak in zip(x, rotation, pressure, strict=True):
        reducer = made_with(large, tolerances, one)
        wanted, pressed = exact(reducer, stage)
        found = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, stage.crank_angle, stage.energy.torque)
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
    reducer = small
    for one in given:
        reducer = effect(one).apply(reducer)
    stage = of(reducer, scattered(PARTS[0], reducer=reducer))
    wanted, _ = exact(reducer, stage)
    rotation, _ = stage.answers(np.zeros((1, 11)))
    np.testing.assert_allclose(rotation[0], wanted, rtol=0.0, atol=0.1 * ARCSEC)
    drawn, _ = exact(small, stage)
    assert np.max(np.abs(wanted - drawn)) > 10.0 * ARCSEC


@pytest.mark.parametrize("law", [None, Palmgren()], ids=["logarithmic", "power"])
@pytest.mark.parametrize("play", [False, True], ids=["no play", "play"])
def test_compiled_is_the_plain_reference(small, scattered, play, law, monkeypatch):
    monkeypatch.setattr(loaded, "TOLERANCE", 1e-11)
    tolerances = scattered(*PARTS, *(READ[:1] if play else ()))
    stage = of(small, tolerances, 2)
    if law is not None:
        stage = replace(stage, energy=replace(stage.energy, law=law))
    x = Draws(tolerances).coordinates(0, 5, 0)
    found, plain = stage.answers(x), minimised(stage, x)
    np.testing.assert_allclose(found[1], plain[1], rtol=1e-6)
    np.testing.assert_allclose(found[0], plain[0], rtol=1e-9)


@pytest.mark.parametrize("times", [0.01, 30.0])
def test_errors_of_any_size_have_their_answer(small, scattered, times, monkeypatch):
    """First order about the drawing, where the search starts, is far off for large ones: other pins carry the load."""
    monkeypatch.setattr(loaded, "TOLERANCE", 1e-11)
    tolerances = scattered(*PARTS, READ[0])
    stage = of(small, tolerances, 4)
    x = times * Draws(tolerances).coordinates(0, 5, 0)
    found, plain = stage.answers(x), minimised(stage, x)
    np.testing.assert_allclose(found[1], plain[1], rtol=1e-6)
    np.testing.assert_allclose(found[0], plain[0], rtol=1e-9)


def test_a_reducer_has_its_answer_whatever_stands_next_to_it(small, scattered, monkeypatch):
    monkeypatch.setattr(loaded, "_BLOCK", 4)
    tolerances = scattered(*PARTS, *READ)
    stage = of(small, tolerances, 1)
    x = Draws(tolerances).coordinates(0, 7, 0)
    whole = stage.answers(x)
    for cut in (slice(0, 2), slice(3, 7), slice(5, 6)):
        for one, all_of_them in zip(stage.answers(x[cut]), whole, strict=True):
            np.testing.assert_array_equal(one, all_of_them[cut])


def test_what_finds_no_balance_is_nan_and_disturbs_nobody(small, scattered):
    stage = of(small, scattered(PARTS[0]), 1)
    x = np.zeros((3, 11))
    x[1] = np.nan
    rotation, pressure = stage.answers(x)
    assert np.all(np.isnan(rotation[1]))
    assert np.all(np.isnan(pressure[1]))
    np.testing.assert_array_equal(rotation[0], rotation[2])
    assert np.all(np.isfinite(rotation[0]))


def test_no_torque_is_refused(small, scattered):
    with pytest.raises(LoadError, match="torque"):
        of(small, scattered(PARTS[0]), 1, 0.0)


def test_one_disc_on_a_central_eccentric(made_with):
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    reducer = as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 5e3))
    tolerances = typical_tolerances(reducer)
    stage = of(reducer, tolerances, 2)
    x = Draws(tolerances).coordinates(0, 1, 0)
    wanted, _ = exact(made_with(reducer, tolerances, x[0]), stage)
    # On a soft bearing the disc gives way by 25 µm, and errors turn their normals with it: 3·25 µm²/3 mm over 12 mm.
    np.testing.assert_allclose(stage.answers(x)[0][0], wanted, rtol=0.0, atol=0.5 * ARCSEC)


@pytest.mark.slow
def test_elastic_supports_find_the_exact_equilibrium(large, scattered, made_with):
    # They give way by more than an error is high: the search must begin with the pins pressed nevertheless.
    on = {"drive.pin_seat.contact": True, "drive.ring.elastic": True, "drive.pillars.elastic": True}
    spec = catalog_drive("rv40e").replace(on)
    drive = drive_of(spec)
    soft = as_drawn(load_case(spec, drive, conventional_profile(spec, drive)))
    tolerances = scattered(*PARTS, reducer=large)
    stage = of(soft, tolerances, 9)
    x = Draws(tolerances, 1).coordinates(0, 40, 0)
    rotation, _ = stage.answers(x)
    assert np.all(np.isfinite(rotation))
    for one, own in zip(x[:2], rotation, strict=False):
        wanted, _ = exact(made_with(soft, tolerances, one), stage)
        np.testing.assert_allclose(own, wanted, rtol=0.0, atol=2.0 * ARCSEC)
