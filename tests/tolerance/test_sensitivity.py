"""Exact derivatives against central differences of the whole nonlinear model, and closed forms.

The model differentiated is built here from its parts: discs turned to first touch by ``first_touch``, and
``StageEquilibrium`` solved again to 1e-12 for each reducer. The step is ±0.5 nm in each size and as little in a
direction: at some tenths of a micrometre another pin begins to carry and a derivative with it, and the law of contact
has no third derivative there; below 0.1 nm the rounding of a balance, 1e-13 rad, shows.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from functools import reduce

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase, StagePositions
from cycloid_profile.contact.bodies import support_model
from cycloid_profile.contact.mesh import first_touch, mesh, output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer, Effect, as_drawn, encoder_error
from cycloid_profile.effects import effect_from_table as effect
from cycloid_profile.geometry import Drive
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import tolerances_of
from cycloid_profile.tolerance.model import RESPONSES, WorkingPoint
from cycloid_profile.tolerance.model._crank_locked import backlash_derivatives
from cycloid_profile.tolerance.model._directional import Gradient, largest, least, weighted_sum
from cycloid_profile.tolerance.model._loaded import loaded_derivatives
from cycloid_profile.tolerance.ranking import ParameterSensitivity, scatter_sensitivities, sensitivities
from cycloid_profile.units import ARCMIN, ARCSEC

BACKLASH, BACKLASH_LEAST, BACKLASH_MEAN, LOST, LOST_MEAN, ERROR, PRESSURE = RESPONSES
# Poses of the quantities (47, 17 and 97), written out: none of them divides 1560.
POSES, LOST_POSES, TURN_POSES = 47, 17, 97
STEP = 5e-4
STEPS = {"deg": 0.01, "arcmin": 1e-3, "arcsec": 0.01, "turn": 1e-4, "k": 1e-3, "kn": 1e-3, "coefficient": 0.01}
# Rounding of a balance over the step, in the unit of each quantity per unit of a parameter.
FLOOR = {
    BACKLASH: 1e-7,
    BACKLASH_LEAST: 1e-7,
    BACKLASH_MEAN: 1e-7,
    LOST: 1e-6,
    LOST_MEAN: 1e-6,
    ERROR: 1e-4,
    PRESSURE: 1e-2,
}

# A reducer with errors of every kind: no two pins, poses or discs tie.
SOME = [
    {"name": "equidistant_error", "amount_um": 0.8, "disc": 1},
    {"name": "radial_moving_error", "amount_um": -1.1},
    {"name": "generating_eccentricity_error", "amount_um": 1.5},
    {"name": "thermal_growth", "temperature_k": 1.3},
    {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1},
    {"name": "disc_oval", "amplitude_um": 0.7, "phase_deg": 15.0, "disc": 2},
    {"name": "cumulative_pitch_error", "amplitude_um": 1.2, "phase_deg": 200.0},
    {"name": "wheel_wear_drift", "amount_um": 0.6},
    {"name": "grinding_chatter", "amplitude_um": 0.1, "waves_per_turn": 27.4, "phase_deg": 10.0},
    {"name": "missing_deformation_compensation", "amount_um": 1.0},
    {"name": "flank_wear", "amount_um": 0.4},
    {"name": "single_tooth_error", "amount_um": -1.0, "lobe": 7, "disc": 2},
    {"name": "pin_radius_error", "amount_um": -0.5},
    {"name": "pin_circle_radius_error", "amount_um": 1.0},
    {"name": "pin_ring_runout", "amplitude_um": 2.0, "phase_deg": 70.0},
    {"name": "pin_ring_oval", "amplitude_um": 2.0, "phase_deg": 11.0},
    {"name": "pin_ring_cumulative_pitch", "amplitude_um": 1.0, "phase_deg": 300.0},
    {"name": "single_pin_error", "amount_um": 0.9, "pin": 12},
    {"name": "pin_position_error", "amplitude_um": 2.0, "direction_deg": 77.0, "pin": 5},
    {"name": "crank_eccentricity_error", "amount_um": 1.0, "crank": 2, "disc": 1},
    {"name": "crank_phase_error", "angle_arcmin": 0.5, "crank": 1, "disc": 2},
    {"name": "crank_hole_error", "amplitude_um": 2.0, "direction_deg": 20.0, "crank": 2, "disc": 1},
    {"name": "crank_bearing_clearance", "radial_um": 1.0},
    {"name": "planet_runout", "amplitude_um": 5.0, "phase_deg": 33.0},
    {"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0},
    {"name": "crank_bearing_compliance", "added_um_per_kn": 0.5},
    {"name": "pin_support_compliance", "added_um_per_kn": 0.5},
    {"name": "coulomb_friction", "torque_nm": 2.0},
    {"name": "load_proportional_friction", "coefficient": 0.02},
    {"name": "encoder_eccentricity", "amplitude_arcsec": 3.0, "phase_deg": 50.0},
    {"name": "tooth_form_error", "amplitude_um": 0.3, "phase_deg": 25.0, "flank": 1},
    {"name": "pin_ring_three_lobed", "amplitude_um": 0.5, "phase_deg": 17.0},
    {"name": "ring_mounting_ovality", "amplitude_um": 0.6, "phase_deg": 140.0, "waves": 4},
    {"name": "carrier_bore_error", "amplitude_um": 1.0, "direction_deg": 65.0, "crank": 3},
    {"name": "common_planet_runout", "amplitude_um": 4.0, "phase_deg": 80.0, "form": 2},
    {"name": "sun_runout", "amplitude_um": 6.0, "phase_deg": 250.0},
    {"name": "input_runout", "amplitude_arcsec": 40.0, "phase_deg": 10.0},
]


@pytest.fixture(scope="module")
def drawn(rv40e: Drive) -> AsBuiltReducer:
    return as_drawn(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3))


def effects(tables) -> list[Effect]:
    return [effect(table) for table in tables]


def turn(reducer: AsBuiltReducer, poses: int) -> np.ndarray:
    return output_turn(reducer.case.drive.trochoid, poses)


def exact_backlash(reducer: AsBuiltReducer, poses: int) -> np.ndarray:
    """Crank held, bearings unloaded, each disc where least squares of its misfits put it; the nearest stops [′]."""
    drive = reducer.case.drive
    met = mesh(drive.trochoid, turn(reducer, poses), drive.discs)
    model = support_model(drive, met.crank_angle, reducer.deviations)
    turned = np.empty((2, drive.discs, poses))
    for j in range(drive.discs):
        rows = slice(3 * j, 3 * j + 3)
        own = slice(1 + 3 * j, 4 + 3 * j)
        stretch = model.spring_stretch[:, rows, :, own].reshape(poses, 6, 3)
        fits = -model.misfit[:, rows].reshape(poses, 6)
        rest = np.stack([np.linalg.lstsq(A, b, rcond=None)[0] for A, b in zip(stretch, fits, strict=True)])
        seen = met.disc(j)
        centre = seen.pin_in_lobe(rest[:, :1] + 1j * rest[:, 1:2], rest[:, 2:], reducer.pin_shift)
        for k, direction in enumerate((1.0, -1.0)):
            placed = dataclasses.replace(seen, pin_centre=centre)
            touch = first_touch(reducer.teeth[j], drive.pin_radius + reducer.pin_oversize, placed, direction)
            assert np.all(touch.settled)
            turned[k, j] = touch.rotation[:, 0]
    return (np.min(turned[0], axis=0) - np.max(turned[1], axis=0)) / ARCMIN


def exact_load(
    reducer: AsBuiltReducer, crank: np.ndarray, torque: np.ndarray, near: StagePositions | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Angle read [rad] and highest pressure [MPa] at each load; the search may begin ``near`` where parts rest."""
    solved = StageEquilibrium(tolerance=1e-12, deviations=reducer.deviations).at(reducer.case, crank, torque, near)
    angle = -crank / reducer.case.drive.trochoid.lobes
    read = encoder_error(reducer.encoder, angle) + (reducer.input_error * np.exp(-121j * angle)).real / 121.0
    return solved.rotation + reducer.series_compliance * torque + read, np.max(solved.pressure, axis=(1, 2))


