"""The three-part lost-motion budget of [LM]: printed numbers, what follows from them, and what its formulas give.

Source: the article on the geometric lost motion of high-precision RV reducers, its three parts 1.76 ± 2.05, 0.63 ± 0.38
and 0.136 ± 0.082 [′], ratio 100, total "0.52 to 1.3", table of parameters. Symbols: Δφ̄ mean, T tolerance, T/2 half
band; d_1 = 50 mm diameter of the sun; e short-width ratio K1; aζ longest lever a z_c.
Tolerance: the parts are printed to two or three digits; what is computed from them is exact arithmetic, so half of the
last digit quoted. Hand calculations are written out next to the numbers.
"""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.articles import (
    TABLE,
    TEXT,
    Budget,
    BudgetPart,
    DifferenceSetup,
    budget_from_geometry,
    printed_errors,
)
from cycloid_profile.articles.lost_motion_budget import (
    PartErrors,
    confidence_of_mean,
    cycloid_stage,
    cycloid_stage_as_published,
    eccentric_bearing,
    involute_stage,
    involute_stage_as_published,
    single_reducer_deviation,
)
from cycloid_profile.catalog import catalog_drive, lost_motion_article
from cycloid_profile.contact import LoadCase
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.geometry import Cranks, Drive, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.units import ARCMIN, UM

READINGS = [(TEXT, 0.389, 0.394, 1.173), (TABLE, 0.195, 0.589, 0.978)]
NO_ERRORS = PartErrors(
    normal_length_upper_um=0.0, normal_length_lower_um=0.0, centre_distance_um=0.0, gear_runout_um=0.0,
    pin_um=0.0, disc_um=0.0, bearing_um=0.0,
)  # fmt: skip


@pytest.fixture(scope="module")
def geometry(rv40e: Drive) -> Budget:
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(6.0 * UM)), 412e3)
    return budget_from_geometry(case, setup=DifferenceSetup(case, poses=41))


def in_arcmin(*angles: float) -> list[float]:
    return [angle / ARCMIN for angle in angles]


# Published numbers.


@pytest.mark.parametrize(("reading", "half", "low", "high"), READINGS)
def test_total_of_the_printed_parts(reading, half, low, high):
    # 1.76/100 + 0.63 + 0.136 and √((2.05/100)² + 0.38² + 0.082²), once and by half.
    total = reading.of(lost_motion_article()).total
    assert in_arcmin(total.mean, total.half_band, *total.range) == pytest.approx([0.784, half, low, high], abs=5e-4)


@pytest.mark.parametrize("reading", [TEXT, TABLE])
def test_no_reading_gives_the_printed_total(reading):
    printed = lost_motion_article().total
    found = reading.of(lost_motion_article()).total
    assert abs(found.mean / ARCMIN - printed.mean_arcmin) > 0.25
    assert abs(found.range[0] / ARCMIN - printed.low_arcmin) > 0.05
    assert abs(found.range[1] / ARCMIN - printed.high_arcmin) > 0.1


@pytest.mark.parametrize("reading", [TEXT, TABLE])
def test_the_involute_stage_is_the_smallest_part(reading):
    involute, cycloid, bearing = reading.of(lost_motion_article()).at_output
    assert involute.mean / ARCMIN == pytest.approx(0.0176)
    assert involute.mean < bearing.mean < cycloid.mean
    assert involute.tolerance < bearing.tolerance < cycloid.tolerance


def test_text_and_table_differ_by_two_on_every_tolerance():
    text, table = (one.of(lost_motion_article()) for one in (TEXT, TABLE))
    for a, b in zip((*text.at_output, text.total), (*table.at_output, table.total), strict=True):
        assert a.tolerance == pytest.approx(2.0 * b.tolerance)
        assert a.mean == b.mean


def test_involute_stage_on_the_printed_parameters():
    # σ of 7.09, 2.43 and 1.82 µm on 50 mm: 6·√(7.09² + 2.43² + 1.82²)·2/50 mm = 6.37′; printed D: √(7.09²)/50 = 0.488′.
    part, printed = (of(printed_errors(), 50.0) for of in (involute_stage, involute_stage_as_published))
    assert in_arcmin(part.tolerance, printed.tolerance) == pytest.approx([6.366, 0.488], abs=5e-4)
    assert part.mean == printed.mean == 0.0


