"""Exact fits of sets of effects on one selection of rows, and the simplest set that explains enough."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search._determined import determined
from cycloid_profile.diagnosis.search.lobe_index import with_offsets

Key = tuple[frozenset[Candidate], tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Fit:
    """The optimum of a set with the lobe index of each file raised by ``offsets``."""

    optimum: Optimum
    offsets: tuple[int, ...]

    @property
    def key(self) -> Key:
        """Members and lobe indices, compared by value."""
        return frozenset(self.optimum.members), self.offsets

    @property
    def kind(self) -> tuple[tuple[Variety, ...], tuple[int, ...]]:
        """What the members are, whatever their places, with the lobe indices."""
        return tuple(sorted((member.variety for member in self.optimum.members), key=str)), self.offsets

    def adds_nothing_to(self, other: Fit) -> bool:
        """Whether this set has the members of another and more, for hardly more evidence."""
        return self.key[0] > other.key[0] and self.evidence < other.evidence + tuned.OPEN

    @property
    def evidence(self) -> float:
        """Log evidence; equal ones keep the order of discovery."""
        return round(self.optimum.log_evidence, 1)


def empty_fit(model: ExactModel) -> Fit:
    """The model without effects."""
    none, state = np.zeros(0), model.baseline
    rows = sum(block.z.size for block in state.blocks)
    empty = Optimum((), none, np.zeros((0, 0)), np.zeros((0, 0)), state.chi2, state.misfit, rows, 0.0, True)
    return Fit(empty, (0,) * len(model.recordings))


class Fits:
    """The best fit of each set, the model without effects first, and the model of each lobe index."""

    def __init__(self, model: ExactModel) -> None:
        none = empty_fit(model)
        self._first = model
        self._models = {none.offsets: model}
        self._best = {none.key: none}

    def __contains__(self, key: Key) -> bool:
        return key in self._best

    def __iter__(self) -> Iterator[Fit]:
        return iter(self._best.values())

    def model(self, offsets: tuple[int, ...]) -> ExactModel:
        """The model with these lobe indices."""
        if offsets not in self._models:
            self._models[offsets] = with_offsets(self._first, offsets)
        return self._models[offsets]

    def keep(self, fit: Fit) -> None:
        """Keep a fit, unless one of the same set has as much evidence."""
        known = self._best.get(fit.key)
        if known is None or fit.optimum.log_evidence > known.optimum.log_evidence:
            self._best[fit.key] = fit

    def _keep_closer(self, fit: Fit) -> None:
        """Keep a fit, unless one of the same set leaves no more."""
        known = self._best.get(fit.key)
        if known is None or fit.optimum.misfit < known.optimum.misfit:
            self._best[fit.key] = fit

    @property
    def ranked(self) -> list[Fit]:
        """All fits by decreasing evidence."""
        return sorted(self, key=lambda one: -one.evidence)

    @property
    def best(self) -> Fit:
        """The fit with the largest evidence, the first of equals."""
        return max(self, key=lambda one: one.evidence)

    def fit_best_closely(self, library: Library) -> None:
        """Fit the sets that may be chosen to the last step: an earlier end can hide more than it promised to gain."""
        ranked = self._ranked_at_variance(self.best.optimum.residual_variance)
        for one in ranked:
            members, stalled = one.optimum.members, one.optimum.stalled
            if members and not stalled and one.evidence > ranked[0].evidence - tuned.DISTINGUISHED:
                closer = self.model(one.offsets).optimum(Attempt(members, one.optimum.u), library.prior(members))
                if closer is not None:
                    self._keep_closer(Fit(closer, one.offsets))

    def _ranked_at_variance(self, variance: float) -> list[Fit]:
        """All fits by decreasing evidence, with this ``variance`` in units of that of the noise, at least 1.

        Without that of the best, members that mend what no effect explains pass for significant (Miller and Dunson
        2019).
        """
        return sorted((self._at_variance(one, variance) for one in self), key=lambda one: -one.evidence)

    def _at_variance(self, one: Fit, variance: float) -> Fit:
        gained = 0.5 * (self.model(one.offsets).baseline.misfit - one.optimum.misfit)
        evidence = one.optimum.log_evidence - (1.0 - 1.0 / variance) * gained
        return replace(one, optimum=replace(one.optimum, log_evidence=evidence))

    def simplest(self, library: Library, progress: Callable[[str], None]) -> tuple[Fit, list[Fit]]:
        """The best of the sets with fewest effects, among those whose evidence is not clearly below the best; and all
        fits by decreasing evidence.

        Members of the best set are left out in turn, as long as the rest is not clearly worse and leaves no more beyond
        the noise.
        """
        variance = self.best.optimum.residual_variance
        best = chosen = self._ranked_at_variance(variance)[0]
        while len(chosen.optimum.members) > 1:
            progress("fitting parts of the best set of effects")
            parts = [self._at_variance(one, variance) for one in self._parts(chosen, library)]
            enough = [one for one in parts if one.optimum.residual_variance <= best.optimum.residual_variance]
            near = [one for one in enough if self._below(one, best, variance) < tuned.DISTINGUISHED]
            if not near:
                break
            chosen = max(near, key=lambda one: one.evidence)
        ranked = self._ranked_at_variance(variance)
        least, most = best.evidence - tuned.DISTINGUISHED, len(chosen.optimum.members)
        near = [
            one
            for one in ranked
            if one.evidence > least or (len(one.optimum.members) <= most and one.evidence > chosen.evidence)
        ]
        return min([chosen, *near], key=lambda one: (len(one.optimum.members), -one.evidence)), ranked

    def _below(self, part: Fit, whole: Fit, variance: float) -> float:
        """Evidence of a part of a set below that of the whole, with the error of the model as in ``deficit``."""
        own = 0.5 * (part.optimum.misfit - whole.optimum.misfit)
        less = own - self.model(whole.offsets).deficit(part.optimum, whole.optimum)
        return whole.evidence - part.evidence - less / variance

    def _parts(self, fit: Fit, library: Library) -> list[Fit]:
        """The subsets of a set that lack one member, fitted closely however much worse they are.

        Those with members that are not determined are left out.
        """
        found, model, size = [], self.model(fit.offsets), len(fit.optimum.members)
        for i in range(size):
            members, start = fit.optimum.part([k for k in range(size) if k != i])
            optimum = model.optimum(Attempt(members, start), library.prior(members))
            if optimum is not None and not optimum.implausible and len(determined(model, optimum)) == len(members):
                self._keep_closer(Fit(optimum, fit.offsets))
            key = frozenset(members), fit.offsets
            if key in self:
                found.append(self._best[key])
        return found