def loads(reducer: AsBuiltReducer) -> list[tuple[np.ndarray, np.ndarray]]:
    """Crank angles and torques of the lost motion, there and back, and of a turn under the rated torque."""
    rated = reducer.case.torque
    return [
        *((turn(reducer, LOST_POSES), np.full(LOST_POSES, sign * 0.03 * rated)) for sign in (1.0, -1.0)),
        (turn(reducer, TURN_POSES), np.full(TURN_POSES, rated)),
    ]


def exact(reducer: AsBuiltReducer, near: Sequence[StagePositions | None] = (None, None, None)) -> dict[str, float]:
    """All quantities of the exact model; ``near``, where the parts rest under each of the ``loads`` or nearly so."""
    backlash = exact_backlash(reducer, POSES)
    found = [exact_load(reducer, *load, place) for load, place in zip(loads(reducer), near, strict=True)]
    (there, _), (back, _), (rotation, pressure) = found
    lost = (there - back) / ARCMIN
    turned = (backlash.max(), backlash.min(), backlash.mean(), lost.max(), lost.mean())
    return dict(zip(RESPONSES, map(float, (*turned, np.ptp(rotation) / ARCSEC, pressure.max())), strict=True))


def step_of(parameter: str) -> float:
    return STEPS.get(parameter.rsplit("_", 1)[-1], STEP)


