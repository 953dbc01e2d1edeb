"""What a tolerance contributes, against closed forms and on the reducer: scattered pins lower the mean backlash."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import as_drawn
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import Limit, tolerances_of
from cycloid_profile.tolerance.ranking import contributions
from cycloid_profile.tolerance.study import Draws, Study

PINS = 40


@pytest.fixture(scope="module")
def drawn(rv40e):
    return as_drawn(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3))


class Formula:
    """Quantities as a formula of the coordinates, in the place of ``QuantityModel``."""

    def __init__(self, names, of) -> None:
        self.names, self.of, self.answers = names, of, (None,)


def study(drawn, tables, formula=None, samples=4096, names=("backlash_arcmin",), **draws):
    found = Study(drawn, Draws(tolerances_of(tables, (), drawn), **draws), ("backlash_arcmin",), samples, 1024)
    if formula is not None:
        found.__dict__["quantity_model"] = Formula(names, formula)
    return found


COMMON = {"name": "pin_radius_error", "amount_um": {"sigma": 1.0, "mean": 5.0}}
RING = {"name": "pin_circle_radius_error", "amount_um": {"sigma": 2.0}}
EACH = {"name": "single_pin_error", "each": "pin", "amount_um": {"sigma": 0.5}}


def test_a_sum_of_two_has_closed_forms(drawn):
    found = contributions(study(drawn, [COMMON, RING], lambda x: np.sum(x, axis=1)[:, np.newaxis]))
    assert found.as_drawn[0].mean.value == pytest.approx(5.0, abs=4.0 * np.sqrt(5.0 / 4096))
    common, ring = found.rows
    for row, own, other in ((common, 1.0, 2.0), (ring, 2.0, 1.0)):
        share = row.variance_share[0]
        assert share.value == pytest.approx(own**2 / 5.0, abs=4.0 * share.error)
        for changed, factor in ((row.halved[0], 0.5), (row.zero[0], 0.0)):
            sigma = np.hypot(factor * own, other) - np.sqrt(5.0)
            for percentile, z in ((changed.percentile_95, 1.6449), (changed.percentile_9973, 2.7822)):
                assert percentile.error > 0.0
                assert percentile.value == pytest.approx(z * sigma, abs=4.0 * percentile.error)
            assert changed.mean.value == pytest.approx(0.0, abs=4.0 * changed.mean.error)
    assert found.yield_as_drawn is None
    assert common.yield_zero is None
    assert [row.label for row in found.ranked()] == ["pin_circle_radius_error", "pin_radius_error"]


def test_the_yield_gained_has_a_closed_form(drawn):
    from scipy.special import ndtr

    made = study(drawn, [COMMON, RING], lambda x: np.sum(x, axis=1)[:, np.newaxis])
    found = contributions(made, [Limit("backlash_arcmin", at_most=8.0)])
    assert found.yield_as_drawn is not None
    before = ndtr(3.0 / np.sqrt(5.0))
    assert found.yield_as_drawn.value == pytest.approx(before, abs=4.0 * found.yield_as_drawn.error)
    for row, halved in zip(found.rows, (np.hypot(0.5, 2.0), np.hypot(1.0, 1.0)), strict=True):
        gained = row.yield_halved
        assert gained is not None
        # Common random numbers: the gain is known far better than two yields apart.
        assert gained.error < np.sqrt(2.0) * found.yield_as_drawn.error
        assert gained.value == pytest.approx(ndtr(3.0 / halved) - before, abs=4.0 * gained.error)
    assert [row.label for row in found.ranked()] == ["pin_circle_radius_error", "pin_radius_error"]


@pytest.mark.slow
def test_standard_errors_are_those_of_repeated_studies(drawn):
    repeated = [
        contributions(study(drawn, [COMMON, RING], lambda x: np.sum(x, axis=1)[:, np.newaxis], 1024, seed=seed), (), 60)
        for seed in range(24)
    ]
    for pick in (
        lambda one: one.rows[1].halved[0].percentile_95,
        lambda one: one.rows[1].variance_share[0],
        lambda one: one.as_drawn[0].mean,
    ):
        between = np.std([pick(one).value for one in repeated], ddof=1)
        stated = np.mean([pick(one).error for one in repeated])
        # 24 repeats know a scatter to 15 %.
        assert stated == pytest.approx(between, rel=0.5)


def test_one_batch_of_reducers_has_the_standard_error_of_independent_ones(drawn):
    # All reducers of the study come from one batch: resampling whole batches would give an error of zero.
    alone, batch = (
        contributions(
            study(drawn, [{**RING, "batch_share": share}], lambda x: x.copy(), 256, batch_size=256), resamples=200
        )
        for share in (0.0, 0.5)
    )
    assert batch.as_drawn[0].mean.error == pytest.approx(2.0 / 16.0, rel=0.25)
    assert batch.as_drawn == alone.as_drawn


def test_a_quantity_of_which_less_is_worse_is_counted_from_below(drawn):
    made = study(drawn, [RING], lambda x: x.copy(), names=("least_backlash_arcmin",))
    figures = contributions(made).as_drawn[0]
    assert figures.percentile_95.value == pytest.approx(-1.6449 * 2.0, abs=4.0 * figures.percentile_95.error)
    assert figures.percentile_9973.value < figures.percentile_95.value


def test_a_reducer_without_an_answer_fails_its_limits(drawn):
    made = study(drawn, [RING], lambda x: np.where(x > 2.0, np.nan, x))
    found = contributions(made, [Limit("backlash_arcmin", at_most=100.0)])
    assert found.yield_as_drawn is not None
    assert found.yield_as_drawn.value == pytest.approx(0.8413, abs=4.0 * found.yield_as_drawn.error)
    assert np.isfinite(found.as_drawn[0].mean.value)
    gained = found.rows[0].yield_zero
    assert gained is not None
    assert gained.value == pytest.approx(1.0 - found.yield_as_drawn.value)


@pytest.mark.slow
def test_scattered_pins_lower_the_mean_backlash(drawn):
    found = contributions(study(drawn, [EACH, {**RING, "amount_um": {"sigma": 1.0}}], samples=1024), resamples=40)
    pins = found.rows[0]
    # The thickest pin stops the turn: pins that are equal again leave more backlash, half as unlike a part of it.
    half, none = pins.halved[0].mean, pins.zero[0].mean
    assert half.value > 10.0 * half.error
    assert none.value - half.value > 10.0 * none.error
    # And to tighten them makes the bad end worse or leaves it, which no sum of variances can say.
    assert pins.zero[0].percentile_95.value > 0.0
