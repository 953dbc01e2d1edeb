"""Physics of transmission error, maps and torque sweep: known spectra, limits and orders of size."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.mesh import backlash, first_order_backlash, input_locked_factor
from cycloid_profile.errors import LoadError
from cycloid_profile.rig import hysteresis_loop, lost_motion_map, spectrum, transmission_error
from cycloid_profile.rig.curves_over_turn import SHARES, backlash_map, encoder_readings, rigidity_map, torque_sweep
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE


@given(st.integers(2, 400), st.data())
def test_spectrum_of_a_cosine_is_its_amplitude(size, data):
    order = data.draw(st.integers(0, size // 2))
    whole = 2 * order in {0, size}
    phase = 0.0 if whole else data.draw(st.floats(-3.0, 3.0))
    amplitude = spectrum(2.5 * np.cos(2.0 * np.pi * order * np.arange(size) / size + phase))
    assert amplitude.size == size // 2 + 1
    assert amplitude[order] == pytest.approx(2.5, rel=1e-9)
    assert np.max(np.delete(amplitude, order), initial=0.0) < 1e-9


def test_error_has_no_mean_and_runs_with_the_output(drawn):
    found = transmission_error(drawn, drawn.case.torque, 100)
    assert abs(np.mean(found.error)) < 1e-18
    assert found.peak_to_peak == np.ptp(found.error)
    np.testing.assert_allclose(found.output_angle, 2.0 * np.pi * np.arange(100) / 100)
    np.testing.assert_array_equal(found.orders, spectrum(found.error))


def test_all_torques_in_one_batch_are_each_by_itself(built_with):
    off = built_with({"name": "pin_ring_runout", "amplitude_um": 3.0})
    torque = np.array([0.03, -0.5, 1.0]) * off.case.torque
    together = encoder_readings(off, torque, 40)
    for T, row in zip(torque, together, strict=True):
        np.testing.assert_array_equal(encoder_readings(off, np.array([T]), 40)[0], row)


@pytest.mark.parametrize("torque", [0.0, np.nan, np.inf])
def test_a_torque_that_is_none_is_refused(drawn, torque):
    with pytest.raises(LoadError, match="torque"):
        transmission_error(drawn, torque, 10)


def test_backlash_with_the_input_held_is_that_of_the_disc_times_the_factor(drawn):
    # Both discs and all poses of the turn: between the least and the worst of one disc over a mesh period.
    drive = drawn.case.drive
    one_disc, factor = backlash(drive, drawn.case.profile, 96), input_locked_factor(drive)
    found = backlash_map(drawn, 390).value
    assert np.max(found) <= one_disc.worst * factor * (1.0 + 1e-5)
    assert np.min(found) >= one_disc.least * factor * (1.0 - 2e-3)
    # 2Δr_rp/(a z_c), 3.3 % less with the input held.
    assert np.mean(found) == pytest.approx(first_order_backlash(drive, 0.006, 0.0) * factor, rel=0.01)
    assert factor == pytest.approx(39.0 / (40.0 + 12.0 / 36.0), rel=1e-15)


def test_lost_motion_without_torque_is_backlash(built_with):
    # The last of the twist goes with the torque, but for the logarithm in the law of contact.
    off = built_with({"name": "pin_ring_oval", "amplitude_um": 2.0})
    limit = backlash_map(off, 12).value
    shares = np.array([1e-1, 1e-2, 1e-3, 1e-4])
    beyond = np.array([lost_motion_map(off, share * off.case.torque, 12).value - limit for share in shares])
    assert np.all(beyond > 0.0)
    assert np.all(np.diff(beyond, axis=0) < 0.0)
    assert np.max(beyond[-1] / limit) < 2e-3
    order = np.polyfit(np.log(shares), np.log(np.mean(beyond, axis=1)), 1)[0]
    assert 0.8 < order < 1.1


def test_lost_motion_is_the_centreline_of_the_loop(built_with):
    off = built_with({"name": "pin_ring_oval", "amplitude_um": 2.0}, {"name": "coulomb_friction", "torque_nm": 1.0})
    at = lost_motion_map(off, poses=12)
    loop = hysteresis_loop(off, points=2000, output_angle=float(at.output_angle[5]), before=1.0)
    top, bottom = int(np.argmax(loop.torque)), int(np.argmin(loop.torque))
    # Friction moved both branches equally along the torque: undone, they are the line of the map.
    falling, rising = slice(top + 200, bottom - 200), slice(bottom + 200, None)
    for branch in (falling, rising):
        left, angle = loop.stage_torque[branch], loop.angle[branch]
        order = np.argsort(left)
        ends = np.interp([-at.torque, at.torque], left[order], angle[order])
        assert ends[1] - ends[0] == pytest.approx(at.value[5], rel=1e-3)


def test_rigidity_is_the_chord_of_the_upper_half(drawn, built_with):
    found = rigidity_map(drawn, 12).value * ARCMIN / NEWTON_METRE
    assert np.mean(found) == pytest.approx(558.0, rel=0.01)
    soft = rigidity_map(built_with({"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0}), 12).value
    np.testing.assert_allclose(1.0 / (soft * ARCMIN / NEWTON_METRE), 1.0 / found + 1.0 / 134.0, rtol=1e-9)


def test_sweep_is_monotone_and_chords_follow_from_it(drawn):
    found = torque_sweep(drawn, poses=24)
    np.testing.assert_allclose(found.torque, SHARES * drawn.case.torque)
    assert np.all(np.diff(found.twist) > 0.0)
    assert np.isnan(found.stiffness[0])
    # More pins carry as the load grows: the stage stiffens. Published 448 → 558 N·m/′ from 3 % to full for 10 µm.
    assert np.all(np.diff(found.stiffness[1:]) > 0.0)
    chord = 2.0 * (found.torque[9] - found.torque[8]) / (found.twist[9] - found.twist[8])
    assert found.stiffness[9] == pytest.approx(chord, rel=1e-12)
    assert 450.0 < found.stiffness[1] * ARCMIN / NEWTON_METRE < found.stiffness[-1] * ARCMIN / NEWTON_METRE < 600.0
    # At rated torque it is lost motion of the whole torque.
    full = lost_motion_map(drawn, drawn.case.torque, 24).value
    assert found.twist[9] == pytest.approx(np.mean(full), rel=1e-12)
    assert np.all(found.transmission_error < 0.4 * ARCSEC)


def test_error_of_few_pins_shrinks_with_load_and_error_of_one_disc_does_not(built_with):
    # As published: pin ring runout 7.6″ → 1.2″, one disc's runout 11.8″ → 11.8″.
    ring = torque_sweep(built_with({"name": "pin_ring_runout", "amplitude_um": 3.0}), np.array([0.03, 0.3, 1.0]), 390)
    assert np.all(np.diff(ring.transmission_error) < 0.0)
    assert ring.transmission_error[-1] < 0.25 * ring.transmission_error[0]
    disc = torque_sweep(
        built_with({"name": "disc_runout", "amplitude_um": 3.0, "disc": 1, "form": 2}), np.array([0.03, 1.0]), 200
    )
    assert disc.transmission_error[1] == pytest.approx(disc.transmission_error[0], rel=0.05)


@pytest.mark.parametrize(
    "measure",
    [
        lambda reducer: reducer,
        lambda reducer: transmission_error(reducer, reducer.case.torque, 12),
        lambda reducer: lost_motion_map(reducer, poses=12),
        lambda reducer: rigidity_map(reducer, 12),
        lambda reducer: hysteresis_loop(reducer, points=20),
    ],
)
def test_results_introduce_themselves_in_few_lines_with_units(drawn, measure):
    shown = repr(measure(drawn))
    assert 3 < len(shown.splitlines()) <= 15
    assert "N·m" in shown


def test_curves_become_tables_in_the_units_of_files(drawn):
    pytest.importorskip("pandas")
    error = transmission_error(drawn, drawn.case.torque, 12)
    np.testing.assert_allclose(error.to_frame()["error_arcsec"], error.error / ARCSEC)
    rigidity = rigidity_map(drawn, 12)
    np.testing.assert_allclose(rigidity.to_frame()["value_nm_per_arcmin"], rigidity.value * ARCMIN / NEWTON_METRE)
    assert set(hysteresis_loop(drawn, points=20).to_frame()) == {"torque_nm", "stage_torque_nm", "angle_arcmin"}
