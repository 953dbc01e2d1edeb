"""Simulated files: what is put in is found again, to the noise, and what no measurement can know does not matter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import as_drawn
from cycloid_profile.errors import LoadError, MeasurementError, SolveError
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid
from cycloid_profile.measurement import (
    HYSTERESIS,
    KINDS,
    PROFILE_SCAN,
    Measurement,
    format_measurement,
    parse_measurement,
)
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.rig import (
    Settings,
    evaluate_loop,
    hysteresis_loop,
    key_figures,
    measurement_residual,
    predict_curves,
    profile_scan,
    simulate,
)
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE

NOISE = {"profile_scan": 0.3, "hysteresis": 0.004, "transmission_error": 0.15, "lost_motion_map": 0.004}
# A bit of everything that the four kinds can see.
SEED = 1
EFFECTS = (
    {"name": "disc_oval", "amplitude_um": 1.0, "phase_deg": 20.0},
    {"name": "pin_ring_runout", "amplitude_um": 1.5, "phase_deg": 130.0},
    {"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0},
    {"name": "coulomb_friction", "torque_nm": 5.0},
)
every_kind = pytest.mark.parametrize("kind", sorted(KINDS))


@pytest.fixture(scope="module")
def used(built_with):
    """A reducer with something of everything."""
    return built_with(*EFFECTS)


def written_and_read(measurement: Measurement) -> Measurement:
    return parse_measurement(format_measurement(measurement), "file.csv")


@pytest.mark.slow
@every_kind
def test_residual_of_a_simulated_file_is_its_noise(used, drawn, kind):
    # χ²/N of 1500 rows scatters by 3.7 %.
    settings = Settings(noise=NOISE[kind], seed=SEED, points=1500, output_angle=0.3)
    found = measurement_residual(used, written_and_read(simulate(used, kind, settings)))
    assert found.noise == NOISE[kind]
    left = found.residual[np.isfinite(found.residual)]
    assert left.size > 0.8 * found.residual.size
    assert np.sum((left / NOISE[kind]) ** 2) == pytest.approx(left.size, rel=0.05)
    # And the drawing is not what was measured.
    assert measurement_residual(drawn, simulate(used, kind, replace(settings, points=320))).rms > 1.5 * NOISE[kind]


@every_kind
def test_residual_without_noise_is_zero(used, kind):
    found = measurement_residual(used, simulate(used, kind, Settings(points=320, output_angle=0.3)))
    left = np.abs(found.residual[np.isfinite(found.residual)])
    # The loop is compared where the stage is pressed, with its mean off.
    assert np.max(left) < 1e-6


@pytest.mark.parametrize("kind", ["profile_scan", "transmission_error"])
def test_noise_is_read_from_neighbouring_rows_where_it_is_not_stated(used, kind):
    measured = simulate(used, kind, Settings(noise=NOISE[kind], seed=SEED, points=1000))
    silent = replace(measured, keys={key: v for key, v in measured.keys.items() if not key.startswith("noise")})
    # Third differences of 1000 rows; their median is good to 5 %.
    assert measurement_residual(used, silent).noise == pytest.approx(NOISE[kind], rel=0.1)


@every_kind
def test_the_seed_makes_the_noise(drawn, kind):
    def column(seed):
        measured = simulate(drawn, kind, Settings(noise=0.1, seed=seed, points=320))
        return measured[KINDS[kind].columns[1]]

    np.testing.assert_array_equal(column(1), column(1))
    assert np.any(column(1) != column(2))


@settings(max_examples=10)
@given(st.floats(-4.0, 4.0), st.floats(-100.0, 100.0), st.floats(-100.0, 100.0))
def test_a_free_datum_is_found(built_with, turned, x, y):
    # Turned by less than half a lobe, 4.6°; shifted by up to 0.1 mm, which is a bore off its axis.
    oval = built_with({"name": "disc_oval", "amplitude_um": 2.0, "phase_deg": 20.0})
    points = profile_scan(oval, 0, 1600, turned * DEGREE) + 1e-3 * (x + 1j * y)
    found = measurement_residual(
        oval, Measurement(PROFILE_SCAN, {"x_mm": points.real, "y_mm": points.imag}, {"datum": "free"})
    )
    assert np.max(np.abs(found.residual)) < 1e-6
    assert found.registration["turn_deg"] == pytest.approx(turned, abs=1e-8)
    assert found.registration["x_um"] == pytest.approx(x, abs=1e-5)
    assert found.registration["y_um"] == pytest.approx(y, abs=1e-5)


@settings(max_examples=10)
@given(st.floats(-720.0, 720.0))
def test_any_turn_of_a_disc_with_equal_lobes_is_found(drawn, turned):
    points = profile_scan(drawn, 1, 1600, turned * DEGREE)
    found = measurement_residual(drawn, Measurement(PROFILE_SCAN, {"x_mm": points.real, "y_mm": points.imag}, {}), 1)
    assert np.max(np.abs(found.residual)) < 1e-6
    # Which lobe it was nobody can say.
    lobe = 360.0 / 39.0
    assert np.remainder(found.registration["turn_deg"] - turned + 0.5 * lobe, lobe) == pytest.approx(
        0.5 * lobe, abs=1e-8
    )


def test_a_datum_in_the_bore_keeps_the_runout_and_a_free_one_takes_it(built_with, drawn):
    off = built_with({"name": "disc_runout", "amplitude_um": 5.0, "phase_deg": 60.0, "disc": 1})
    scan = simulate(off, "profile_scan", Settings(points=1600))
    assert measurement_residual(drawn, scan).rms == pytest.approx(5.0 / np.sqrt(2.0), rel=0.1)
    free = replace(scan, keys={"datum": "free"})
    found = measurement_residual(drawn, free)
    # Moved as a whole: 5 µm towards 60°.
    assert found.rms < 0.01
    assert found.registration["x_um"] == pytest.approx(2.5, abs=0.02)
    assert found.registration["y_um"] == pytest.approx(5.0 * np.sin(60.0 * DEGREE), abs=0.02)


def test_a_scan_registers_on_its_disc(built_with):
    off = built_with({"name": "disc_oval", "amplitude_um": 3.0, "disc": 2})
    scan = simulate(off, "profile_scan", Settings(points=1600, disc=1))
    assert scan.keys["specimen"] == "disc 2"
    assert measurement_residual(off, scan, 1).rms < 1e-6
    assert measurement_residual(off, scan, 0).rms > 1.0


@pytest.mark.parametrize("disc", [-1, 2, 9])
def test_a_missing_disc_is_refused(drawn, disc):
    with pytest.raises(LoadError, match="is not one of the 2 discs"):
        profile_scan(drawn, disc)
    with pytest.raises(MeasurementError, match="is not one of the 2 discs"):
        measurement_residual(drawn, simulate(drawn, "profile_scan", Settings(points=320)), disc)


def test_a_scan_of_another_drive_is_refused(drawn):
    other = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    case = LoadCase(other, modify(other.theoretical_profile, Equidistant(0.02)), 5e3)
    scan = simulate(as_drawn(case), "profile_scan", Settings(points=400))
    with pytest.raises(MeasurementError, match="this is a scan of another disc") as refused:
        measurement_residual(drawn, replace(scan, name="scan.csv"))
    assert refused.value.what.startswith("scan.csv")


@pytest.mark.parametrize("kind", ["transmission_error", "lost_motion_map"])
def test_an_angle_without_load_is_refused(drawn, kind):
    columns = dict.fromkeys(KINDS[kind].columns, np.arange(4.0))
    with pytest.raises(MeasurementError, match="leaves the angle undefined"):
        measurement_residual(drawn, Measurement(KINDS[kind], columns, {"torque_nm": "0"}, "te.csv"))


def test_a_prediction_near_another_reducer_is_the_same(built_with, drawn):
    kinds = ("hysteresis", "transmission_error", "lost_motion_map")
    files = [simulate(drawn, kind, Settings(points=40)) for kind in kinds]
    asked = [(file, np.arange(40)) for file in files]
    changed = built_with({"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 20.0})
    cold = predict_curves(changed, asked)
    near = predict_curves(changed, asked, predict_curves(drawn, asked))
    for a, b in zip(near, cold, strict=True):
        assert a.terms[0].sharing.iterations <= b.terms[0].sharing.iterations
        np.testing.assert_allclose(a.value, b.value, rtol=0.0, atol=1e-5)


def test_the_encoder_and_shafts_are_in_the_prediction(built_with, drawn):
    read = built_with({"name": "encoder_eccentricity", "amplitude_arcsec": 5.0, "phase_deg": 30.0})
    measured = simulate(read, "transmission_error", Settings(points=200))
    assert measurement_residual(read, measured).rms < 1e-9
    assert measurement_residual(drawn, measured).rms == pytest.approx(5.0 / np.sqrt(2.0), rel=1e-3)


@pytest.mark.parametrize(
    "settings",
    [
        {"noise": -1.0},
        {"noise": np.nan},
        {"noise": np.inf},
        {"points": 0},
        {"points": 1},
        {"points": -5},
        {"seed": -1},
    ],
    ids=str,
)
def test_impossible_settings_are_refused(settings):
    with pytest.raises(MeasurementError):
        Settings(**settings)


def test_an_unknown_kind_is_refused_with_the_known_ones(drawn):
    with pytest.raises(MeasurementError, match="is not known") as refused:
        simulate(drawn, "xyzzy")
    assert all(kind in refused.value.remedy for kind in KINDS)
    with pytest.raises(MeasurementError, match="did you mean hysteresis"):
        simulate(drawn, "histeresis")


def test_a_binding_reducer_is_refused(built_with):
    # A tenth of a millimetre of infeed that was left out: disc and pins overlap everywhere.
    bound = built_with({"name": "pin_circle_radius_error", "amount_um": -200.0})
    with pytest.raises(SolveError, match="equilibrium"):
        simulate(bound, "transmission_error", Settings(points=5))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_loop_may_start_either_way(built_with, sense):
    # So much friction that the first rows are compared: they follow a push the other way.
    rubbing = built_with({"name": "coulomb_friction", "torque_nm": 40.0})
    loop = hysteresis_loop(rubbing, sense * rubbing.case.torque, 200, before=-sense)
    columns = {"torque_nm": loop.torque / NEWTON_METRE, "angle_arcmin": loop.angle / ARCMIN}
    found = measurement_residual(rubbing, Measurement(HYSTERESIS, columns, {}))
    assert np.all(np.isfinite(found.residual[:5]))
    assert np.nanmax(np.abs(found.residual)) < 1e-6


def test_figures_of_a_loop_are_in_arc_minutes(used):
    loop = hysteresis_loop(used, points=320)
    found, figures = (
        evaluate_loop(loop.torque, loop.angle),
        key_figures(simulate(used, "hysteresis", Settings(points=320))),
    )
    assert figures == pytest.approx(
        {
            "lost_motion_arcmin": found.lost_motion / ARCMIN,
            "hysteresis_loss_arcmin": found.hysteresis_loss / ARCMIN,
            "torsional_rigidity_nm_per_arcmin": found.torsional_rigidity * ARCMIN / NEWTON_METRE,
            "loss_energy_nm_arcmin": found.loss_energy / ARCMIN / NEWTON_METRE,
        },
        rel=1e-9,
    )


def test_figures_of_every_kind_have_their_unit(used):
    wanted = {
        "hysteresis": "lost_motion_arcmin",
        "transmission_error": "peak_to_peak_arcsec",
        "lost_motion_map": "mean_arcmin",
        "profile_scan": "root_radius_mm",
    }
    for kind, name in wanted.items():
        figures = key_figures(simulate(used, kind, Settings(points=320)))
        assert name in figures
        assert all(np.isfinite(value) for value in figures.values())
        assert all("_" in key or key == "points" for key in figures)
