"""Reading errors are isolated; features are wider than the row spacing."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.diagnosis import diagnose
from cycloid_profile.diagnosis.data import _reading_errors as errors
from cycloid_profile.diagnosis.data._reading_errors import errors_of_turn, gross_errors, reading_step
from cycloid_profile.diagnosis.data.noise import estimate_noise, local_noise
from cycloid_profile.geometry import Trochoid
from cycloid_profile.measurement import parse_measurement
from tests.diagnosis.blind import Hidden, Noise, Reducer, scan
from tests.diagnosis.test_bad_files import reducer

SIGMA = 0.3
ROWS = 5000


def noise(seed: int = 1) -> np.ndarray:
    return SIGMA * np.random.default_rng(seed).standard_normal(ROWS)


@given(st.integers(10, ROWS - 10), st.sampled_from([-1.0, 1.0]), st.floats(10.0, 1e4))
def test_one_outlier_is_omitted(row, sign, sigmas):
    residual = np.zeros(ROWS)
    residual[row] = sign * sigmas * SIGMA
    assert np.flatnonzero(gross_errors(residual, SIGMA)).tolist() == [row]


@given(st.integers(10, ROWS - 10), st.sampled_from([-1.0, 1.0]), st.floats(10.0, 1e4), st.floats(5.0, 1e4))
def test_two_rows_displaced_to_one_side_are_a_feature(row, sign, sigmas, neighbour):
    residual = np.zeros(ROWS)
    residual[row : row + 2] = sign * sigmas * SIGMA, sign * neighbour * SIGMA
    assert not np.any(gross_errors(residual, SIGMA))


@given(st.integers(10, ROWS - 10), st.floats(10.0, 1e4), st.floats(10.0, 1e4))
def test_two_rows_displaced_to_opposite_sides_are_errors(row, sigmas, neighbour):
    residual = np.zeros(ROWS)
    residual[row : row + 2] = sigmas * SIGMA, -neighbour * SIGMA
    assert np.flatnonzero(gross_errors(residual, SIGMA)).tolist() == [row, row + 1]


@pytest.mark.parametrize("seed", range(5))
def test_where_some_errors_are_gross_smaller_ones_are_omitted_too(seed):
    """Of errors about 10 standard deviations some are near 5: left over, one was reported as an unknown effect."""
    draw = np.random.default_rng(seed)
    rows = np.arange(100, ROWS - 100, 200)
    residual = noise(seed)
    residual[rows] += SIGMA * draw.choice([-1.0, 1.0], rows.size) * draw.uniform(6.5, 12.0, rows.size)
    found = np.flatnonzero(gross_errors(residual, SIGMA))
    assert np.isin(rows, found).mean() > 0.9
    assert found.size - np.isin(found, rows).sum() <= 2
    # Noise alone has none, nor one of six deviations with no gross one.
    residual = noise(seed)
    residual[1000] = 6.0 * SIGMA
    assert not np.any(gross_errors(residual, SIGMA))


def test_an_error_near_two_larger_ones_is_omitted():
    # The larger two tilt two of the five slopes across the row of the first: the median of five does not follow them.
    residual = np.zeros(ROWS)
    residual[[100, 102, 104]] = 10.0 * SIGMA, 1000.0 * SIGMA, 1000.0 * SIGMA
    assert np.flatnonzero(gross_errors(residual, SIGMA)).tolist() == [100, 102, 104]


def test_five_errors_among_eleven_rows_are_omitted():
    # Six of the eleven are right: a majority.
    residual = np.zeros(ROWS)
    residual[100:110:2] = 10.0 * SIGMA
    assert np.flatnonzero(gross_errors(residual, SIGMA)).tolist() == [100, 102, 104, 106, 108]


@pytest.mark.parametrize(("sigmas", "feature"), [(3.09, False), (3.17, True)])
def test_a_displaced_neighbour_makes_a_feature_at_three_in_a_thousand(sigmas, feature):
    # Three tests of the neighbours, 3·Φ(−3.13) = 0.0026, and a second error on either side, 2/5000.
    residual = np.zeros(ROWS)
    residual[2000:2002] = 20.0 * SIGMA, sigmas * SIGMA
    assert np.any(gross_errors(residual, SIGMA)) != feature


def test_among_many_reading_errors_two_come_together_by_chance():
    residual = np.zeros(ROWS)
    residual[50::100] = 20.0 * SIGMA
    residual[51] = 20.0 * SIGMA
    assert np.count_nonzero(gross_errors(residual, SIGMA)) == 51


def test_a_reading_error_is_rarely_taken_for_a_feature():
    """The target is 3 in 1000: at most four of 400."""
    draw, kept = np.random.default_rng(2), 0
    for seed in range(400):
        residual, row = noise(seed), int(draw.integers(10, ROWS - 10))
        residual[row] += 5.0 * draw.choice([-1.0, 1.0])
        kept += not gross_errors(residual, SIGMA)[row]
    assert kept <= 5


@pytest.mark.slow
@pytest.mark.parametrize(("width", "verdict"), [(0.08, "unknown_effect"), (0.02, "agrees")])
def test_a_pit_of_two_points_is_a_feature_of_one_point_an_error(width, verdict):
    """39 lobes with 5,000 points: one every 0.05 rad."""
    pit = Hidden("x_pit", {"depth_um": 6.0, "psi_rad": 1.16, "width_rad": width, "lobe": 27, "disc": 1})
    text = scan(Reducer(), (pit,), points=ROWS, noise=Noise(SIGMA), seed=4)
    found = diagnose(reducer(), [parse_measurement(text, "scan.csv")])
    assert found.verdict == verdict


def test_one_step_of_a_coarse_instrument_is_no_reading_error():
    # Steps of four standard deviations: most rows read the same, some the next value, and five are hit.
    draws = np.random.default_rng(4)
    read = SIGMA * 4.0 * np.round(draws.normal(0.0, 0.25, size=1200))
    hit = np.arange(100, 1200, 240)
    read[hit] += 10.0 * 4.0 * SIGMA
    assert np.flatnonzero(gross_errors(read, SIGMA, reading_step(read))).tolist() == hit.tolist()
    assert np.count_nonzero(np.abs(read) > 0.0) > 2 * hit.size


@pytest.mark.parametrize("steps", [0.0, 1.0])
def test_a_neighbour_one_step_away_makes_no_feature(steps):
    read = SIGMA * 4.0 * np.round(np.random.default_rng(4).normal(0.0, 0.25, size=1200))
    read[599:602] = np.array([0.0, 10.0, steps]) * 4.0 * SIGMA
    assert np.flatnonzero(gross_errors(read, SIGMA, reading_step(read))).tolist() == [600]


def test_a_single_far_value_is_no_reading_step():
    read = np.zeros(1200)
    read[600] = 50.0
    assert reading_step(read) == 0.0
    assert np.flatnonzero(gross_errors(read, SIGMA, reading_step(read))).tolist() == [600]
    # Values that were computed differ by rounding.
    computed = np.tile([0.1 + 0.2 - 0.3, 0.0, 0.5], 40)
    assert reading_step(computed) == pytest.approx(0.5)


def test_the_reading_step_of_a_fine_instrument_is_far_below_its_noise():
    assert reading_step(np.random.default_rng(1).normal(size=2000)) < 1e-3
    assert reading_step(np.zeros(30)) == 0.0


ELEVEN_LOBES = Trochoid(pins=12, pin_circle_radius=60.0, eccentricity=2.5)


def turn_with_corners(seed: int, errors: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Ten rows for each of 132 arches of the mesh, eleven times the noise high, with errors in some rows."""
    draw = np.random.default_rng(seed)
    angle = np.arange(1355) * 2.0 * np.pi / 1355
    residual = SIGMA * (11.0 + draw.random()) * np.abs(np.sin(66.0 * angle)) + SIGMA * draw.standard_normal(angle.size)
    hit = draw.choice(np.arange(10, angle.size - 10), errors, replace=False)
    residual[hit] += SIGMA * draw.choice([-1.0, 1.0], errors) * draw.uniform(8.0, 14.0, errors)
    return angle, residual, hit