def test_printed_variances_are_no_squares_of_lengths():
    """In another unit of length the printed T is another angle, D(j2) and D(j3) being mm⁴; the corrected T is not."""
    errors, inch = replace(printed_errors(), centre_distance_um=1000.0, gear_runout_um=1500.0), 25.4
    per_inch = PartErrors(
        **{name: getattr(errors, name) / inch for name in errors.__dataclass_fields__}  # as if µm were micro-inches
    )
    assert involute_stage(per_inch, 50.0 / inch).tolerance == pytest.approx(involute_stage(errors, 50.0).tolerance)
    printed = [involute_stage_as_published(one, d).tolerance for one, d in ((errors, 50.0), (per_inch, 50.0 / inch))]
    assert printed[1] < 0.9 * printed[0]


def test_root_under_the_profile_error_multiplies(rv40e):
    # RV-40E, 2k/50.7 = 135.6113 ′/mm: times √(1 − 0.8125²) = 79.0561, divided by it 232.625.
    right, printed = (of(rv40e, NO_ERRORS, disc=1.0).mean for of in (cycloid_stage, cycloid_stage_as_published))
    assert in_arcmin(right, printed) == pytest.approx([79.0561, 232.625], abs=5e-4)
    assert printed / right == pytest.approx(1.0 / (1.0 - 0.8125**2))


def test_tolerance_of_the_pins_has_the_factor_of_their_mean(rv40e):
    only_pins = replace(NO_ERRORS, pin_um=5.0)
    right, printed = (of(rv40e, only_pins, pin=5.0 * UM) for of in (cycloid_stage, cycloid_stage_as_published))
    assert right.half_band == pytest.approx(right.mean)
    assert printed.half_band == pytest.approx(0.5 * printed.mean)


def test_bearing_on_the_crank_circle(rv40e):
    # 0.136′ is 1.42 µm on 36 mm, as a diametral clearance.
    part = eccentric_bearing(rv40e, NO_ERRORS, radial_play=0.5 * 1.424 * UM)
    assert part.mean / ARCMIN == pytest.approx(0.136, abs=5e-4)
    assert eccentric_bearing(rv40e, NO_ERRORS, radial_play=1.0, factor=4.0).mean == pytest.approx(2.0 / 36.0 / 4.0)


def test_the_printed_monte_carlo_is_the_confidence_of_a_mean():
    # 0.0036·√500/1.96 = 0.0411′, ±3 σ = ±0.123′; the budget's own would be ±0.0114′ or ±0.0057′.
    given_ = lost_motion_article().monte_carlo
    assert 3 * single_reducer_deviation(given_.plus_minus_arcmin, given_.runs) == pytest.approx(0.123, abs=5e-4)
    own = [confidence_of_mean(one.of(lost_motion_article()).total, given_.runs) for one in (TEXT, TABLE)]
    assert in_arcmin(*own) == pytest.approx([0.0114, 0.0057], abs=5e-5)
    assert min(own) > given_.plus_minus_arcmin * ARCMIN


def test_confidence_and_scatter_undo_each_other():
    part = BudgetPart(0.0, 0.3)
    assert 6.0 * single_reducer_deviation(confidence_of_mean(part, 77), 77) == pytest.approx(part.tolerance)


# From geometry.


def test_involute_stage_from_geometry_is_the_corrected_formula(geometry):
    # Sun of 18 mm; exact involutes and the stage model against first order: 4e-4.
    assert geometry.involute.tolerance == pytest.approx(involute_stage(printed_errors(), 18.0).tolerance, rel=4e-4)
    assert geometry.involute.mean == 0.0
    assert geometry.ratio == 121.0


def test_cycloid_stage_from_geometry_has_the_exact_backlash(geometry, rv40e):
    # 2·6 µm/50.7 mm = 0.8137′; pins next to ψ0 have up to 0.3 % less lever.
    by_formula = cycloid_stage(rv40e, printed_errors(), pin=6.0 * UM)
    assert 1.0 < geometry.cycloid.mean / by_formula.mean < 1.003
    assert 1.0 < geometry.cycloid.tolerance / by_formula.tolerance < 1.005


