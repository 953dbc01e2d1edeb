"""Draws: what was asked for is in them, and they depend on seed, chunk and nothing else.

Every statistical bound is said in standard errors of the estimate: 4 of them, and the seed is fixed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from cycloid_profile.tolerance.study import SEQUENCES, Draws, Random, Sobol, Study
from cycloid_profile.tolerance.study.draws import LatinHypercube, batch_normals

COUNT = 4096
PINS = 11
RUNOUT = {"name": "disc_runout", "each": "disc", "amplitude_um": {}}
PIN = {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 3.0}}


def block(draws: Draws, chunk: int = 0, count: int = COUNT, first: int = 0) -> np.ndarray:
    return draws.coordinates(chunk, count, first)


def test_sizes_come_out_as_their_distribution_says(scattered):
    tolerances = scattered(
        {"name": "equidistant_error", "amount_um": {"plus_minus": 3.0, "mean": 1.0}},
        {"name": "radial_moving_error", "amount_um": {"plus_minus": 3.0, "cp": 2.0}},
        {"name": "pin_radius_error", "amount_um": {"plus_minus": 2.0, "distribution": "uniform"}},
        {"name": "generating_eccentricity_error", "amount_um": {"plus_minus": 2.0, "distribution": "triangular"}},
        {"name": "pin_circle_radius_error", "amount_um": {"sigma": 2.0}},
    )
    x = block(Draws(tolerances))
    wanted = (
        stats.norm(1.0, 1.0), stats.norm(0.0, 0.5), stats.uniform(-2.0, 4.0), stats.triang(0.5, -2.0, 4.0),
        stats.norm(0.0, 2.0),
    )  # fmt: skip
    for column, reference in zip(x.T, wanted, strict=True):
        assert stats.kstest(column, reference.cdf).statistic < 1.63 / math.sqrt(COUNT)


@pytest.mark.parametrize("given", [{"plus_minus": 3.0}, {"plus_minus": 3.0, "inspected": True}, {"sigma": 1.0}])
def test_offsets_point_in_any_direction_and_have_their_length(scattered, given):
    tolerances = scattered({"name": "disc_runout", "each": "disc", "amplitude_um": given})
    x = block(Draws(tolerances)).reshape(-1, 2)
    length, angle = np.hypot(*x.T), np.arctan2(x[:, 1], x[:, 0])
    size = tolerances.scatters[0].size
    assert stats.kstest(angle, stats.uniform(-math.pi, 2.0 * math.pi).cdf).statistic < 1.63 / math.sqrt(len(x))
    whole = 1.0 if math.isinf(size.limit) else stats.rayleigh(scale=size.sigma).cdf(size.limit)
    found = stats.kstest(length, lambda v: np.minimum(stats.rayleigh(scale=size.sigma).cdf(v) / whole, 1.0))
    assert found.statistic < 1.63 / math.sqrt(len(x))
    assert np.max(length) <= size.limit


def test_a_direction_that_is_given_is_kept(scattered):
    x = block(Draws(scattered({**RUNOUT, "phase_deg": {"mean": 30.0, "plus_minus": 5.0}}))).reshape(-1, 2)
    angle = np.degrees(np.arctan2(x[:, 1], x[:, 0]))
    assert stats.kstest(angle, stats.uniform(25.0, 10.0).cdf).statistic < 1.63 / math.sqrt(angle.size)
    # A number fixes it: the size alone is left, along that direction either way.
    fixed = scattered({**RUNOUT, "phase_deg": 30.0})
    assert block(Draws(fixed), count=64).shape == (64, 2)
    assert fixed.scatters[0].axes.effect(np.array([2.0]), fixed.scatters[0].choices[1]).phase_deg == 30.0


@pytest.mark.parametrize("value", [-0.9, -0.3, 0.5, 0.95])
def test_correlation_is_achieved_part_by_part(scattered, value):
    tolerances = scattered(
        PIN,
        {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 3.0}, "direction_deg": 0.0},
        correlations=({"between": ["single_pin_error.amount_um", "pin_position_error.amplitude_um"], "value": value},),
    )
    x = block(Draws(tolerances))
    radius, place = x[:, :PINS], x[:, PINS:]
    found = np.corrcoef(radius.T, place.T)
    error = 4.0 * (1.0 - value**2) / math.sqrt(COUNT)
    np.testing.assert_allclose(np.diag(found, PINS), value, rtol=0.0, atol=error)
    # Pins among each other stay strangers, and the widths are what they were.
    strange = np.abs(found[:PINS, PINS:] - np.diag(np.diag(found, PINS)))
    assert np.max(strange) < 4.5 / math.sqrt(COUNT)
    np.testing.assert_allclose(np.std(x[:, :PINS], axis=0), 1.0, rtol=4.0 / math.sqrt(2.0 * COUNT))
    np.testing.assert_allclose(np.std(place, axis=0), 1.0, rtol=4.0 / math.sqrt(2.0 * COUNT))


@pytest.mark.parametrize("over", [0.5, 2.0, 5.0])
def test_neighbours_are_equal_round_the_ring(scattered, over):
    x = block(Draws(scattered({**PIN, "neighbours": over})))
    found = np.corrcoef(x.T)
    apart = np.arange(PINS)
    apart = np.minimum(apart, PINS - apart)
    wanted = np.exp(-apart / over)
    for k in range(1, PINS):
        own = np.mean(np.diag(np.roll(found, -k, axis=1)))
        assert own == pytest.approx(wanted[k], abs=4.5 / math.sqrt(COUNT))
    np.testing.assert_allclose(np.std(x, axis=0), 1.0, rtol=4.5 / math.sqrt(2.0 * COUNT))


def test_neighbours_of_an_offset_are_equal_in_both_components(scattered):
    given = {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 3.0}, "neighbours": 2.0}
    x = block(Draws(scattered(given)))
    for component in (x[:, 0::2], x[:, 1::2]):
        own = np.mean(np.diag(np.roll(np.corrcoef(component.T), -1, axis=1)))
        assert own == pytest.approx(math.exp(-0.5), abs=4.5 / math.sqrt(COUNT))


@pytest.mark.parametrize("share", [0.0, 0.3, 1.0])
def test_batch_share_is_the_variance_between_batches(scattered, share):
    size, batches = 16, 256
    draws = Draws(scattered({**PIN, "batch_share": share}), batch_size=size)
    x = block(draws, count=size * batches).reshape(batches, size, PINS)
    within = np.mean(np.var(x, axis=1, ddof=1), axis=0)
    between = np.var(np.mean(x, axis=1), axis=0, ddof=1) - within / size
    # One-way analysis of variance: the parts add up to the whole.
    error = 5.0 * math.sqrt(2.0 / batches)
    np.testing.assert_allclose(within, 1.0 - share, rtol=0.0, atol=5.0 * math.sqrt(2.0 / (batches * (size - 1))))
    np.testing.assert_allclose(between, share, rtol=0.0, atol=error * (share + 1.0 / size))


def test_a_batch_that_runs_over_two_chunks_is_one_batch(scattered):
    draws = Draws(scattered({**PIN, "batch_share": 1.0}), batch_size=100)
    first, second = block(draws, 0, 64, 0), block(draws, 1, 64, 64)
    np.testing.assert_array_equal(first[0], second[35])
    assert np.all(second[36] != second[35])
    np.testing.assert_array_equal(first[0], batch_normals(draws.seed, 0, PINS))


@pytest.mark.parametrize("name", SEQUENCES)
def test_a_chunk_depends_on_its_number_and_the_seed_alone(scattered, name):
    tolerances = scattered({**PIN, "batch_share": 0.2}, RUNOUT)
    draws = Draws(tolerances, sequence=SEQUENCES[name])
    there = [block(draws, k, 128, 128 * k) for k in range(3)]
    back = [block(Draws(tolerances, sequence=SEQUENCES[name]), k, 128, 128 * k) for k in (2, 1, 0)][::-1]
    for one, other in zip(there, back, strict=True):
        np.testing.assert_array_equal(one, other)
    assert not np.any(there[0] == there[1])
    other_seed = block(replace(draws, seed=2), 0, 128)
    assert not np.any(there[0] == other_seed)


@pytest.mark.parametrize("name", SEQUENCES)
def test_a_longer_study_begins_with_the_same_reducers(small, scattered, name):
    draws = Draws(scattered(PIN, RUNOUT), sequence=SEQUENCES[name])
    short, long = (Study(small, draws, ("backlash_arcmin",), samples, chunk=64) for samples in (150, 1000))
    for k in range(short.chunks):
        ours = short.coordinates(k)
        np.testing.assert_array_equal(ours, long.coordinates(k)[: len(ours)])
    assert short.span(2) == (128, 22)
    assert short.fingerprint == long.fingerprint


@pytest.mark.parametrize("name", ["latin-hypercube", "sobol"])
def test_even_points_leave_means_true_and_steadier(name):
    # A sum of ten sizes, its mean over 64 chunks of 256: unbiased, and far steadier than with random numbers.
    def means(sequence):
        return np.array([np.mean(np.sum(sequence.normals(3, k, 256, 10), axis=1)) for k in range(64)])

    even, plain = means(SEQUENCES[name]), means(Random())
    assert abs(np.mean(even)) < 4.0 * np.std(even) / 8.0
    assert np.var(plain) == pytest.approx(10.0 / 256.0, rel=4.0 * math.sqrt(2.0 / 63.0))
    assert np.var(even) < 0.02 * np.var(plain)


@pytest.mark.parametrize("sequence", [Random(), LatinHypercube(), Sobol()])
def test_every_number_is_standard_normal_and_finite(sequence):
    z = sequence.normals(5, 2, 1024, 7)
    assert z.shape == (1024, 7)
    assert np.all(np.isfinite(z))
    for column in z.T:
        assert stats.kstest(column, stats.norm.cdf).statistic < 1.63 / 32.0


def test_a_hypercube_has_one_point_in_every_row():
    from scipy.special import ndtr

    ranks = np.floor(ndtr(LatinHypercube().normals(1, 0, 50, 4)) * 50.0)
    np.testing.assert_array_equal(np.sort(ranks, axis=0), np.arange(50.0)[:, np.newaxis] + np.zeros(4))


def test_the_beginning_of_a_net_is_that_of_the_whole_net():
    np.testing.assert_array_equal(Sobol().normals(1, 3, 100, 5), Sobol().normals(1, 3, 128, 5)[:100])
    assert Sobol().normals(1, 0, 1, 3).shape == (1, 3)