def with_changed(drawn: AsBuiltReducer, made: list[Effect], which: int, parameter: str, by: float) -> AsBuiltReducer:
    """All effects again from the drawing, one parameter of one of them changed."""
    other = dataclasses.replace(made[which], **{parameter: getattr(made[which], parameter) + by})
    return reduce(lambda reducer, one: one.apply(reducer), [*made[:which], other, *made[which + 1 :]], drawn)


def central(
    drawn: AsBuiltReducer, made: list[Effect], which: int, parameter: str, near: Sequence[StagePositions]
) -> dict[str, float]:
    h = step_of(parameter)
    up, down = (exact(with_changed(drawn, made, which, parameter, sign * h), near) for sign in (1.0, -1.0))
    return {name: (up[name] - down[name]) / (2.0 * h) for name in RESPONSES}


def check(row: ParameterSensitivity, difference: dict[str, float]) -> None:
    for name in RESPONSES:
        assert not row.of(name).kink, (row.effect, row.parameter, name)
        assert row.of(name).rising == pytest.approx(difference[name], rel=1e-3, abs=FLOOR[name]), (
            row.effect,
            row.parameter,
            name,
        )


@pytest.fixture(scope="module")
def every_row(drawn):
    return sensitivities(drawn, effects(SOME))


@pytest.fixture(scope="module")
def at_rest(drawn) -> list[StagePositions]:
    """Where the parts rest with all effects, under each of the loads: a small change leaves them near."""
    whole = reduce(lambda reducer, one: one.apply(reducer), effects(SOME), drawn)
    stage = StageEquilibrium(tolerance=1e-12, deviations=whole.deviations)
    return [stage.at(whole.case, *load).place for load in loads(whole)]


@pytest.mark.slow
@pytest.mark.parametrize("which", range(len(SOME)), ids=[str(one["name"]) for one in SOME])
def test_every_parameter_against_central_differences(drawn, every_row, at_rest, which):
    made = effects(SOME)
    rows = [row for row in every_row if row.effect == made[which].name]
    assert rows
    for row in rows:
        check(row, central(drawn, made, which, row.parameter, at_rest))


@pytest.mark.slow
def test_values_at_the_working_point_are_those_of_the_model(drawn):
    point = WorkingPoint(drawn, tuple(effects(SOME)))
    expected = exact(point.whole)
    for one in point.responses:
        assert one.value == pytest.approx(expected[one.name], rel=1e-9)


@pytest.mark.parametrize(("which", "parameter"), [(18, "amplitude_um"), (21, "direction_deg"), (22, "radial_um")])
def test_answers_at_each_load_against_central_differences(drawn, which, parameter):
    # A few loads of a few effects, so that it is quick; pins, cranks and play.
    some = [SOME[i] for i in (0, 18, 21, 22)]
    made = effects(some)
    at = [one["name"] for one in some].index(SOME[which]["name"])
    point = WorkingPoint(drawn, tuple(made))
    placed = point.placed[at]
    direction = placed.along_angle() if parameter.endswith("_deg") else placed.along_size()
    crank = turn(drawn, 5)
    torque = drawn.case.torque * np.array([1.0, 1.0, -1.0, 0.03, -0.03])
    slopes = loaded_derivatives(point.whole, point.changes(placed), crank, torque)
    h = step_of(parameter)
    up, down = (exact_load(with_changed(drawn, made, at, parameter, way * h), crank, torque)[0] for way in (1.0, -1.0))
    np.testing.assert_allclose(slopes.rotation_by_unit @ direction, (up - down) / (2.0 * h), rtol=1e-3, atol=1e-11)
    _, touched = backlash_derivatives(point.whole, point.changes(placed), crank)
    up, down = (exact_backlash(with_changed(drawn, made, at, parameter, way * h), 5) for way in (1.0, -1.0))
    found = [float(one.along(direction[:, np.newaxis])[0]) / ARCMIN for one in touched]
    np.testing.assert_allclose(found, (up - down) / (2.0 * h), rtol=1e-3, atol=1e-7)


