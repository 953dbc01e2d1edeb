"""Sobol indices: share of each scatter in the variance of each quantity (docs/tolerance.md, Eqs. 65, 66).

One scatter with all its parts forms a group; correlated scatters form one common group. A minimum over pins depends
nonlinearly on all sizes, and its mean on the width of every tolerance. First-order indices miss the interactions, so
total indices are computed, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.tolerance.study import Draws, Interval, Study, generator, on_all_cores, require_equilibria

_BOOTSTRAP = 2  # purpose of a stream of random numbers, next to those of ``draws``
_FIRST_SAMPLES = 128


@dataclass(frozen=True, slots=True)
class SobolShare:
    """Share of one group in the variance of one quantity.

    ``first`` order, expected reduction of the variance if the group is known; ``total``, expected remaining share if
    all other groups are known; ``linear``, the share by first derivatives at the working point, None where not asked.
    """

    group: str
    quantity: str
    first: Interval
    total: Interval
    linear: float | None


@dataclass(frozen=True, repr=False)
class SobolShares(Described):
    """Shares of all ``groups`` in the variances of all ``quantities``.

    ``mean`` and ``deviation`` of each quantity over the reducers drawn; ``reducers`` computed, and ``lost``: reducers
    without equilibrium in one of the mixed samples, which are omitted. ``width`` of the widest interval of a total
    index, and the one ``wanted``, None if the number of reducers was given.
    """

    groups: tuple[str, ...]
    quantities: tuple[str, ...]
    shares: tuple[SobolShare, ...]
    mean: tuple[float, ...]
    deviation: tuple[float, ...]
    reducers: int
    lost: int
    width: float
    wanted: float | None = None

    @property
    def settled(self) -> bool:
        """False where the cap on the reducers ended the sampling before the wanted width."""
        return self.wanted is None or self.width <= self.wanted

    @property
    def ending(self) -> str:
        """How the sampling ended."""
        found = f"widest interval of a total index {self.width:.2g} with {self.reducers:,} reducers"
        if self.wanted is None:
            return found
        if self.settled:
            return f"{found}, {self.wanted:g} was wanted"
        return f"{found}, the cap on their number; {self.wanted:g} was wanted"

    def to_frame(self) -> Any:
        """A ``pandas.DataFrame``, one row a group and quantity: first, total and linear share."""
        return frame(
            {
                "group": [one.group for one in self.shares],
                "quantity": [one.quantity for one in self.shares],
                "first": [one.first.value for one in self.shares],
                "total": [one.total.value for one in self.shares],
                "linear": [one.linear for one in self.shares],
            }
        )

    def _key_figures(self) -> Mapping[str, str]:
        first = sorted(self.of(self.quantities[0]), key=lambda one: -one.total.value)
        figures = {"ending": self.ending, "quantity": self.quantities[0]}
        return figures | {one.group: f"first {one.first.value:.3f}, total {one.total.value:.3f}" for one in first}

    def of(self, quantity: str) -> tuple[SobolShare, ...]:
        """Shares in one quantity, in the order of the groups."""
        return tuple(share for share in self.shares if share.quantity == quantity)


@dataclass(frozen=True)
class Groups:
    """Groups of the normal numbers of a reducer."""

    draws: Draws

    @cached_property
    def members(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the scatters of each group: scatters connected by correlations, directly or through other
        scatters."""
        joined = list(range(len(self.draws.tolerances.scatters)))
        for one in self.draws.tolerances.correlations:
            if one.value:
                old, new = joined[one.second], joined[one.first]
                joined = [new if root == old else root for root in joined]
        return tuple(tuple(np.flatnonzero(np.equal(joined, root)).tolist()) for root in dict.fromkeys(joined))

    @property
    def labels(self) -> tuple[str, ...]:
        """Label of each group: the labels of its scatters joined by " + "."""
        scatters = self.draws.tolerances.scatters
        return tuple(" + ".join(scatters[i].label for i in group) for group in self.members)

    @cached_property
    def normals(self) -> tuple[IntArray, ...]:
        """Columns of each group among the normal numbers of a reducer."""
        return self._columns(self.draws.normal_columns)

    @cached_property
    def coordinates(self) -> tuple[IntArray, ...]:
        """Columns of each group among the coordinates of a reducer."""
        return self._columns(self.draws.columns)

    def _columns(self, ends: IntArray) -> tuple[IntArray, ...]:
        return tuple(
            np.concatenate([np.arange(ends[i], ends[i + 1]) for i in group]).astype(np.intp) for group in self.members
        )


def sobol_shares(
    study: Study,
    samples: int = 1024,
    gradients: Mapping[str, FloatArray] | None = None,
    confidence: float = 0.95,
    resamples: int = 200,
    width: float | None = None,
) -> SobolShares:
    """Sobol indices of the quantities of a ``study``, by (groups + 2)·``samples`` reducers; the same for the same seed.

    ``gradients`` of quantities by the coordinates of the study, shape (coordinates,), give the ``linear`` shares.
    Batches are ignored: they correlate reducers, not the numbers within one. The estimators are those of Saltelli et
    al., Comput. Phys. Commun. 181 (2010) 259, in scipy. The intervals come from a bootstrap over the reducers.

    With a ``width``, the reducers are doubled from 128 samples on until every interval of a total index is that narrow;
    ``samples`` is then the cap.

    Raises
    ------
    SolveError
        If more than 1 % of the drawn reducers have no equilibrium.
    ValueError
        If ``samples`` is no power of two (raised by scipy).
    """
    groups, draws = Groups(study.draws), study.draws
    # Halves of one sequence: rows of two scrambled nets have their leading digits in common and are not independent.
    A, B = np.split(draws.sequence.normals(draws.seed, 0, samples, 2 * draws.dimensions), 2, axis=1)
    linear = {name: linear_shares(groups, gradient) for name, gradient in (gradients or {}).items()}
    count = samples if width is None else min(_FIRST_SAMPLES, samples)
    values = _evaluated(study, groups, A[:count], B[:count])
    while True:
        found = _shares(study, groups, values, linear, confidence, resamples)
        if width is None or count == samples or found.width <= width:
            return replace(found, wanted=width)
        more = min(2 * count, samples)
        added = _evaluated(study, groups, A[count:more], B[count:more])
        values = tuple(np.concatenate(both, axis=-1) for both in zip(values, added, strict=True))
        count = more


