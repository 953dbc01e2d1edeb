"""Which tolerance to tighten: what each alone moves when it is halved, and when it is zero (docs/tolerance.md, Eq. 67).

The same reducers are drawn with one width changed, so that what is compared differs in that alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.limits import Limit, within
from cycloid_profile.tolerance.sequence import generator
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.workers import cores

PERCENTS = (95.0, 99.73)
# Quantities of which less is worse: their percentiles are counted from below.
_LESS_IS_WORSE = ("least_backlash_arcmin",)
_BOOTSTRAP = 3  # purpose of a stream of random numbers


@dataclass(frozen=True, slots=True)
class Estimate:
    """A ``value`` with its standard ``error``."""

    value: float
    error: float


@dataclass(frozen=True, slots=True)
class Figures:
    """Of one quantity, in its unit: ``mean``, and the percentiles 95 and 99.73 of its bad side."""

    mean: Estimate
    percentile_95: Estimate
    percentile_9973: Estimate


@dataclass(frozen=True, slots=True)
class Contribution:
    """What one tolerance contributes.

    ``label`` of the scatter; its ``plus_minus`` and ``unit``. ``halved`` and ``zero``: what the figures of each
    quantity change by with the tolerance at half and at nothing, below zero where they fall; ``yield_halved`` and
    ``yield_zero``, what the share within all limits gains, None without limits. ``variance_share``, what of the
    variance of each quantity goes with the tolerance; below zero where the quantity would scatter more.
    """

    label: str
    plus_minus: float | None
    unit: str
    halved: tuple[Figures, ...]
    zero: tuple[Figures, ...]
    yield_halved: Estimate | None
    yield_zero: Estimate | None
    variance_share: tuple[Estimate, ...]


@dataclass(frozen=True)
class Contributions:
    """Contributions of all tolerances: ``quantities``, their figures ``as_drawn``, the ``yield_as_drawn``, one of
    ``rows`` a scatter in the order of the tolerances; ``reducers`` drawn.
    """

    quantities: tuple[str, ...]
    as_drawn: tuple[Figures, ...]
    yield_as_drawn: Estimate | None
    rows: tuple[Contribution, ...]
    reducers: int

    def ranked(self, quantity: str | None = None) -> tuple[Contribution, ...]:
        """The rows, what gains most when halved first: by the 99.73 % percentile of a quantity, by yield without one.

        Without limits there is no yield, and the first quantity decides.
        """
        if quantity is None and self.yield_as_drawn is not None:
            return tuple(sorted(self.rows, key=_yield_gained, reverse=True))
        which = 0 if quantity is None else self.quantities.index(quantity)
        less = self.quantities[which] in _LESS_IS_WORSE
        return tuple(sorted(self.rows, key=lambda row: row.halved[which].percentile_9973.value, reverse=less))


def _yield_gained(row: Contribution) -> float:
    return 0.0 if row.yield_halved is None else row.yield_halved.value


def contributions(study: Study, limits: Sequence[Limit] = (), resamples: int = 100) -> Contributions:
    """Contributions of the tolerances of a ``study`` to its quantities, and to the yield against ``limits``.

    Each tolerance costs two more runs of the study. Standard errors by bootstrap over reducers in pairs, over batches
    where reducers of a batch are alike; of hypercubes and nets they say too much.
    """
    names, scatters = study.measures.names, study.tolerances.scatters
    drawn = _values(study, study)
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
                halved=halved.figures_less(base),
                zero=zero.figures_less(base),
                yield_halved=halved.yield_less(base),
                yield_zero=zero.yield_less(base),
                variance_share=zero.variance_gone(base),
            )
        )
    return Contributions(names, base.figures_less(None), base.yield_less(None), tuple(rows), study.samples)


def _values(study: Study, other: Study) -> FloatArray:
    """Quantities of all reducers of another study of the same parts, shape (reducers, quantities)."""
    # Whatever the widths, a unit of an error changes the same: made once for all.
    measures = study.measures
    assert measures.answers
    with ThreadPoolExecutor(cores()) as pool:
        return np.concatenate(list(pool.map(lambda k: measures.of(other.coordinates(k)), range(study.chunks))))


def _changed(study: Study, number: int, factor: float, base: _Sample) -> _Sample:
    factors = [1.0] * len(study.tolerances.scatters)
    factors[number] = factor
    other = study.with_tolerances(study.tolerances.scaled(factors))
    return _Sample(_values(study, other), base.names, base.limits, base.pick)


def _resampled(study: Study, resamples: int) -> list[np.ndarray]:
    """All reducers, and then as many drawn anew, in whole batches where those are alike."""
    alike = study.draws.batch_size if any(one.batch_share for one in study.tolerances.scatters) else 1
    reducers = np.arange(study.samples)
    batches = np.split(reducers, range(alike, study.samples, alike)) if alike > 1 else None
    stream = generator(study.draws.seed, _BOOTSTRAP, 0)
    picks = [reducers]
    for _ in range(resamples):
        if batches is None:
            picks.append(stream.integers(0, study.samples, study.samples))
        else:
            picks.append(np.concatenate([batches[i] for i in stream.integers(0, len(batches), len(batches))]))
    return picks


class _Sample:
    """Figures of drawn reducers and of their resamples; those without an answer count against the yield alone."""

    def __init__(
        self, values: FloatArray, names: tuple[str, ...], limits: Sequence[Limit], pick: list[np.ndarray]
    ) -> None:
        self.names, self.limits, self.pick = names, limits, pick
        good = within(values, names, limits) if limits else None
        bad_side = np.array([-1.0 if name in _LESS_IS_WORSE else 1.0 for name in names])
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

    def figures_less(self, other: _Sample | None) -> tuple[Figures, ...]:
        """Figures of each quantity, less those of another sample of the same reducers."""
        less = self.figures if other is None else self.figures - other.figures
        return tuple(
            Figures(*(_estimate(less[:, figure, quantity]) for figure in range(1 + len(PERCENTS))))
            for quantity in range(len(self.names))
        )

    def yield_less(self, other: _Sample | None) -> Estimate | None:
        """Yield, less that of another sample."""
        if self.yields is None:
            return None
        return _estimate(self.yields if other is None or other.yields is None else self.yields - other.yields)

    def variance_gone(self, other: _Sample) -> tuple[Estimate, ...]:
        """Share of the variance of another sample that is not in this one."""
        whole = other.figures[:, -1]
        share = np.divide(whole - self.figures[:, -1], whole, out=np.zeros_like(whole), where=whole > 0.0)
        return tuple(_estimate(share[:, quantity]) for quantity in range(len(self.names)))


def _estimate(values: FloatArray) -> Estimate:
    """The value of all reducers, with the scatter of the resamples as its error."""
    return Estimate(float(values[0]), float(np.std(values[1:], ddof=1)))
