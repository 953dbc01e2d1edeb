"""Shares of the variance of each quantity by scatter: Sobol indices (docs/tolerance.md, Eqs. 65, 66).

A group is one scatter with all its parts, as many numbers as they take; scatters that are correlated make one group.
Where a quantity is a minimum over pins its mean moves with every width, and first order alone tells too little.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.scatter import Tolerances
from cycloid_profile.tolerance.sequence import generator
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.summary import Interval
from cycloid_profile.tolerance.workers import cores

_BOOTSTRAP = 2  # purpose of a stream of random numbers, beside those of ``sequence``
_LOST_SHARE = 0.01  # reducers without an answer that may be left out


@dataclass(frozen=True, slots=True)
class Share:
    """Share of one group in the variance of one quantity.

    ``first`` order, what is saved on average if the group alone becomes exact and known; ``total``, what is left if all
    others do; ``linear``, what first derivatives at the working point say, None where not asked.
    """

    group: str
    quantity: str
    first: Interval
    total: Interval
    linear: float | None


@dataclass(frozen=True)
class SobolShares:
    """Shares of all ``groups`` in the variances of all ``quantities``.

    ``mean`` and ``deviation`` of each quantity over the reducers drawn; ``reducers`` computed, and ``lost`` of the
    drawn that had no answer in one of their mixtures and were left out.
    """

    groups: tuple[str, ...]
    quantities: tuple[str, ...]
    shares: tuple[Share, ...]
    mean: tuple[float, ...]
    deviation: tuple[float, ...]
    reducers: int
    lost: int

    def of(self, quantity: str) -> tuple[Share, ...]:
        """Shares in one quantity, in the order of the groups."""
        return tuple(share for share in self.shares if share.quantity == quantity)


@dataclass(frozen=True)
class Groups:
    """What of the normal numbers of a reducer belongs together."""

    draws: Draws

    @property
    def tolerances(self) -> Tolerances:
        """What scatters."""
        return self.draws.tolerances

    @cached_property
    def members(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the scatters of each group: those that correlations join, directly or by others between."""
        joined = list(range(len(self.tolerances.scatters)))
        for one in self.tolerances.correlations:
            if one.value:
                old, new = joined[one.second], joined[one.first]
                joined = [new if root == old else root for root in joined]
        return tuple(tuple(np.flatnonzero(np.equal(joined, root)).tolist()) for root in dict.fromkeys(joined))

    @property
    def names(self) -> tuple[str, ...]:
        """Labels of the scatters of each group."""
        scatters = self.tolerances.scatters
        return tuple(" + ".join(scatters[i].label for i in group) for group in self.members)

    @cached_property
    def normals(self) -> tuple[IntArray, ...]:
        """Columns of each group among the normal numbers of a reducer."""
        counts = [len(one.choices) * (1 if one.angle_deg is None else 2) for one in self.tolerances.scatters]
        return self._columns(np.concatenate([[0], np.cumsum(counts)]))

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
) -> SobolShares:
    """Sobol indices of the quantities of a ``study``, by (groups + 2)·``samples`` reducers; the same for the same seed.

    ``gradients`` of quantities by the coordinates of the study, shape (coordinates,), give the ``linear`` shares.
    Batches are left aside: they make reducers alike, not the numbers within one. Estimators of Saltelli et al., Comput.
    Phys. Commun. 181 (2010) 259, as scipy has them; intervals by bootstrap over the reducers.

    Raises
    ------
    SolveError
        If more than 1 % of the drawn reducers have no answer.
    ValueError
        If ``samples`` is no power of two (raised by scipy).
    """
    groups = Groups(study.draws)
    names, f_A, f_B, f_AB = _evaluated(study, groups, samples)
    answered = np.all(np.isfinite(f_A), axis=0) & np.all(np.isfinite(f_B), axis=0)
    answered &= np.all(np.isfinite(f_AB), axis=(0, 1))
    lost = int(np.sum(~answered))
    if lost > _LOST_SHARE * samples:
        raise SolveError("reducers without an answer", f"{lost} of {samples}", "are too many to leave out",
                         "narrow the tolerances until the discs can be assembled")  # fmt: skip
    # Others that were drawn take the places of the few that are lost, so that the count stays a power of two.
    kept = np.flatnonzero(answered)
    chosen = np.concatenate([kept, kept[:lost]])
    evaluated = _Evaluated(f_A[:, chosen], f_B[:, chosen], f_AB[..., chosen])
    first, total = evaluated.indices(np.arange(samples))
    low, high = _intervals(evaluated, study.draws.seed, confidence, resamples)
    linear = {name: linear_shares(groups, gradient) for name, gradient in (gradients or {}).items()}
    shares = tuple(
        Share(
            group,
            quantity,
            Interval(float(first[q, g]), float(low[0, q, g]), float(high[0, q, g])),
            Interval(float(total[q, g]), float(low[1, q, g]), float(high[1, q, g])),
            float(linear[quantity][g]) if quantity in linear else None,
        )
        for q, quantity in enumerate(names)
        for g, group in enumerate(groups.names)
    )
    both = np.concatenate([evaluated.f_A, evaluated.f_B], axis=1)
    mean, deviation = (tuple(map(float, each)) for each in (np.mean(both, axis=1), np.std(both, axis=1)))
    count = samples * (len(groups.members) + 2)
    return SobolShares(groups.names, names, shares, mean, deviation, count, lost)


def linear_shares(groups: Groups, gradient: FloatArray, samples: int = 4096) -> FloatArray:
    """Shares of the variance of a quantity that is linear with this ``gradient``, shape (groups,).

    From the variances of so many draws, which takes any shape of the sizes and what hangs together within a group.
    """
    draws = groups.draws
    x = draws.from_normals(draws.sequence.normals(draws.seed, 0, samples, draws.dimensions))
    varied = np.array([np.var(x[:, columns] @ gradient[columns]) for columns in groups.coordinates])
    whole = float(np.sum(varied))
    return varied / whole if whole > 0.0 else varied


def _evaluated(
    study: Study, groups: Groups, samples: int
) -> tuple[tuple[str, ...], FloatArray, FloatArray, FloatArray]:
    """Names of the quantities; their values for A, for B, and for A with one group at a time from B."""
    draws = groups.draws
    # Halves of one sequence: rows of two scrambled nets have their leading digits in common and are not independent.
    A, B = np.split(draws.sequence.normals(draws.seed, 0, samples, 2 * draws.dimensions), 2, axis=1)

    def values(z: FloatArray) -> FloatArray:
        return study.measures.of(draws.from_normals(z)).T

    def mixed(columns: IntArray) -> FloatArray:
        z = A.copy()
        z[:, columns] = B[:, columns]
        return values(z)

    names = study.measures.names
    with ThreadPoolExecutor(cores()) as pool:
        pages = list(pool.map(mixed, groups.normals))
    return names, values(A), values(B), np.stack(pages)


@dataclass(frozen=True, eq=False)
class _Evaluated:
    """Values for A and B, shape (quantities, samples), and for A with groups from B, (groups, quantities, samples)."""

    f_A: FloatArray
    f_B: FloatArray
    f_AB: FloatArray

    def indices(self, some: IntArray) -> FloatArray:
        """First and total order of a choice of the samples, shape (2, quantities, groups)."""
        from scipy.stats import sobol_indices

        # Of one group and one quantity scipy would make a bare number and stumble on it: two rows of the same.
        rows = np.arange(max(len(self.f_A), 2)) % len(self.f_A)
        # Picking copies: scipy centres what it is given in place.
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