def _shares(
    study: Study,
    groups: Groups,
    values: tuple[FloatArray, ...],
    linear: Mapping[str, FloatArray],
    confidence: float,
    resamples: int,
) -> SobolShares:
    """Indices from the ``values`` for A, for B, and for A with one group at a time from B."""
    f_A, f_B, f_AB = values
    names, samples = study.quantity_model.names, f_A.shape[1]
    answered = np.all(np.isfinite(f_A), axis=0) & np.all(np.isfinite(f_B), axis=0)
    answered &= np.all(np.isfinite(f_AB), axis=(0, 1))
    lost = int(np.sum(~answered))
    require_equilibria(lost, samples)
    # Others that were drawn take the places of the few that are lost, so that the count stays a power of two.
    kept = np.flatnonzero(answered)
    chosen = np.concatenate([kept, kept[:lost]])
    evaluated = _Evaluated(f_A[:, chosen], f_B[:, chosen], f_AB[..., chosen])
    first, total = evaluated.indices(np.arange(samples))
    low, high = _intervals(evaluated, study.draws.seed, confidence, resamples)
    shares = tuple(
        SobolShare(
            group,
            quantity,
            Interval(float(first[q, g]), float(low[0, q, g]), float(high[0, q, g])),
            Interval(float(total[q, g]), float(low[1, q, g]), float(high[1, q, g])),
            float(linear[quantity][g]) if quantity in linear else None,
        )
        for q, quantity in enumerate(names)
        for g, group in enumerate(groups.labels)
    )
    both = np.concatenate([evaluated.f_A, evaluated.f_B], axis=1)
    mean, deviation = (tuple(map(float, each)) for each in (np.mean(both, axis=1), np.std(both, axis=1)))
    count = samples * (len(groups.members) + 2)
    width = max(one.total.high - one.total.low for one in shares)
    return SobolShares(groups.labels, names, shares, mean, deviation, count, lost, width)


def linear_shares(groups: Groups, gradient: FloatArray, samples: int = 4096) -> FloatArray:
    """Shares of the variance of a quantity that is linear with this ``gradient``, shape (groups,).

    Variances of the draws are used, so any distribution of the sizes and correlations within a group are permitted.
    """
    draws = groups.draws
    x = draws.from_normals(draws.sequence.normals(draws.seed, 0, samples, draws.dimensions))
    varied = np.array([np.var(x[:, columns] @ gradient[columns]) for columns in groups.coordinates])
    whole = float(np.sum(varied))
    return varied / whole if whole > 0.0 else varied


def _evaluated(study: Study, groups: Groups, A: FloatArray, B: FloatArray) -> tuple[FloatArray, ...]:
    """Values of the quantities for A, for B, and for A with one group at a time from B."""
    draws = groups.draws

    def values(z: FloatArray) -> FloatArray:
        return study.quantity_model.of(draws.from_normals(z)).T

    def mixed(columns: IntArray) -> FloatArray:
        z = A.copy()
        z[:, columns] = B[:, columns]
        return values(z)

    return values(A), values(B), np.stack(on_all_cores(mixed, groups.normals))


@dataclass(frozen=True, eq=False)
class _Evaluated:
    """Values for A and B, shape (quantities, samples), and for A with groups from B, (groups, quantities, samples)."""

    f_A: FloatArray
    f_B: FloatArray
    f_AB: FloatArray

    def indices(self, some: IntArray) -> FloatArray:
        """First- and total-order indices from a selection of the samples, shape (2, quantities, groups)."""
        from scipy.stats import sobol_indices

        # For one group and one quantity scipy returns a scalar and fails: two identical rows avoid that.
        rows = np.arange(max(len(self.f_A), 2)) % len(self.f_A)
        # Indexing makes a copy, because scipy centres its input in place.
        func = {name: getattr(self, name)[..., rows, :][..., some] for name in ("f_A", "f_B", "f_AB")}
        found = sobol_indices(func=func, n=some.size)
        return np.reshape([found.first_order, found.total_order], (2, rows.size, -1))[:, : len(self.f_A)]


def _intervals(evaluated: _Evaluated, seed: int, confidence: float, resamples: int) -> tuple[FloatArray, FloatArray]:
    from scipy.stats import bootstrap

    statistic: Callable[[IntArray], FloatArray] = evaluated.indices
    found = bootstrap(
        (np.arange(evaluated.f_A.shape[1]),),
        statistic,
        n_resamples=resamples,
        confidence_level=confidence,
        # scipy's own intervals of Sobol indices take no seed, and cost a jackknife.
        method="percentile",
        vectorized=False,
        rng=generator(seed, _BOOTSTRAP, 0),
    )
    return found.confidence_interval.low, found.confidence_interval.high
