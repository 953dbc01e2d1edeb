"""Physics of sun, planets, input, carrier bores and forms of ring and tooth: exact motions, orders, first order.

The oracle of the leads is the involute itself: gears on base circles of radii rb1 and rb2 at a distance D touch where
a crossed belt would run, so that rb1 θ1 + rb2 θ2 = (rb1 + rb2)(β ± inv α), with β the direction from sun to planet
and cos α = (rb1 + rb2)/D. The two signs are the two flanks; the stage takes the mean of both.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact.bodies import PartDeviations, crank_turn_per_carrier_turn, support_misfit
from cycloid_profile.contact.mesh import input_locked_factor, output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import apply_effects, as_drawn, effect_from_table
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import InvoluteStage
from cycloid_profile.measurement import TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import LinearisedCurve, encoder_readings, predict_curve, spectrum
from cycloid_profile.units import ARCMIN, ARCSEC, UM

PINS, LOBES, CRANKS, RATIO = 40, 39, 3, 121
PRESSURE_ANGLE = math.radians(20.0)
R1, R2, R_C, ECCENTRICITY = 9.0, 27.0, 36.0, 1.3
FEW = 3 * 2 * PINS  # poses, six a pin pitch; every multiple of 40 folds onto 40, 80 or 120
WHOLE = 3120  # a multiple of 2 z_c z_p: an order beyond half of it folds onto one of the same family
LIGHT = 0.03
angles = st.floats(0.0, 360.0)
sizes = st.floats(1.0, 20.0)


@pytest.fixture(scope="module")
def drawn(case):
    return as_drawn(case)


def planet_turn(sun: complex, planet: complex, sun_turn: float = 0.0) -> float:
    """Angle of an involute planet whose sun is at ``sun`` and turned, mean of both flanks [rad]."""
    rb1, rb2 = (r * math.cos(PRESSURE_ANGLE) for r in (R1, R2))
    between = planet - sun
    working = math.acos((rb1 + rb2) / abs(between))
    involute = math.tan(working) - working
    direction = math.atan2(between.imag, between.real)
    flanks = [((rb1 + rb2) * (direction + sign * involute) - rb1 * sun_turn) / rb2 for sign in (1.0, -1.0)]
    return 0.5 * sum(flanks)


def leads(reducer, crank_angle: float) -> np.ndarray:
    """How far each crank runs ahead [rad], from where its eccentric stands off in disc 1."""
    seats = replace(reducer.deviations, bore_shift=None)
    misfit = support_misfit(reducer.case.drive, np.array([[crank_angle, crank_angle + math.pi]]), seats)[0, :CRANKS]
    swing = 1j * ECCENTRICITY * np.exp(1j * crank_angle)
    return ((misfit[:, 0] + 1j * misfit[:, 1]) / swing).real


@given(sizes, angles, st.floats(-200.0, 200.0))
def test_a_sun_off_its_axis_drives_as_involutes_do(built_with, size, phase, crank_angle):
    # In the frame of the carrier, which is at −φ/z_c: planets turn on it by φ(1 + 1/z_c), the sun against them.
    found = leads(built_with({"name": "sun_runout", "amplitude_um": size, "phase_deg": phase}), crank_angle)
    turned = math.radians(phase) - crank_angle * (1.0 + 1.0 / LOBES) * R2 / R1
    sun = size * UM * np.exp(1j * turned)
    for m, lead in enumerate(found):
        outwards = np.exp(2j * math.pi * m / CRANKS)
        exact = planet_turn(sun / outwards, R_C) - planet_turn(0.0, R_C)
        # Second order: the square of the offset over the radii.
        assert lead == pytest.approx(exact, abs=(size * UM) ** 2 / R1)
    # Evenly spaced planets: none of it on the mean.
    assert np.sum(found) == pytest.approx(0.0, abs=1e-15)


@given(sizes, angles, st.integers(1, 3))
def test_a_bore_of_the_carrier_takes_crank_and_planet_along(built_with, size, direction, crank):
    table = {"name": "carrier_bore_error", "amplitude_um": size, "direction_deg": direction, "crank": crank}
    reducer = built_with(table)
    moved = size * UM * np.exp(1j * math.radians(direction))
    lead = np.zeros(CRANKS)
    lead[crank - 1] = planet_turn(0.0, R_C + moved) - planet_turn(0.0, R_C)
    np.testing.assert_allclose(leads(reducer, 3.3), lead, rtol=0.0, atol=(size * UM) ** 2 / R2)
    # The discs meet it as bores of theirs moved the other way, all equally.
    outwards = math.degrees(2.0 * math.pi / CRANKS * (crank - 1))
    other_way = {"name": "crank_hole_error", "amplitude_um": size, "crank": crank}
    other_way["direction_deg"] = direction + outwards + 180.0
    bores = built_with({**other_way, "disc": 1}, {**other_way, "disc": 2})
    np.testing.assert_allclose(reducer.bore_shift, bores.bore_shift, rtol=0.0, atol=1e-15)


def test_bores_moved_equally_along_the_circle_are_a_carrier_turned(built_with, drawn):
    tables = [
        {"name": "carrier_bore_error", "amplitude_um": 5.0, "direction_deg": 90.0, "crank": crank}
        for crank in (1, 2, 3)
    ]
    torque = drawn.case.torque * np.array([LIGHT, -LIGHT, 1.0])
    moved = encoder_readings(built_with(*tables), torque, FEW) - encoder_readings(drawn, torque, FEW)
    np.testing.assert_allclose(moved, -5.0 * UM / R_C, rtol=1e-6)


@given(st.sampled_from([1, 2]), sizes, angles)
def test_common_runout_is_that_of_every_planet_with_its_phase(built_with, form, size, phase):
    together = built_with({"name": "common_planet_runout", "amplitude_um": size, "phase_deg": phase, "form": form})
    behind = 0.0 if form == 1 else 360.0 / CRANKS
    each = built_with(
        *(
            {"name": "planet_runout", "amplitude_um": size, "phase_deg": phase - behind * m, "planet": m + 1}
            for m in range(CRANKS)
        )
    )
    np.testing.assert_allclose(together.crank_lead, each.crank_lead, rtol=0.0, atol=1e-15)


def order(error: np.ndarray) -> int:
    """Largest order per turn of the output."""
    return int(np.argmax(spectrum(error)[1:])) + 1


def reading(reducer, share: float, poses: int) -> np.ndarray:
    return encoder_readings(reducer, np.array([share * reducer.case.torque]), poses)[0]


def test_planets_in_phase_drive_three_times_as_far_as_one(built_with):
    one, three, parallel = (
        spectrum(reading(built_with(table), 1.0, FEW))[PINS]
        for table in (
            {"name": "planet_runout", "amplitude_um": 10.0},
            {"name": "common_planet_runout", "amplitude_um": 10.0},
            {"name": "common_planet_runout", "amplitude_um": 10.0, "form": 2},
        )
    )
    assert three == pytest.approx(3.0 * one, rel=1e-3)
    # The carrier follows the lead of all cranks as it follows the input.
    assert three == pytest.approx(10.0 * UM / R2 / (PINS + R1 / R2), rel=1e-3)
    assert parallel < 1e-3 * one


@pytest.mark.parametrize("phase", [0.0, 55.0, 90.0])
def test_parallel_eccentricities_turn_the_discs_against_each_other(built_with, drawn, phase):
    # The cranks of a disc turn it by (1/3)Σ a·cos(x − 2πm/3)·(A/r2)·cos(x + φ − 2πm/3)/r_c = (a A/(2 r2 r_c)) cos φ,
    # whatever the pose, those of the other by as much the other way. Each flank meets the disc that is ahead.
    table = {"name": "common_planet_runout", "amplitude_um": 10.0, "phase_deg": phase, "form": 2}
    ahead = ECCENTRICITY * 10.0 * UM / (2.0 * R2 * R_C) * abs(math.cos(math.radians(phase)))
    touching = drawn.case.torque * np.array([1e-5, -1e-5])
    nominal, closed = (np.subtract(*encoder_readings(one, touching, 60)) for one in (drawn, built_with(table)))
    expected = 2.0 * ahead * input_locked_factor(drawn.case.drive)
    np.testing.assert_allclose(nominal - closed, expected, rtol=0.01, atol=1e-9)


def test_like_discs_hide_the_sun_and_unlike_ones_show_it(built_with):
    # The cranks turn a disc by cos(φ_j) and the planets' leads, z_p and z_p z2/z1 = 120 per turn, both against the
    # order of the planets: 160, of either sign in the two discs. Like discs cancel it and leave its double.
    sun = {"name": "sun_runout", "amplitude_um": 30.0}
    unlike = {"name": "equidistant_error", "amount_um": 3.0, "disc": 1}
    assert order(reading(built_with(sun), LIGHT, WHOLE)) == 320
    assert order(reading(built_with(sun, unlike), LIGHT, WHOLE)) == 160
    # Under load all pins carry, and the small turns of the discs cancel.
    assert np.max(spectrum(reading(built_with(sun), 1.0, WHOLE))[1:400]) < 0.01 * ARCSEC


@given(sizes, angles)
@settings(max_examples=5)
def test_an_error_of_the_input_comes_through_the_ratio(built_with, drawn, size, phase):
    table = {"name": "input_runout", "amplitude_arcsec": 20.0 * size, "phase_deg": phase}
    torque = np.array([1.0, -LIGHT]) * drawn.case.torque
    added = encoder_readings(built_with(table), torque, FEW + 1) - encoder_readings(drawn, torque, FEW + 1)
    output = 2.0 * math.pi * np.arange(FEW + 1) / (FEW + 1)
    expected = 20.0 * size * ARCSEC * np.cos(RATIO * output - math.radians(phase)) / RATIO
    np.testing.assert_allclose(added, np.stack([expected, expected]), rtol=0.0, atol=1e-13)


def test_an_eccentric_that_is_the_input_turns_the_output_back(case):
    drive = replace(case.drive, first_stage=None)
    reducer = apply_effects(
        replace(case, drive=drive), [effect_from_table({"name": "input_runout", "amplitude_arcsec": 60.0})]
    )
    # The crank is at −z_c Θ: a quarter of its turn on, the input is ahead by nothing.
    assert reducer.angle_error(0.0) == pytest.approx(-60.0 * ARCSEC / LOBES, rel=1e-12)
    assert reducer.angle_error(0.5 * math.pi / LOBES) == pytest.approx(0.0, abs=1e-15)


# What stands in the carrier shows at multiples of z_p, in the housing of z_c, doubled by two like discs.
ORDERS = {
    "pin_ring_three_lobed": ({"phase_deg": 20.0}, 78, 234),
    "ring_mounting_ovality": ({"phase_deg": 20.0}, 78, 78),
    "ring_mounting_ovality, four bolts": ({"waves": 4}, 78, 156),
    "tooth_form_error": ({"waves": 4}, 1560, 1560),
    "carrier_bore_error": ({"direction_deg": 30.0}, 40, 80),
    "common_planet_runout": ({}, 40, 40),
    "sun_runout": ({"amplitude_um": 30.0}, 40, 320),
}


@pytest.mark.parametrize("name", ORDERS)
def test_orders_are_those_of_the_part_that_errs(built_with, name):
    more, base, largest = ORDERS[name]
    bare = name.split(",")[0]
    found = spectrum(reading(built_with({"name": bare, "amplitude_um": 3.0, **more}), LIGHT, WHOLE))
    # A folded mesh order is one of the mesh again.
    allowed = np.arange(found.size) % base == 0
    assert np.sqrt(np.sum(found[~allowed] ** 2)) < 1e-6 * np.sqrt(np.sum(found[1:] ** 2))
    assert int(np.argmax(found[1:])) + 1 == largest


@pytest.mark.parametrize("name", ["pin_ring_three_lobed", "ring_mounting_ovality"])
@given(st.integers(1, 39), angles)
@settings(max_examples=4)
def test_a_ring_form_turned_by_pin_pitches_is_met_as_many_later(built_with, name, pitches, phase):
    # The phase of a ground form is an angle of the ring, that of a bent ring one of its wave, here of two periods.
    waves = 1.0 if name == "pin_ring_three_lobed" else 2.0
    turned = phase + waves * pitches * 360.0 / PINS
    first, later = (
        reading(built_with({"name": name, "amplitude_um": 3.0, "phase_deg": one}), 1.0, PINS) for one in (phase, turned)
    )
    np.testing.assert_allclose(later, np.roll(first, pitches), rtol=0.0, atol=1e-12)


@given(angles, st.integers(1, 20))
def test_a_bent_ring_keeps_its_length_and_a_ground_one_does_not(built_with, phase, waves):
    alpha = 2.0 * math.pi * np.arange(PINS) / PINS
    out = np.exp(1j * alpha)
    reducer = built_with({"name": "ring_mounting_ovality", "amplitude_um": 3.0, "phase_deg": phase, "waves": waves})
    local = reducer.pin_shift / out
    # ε = (u_r + du_θ/dθ)/r: the tangential shift is minus the integral of the radial one, here by its spectrum.
    spectral = np.fft.fft(local.imag)
    n = np.fft.fftfreq(PINS, 1.0 / PINS)
    if waves < PINS // 2:
        strain = local.real + np.fft.ifft(1j * n * spectral).real
        assert np.max(np.abs(strain)) < 1e-12
    if waves == 1:
        # One wave moves the ring as a whole.
        runout = built_with({"name": "pin_ring_runout", "amplitude_um": 3.0, "phase_deg": phase})
        np.testing.assert_allclose(reducer.pin_shift, runout.pin_shift, rtol=0.0, atol=1e-15)
    oval = built_with({"name": "pin_ring_oval", "amplitude_um": 3.0, "phase_deg": phase}).pin_shift / out
    np.testing.assert_allclose(oval.imag, 0.0, atol=1e-15)


@pytest.mark.parametrize(("waves", "flank"), [(2, None), (3, None), (2, 1), (5, 2)])
def test_a_form_of_every_tooth_shifts_the_mean_and_shows_the_mesh(built_with, drawn, waves, flank):
    # "Every tooth 2 µm form: TE 0.1 to 0.5″ at 1560, lost motion: mean shift only."
    table = {"name": "tooth_form_error", "amplitude_um": 2.0, "waves": waves} | ({"flank": flank} if flank else {})
    formed, torque = built_with(table), drawn.case.torque
    forward, backward = encoder_readings(formed, np.array([LIGHT, -LIGHT]) * torque, 241)
    assert np.ptp(forward) < 0.6 * ARCSEC
    lost = forward - backward
    nominal = np.subtract(*encoder_readings(drawn, np.array([LIGHT, -LIGHT]) * torque, 241))
    assert np.ptp(lost) < 0.02 * ARCMIN < abs(np.mean(lost - nominal))
    spared = encoder_readings(formed, np.array([-1.0, 1.0]) * torque, 24)[0 if flank == 1 else 1]
    same = encoder_readings(drawn, np.array([-1.0, 1.0]) * torque, 24)[0 if flank == 1 else 1]
    # A form of one flank is not felt by the other.
    assert (np.max(np.abs(spared - same)) < 1e-9) == (flank is not None)


@given(st.integers(1, 20), angles)
def test_a_form_of_both_flanks_is_a_chatter_of_as_many_waves_on_every_tooth(built_with, waves, phase):
    form = {"name": "tooth_form_error", "amplitude_um": 2.0, "waves": waves, "phase_deg": phase, "disc": 1}
    chatter = {"name": "grinding_chatter", "amplitude_um": 2.0, "waves_per_turn": float(waves * LOBES)}
    psi = np.linspace(0.0, 240.0, 999)
    one, other = (
        built_with(table).teeth[0].removal(psi) for table in (form, {**chatter, "phase_deg": phase, "disc": 1})
    )
    for a, b in zip(one, other, strict=True):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=1e-9 * waves**2)


# The sun stands the same after a pin pitch only if z2 is a multiple of z1.


@pytest.fixture(scope="module")
def uneven(case):
    """The case with 14 and 35 teeth: the sun makes 2.5 turns on the carrier per pin pitch."""
    return replace(case, drive=replace(case.drive, first_stage=InvoluteStage(14, 35, 1.5)))


def turn_file(rows: int) -> Measurement:
    angle = np.arange(rows) * 360.0 / rows
    columns = {"output_angle_deg": angle, "error_arcsec": np.zeros(rows)}
    return Measurement(TRANSMISSION_ERROR, columns, {"torque_nm": "12.36"}, "te")


def test_every_row_has_its_own_sun(uneven):
    sun = effect_from_table({"name": "sun_runout", "amplitude_um": 20.0, "phase_deg": 30.0})
    disc = effect_from_table({"name": "equidistant_error", "amount_um": 3.0, "disc": 1})
    drawn, reducer = apply_effects(uneven, [disc]), apply_effects(uneven, [disc, sun])
    crank = output_turn(reducer.case.drive.trochoid, FEW)
    alone = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, crank, LIGHT * uneven.torque).rotation
    turned = reading(reducer, LIGHT, FEW)
    np.testing.assert_allclose(turned, alone, rtol=0.0, atol=1e-12)
    # Twice as long as a pin pitch: order z_p(1 + z2/z1) = 140.
    assert order(turned) == FEW - 140
    # The first-order change about poses that are equivalent as drawn, against the quotient of two solves.
    file = turn_file(FEW)
    before = predict_curve(drawn, file)
    assert before.terms[0].sharing.torque.size == FEW // PINS
    small = apply_effects(uneven, [disc, replace(sun, amplitude_um=0.02)])
    exact = predict_curve(small, file).value - before.value
    np.testing.assert_allclose(
        LinearisedCurve(before).change(small), exact, rtol=0.0, atol=0.02 * np.max(np.abs(exact))
    )


@pytest.mark.parametrize(
    "table",
    [
        {"name": "sun_runout", "amplitude_um": 0.2, "phase_deg": 70.0},
        {"name": "common_planet_runout", "amplitude_um": 0.2, "phase_deg": 10.0},
        {"name": "common_planet_runout", "amplitude_um": 0.2, "form": 2},
        {"name": "carrier_bore_error", "amplitude_um": 0.02, "direction_deg": 70.0, "crank": 2},
        {"name": "input_runout", "amplitude_arcsec": 1.0},
        {"name": "pin_ring_three_lobed", "amplitude_um": 0.02, "phase_deg": 10.0},
        {"name": "ring_mounting_ovality", "amplitude_um": 0.02, "waves": 3},
        {"name": "tooth_form_error", "amplitude_um": 0.02, "phase_deg": 10.0},
        {"name": "tooth_form_error", "amplitude_um": 0.02, "flank": 1},
    ],
    ids=lambda table: "-".join(str(value) for value in table.values()),
)
def test_first_order_is_the_quotient_of_two_solves(built_with, table):
    # A reducer with unlike discs, about which single parts count.
    unlike = {"name": "equidistant_error", "amount_um": 1.0, "disc": 1}
    before, after = built_with(unlike), built_with(unlike, table)
    file = turn_file(FEW)
    nominal = predict_curve(before, file)
    exact = predict_curve(after, file).value - nominal.value
    assert np.max(np.abs(exact)) > 1e-4
    # Rows are linearised without the change of curvature, which for a wave of two periods a tooth is 3 %; the study of
    # tolerances has it (tests/tolerance/test_sensitivity.py).
    within = 0.05 if table["name"] == "tooth_form_error" else 0.02
    np.testing.assert_allclose(
        LinearisedCurve(nominal).change(after), exact, rtol=0.0, atol=within * np.max(np.abs(exact))
    )
    # Half the size, half the change.
    half = built_with(unlike, halved(table))
    np.testing.assert_allclose(
        LinearisedCurve(nominal).change(half), 0.5 * LinearisedCurve(nominal).change(after), rtol=1e-3, atol=1e-6
    )


def halved(table):
    size = "amplitude_arcsec" if "amplitude_arcsec" in table else "amplitude_um"
    return {**table, size: 0.5 * table[size]}


def test_a_sun_needs_a_first_stage(drawn):
    drive = replace(drawn.case.drive, first_stage=None)
    assert crank_turn_per_carrier_turn(drive) == 0.0
    with pytest.raises(LoadError, match="sun_shift"):
        PartDeviations(sun_shift=1e-3 + 0j).check(drive)
    with pytest.raises(LoadError, match="is not finite"):
        PartDeviations(sun_shift=complex(math.nan, 0.0))