# Closed forms.


@pytest.fixture(scope="module")
def common(drawn):
    tables = [{"name": "equidistant_error", "amount_um": 0.0}, {"name": "radial_moving_error", "amount_um": 0.0},
              {"name": "equidistant_error", "amount_um": 0.0, "disc": 1}]  # fmt: skip
    return sensitivities(drawn, effects(tables))


def test_equidistant_and_radial_moving_have_their_closed_forms(common, rv40e):
    # 2/(a z_c) is what a pin at the longest lever gives: 135.6113′/mm. No pin stands exactly there, so that the touch
    # has less lever by at most 0.3 %: 1 − l/(a z_c) of a phase half a pitch of 9° off.
    K1 = rv40e.trochoid.short_width_ratio
    for row, closed in zip(common[:2], (135.6113e-3, 135.6113e-3 * np.sqrt(1.0 - K1**2)), strict=True):
        assert row.of(BACKLASH_MEAN).rising == pytest.approx(closed, rel=4e-3)
        assert not row.of(BACKLASH_MEAN).kink
    assert common[0].of(BACKLASH_LEAST).rising >= 135.6113e-3 * (1.0 - 1e-6)


def test_two_discs_that_tie_make_a_kink(common):
    # More clearance on one disc: the other still stops the turn. Less: this one stops first.
    one = common[2].of(BACKLASH_MEAN)
    assert one.kink
    assert one.rising == pytest.approx(0.0, abs=1e-12)
    assert one.falling == pytest.approx(common[0].of(BACKLASH_MEAN).falling, rel=1e-9)


def test_slopes_of_maxima_are_one_sided():
    steep, flat = Gradient(np.array([2.0, 0.0])), Gradient(np.array([-1.0, 1.0]))
    ways = np.array([[1.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    np.testing.assert_array_equal(largest(np.array([1.0, 1.0]), [steep, flat], 1e-9).along(ways), [2.0, 1.0, 0.0])
    np.testing.assert_array_equal(least(np.array([1.0, 1.0]), [steep, flat], 1e-9).along(ways), [-1.0, -2.0, -1.0])
    np.testing.assert_array_equal(largest(np.array([1.0, 2.0]), [steep, flat], 1e-9).along(ways), [-1.0, 1.0, -1.0])
    np.testing.assert_array_equal(weighted_sum((steep, flat), 0.5).along(ways), [0.5, -0.5, -0.5])


def test_a_size_at_zero_is_reported_over_all_directions(drawn):
    (row,) = sensitivities(drawn, effects([{"name": "encoder_eccentricity", "amplitude_arcsec": 0.0}]))
    assert row.over_direction
    # A ripple of the encoder over that of the mesh, which has its extremes at two poses a way φ apart: 2 sin(φ/2).
    ahead = row.of(ERROR)
    assert 0.0 < ahead.rising <= 2.0
    assert ahead.falling == pytest.approx(-ahead.rising, rel=1e-4)
    assert row.of(BACKLASH).largest == 0.0
    assert row.of(LOST).largest < 1e-9


def test_parts_together_are_the_root_of_the_sum_of_squares(drawn):
    tolerances = tolerances_of([{"name": "single_pin_error", "each": "pin", "amount_um": {}}], (), drawn)
    point = WorkingPoint.of(drawn, tolerances)
    (row,) = scatter_sensitivities(tolerances, point)
    each = np.array([[1.0 if k == i else 0.0 for k in range(40)] for i in range(40)])
    gradient = next(one.derivative.along(each) for one in point.responses if one.name == LOST_MEAN)
    assert row.count == 40
    assert row.root_sum_square[list(RESPONSES).index(LOST_MEAN)] == pytest.approx(
        np.sqrt(np.sum(gradient**2)), rel=1e-9
    )
    assert row.worst[list(RESPONSES).index(LOST_MEAN)].of(LOST_MEAN).largest == pytest.approx(np.max(np.abs(gradient)))
    # All pins equally: their sum is what a common radius does.
    (common,) = sensitivities(drawn, effects([{"name": "pin_radius_error", "amount_um": 0.0}]))
    assert np.sum(gradient) == pytest.approx(common.of(LOST_MEAN).rising, rel=1e-9)