def test_corners_that_repeat_with_the_mesh_are_no_reading_errors():
    """Omitted as errors, they tore the turn into short runs, whose noise came out two and a half times too large."""
    taken, sigma = 0, []
    for seed in range(4):
        angle, residual, _ = turn_with_corners(seed, 0)
        taken += int(np.sum(gross_errors(residual, local_noise(residual, np.arange(residual.size)).sigma)))
        omitted, filled = errors_of_turn(residual, angle, ELEVEN_LOBES)
        assert not np.any(omitted)
        sigma.append(estimate_noise(filled, np.arange(residual.size)).sigma)
    assert taken > 0  # the single rows alone do not show it
    assert np.mean(sigma) == pytest.approx(SIGMA, rel=0.05)


@pytest.mark.parametrize("seed", range(2))
def test_reading_errors_between_corners_are_found_and_filled(seed):
    angle, residual, hit = turn_with_corners(seed, 7)
    omitted, filled = errors_of_turn(residual, angle, ELEVEN_LOBES)
    assert np.flatnonzero(omitted).tolist() == sorted(hit.tolist())
    clean = turn_with_corners(seed, 0)[1]
    assert np.std((filled - clean)[omitted]) < 3.0 * SIGMA
    np.testing.assert_allclose(filled[~omitted], residual[~omitted], rtol=0.0, atol=1e-9)
    assert estimate_noise(filled, np.arange(residual.size)).sigma == pytest.approx(SIGMA, rel=0.12)


@pytest.mark.parametrize("seed", range(2))
def test_narrow_peaks_at_every_pin_are_no_reading_errors(seed):
    # Without the rows first taken for errors the waves are too low: they need some rounds.
    trochoid = Trochoid(pins=40, pin_circle_radius=120.0, eccentricity=1.5)
    angle = np.arange(719) * 2.0 * np.pi / 719
    off = np.mod(40.0 * angle + np.pi, 2.0 * np.pi) - np.pi
    residual = SIGMA * (25.0 * np.exp(-0.5 * (off / 0.2) ** 2) + np.random.default_rng(seed).normal(size=719))
    assert np.any(gross_errors(residual, local_noise(residual, np.arange(719)).sigma))
    assert not np.any(errors_of_turn(residual, angle, trochoid)[0])


def test_a_wave_that_rows_show_as_several_orders_is_found():
    # 720 rows show the first multiple of 39 · 40 as order 120, three times the pins.
    trochoid = Trochoid(pins=40, pin_circle_radius=120.0, eccentricity=1.5)
    angle = np.arange(720) * 2.0 * np.pi / 720
    residual = noise()[:720] + 0.8 * SIGMA * np.cos(120.0 * angle)
    waves = errors._mesh_waves(angle, trochoid)
    ripple = errors._ripple(residual, waves, np.ones(720, dtype=bool))
    assert np.std(ripple) == pytest.approx(0.8 * SIGMA / np.sqrt(2.0), rel=0.2)


def test_few_rows_of_a_turn_show_no_ripple():
    residual = noise()[:60]
    residual[30] = 20.0 * SIGMA
    omitted, filled = errors_of_turn(residual, np.arange(60) * 2.0 * np.pi / 60, ELEVEN_LOBES)
    assert np.flatnonzero(omitted).tolist() == [30]
    assert filled[30] == pytest.approx(0.5 * (residual[29] + residual[31]))
