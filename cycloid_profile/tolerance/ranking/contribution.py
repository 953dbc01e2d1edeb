"""Contribution of each tolerance: change of the quantities with it alone halved, or zero (docs/tolerance.md, Eq. 67).

The same reducers are drawn with one width changed, so that both samples differ in that alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.inputs import Limit, within
from cycloid_profile.tolerance.study import Study, generator, on_all_cores

PERCENTS = (95.0, 99.73)
# Quantities whose low values are the bad ones: their percentiles are counted from below.
_LOW_IS_BAD = ("least_backlash_arcmin",)
_BOOTSTRAP = 3  # purpose of a stream of random numbers


@dataclass(frozen=True, slots=True)
class Estimate:
    """A ``value`` with its standard ``error``."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class QuantityStatistics:
    """Statistics of one quantity, in its unit: ``mean``, and the 95 % and 99.73 % percentiles towards its unfavourable
    side."""

    mean: Estimate
    percentile_95: Estimate
    percentile_9973: Estimate


@dataclass(frozen=True, slots=True)
class Contribution:
    """Contribution of one tolerance.

    ``label`` of the scatter; its ``plus_minus`` and ``unit``. ``halved`` and ``zero``: change of the figures of each
    quantity with the tolerance halved and set to zero; ``yield_halved`` and ``yield_zero``, gain of the share within
    all limits, None without limits. ``variance_share`` of each quantity that disappears with the tolerance; below zero
    where the quantity would scatter more.
    """

    label: str
    plus_minus: float | None
    unit: str
    halved: tuple[QuantityStatistics, ...]
    zero: tuple[QuantityStatistics, ...]
    yield_halved: Estimate | None
    yield_zero: Estimate | None
    variance_share: tuple[Estimate, ...]


@dataclass(frozen=True, repr=False)
class Contributions(Described):
    """Contributions of all tolerances: ``quantities``, their figures ``as_drawn``, the ``yield_as_drawn``, one of
    ``rows`` a scatter in the order of the tolerances; ``reducers`` drawn.
    """

    quantities: tuple[str, ...]
    as_drawn: tuple[QuantityStatistics, ...]
    yield_as_drawn: Estimate | None
    rows: tuple[Contribution, ...]
    reducers: int

    def ranked(self, quantity: str | None = None) -> tuple[Contribution, ...]:
        """The rows in descending gain when halved: by the 99.73 % percentile of a quantity, by yield without one.

        Without limits there is no yield, and the first quantity decides.
        """
        if quantity is None and self.yield_as_drawn is not None:
            return tuple(sorted(self.rows, key=_yield_gained, reverse=True))
        which = 0 if quantity is None else self.quantities.index(quantity)
        less = self.quantities[which] in _LOW_IS_BAD
        return tuple(sorted(self.rows, key=lambda row: row.halved[which].percentile_9973.value, reverse=less))

    def to_frame(self) -> Any:
        """A ``pandas.DataFrame``, one row a tolerance: gains when it is halved, and its share of each variance."""
        columns: dict[str, list[Any]] = {
            "tolerance": [row.label for row in self.rows],
            "plus_minus": [row.plus_minus for row in self.rows],
            "unit": [row.unit for row in self.rows],
            "yield_gained": [None if row.yield_halved is None else row.yield_halved.value for row in self.rows],
        }
        for i, name in enumerate(self.quantities):
            columns[f"{name}_p99_73_change"] = [row.halved[i].percentile_9973.value for row in self.rows]
            columns[f"{name}_variance_share"] = [row.variance_share[i].value for row in self.rows]
        return frame(columns)

    def _key_figures(self) -> Mapping[str, str]:
        unit = (
            "of the yield" if self.yield_as_drawn is not None else f"on the 99.73 % percentile of {self.quantities[0]}"
        )
        gains = {
            row.label: row.yield_halved if row.yield_halved is not None else row.halved[0].percentile_9973
            for row in self.ranked()
        }
        return {"reducers": f"{self.reducers:,}"} | {
            f"{label}, halved": f"{one.value:+.3g} ± {one.error:.1g} {unit}" for label, one in gains.items()
        }


def _yield_gained(row: Contribution) -> float:
    return 0.0 if row.yield_halved is None else row.yield_halved.value


