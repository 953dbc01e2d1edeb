"""The fifteen sensitivities of [TP]: printed numbers, what they should be, and the exact model next to them.

Source: "Optimization of Cycloidal Gear Tooth Profile in Rotary Vector Reducer Based on Backlash Reduction", table of
sensitivities and weights of the RV-40E. Symbols: its α (also a) is the eccentricity a = 1.3 mm, z_c = 39 lobes,
K_1 = 0.8125, i = 121, r_1 printed as the planet's 27 mm and meant as the sun's 9 mm, α_0 the crank circle, 36 mm.
Tolerance: the article prints four decimals, hence half of the fourth. Compared with a first-order
formula the tolerance is what pins next to ψ0 and finite amounts make, said at each place.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.articles import FACTORS, BacklashSensitivity, DifferenceSetup, sensitivities
from cycloid_profile.articles import formulas as formulas
from cycloid_profile.articles.backlash_sensitivities import RequiredPart, larger_eccentrics, weights
from cycloid_profile.articles.finite_difference import (
    bearing_play,
    by_effect,
    one_sided,
    output_per_sun_play,
    scattered_pins,
)
from cycloid_profile.articles.formulas import PRESSURE_ANGLE, InvolutePair
from cycloid_profile.catalog import catalog_drive, tooth_profile_article
from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import crank_turn_per_carrier_turn
from cycloid_profile.contact.mesh import gaps, mesh
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.effects import CumulativePitchError, DiscRunout, EquidistantError, as_drawn
from cycloid_profile.geometry import CentralEccentric, Drive, InvoluteStage, Trochoid, undercut_limit
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.rig import backlash_map
from cycloid_profile.units import ARCMIN, UM

FOUR_DECIMALS = 0.5e-4
AMOUNT = 6.0 * UM


def of(drive: Drive, equidistant: float = AMOUNT) -> LoadCase:
    return LoadCase(drive, modify(drive.theoretical_profile, Equidistant(equidistant)), 412e3)


@pytest.fixture(scope="module")
def setup(rv40e: Drive) -> DifferenceSetup:
    return DifferenceSetup(of(rv40e), poses=41)


@pytest.fixture(scope="module")
def rows(setup: DifferenceSetup) -> dict[int, BacklashSensitivity]:
    return {row.factor.number: row for row in sensitivities(setup.case, setup)}


# Published numbers.


@pytest.mark.parametrize("factor", [one for one in FACTORS if one.number != 12], ids=lambda one: str(one.number))
def test_printed_sensitivity_comes_out_of_its_formula(factor, rv40e):
    (printed,) = (one for one in tooth_profile_article().sensitivities if one.number == factor.number)
    assert factor.as_published(rv40e) / ARCMIN == pytest.approx(printed.arcmin_per_mm, abs=FOUR_DECIMALS)


def test_the_nine_numbers(rv40e):
    found = sorted({round(one.as_published(rv40e) / ARCMIN, 4) for one in FACTORS if one.as_published is not None})
    assert found == [0.7660, 1.1198, 33.9028, 46.0867, 55.0921, 67.8057, 95.4930, 110.1842, 135.6113]


def test_printed_weights_are_sensitivities_over_their_sum():
    printed = tooth_profile_article().sensitivities
    assert sum(one.arcmin_per_mm for one in printed) == pytest.approx(911.88, abs=0.005)
    shares = weights(tuple(one.arcmin_per_mm for one in printed))
    assert shares == pytest.approx([one.weight for one in printed], abs=FOUR_DECIMALS)


def test_corrected_numbers(rv40e):
    # Radius of the sun, 9 mm, and the root of 1 − K1²: hand calculation from the lengths above, k = 3437.747′.
    k = 10800.0 / math.pi
    found = [one.corrected(rv40e) / ARCMIN for one in FACTORS]
    assert found[0] == pytest.approx(k / (121 * 9) / math.cos(math.radians(20)))
    assert found[:3] == pytest.approx([3.3594, 2.2980, 2.2980], abs=FOUR_DECIMALS)
    assert [found[i] for i in (3, 10, 14)] == pytest.approx([79.0561] * 3, abs=FOUR_DECIMALS)
    assert found[11] == 0.0
    assert sum(found) == pytest.approx(1014.435, abs=0.0005)


def test_eccentricity_has_no_published_formula(rows):
    assert rows[12].as_published is None
    assert rows[12].printed / ARCMIN == pytest.approx(1.6544)


def test_factors_are_those_of_the_article():
    assert [one.number for one in FACTORS] == [one.number for one in tooth_profile_article().sensitivities]
    assert tooth_profile_article().drive == "rv40e"
    assert drive_of(catalog_drive("rv40e")).trochoid == Trochoid(40, 64.0, 1.3)


# From geometry, each compared with another way.


@pytest.mark.parametrize("number", [4, 5, 6, 10, 11, 14, 15])
def test_exact_contact_agrees_with_first_order(number, rows):
    # A pin up to half a pitch, 4.5°, from ψ0 has up to 0.7 % less lever; none has more.
    row = rows[number]
    assert row.geometry.least == pytest.approx(row.corrected, rel=5e-4)
    assert row.corrected * (1 - 1e-5) < row.geometry.mean < row.geometry.greatest < 1.01 * row.corrected
    assert row.geometry.one_disc == pytest.approx(row.geometry.mean, rel=1e-3)


def test_crank_held_backlash_is_that_of_the_rig(setup, rv40e):
    # The rig turns the whole stage with its input held: Eq. 33.
    reducer = EquidistantError(2.0).apply(as_drawn(setup.case))
    on_rig = backlash_map(reducer, 41).value
    factor = (rv40e.trochoid.lobes + crank_turn_per_carrier_turn(rv40e)) / rv40e.trochoid.lobes
    np.testing.assert_allclose(on_rig * factor, setup.backlash(reducer)[0], rtol=2e-4)


@pytest.mark.parametrize("body", ["rigid", "elastic"])
def test_play_of_the_sun_reaches_the_output_over_the_ratio(body):
    spec = catalog_drive("rv40e").replace("load.disc_body", body)
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    # Kinematics: 1/121. A light torque leaves 4e-5 of the wind-up that changes with the crank angle.
    assert output_per_sun_play(case) == pytest.approx(1.0 / drive.reduction_ratio, rel=1e-4)


def test_first_stage_agrees_with_kinematics(rows):
    for number in (1, 2):
        assert rows[number].geometry.mean == pytest.approx(rows[number].corrected, rel=4e-4)
    offset = rows[3].geometry
    assert (offset.least, offset.greatest) == pytest.approx((-rows[3].corrected, rows[3].corrected), rel=4e-4)
    assert abs(offset.mean) < 1e-3 * rows[3].corrected


def test_involute_play_of_the_centre_distance_is_linear_at_first():
    pair = InvolutePair(InvoluteStage(12, 36, 1.5))
    wider = np.array([0.4, 0.2, 0.1, 0.05])
    linear = 2.0 * wider * math.tan(PRESSURE_ANGLE) / pair.sun_radius
    errors = np.abs([pair.play_of_centre_distance(float(w)) for w in wider] - linear)
    assert np.polyfit(np.log(wider), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


def test_bearing_play_tends_to_diametral_clearance_over_the_crank_circle(rows):
    # 0.1 % of the torque still leaves 0.5 % of yielding where the play presses fewer bearings.
    assert rows[13].geometry.mean == pytest.approx(rows[13].corrected, rel=1e-2)
    assert rows[13].corrected / ARCMIN == pytest.approx(95.4930, abs=FOUR_DECIMALS)


def test_two_cranks_let_a_disc_shift_as_well(rv40e):
    # Along the line between the cranks a disc is free to first order. Play c taken up by a turn x and a shift d with
    # (r_c x)² + d² = c² turns it by x + d/(a z_c) where d is square to the crank, c/r_c where it is along it.
    two = replace(rv40e, support=replace(rv40e.support, count=2))
    found, r_c, lever = bearing_play(DifferenceSetup(of(two))), 36.0, rv40e.trochoid.longest_lever
    assert found.least == pytest.approx(1.0 / r_c, rel=2e-2)
    assert found.greatest == pytest.approx(math.hypot(1.0 / r_c, 1.0 / lever), rel=2e-2)


def test_eccentricity_has_no_first_order_effect(rows, setup):
    # Half the printed 1.6544 would show; what is left are pins next to ψ0, whose mean over a mesh cycle is small.
    assert abs(rows[12].geometry.mean) < 0.15 * rows[12].printed
    more, less = (setup.backlash(larger_eccentrics(setup.case, s * UM)) for s in (1.0, -1.0))
    assert np.mean(more[0]) < np.mean(setup.nominal_backlash[0])
    assert np.mean(less[0]) < np.mean(setup.nominal_backlash[0])


@pytest.mark.parametrize("number", [7, 8, 9])
def test_what_differs_from_place_to_place_lowers_the_mean_backlash(number, rows):
    row = rows[number]
    assert row.geometry.mean < 0.0 < row.as_published
    assert row.geometry.greatest < row.as_published


@pytest.mark.parametrize("effect", [DiscRunout, CumulativePitchError])
def test_on_one_disc_what_comes_round_has_a_mean_of_second_order(effect, setup):
    amplitudes = np.array([0.5, 1.0, 2.0])
    slopes = [one_sided(by_effect(effect))(replace(setup, step=a * UM, poses=23)).one_disc for a in amplitudes]
    assert np.polyfit(np.log(amplitudes), np.log(-np.array(slopes)), 1)[0] == pytest.approx(1.0, abs=0.25)


def test_scatter_of_pins_by_patterns_of_the_gaps(setup):
    """To first order a pin shift adds its part along the normal to the gap, and the nearest pin stops the disc."""
    drive, case = setup.case.drive, setup.case
    few = replace(setup, poses=7)
    meshing = mesh(drive.trochoid, few.crank_angle, drive.discs)
    shift = UM * np.random.default_rng(3).standard_normal(40) * 1j * np.exp(2j * np.pi * np.arange(40) / 40)
    turned = []
    for way in (1.0, -1.0):
        start = 0.4 * way * ARCMIN  # near the touch, where levers are those of the touching pins
        seen = gaps(case.profile, drive.pin_radius, meshing, rotation=np.full((7, 2), start))
        reach = np.where(way * seen.lever > 10.0, (seen.gap + (np.conj(seen.normal) * shift).real), np.inf)
        turned.append(start + way * np.min(reach / np.abs(seen.lever), axis=(1, 2)))
    exact = few.backlash(replace(as_drawn(case), pin_shift=shift))[0]
    np.testing.assert_allclose(turned[0] - turned[1], exact, atol=2e-3 * ARCMIN)


def test_more_scatter_of_the_pins_lowers_the_backlash_more(setup):
    few = replace(setup, poses=7)
    slopes = [scattered_pins(replace(few, step=s * UM), 8).mean * s for s in (0.5, 2.0)]
    assert 0.0 > slopes[0] > slopes[1]


# Every drive.


@st.composite
def cases(draw):
    """Drives with a pin exactly at ψ0 on either flank at crank angle 0, so that first order is met."""
    pins = draw(st.integers(12, 60))
    steps = draw(st.integers(math.ceil(0.15 * pins / 2), math.floor(0.42 * pins / 2)))
    r_p = draw(st.floats(20.0, 200.0))
    trochoid = Trochoid(pins, r_p, math.cos(2.0 * math.pi * steps / pins) * r_p / pins)
    limit = min(undercut_limit(trochoid), r_p * math.sin(math.pi / pins))
    drive = Drive(trochoid, draw(st.floats(0.2, 0.8)) * limit, 10.0, 1, CentralEccentric(1e5))
    return of(drive, 1e-5 * r_p)


@settings(max_examples=12)
@given(cases())
def test_geometry_meets_the_formulas_on_any_drive(case):
    # Amounts of 1e-5 of the size: what is left is the second order of gaps next to ψ0.
    setup = DifferenceSetup(case, step=1e-6 * case.drive.trochoid.pin_circle_radius, poses=1)
    for number, factor in ((10, formulas.pin_radius), (11, formulas.pin_circle)):
        found = FACTORS[number - 1].method(setup).mean
        assert found == pytest.approx(factor(case.drive), rel=2e-3)


@settings(max_examples=8)
@given(cases(), st.floats(0.2, 5.0))
def test_sensitivities_fall_as_the_drive_grows(case, size):
    """Per mm of an error, a drive ``size`` times as large answers 1/size times as much."""
    drive = case.drive
    path = Trochoid(drive.trochoid.pins, size * drive.trochoid.pin_circle_radius, size * drive.trochoid.eccentricity)
    larger = replace(case, drive=replace(drive, trochoid=path, pin_radius=size * drive.pin_radius))
    larger = replace(larger, profile=of(larger.drive, size * 1e-5 * drive.trochoid.pin_circle_radius).profile)
    for factor in FACTORS[3:12]:
        assert factor.corrected(larger.drive) == pytest.approx(factor.corrected(drive) / size)
    step = 1e-6 * drive.trochoid.pin_circle_radius
    small, big = (
        one_sided(by_effect(DiscRunout))(DifferenceSetup(one, step=s, poses=3)).mean
        for one, s in ((case, step), (larger, size * step))
    )
    assert big == pytest.approx(small / size, rel=1e-6, abs=1e-9 / drive.trochoid.pin_circle_radius)


@given(st.integers(10, 80), st.floats(20.0, 200.0), st.floats(0.2, 0.9), st.floats(0.3, 0.95))
def test_formulas_scale_with_eccentricity_lobes_and_pin_circle(pins, r_p, K1, share):
    a = K1 * r_p / pins
    drives = [
        Drive(Trochoid(pins, r, e), 0.1, 10.0, 1, CentralEccentric(1e5))
        for r, e in ((r_p, a), (r_p, share * a), (r_p / share, a))
    ]
    first, slower, wider = drives
    assert formulas.pin_radius(slower) == pytest.approx(formulas.pin_radius(first) / share)
    assert formulas.pin_radius(wider) == formulas.pin_radius(first)
    # Less K1, by a smaller eccentricity or a larger circle: the normal at ψ0 is more radial and less tangential.
    for less in (slower, wider):
        ratio = formulas.pin_circle(less) / formulas.pin_radius(less)
        assert ratio == pytest.approx(math.sqrt(1 - (share * K1) ** 2))
        assert formulas.pin_position(less) / formulas.pin_radius(less) == pytest.approx(share * K1)


# Drives that lack a part.


def small(case: LoadCase) -> dict[int, BacklashSensitivity]:
    return {row.factor.number: row for row in sensitivities(case, DifferenceSetup(case, poses=7))}


def test_a_central_eccentric_has_neither_first_stage_nor_crank_bearings():
    spec = catalog_drive("printed_11")
    drive = drive_of(spec)
    found = small(load_case(spec, drive, conventional_profile(spec, drive)))
    absent = {number for number, row in found.items() if row.geometry is None}
    assert absent == {1, 2, 3, 13}
    for number in absent:
        row = found[number]
        assert (row.as_published, row.corrected) == (None, None)
        assert row.why.startswith("absent")
    assert sum(share for share in weights(tuple(row.corrected for row in found.values())) if share) == pytest.approx(1)


def test_a_tooth_without_clearance_is_measured_where_an_error_opens_it(rv40e):
    found = small(of(rv40e, 0.0))
    for number in (4, 5, 6, 10, 11, 14, 15):
        assert found[number].geometry.mean == pytest.approx(found[number].corrected, rel=1e-2)
    unmeasured = {number for number, row in found.items() if row.geometry is None}
    assert 12 in unmeasured <= {7, 8, 9, 12}
    assert all("binds" in found[number].why for number in unmeasured)


def test_cranks_without_a_first_stage_keep_their_bearings(rv40e):
    found = small(of(replace(rv40e, first_stage=None)))
    assert {number for number, row in found.items() if row.geometry is None} == {1, 2, 3}
    assert found[1].why == RequiredPart.FIRST_STAGE.value


def test_a_single_disc_is_its_own_reducer(rv40e):
    slope = one_sided(by_effect(DiscRunout))(DifferenceSetup(of(replace(rv40e, discs=1)), poses=11))
    assert slope.one_disc == slope.mean


def test_the_first_stage_does_not_matter_to_the_bearings(rv40e):
    with_stage, without = (
        bearing_play(DifferenceSetup(of(drive), poses=7)).mean for drive in (rv40e, replace(rv40e, first_stage=None))
    )
    assert with_stage == without


def test_amounts_of_the_set_up_and_errors_of_it_are_the_same_geometry(setup):
    few = replace(setup, poses=5)
    by_setup = FACTORS[14].method(few).mean
    by_error = FACTORS[10].method(few).mean
    assert by_setup == pytest.approx(by_error, rel=1e-12)


def test_more_of_an_error_is_the_same_slope(setup):
    one, two = (one_sided(by_effect(EquidistantError))(replace(setup, step=s * UM, poses=5)).mean for s in (1, 2))
    assert one == pytest.approx(two, rel=1e-3)
