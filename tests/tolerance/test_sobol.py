"""Grouped Sobol indices against closed forms, and a minimum over pins, of which first order gives too little.

Responses are given as formulas in place of the reducer: what is tested is how numbers are drawn, grouped and mixed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import tolerances_of
from cycloid_profile.tolerance.model import WorkingPoint
from cycloid_profile.tolerance.ranking import sobol_shares
from cycloid_profile.tolerance.ranking.sobol import Groups, linear_shares
from cycloid_profile.tolerance.study import Draws, Random, Sobol, Study

TABLES = [
    {"name": "pin_radius_error", "amount_um": {"sigma": 1.0}},
    {"name": "single_pin_error", "each": "pin", "amount_um": {"sigma": 0.5}},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {"sigma": 0.25}},
    {"name": "pin_circle_radius_error", "amount_um": {"plus_minus": 3.0, "distribution": "uniform"}},
]
PINS = 40


@pytest.fixture(scope="module")
def drawn(rv40e):
    return as_drawn(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), 412e3))


@dataclass
class Formula:
    """Quantities as a formula of the coordinates, in the place of ``QuantityModel``."""

    names: tuple[str, ...]
    of: object


def study(drawn, formula, tables=TABLES, correlated=(), sequence=None, names=("y",)):
    found = Study(drawn, Draws(tolerances_of(tables, correlated, drawn), sequence=sequence or Random()), ("y",), 1024)
    # A cached property: what is put in its place is what is found.
    found.__dict__["quantity_model"] = Formula(names, formula)
    return found


def linear(x):
    """A response linear in everything: y = 2 common + Σ single/4 + Σ(x + y)/8 + circle."""
    single, placed = x[:, 1 : 1 + PINS], x[:, 1 + PINS : 1 + 3 * PINS]
    return (2.0 * x[:, 0] + np.sum(single, axis=1) / 4.0 + np.sum(placed, axis=1) / 8.0 + x[:, -1])[:, np.newaxis]


# Variances: 4·1, 40·0.25/16, 80·0.0625/64, 3²/3.
VARIANCES = np.array([4.0, 0.625, 0.078125, 3.0])
GRADIENT = np.concatenate([[2.0], np.full(PINS, 0.25), np.full(2 * PINS, 0.125), [1.0]])


@pytest.mark.parametrize("sequence", [Random(), Sobol()])
def test_a_linear_response_has_its_variance_shares(drawn, sequence):
    found = sobol_shares(study(drawn, linear, sequence=sequence), 2048, {"y": GRADIENT}, resamples=40)
    shares = found.of("y")
    assert found.groups == ("pin_radius_error", "single_pin_error", "pin_position_error", "pin_circle_radius_error")
    assert found.deviation[0] ** 2 == pytest.approx(VARIANCES.sum(), rel=0.05)
    for share, expected in zip(shares, VARIANCES / VARIANCES.sum(), strict=True):
        # Some three standard errors of 2048 reducers, (1/2048)^½ of the variance each.
        assert share.first.value == pytest.approx(expected, abs=0.06)
        assert share.total.value == pytest.approx(expected, abs=0.06)
        assert share.linear == pytest.approx(expected, abs=0.03)
        assert share.first.low < share.first.value < share.first.high
        assert share.total.low < share.total.value < share.total.high
    assert (found.reducers, found.lost) == (6 * 2048, 0)


def test_of_a_minimum_over_pins_first_order_gives_too_little(drawn):
    # y = min over pins: by itself each pin moves little of the mean, together they move all of it.
    found = sobol_shares(
        study(drawn, lambda x: np.min(x[:, 1 : 1 + PINS] * (1.0 + 0.5 * x[:, :1]), axis=1)[:, np.newaxis]),
        4096,
        {"y": np.concatenate([[0.0], np.full(PINS, 0.5 / PINS), np.zeros(2 * PINS + 1)])},
        resamples=50,
    )
    common, single = found.of("y")[:2]
    # At the drawing the common size has no derivative, yet it scales the minimum: half of the variance and more.
    assert common.linear == 0.0
    assert common.first.low > 0.5
    # y = m (1 + c): V = V(m)(1 + V(c)) + E(m)² V(c), with V(c) = 1/4; what they do only together is V(m) V(c).
    least = np.min(np.random.default_rng(7).normal(0.0, 0.5, (100_000, PINS)), axis=1)
    mean, spread = float(np.mean(least)), float(np.var(least))
    whole = 1.25 * spread + 0.25 * mean**2
    for share, first, total in ((common, 0.25 * mean**2, 0.25 * (mean**2 + spread)), (single, spread, 1.25 * spread)):
        assert share.first.value == pytest.approx(first / whole, abs=0.05)
        assert share.total.value == pytest.approx(total / whole, abs=0.05)
    assert single.total.value > single.first.value


def test_correlated_scatters_are_one_group(drawn):
    tables = [*TABLES[:1], TABLES[3]]
    correlated = [{"between": ["pin_radius_error.amount_um", "pin_circle_radius_error.amount_um"], "value": 0.8}]
    made = study(drawn, lambda x: x[:, :1] + x[:, 1:2], tables, correlated)
    groups = Groups(made.draws)
    assert groups.labels == ("pin_radius_error + pin_circle_radius_error",)
    np.testing.assert_array_equal(groups.normals[0], [0, 1])
    share = sobol_shares(made, 256, resamples=20).of("y")[0]
    assert share.first.value == pytest.approx(1.0, abs=0.25)
    assert share.total.value == pytest.approx(1.0, abs=0.25)
    assert share.linear is None


def test_columns_of_groups_cover_every_number_once(drawn):
    groups = Groups(Draws(tolerances_of(TABLES, (), drawn)))
    np.testing.assert_array_equal(np.sort(np.concatenate(groups.normals)), np.arange(groups.draws.dimensions))
    np.testing.assert_array_equal(np.sort(np.concatenate(groups.coordinates)), np.arange(groups.draws.columns[-1]))


def test_reducers_are_added_until_the_intervals_are_narrow(drawn):
    wide, narrow = (sobol_shares(study(drawn, linear), 4096, resamples=40, width=width) for width in (0.5, 0.15))
    for found, width in ((wide, 0.5), (narrow, 0.15)):
        assert max(share.total.high - share.total.low for share in found.of("y")) == found.width <= width
        assert "cap" not in found.ending
    assert wide.reducers < narrow.reducers
    count = narrow.reducers // 6
    assert sobol_shares(study(drawn, linear), 4096, resamples=40, width=1e-9).reducers == 6 * 4096
    assert count & (count - 1) == 0


def test_the_cap_on_the_reducers_is_reported(drawn):
    found = sobol_shares(study(drawn, linear), 256, resamples=40, width=0.001)
    assert found.reducers == 6 * 256
    assert found.width > 0.001
    assert "the cap on their number" in found.ending
    assert "ending" in found._key_figures()


def test_the_same_seed_says_the_same(drawn):
    one, other = (sobol_shares(study(drawn, linear), 64, resamples=20) for _ in range(2))
    assert one.shares == other.shares


def test_neighbours_that_are_equal_count_in_the_linear_share(drawn):
    # Sums of neighbours that are equal scatter more: their share rises above that of independent pins.
    equal_neighbours = [TABLES[0], {**TABLES[1], "neighbours": 10.0}]
    gradient = np.concatenate([[2.0], np.full(PINS, 0.25)])
    apart, near = (
        linear_shares(Groups(Draws(tolerances_of(tables, (), drawn))), gradient)[1]
        for tables in (TABLES[:2], equal_neighbours)
    )
    assert apart == pytest.approx(0.625 / 4.625, abs=0.02)
    # Σ of a row of the correlation matrix is the factor by which the variance of the sum grows.
    factor = np.sum(np.exp(-np.minimum(np.arange(PINS), PINS - np.arange(PINS)) / 10.0))
    assert near == pytest.approx(0.625 * factor / (4.0 + 0.625 * factor), abs=0.04)


def test_too_many_reducers_without_an_answer_are_refused(drawn):
    def lost(x):
        return np.where(x[:, :1] > 1.0, np.nan, x[:, :1])

    with pytest.raises(SolveError, match="narrow the tolerances"):
        sobol_shares(study(drawn, lost), 256)


def test_a_few_lost_reducers_are_reported(drawn):
    found = sobol_shares(study(drawn, lambda x: np.where(x[:, :1] > 3.0, np.nan, x[:, :1])), 1024, resamples=20)
    assert 0 < found.lost <= 10
    assert found.of("y")[0].first.value == pytest.approx(1.0, abs=0.15)


@pytest.mark.slow
def test_backlash_of_scattered_pins_is_beyond_first_derivatives(drawn):
    tables = [
        {"name": "pin_radius_error", "amount_um": {"plus_minus": 1.0}},
        {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 6.0}},
    ]
    tolerances = tolerances_of(tables, (), drawn)
    made = Study(drawn, Draws(tolerances), ("backlash_arcmin",), 1024)
    gradients = WorkingPoint.of(drawn, tolerances).gradients
    found = sobol_shares(made, 256, gradients, resamples=50)
    pins = found.of("backlash_arcmin")[1]
    # At the drawing no single pin holds the worst pose back: to first order the places of pins do nothing.
    assert pins.linear is not None
    assert pins.linear < 0.01
    assert pins.total.low > 0.05