def contributions(study: Study, limits: Sequence[Limit] = (), resamples: int = 100) -> Contributions:
    """Contributions of the tolerances of a ``study`` to its quantities, and to the yield against ``limits``.

    Each tolerance costs two more runs of the study. Every reducer is drawn from a batch of its own: few batches would
    give no standard error. Standard errors by bootstrap over reducers in pairs; for hypercubes and nets they are too
    large.
    """
    names, scatters = study.quantity_model.names, study.tolerances.scatters
    drawn = _values(study, _unbatched(study))
    pick = _resampled(study, resamples)
    base = _Sample(drawn, names, limits, pick)
    rows = []
    for number, one in enumerate(scatters):
        halved, zero = (_changed(study, number, factor, base) for factor in (0.5, 0.0))
        rows.append(
            Contribution(
                label=one.label,
                plus_minus=one.plus_minus,
                unit=one.unit,
                halved=halved.figures_change(base),
                zero=zero.figures_change(base),
                yield_halved=halved.yield_gain(base),
                yield_zero=zero.yield_gain(base),
                variance_share=zero.variance_reduction(base),
            )
        )
    return Contributions(names, base.figures_change(None), base.yield_gain(None), tuple(rows), study.samples)


def _values(study: Study, other: Study) -> FloatArray:
    """Quantities of all reducers of another study of the same parts, shape (reducers, quantities)."""
    # A unit of an error has the same effect at any width: made once for all.
    quantity_model = study.quantity_model
    assert quantity_model.answers
    return np.concatenate(on_all_cores(lambda k: quantity_model.of(other.coordinates(k)), range(study.chunks)))


def _changed(study: Study, number: int, factor: float, base: _Sample) -> _Sample:
    factors = [1.0] * len(study.tolerances.scatters)
    factors[number] = factor
    other = study.with_tolerances(study.tolerances.scaled(factors))
    return _Sample(_values(study, _unbatched(other)), base.names, base.limits, base.pick)


def _resampled(study: Study, resamples: int) -> list[np.ndarray]:
    """All reducers, and then bootstrap samples of as many."""
    stream = generator(study.draws.seed, _BOOTSTRAP, 0)
    return [np.arange(study.samples), *(stream.integers(0, study.samples, study.samples) for _ in range(resamples))]


def _unbatched(study: Study) -> Study:
    """The same study with every reducer from a batch of its own: the same distribution of one reducer."""
    tolerances = study.tolerances
    scatters = tuple(replace(one, batch_share=0.0) for one in tolerances.scatters)
    return study.with_tolerances(replace(tolerances, scatters=scatters))


class _Sample:
    """Figures of drawn reducers and of their resamples; those without a converged solution count against the yield
    alone.
    """

    def __init__(
        self, values: FloatArray, names: tuple[str, ...], limits: Sequence[Limit], pick: list[np.ndarray]
    ) -> None:
        self.names, self.limits, self.pick = names, limits, pick
        good = within(values, names, limits) if limits else None
        bad_side = np.array([-1.0 if name in _LOW_IS_BAD else 1.0 for name in names])
        turned = values * bad_side
        answered = np.all(np.isfinite(values), axis=1)
        # (resamples + 1, figures, quantities): mean, percentiles of the bad side, variance.
        found = np.empty((len(pick), 2 + len(PERCENTS), len(names)))
        self.yields = None if good is None else np.array([np.mean(good[some]) for some in pick])
        for i, some in enumerate(pick):
            used = turned[some[answered[some]]]
            found[i, 0] = np.mean(used, axis=0) * bad_side
            found[i, 1:-1] = np.percentile(used, PERCENTS, axis=0) * bad_side
            found[i, -1] = np.var(used, axis=0)
        self.figures = found

    def figures_change(self, other: _Sample | None) -> tuple[QuantityStatistics, ...]:
        """Figures of each quantity, less those of another sample of the same reducers."""
        less = self.figures if other is None else self.figures - other.figures
        return tuple(
            QuantityStatistics(*(_estimate(less[:, figure, quantity]) for figure in range(1 + len(PERCENTS))))
            for quantity in range(len(self.names))
        )

    def yield_gain(self, other: _Sample | None) -> Estimate | None:
        """Yield, less that of another sample."""
        if self.yields is None:
            return None
        return _estimate(self.yields if other is None or other.yields is None else self.yields - other.yields)

    def variance_reduction(self, other: _Sample) -> tuple[Estimate, ...]:
        """Share of the variance of another sample that is not in this one."""
        whole = other.figures[:, -1]
        share = np.divide(whole - self.figures[:, -1], whole, out=np.zeros_like(whole), where=whole > 0.0)
        return tuple(_estimate(share[:, quantity]) for quantity in range(len(self.names)))


def _estimate(values: FloatArray) -> Estimate:
    """The value of all reducers, with the scatter of the resamples as its error."""
    return Estimate(float(values[0]), float(np.std(values[1:], ddof=1)))
