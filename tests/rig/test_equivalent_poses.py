"""Poses that a turn by pin pitches maps on each other: few are solved, and all have the answers of their own solves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import AxialRelief, FaceWidth
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.measurement import LOST_MOTION_MAP, TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import LinearisedCurve, encoder_readings, predict_curves
from cycloid_profile.rig._equivalent_poses import equivalent_poses
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

# Of the rotor all, of the pins what they have in common.
ROTOR = (
    {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 30.0, "disc": 1},
    {"name": "single_tooth_error", "amount_um": -2.0, "lobe": 5, "disc": 2},
    {"name": "crank_hole_error", "amplitude_um": 2.0, "direction_deg": 50.0, "crank": 2, "disc": 2},
    {"name": "crank_phase_error", "angle_arcmin": 2.0, "crank": 1, "disc": 1},
    {"name": "carrier_bore_error", "amplitude_um": 2.0, "direction_deg": 50.0, "crank": 3},
    {"name": "common_planet_runout", "amplitude_um": 5.0, "phase_deg": 15.0},
    {"name": "sun_runout", "amplitude_um": 5.0, "phase_deg": 25.0},
    {"name": "crank_bearing_clearance", "radial_um": 0.3},
    {"name": "pin_radius_error", "amount_um": 1.0},
    {"name": "pin_circle_radius_error", "amount_um": 0.5},
    {"name": "encoder_eccentricity", "amplitude_arcsec": 3.0, "phase_deg": 70.0},
    {"name": "input_runout", "amplitude_arcsec": 90.0, "phase_deg": 35.0},
)
ONE_PIN = {"name": "single_pin_error", "amount_um": 1.0, "pin": 7}
MORE = (
    ONE_PIN,
    {"name": "pin_ring_runout", "amplitude_um": 1.0, "phase_deg": 40.0},
    {"name": "disc_oval", "amplitude_um": 1.0, "phase_deg": 20.0, "disc": 2},
    {"name": "crank_eccentricity_error", "amount_um": 1.0, "crank": 3},
    {"name": "pin_support_compliance", "added_um_per_kn": 1.0},
    {"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0},
    {"name": "sun_runout", "amplitude_um": 1.0, "phase_deg": 100.0},
)


@pytest.fixture(scope="module")
def files() -> list[Measurement]:
    """A turn of the output by 240 rows, six a pin pitch, the angle as the files write it."""
    angle = np.round(np.arange(240) * 1.5, 7)
    empty = np.zeros(angle.size)
    return [
        Measurement(TRANSMISSION_ERROR, {"output_angle_deg": angle, "error_arcsec": empty}, {"torque_nm": "412"}, "te"),
        Measurement(
            LOST_MOTION_MAP, {"output_angle_deg": angle, "lost_motion_arcmin": empty}, {"torque_nm": "12.36"}, "map"
        ),
    ]


def _every_pose(reducer: AsBuiltReducer, angle_deg: np.ndarray, torque_nm: float) -> np.ndarray:
    """The angle of the output, each row solved by itself [rad]."""
    angle = angle_deg * DEGREE
    stage = StageEquilibrium(deviations=reducer.deviations, tolerance=1e-12)
    solved = stage.at(reducer.case, -angle * reducer.case.drive.trochoid.lobes, torque_nm * NEWTON_METRE)
    assert solved.converged
    return solved.rotation + reducer.angle_error(angle)


def test_every_row_has_the_answer_of_its_own_solve(built_with, files):
    reducer = built_with(*ROTOR)
    te, lost_motion = predict_curves(reducer, [(file, np.arange(240)) for file in files])
    assert [one.terms[0].sharing.torque.size for one in (te, lost_motion)] == [6, 6]
    angle = files[0]["output_angle_deg"]
    np.testing.assert_allclose(te.value * ARCSEC, _every_pose(reducer, angle, 412.0), rtol=0.0, atol=1e-12)
    both = _every_pose(reducer, angle, 12.36) - _every_pose(reducer, angle, -12.36)
    np.testing.assert_allclose(lost_motion.value * ARCMIN, both, rtol=0.0, atol=1e-12)
    assert np.ptp(te.value) > 10.0


def test_the_simulated_turn_is_that_of_every_pose(built_with):
    reducer = built_with(*ROTOR)
    turned = encoder_readings(reducer, np.array([412.0, -41.2]) * NEWTON_METRE, 200)
    angle = np.arange(200) * 1.8
    for torque, own in zip([412.0, -41.2], turned, strict=True):
        np.testing.assert_allclose(own, _every_pose(reducer, angle, torque), rtol=0.0, atol=1e-12)


def test_discs_that_tilt_start_from_the_tilt_of_their_representative(drawn, files):
    face = FaceWidth(drawn.case.drive.disc_width, 4, AxialRelief(0.001, taper=0.003), tilt_stiffness=2e6)
    reducer = as_drawn(replace(drawn.case, width=face))
    asked = [(files[0], np.arange(240))]
    (first,) = predict_curves(reducer, asked)
    np.testing.assert_allclose(
        first.value * ARCSEC, _every_pose(reducer, files[0]["output_angle_deg"], 412.0), atol=1e-12
    )
    place = first.terms[0].place(np.arange(240))
    crank = -first.terms[0].output_angle * reducer.case.drive.trochoid.lobes
    solved = StageEquilibrium(tolerance=1e-12).at(reducer.case, crank, 412e3)
    np.testing.assert_allclose(place.tilt, solved.stage.tilt, atol=1e-10)
    (again,) = predict_curves(reducer, asked, [first])
    np.testing.assert_allclose(again.value, first.value, rtol=0.0, atol=1e-5)


def test_pins_that_differ_are_met_one_by_one(built_with, files):
    reducer = built_with(*ROTOR, ONE_PIN)
    (te,) = predict_curves(reducer, [(files[0], np.arange(240))])
    assert te.terms[0].sharing.torque.size == 240
    np.testing.assert_allclose(
        te.value * ARCSEC, _every_pose(reducer, files[0]["output_angle_deg"], 412.0), rtol=0.0, atol=1e-12
    )


def test_from_a_turn_with_like_pins_to_one_with_another_pin_and_back(built_with, files):
    asked = [(file, np.arange(240)) for file in files]
    like, unlike = built_with(*ROTOR), built_with(*ROTOR, ONE_PIN)
    for near, reducer in ((like, unlike), (unlike, like)):
        short = predict_curves(reducer, asked, predict_curves(near, asked))
        for a, b in zip(short, predict_curves(reducer, asked), strict=True):
            np.testing.assert_allclose(a.value, b.value, rtol=0.0, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("more", MORE, ids=lambda one: one["name"])
def test_small_changes_are_those_about_every_pose(built_with, files, more, monkeypatch):
    reducer, after = built_with(*ROTOR), built_with(*ROTOR, more)
    asked = [(file, np.arange(240)) for file in files]
    few = predict_curves(reducer, asked)
    monkeypatch.setattr("cycloid_profile.rig._equivalent_poses._pins_identical", lambda _: False)
    for one, every in zip(few, predict_curves(reducer, asked), strict=True):
        assert every.terms[0].sharing.torque.size == 240 > one.terms[0].sharing.torque.size
        expected = LinearisedCurve(every).change(after)
        assert np.ptp(expected) + np.max(np.abs(expected)) > 1e-3
        np.testing.assert_allclose(
            LinearisedCurve(one).change(after), expected, rtol=0.0, atol=1e-6 * np.max(np.abs(expected))
        )


def test_some_rows_are_those_rows_of_all(built_with, files):
    reducer, after = built_with(*ROTOR), built_with(*ROTOR, ONE_PIN)
    (whole,) = predict_curves(reducer, [(files[0], np.arange(240))])
    rows = np.array([3, 8, 9, 21, 100, 233])
    some = whole.at(rows)
    np.testing.assert_array_equal(some.value, whole.value[rows])
    np.testing.assert_array_equal(some.terms[0].angle(reducer) / ARCSEC, whole.value[rows])
    np.testing.assert_allclose(
        LinearisedCurve(some).change(after), LinearisedCurve(whole).change(after)[rows], atol=1e-9
    )


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60))
def test_a_pose_represents_those_at_whole_pin_pitches(drawn, seed, rows):
    pitch = 2.0 * np.pi / drawn.case.drive.trochoid.pins
    rng = np.random.default_rng(seed)
    within, ahead = rng.choice(rng.uniform(0.0, pitch, 5), rows), rng.integers(0, 90, rows)
    angle, torque = within + ahead * pitch, rng.choice([1e5, -1e5], rows)
    solved, equivalent = equivalent_poses(drawn, angle, torque)
    np.testing.assert_allclose(
        angle[solved][equivalent.representative] + equivalent.pitches * pitch, angle, rtol=0.0, atol=3e-8
    )
    np.testing.assert_array_equal(torque[solved][equivalent.representative], torque)
    assert solved.size <= max(10, rows // 2 + 10)


def test_unrepeated_angles_are_all_solved(drawn):
    angle = np.sort(np.random.default_rng(2).uniform(0.0, 2.0 * np.pi, 300))
    solved, equivalent = equivalent_poses(drawn, angle, np.full(300, 1e5))
    np.testing.assert_array_equal(solved, np.arange(300))
    np.testing.assert_array_equal(equivalent.representative, np.arange(300))
    assert not np.any(equivalent.pitches)
