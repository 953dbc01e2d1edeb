"""Physics properties: what effects do to a reducer under load, and how they hang together.

Discs ground together are identical in the frame of the carrier, where two discs 180° of the crank apart cancel the
odd multiples of z_p = 40; what two effects have in common is found under both names.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from cycloid_profile.contact.mesh import backlash, input_locked_factor
from cycloid_profile.effects import as_drawn
from cycloid_profile.effects.process import STEEL_EXPANSION
from cycloid_profile.rig import backlash_map, encoder_readings, lost_motion_map, spectrum, transmission_error
from cycloid_profile.units import ARCMIN, ARCSEC, UM

PINS, LOBES = 40, 39
MESH = PINS * LOBES
WHOLE_TURN = 2 * MESH  # poses; orders beyond fold onto orders of the same family
FEW = 720  # poses; the mesh order folds onto 120
LIGHT = 0.03


def light(reducer, poses=120):
    """Rotation under plus and minus 3 % of the rated torque, shape (2, poses) [rad]."""
    T = LIGHT * reducer.case.torque
    return encoder_readings(reducer, np.array([T, -T]), poses)


@pytest.fixture(scope="module")
def drawn(case):
    return as_drawn(case)


@pytest.mark.parametrize(
    "given",
    [
        {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0},
        {"name": "disc_oval", "amplitude_um": 3.0, "phase_deg": 25.0},
        pytest.param(
            {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0, "form": 2}, marks=pytest.mark.slow
        ),
        pytest.param(
            {"name": "cumulative_pitch_error", "amplitude_um": 3.0, "phase_deg": 25.0}, marks=pytest.mark.slow
        ),
    ],
    ids=lambda given: f"{given['name']}-{given.get('form', 1)}",
)
def test_discs_ground_together_show_even_multiples_alone(built_with, given):
    both = built_with(given)
    orders = transmission_error(both, LIGHT * both.case.torque, WHOLE_TURN).orders
    k = np.arange(orders.size)
    # Odd multiples come back about odd multiples of the mesh order: below half of it they are all but gone.
    low = (k > 0) & (k < MESH / 2)
    even, odd = np.max(orders[low & (k % 80 == 0)]), np.max(orders[low & (k % 80 == 40)])
    assert even > 2.5 * ARCSEC
    assert odd < 0.005 * even
    assert np.max(orders[k % PINS != 0]) < 1e-9 * even
    # On one disc alone the first order stands out, which for an oval is even.
    alone = transmission_error(built_with({**given, "disc": 1}), LIGHT * both.case.torque, FEW).orders
    assert int(np.argmax(alone[1:])) + 1 == (80 if given["name"] == "disc_oval" else 40)


def test_all_discs_means_one_direction_of_the_carrier(built_with):
    # Disc 2 is mounted half a lobe pitch back: what is at 25° of the carrier is at 25° + 180°/39 of that disc.
    together = built_with({"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0})
    apart = built_with(
        {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0, "disc": 1},
        {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0 + 180.0 / LOBES, "disc": 2},
    )
    np.testing.assert_allclose(light(together), light(apart), rtol=0.0, atol=1e-15)
    # Not the discs' own: with the same angle on both the first order is there.
    off = built_with(
        {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0, "disc": 1},
        {"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 25.0, "disc": 2},
    )
    assert np.max(np.abs(light(together) - light(off))) > 0.1 * ARCSEC


@pytest.mark.parametrize("share", [LIGHT, 1.0])
def test_a_tooth_moved_as_a_whole_is_bores_moved_the_other_way(built_with, share):
    # The same disc, whether its teeth stand off the bores or its bores off the teeth. A removal along the normal and
    # a shift differ by second order, (3 µm)²/3 mm.
    tooth = built_with({"name": "disc_runout", "amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1})
    bores = built_with(
        *({"name": "crank_hole_error", "amplitude_um": 3.0, "direction_deg": 220.0, "crank": c} for c in (1, 2, 3))
    )
    torque = share * tooth.case.torque
    one, other = (transmission_error(reducer, torque, 780).error for reducer in (tooth, bores))
    assert np.ptp(one) > 11.0 * ARCSEC
    assert np.max(np.abs(one - other)) < 1e-3 * np.max(np.abs(one))


def test_a_warm_disc_looks_like_a_wrong_infeed(built_with, case):
    psi = np.linspace(-math.pi, math.pi, 2001)
    points, K1 = case.profile.at(psi), case.drive.trochoid.short_width_ratio
    warm = (np.conj(points.normal) * points.position).real
    infeed = 64.0 * (1.0 - K1 * np.cos(psi)) / np.sqrt(1.0 + K1**2 - 2.0 * K1 * np.cos(psi))
    assert warm @ infeed / np.linalg.norm(warm) / np.linalg.norm(infeed) > 0.999
    # And so on the rig: 3 K take as much lost motion as the infeed of the same growth, to a tenth.
    at_rest = np.mean(lost_motion_map(as_drawn(case), poses=60).value)
    growth = STEEL_EXPANSION * 3.0 * 64.0 / UM
    heated, set_off = (
        np.mean(lost_motion_map(built_with(given), poses=60).value) - at_rest
        for given in (
            {"name": "thermal_growth", "temperature_k": 3.0},
            {"name": "radial_moving_error", "amount_um": -growth},
        )
    )
    assert heated == pytest.approx(set_off, rel=0.1)
    # Published: −0.053′ per kelvin.
    assert heated / ARCMIN / 3.0 == pytest.approx(-0.053, abs=1e-3)


@pytest.mark.parametrize("amount", [-2.0, 1.0, 4.0])
def test_missing_compensation_is_backlash(built_with, drawn, amount):
    # 2δ/(a z_c) at every pose, and with the input held less by z_c/(z_p + z1/z2).
    drive = drawn.case.drive
    without = built_with({"name": "missing_deformation_compensation", "amount_um": amount})
    wanted = 2.0 * amount * UM / drive.trochoid.longest_lever
    grown = backlash(drive, without.teeth[0]).values - backlash(drive, drawn.teeth[0]).values
    np.testing.assert_allclose(grown, wanted, rtol=2e-4)
    held = backlash_map(without, 60).value - backlash_map(drawn, 60).value
    np.testing.assert_allclose(held, wanted * input_locked_factor(drive), rtol=2e-4)


@pytest.mark.parametrize("clearance", [1.0, 3.4, 10.0])
def test_clearance_of_crank_bearings_adds_to_lost_motion(built_with, drawn, clearance):
    # 2c/r_c; the load shares it between the bearings, which is worth two parts in a hundred.
    loose = built_with({"name": "crank_bearing_clearance", "radial_um": clearance})
    added = lost_motion_map(loose, poses=60).value - lost_motion_map(drawn, poses=60).value
    assert np.mean(added) == pytest.approx(2.0 * clearance * UM / 36.0, rel=0.03)
    # Flat: it is the same all round.
    assert np.ptp(added) < 0.02 * np.mean(added)


def test_compliance_in_series_adds_torque_over_stiffness(built_with, drawn):
    soft = built_with({"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0})
    torque = np.array([-1.0, 0.03, 0.5, 1.0]) * drawn.case.torque
    added = encoder_readings(soft, torque, 12) - encoder_readings(drawn, torque, 12)
    wanted = torque / 1e3 / 134.0 * ARCMIN
    np.testing.assert_allclose(added, np.broadcast_to(wanted[:, np.newaxis], (4, 12)), rtol=1e-9)
    # Two springs in series are as soft as both together.
    twice = built_with(*[{"name": "series_compliance", "stiffness_nm_per_arcmin": 134.0}] * 2)
    assert twice.series_compliance == pytest.approx(2.0 * soft.series_compliance, rel=1e-15)


def test_an_encoder_off_centre_errs_once_per_turn(built_with, drawn):
    read = built_with({"name": "encoder_eccentricity", "amplitude_arcsec": 5.0, "phase_deg": 70.0})
    torque = np.array([drawn.case.torque])
    added = (encoder_readings(read, torque, 360) - encoder_readings(drawn, torque, 360))[0]
    np.testing.assert_allclose(added, 5.0 * ARCSEC * np.cos(np.deg2rad(np.arange(360) - 70.0)), atol=1e-15)
    orders = spectrum(added)
    assert orders[1] == pytest.approx(5.0 * ARCSEC, rel=1e-9)
    assert np.max(np.delete(orders, 1)) < 1e-9 * orders[1]


def test_a_planet_off_its_axis_shows_at_the_fortieth_order(built_with, drawn):
    # Each planet turns z_p times on the carrier per turn of the output; wherever it sits, it drives as far ahead.
    amplitudes = []
    for planet in (1, 2, 3):
        given = {"name": "planet_runout", "amplitude_um": 10.0, "planet": planet, "phase_deg": 15.0}
        orders = transmission_error(built_with(given), drawn.case.torque, FEW).orders
        assert int(np.argmax(orders[1:])) + 1 == PINS
        amplitudes.append(orders[PINS])
    np.testing.assert_allclose(amplitudes, amplitudes[0], rtol=1e-3)
    # One crank of three leads by 10 µm/27 mm; on the mean the carrier follows it as it follows the input.
    lead = 10.0 * UM / 27.0
    assert amplitudes[0] == pytest.approx(lead / 3.0 / (PINS + 12.0 / 36.0), rel=0.05)


def test_an_eccentric_turned_ahead_is_the_crank_turned_ahead(built_with, drawn):
    # All three cranks 1′ ahead on both discs. The crank runs against the output: z_c Θ = −(1′ + (1 + z1/z2) Θ).
    ahead = built_with({"name": "crank_phase_error", "angle_arcmin": 1.0})
    moved = light(ahead) - light(drawn)
    assert np.mean(moved) == pytest.approx(-ARCMIN / (PINS + 12.0 / 36.0), rel=0.01)
    assert np.ptp(moved) < 0.02 * abs(np.mean(moved))


@pytest.mark.parametrize("flank", [1, 2])
def test_wear_shows_in_the_direction_of_its_torque(built_with, drawn, flank):
    worn = built_with({"name": "flank_wear", "amount_um": 3.0, "flank": flank})
    forward, backward = np.mean(light(worn) - light(drawn), axis=1)
    carried, spared = (forward, -backward) if flank == 1 else (-backward, forward)
    # 3 µm all over would be 0.2′; wear spares the adjacent pins, which then carry more.
    assert carried > 0.05 * ARCMIN
    assert abs(spared) < 1e-6 * carried
    psi = np.linspace(-math.pi, math.pi, 4001)
    depth = worn.teeth[0].removal(psi).value
    side = 1.0 if flank == 1 else -1.0
    assert np.max(depth) == pytest.approx(3.0 * UM, rel=0.01)
    assert 0.5 < side * psi[np.argmax(depth)] < 1.6
    assert np.max(np.abs(depth[side * psi < -0.1])) < 0.01 * 3.0 * UM


def test_friction_leaves_parts_and_angles_alone(built_with, drawn):
    rubbing = built_with(
        {"name": "coulomb_friction", "torque_nm": 7.0}, {"name": "load_proportional_friction", "coefficient": 0.03}
    )
    assert (rubbing.coulomb_torque, rubbing.proportional_friction) == (7000.0, 0.03)
    np.testing.assert_array_equal(light(rubbing), light(drawn))


def test_sizes_of_the_same_effect_add_up(built_with):
    for given in (
        {"name": "pin_ring_runout", "amplitude_um": 2.0, "phase_deg": 30.0},
        {"name": "crank_eccentricity_error", "amount_um": 2.0, "crank": 2},
        {"name": "coulomb_friction", "torque_nm": 2.0},
        {"name": "encoder_eccentricity", "amplitude_arcsec": 2.0, "phase_deg": 10.0},
        {"name": "crank_bearing_compliance", "added_um_per_kn": 2.0},
        {"name": "crank_bearing_clearance", "radial_um": 2.0},
        {"name": "planet_runout", "amplitude_um": 2.0},
    ):
        size = next(key for key, value in given.items() if value == 2.0)
        twice, whole = built_with(given, given), built_with({**given, size: 4.0})
        for part in ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift", "crank_lead"):
            np.testing.assert_allclose(getattr(twice, part), getattr(whole, part), rtol=1e-15)
        assert twice.coulomb_torque == whole.coulomb_torque
        assert twice.encoder == pytest.approx(whole.encoder, rel=1e-15)
        for stiffness_or_play in ("bearing_stiffness", "bearing_play"):
            one, other = (getattr(b.case.drive.support, stiffness_or_play) for b in (twice, whole))
            assert one == pytest.approx(other, rel=1e-14)