def test_bearing_from_geometry_is_that_of_the_stage_model(geometry, rv40e):
    by_formula = eccentric_bearing(rv40e, printed_errors())
    assert geometry.bearing.tolerance == pytest.approx(by_formula.tolerance, rel=1e-2)
    assert geometry.bearing.mean == 0.0


def test_play_of_the_drawing_is_the_mean(rv40e):
    played = replace(rv40e, support=replace(rv40e.support, bearing_play=2.0 * UM))
    case = LoadCase(played, modify(rv40e.theoretical_profile, Equidistant(6.0 * UM)), 412e3)
    part = budget_from_geometry(case, setup=DifferenceSetup(case, poses=7)).bearing
    assert part.mean == pytest.approx(2.0 * 2.0 * UM / 36.0, rel=2e-2)


def test_thinner_teeth_give_play(rv40e):
    thinner = replace(NO_ERRORS, normal_length_upper_um=-10.0, normal_length_lower_um=-30.0)
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(6.0 * UM)), 412e3)
    found = budget_from_geometry(case, thinner, DifferenceSetup(case, poses=7)).involute
    assert found.mean == pytest.approx(20.0 * UM / math.cos(math.radians(20.0)) / 9.0, rel=4e-4)
    assert (found.mean, found.tolerance) == pytest.approx(
        (involute_stage(thinner, 18.0).mean, involute_stage(thinner, 18.0).tolerance), rel=4e-4
    )


def test_a_central_eccentric_has_one_part():
    spec = catalog_drive("printed_11")
    drive = drive_of(spec)
    case = load_case(spec, drive, conventional_profile(spec, drive))
    budget = budget_from_geometry(case, setup=DifferenceSetup(case, poses=7))
    assert budget.involute is None
    assert budget.bearing is None
    assert budget.total == budget.cycloid
    assert eccentric_bearing(drive, printed_errors()) is None


# Every budget.

angles = st.floats(1e-6, 1e-2)
parts = st.builds(BudgetPart, angles, angles)


@given(parts, parts, parts, st.floats(1.0, 300.0))
def test_means_add_and_bands_add_by_squares(involute, cycloid, bearing, ratio):
    budget = Budget(involute, cycloid, bearing, ratio)
    total, seen = budget.total, budget.at_output
    assert total.mean == pytest.approx(sum(part.mean for part in seen))
    assert max(part.tolerance for part in seen) <= total.tolerance * (1 + 1e-12)
    assert total.tolerance < sum(part.tolerance for part in seen)
    assert Budget(None, cycloid, bearing, ratio).total.tolerance < total.tolerance


@given(st.floats(0.1, 10.0), st.floats(5.0, 100.0))
def test_the_involute_stage_scales_with_errors_and_inversely_with_the_sun(factor, diameter):
    errors = replace(printed_errors(), normal_length_upper_um=-3.0)
    scaled = PartErrors(**{name: factor * getattr(errors, name) for name in errors.__dataclass_fields__})
    part, larger = involute_stage(errors, diameter), involute_stage(scaled, diameter)
    assert (larger.mean, larger.tolerance) == pytest.approx((factor * part.mean, factor * part.tolerance))
    wider = involute_stage(errors, factor * diameter)
    assert (wider.mean, wider.tolerance) == pytest.approx((part.mean / factor, part.tolerance / factor))
    assert part.mean > 0.0


@given(st.integers(10, 80), st.floats(20.0, 200.0), st.floats(0.2, 0.9), st.floats(0.2, 5.0))
def test_cycloid_and_bearing_scale_inversely_with_the_drive(pins, r_p, K1, size):
    drives = [
        Drive(Trochoid(pins, s * r_p, s * K1 * r_p / pins), 0.05 * s, 10.0, 1, Cranks(3, s * 0.5 * r_p, 1e5))
        for s in (1.0, size)
    ]
    errors = printed_errors()
    for of in (lambda d: cycloid_stage(d, errors, pin=1.0, disc=0.5), lambda d: eccentric_bearing(d, errors, 1.0)):
        part, scaled = (of(drive) for drive in drives)
        assert (scaled.mean, scaled.tolerance) == pytest.approx((part.mean / size, part.tolerance / size))
