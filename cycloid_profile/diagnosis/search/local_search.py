"""Local search: from starting sets to the best neighbouring set, scored with the exact model.

Errors of the linear model can appear as an additional effect. The search therefore relinearises about each new optimum
until the best set remains the best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import islice

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.evidence import Scored, estimate, linear_evidence, rank_sets
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations, normal_equations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.subsampling import prefilter_attempts

_FINALISTS = 4  # sets of each kind that are fitted exactly in one round
_SIMPLER = 2  # sets of each smaller size, and of two more members
_AS_MANY, _ONE_MORE = 4, 8  # sets of the same size and of one more member that the prefilter receives
_MAX_CANDIDATES = 400  # linear sets compared by names: bounds the time of a flat ranking
_LINEAR_ERROR = 0.01  # share of the evidence
_FEW_VARIANTS = 12  # of one effect: up to this number all are proposed
_SWAPPED = 2  # alternatives for each member
_LOCATIONS, _LOCATIONS_REACH = 4, 40.0  # other locations of each member, and the largest deficit in evidence
_MORE_THAN_NOISE = 3.0  # standard deviations of chi², including the scatter of the noise estimate
_ABANDONED_ON_SUBSAMPLE = 50.0  # of chi²
_PREFILTER_STEPS = 3  # on the subsample, enough to rank
_STEPS, _STEPS_AFTER_PREFILTER = 8, 4  # a fit from the prefilter starts near its optimum
_CLOSE = 8.0  # of the evidence: allows for the error of linear evidence
_BETTER = 0.05  # of the evidence: a smaller gain is the tolerance of convergence
LEAST_CONTRIBUTION = 1.0  # times the accuracy of the simulation

Start = tuple[list[int], FloatArray]
Found = dict[tuple[int, ...], Optimum]


class LocalSearch:
    """Search on one ``model``. ``found`` maps library indices to the optima of all sets fitted so far.

    ``rescorings`` limits the number of exact fits. ``thorough``: try the neighbours of each best set even if chi² is
    within its scatter. ``prefilter``: the same model with fewer rows, which rejects improbable sets before the exact
    fit.
    """

    def __init__(
        self,
        model: ExactModel,
        library: Library,
        rescorings: int,
        progress: Callable[[str], None],
        found: Found | None = None,
        thorough: bool = False,
        prefilter: ExactModel | None = None,
    ) -> None:
        self.model, self.library, self.progress = model, library, progress
        self._prefilter = prefilter
        self.found: Found = {} if found is None else found
        self._rescorings_left = rescorings
        self._thorough = thorough

    def with_library(self, library: Library, rescorings: int) -> LocalSearch:
        """A search in an extended library that keeps the optima found so far."""
        return LocalSearch(self.model, library, rescorings, self.progress, self.found, self._thorough, self._prefilter)

    @property
    def ranked(self) -> list[Optimum]:
        """All fitted sets by decreasing evidence; equal ones in the order of discovery."""
        return sorted(self.found.values(), key=lambda o: -round(o.log_evidence, 1))

    def run(self, starts: Sequence[Start], rounds: int) -> Optimum:
        """Best set reachable from ``starts`` in at most ``rounds`` relinearisations."""
        best = self._rescored(starts, empty_optimum(self.model), self._prefilter)
        for number in range(rounds):
            self.progress(f"local search about the best set, round {number + 1}")
            equations = equations_about(self.model, self.library, best)
            places = self.library.places(best.members)
            proposals = rank_sets(equations, self.library.priors, keep=places)
            if not proposals:
                break
            short = self._thorough or leaves_residual(self.model, best)
            challenger = self._rescored(self._proposed(equations, proposals, len(places), short), best, self._prefilter)
            if short and not challenger.log_evidence > best.log_evidence + _BETTER:
                challenger = self._rescored(
                    self._new(equations, self._neighbours(equations, places)), best, self._prefilter
                )
            if not challenger.log_evidence > best.log_evidence + _BETTER and not self.model.only_scans:
                challenger = self._rescored(
                    self._new(equations, self._at_other_locations(equations, places)), best, self._prefilter
                )
            if not challenger.log_evidence > best.log_evidence + _BETTER:
                break
            best = challenger
        return best

    def best_of_optima(self, optima: Sequence[Optimum], best: Optimum) -> Optimum:
        """The best of ``best`` and of sets with ``optima`` on a subsample, fitted on this model."""
        return self.best_of_starts([(self.library.places(one.members), one.u) for one in optima], best)

    def best_of_starts(self, starts: Sequence[Start], best: Optimum, least: float = 0.0) -> Optimum:
        """The best of ``best`` and of sets fitted from ``starts``.

        Fits stop if a member falls below ``least`` widths.
        """
        self._rescorings_left = max(self._rescorings_left, len(starts))
        return self._rescored(starts, best, None, least)

    def _rescored(
        self, starts: Sequence[Start], best: Optimum, prefilter: ExactModel | None, least: float = 0.0
    ) -> Optimum:
        """The best of ``best`` and of the starts that pass ``prefilter``, fitted on this model."""
        asked = {tuple(sorted(members)): (members, u) for members, u in reversed(starts)}
        fresh = [start for key, start in reversed(asked.items()) if key not in self.found]
        if prefilter is not None and best.members:
            fresh = self._prefiltered(prefilter, fresh, best)
        fresh = fresh[: self._rescorings_left]
        self._rescorings_left -= len(fresh)
        beat = best.misfit if best.members else np.inf
        attempts = [
            Attempt(self.library.members(members), u, self._steps(members), beat, least=least) for members, u in fresh
        ]
        for (members, _), optimum in zip(fresh, self.model.optima(attempts, self.library.prior), strict=True):
            if optimum is not None and not optimum.implausible:
                self.found[tuple(sorted(members))] = optimum
        rescored = (self.found[key] for key in asked if key in self.found)
        return max([best, *rescored], key=lambda o: o.log_evidence)

    def _steps(self, members: Sequence[int]) -> int:
        """Fewer steps after the prefilter, whose optimum is a close start."""
        subsampled = self._prefilter is not None and not self.model.solves_few_poses(self.library.members(members))
        return _STEPS_AFTER_PREFILTER if subsampled else _STEPS

    def _prefiltered(self, subsampled: ExactModel, starts: Sequence[Start], best: Optimum) -> list[Start]:
        """Best starts on the subsample, moved to their optimum there."""
        attempts = [Attempt(self.library.members(members), u, _PREFILTER_STEPS) for members, u in starts]
        found = prefilter_attempts(subsampled, attempts, self.library.prior, best, _ABANDONED_ON_SUBSAMPLE)
        return [(self.library.places(one.members), one.u) for one in found[:_FINALISTS]]

    def _new(self, equations: NormalEquations, sets: Iterable[tuple[int, ...]], most: int | None = None) -> list[Start]:
        """Starts of the first ``most`` sets that have not been fitted and whose members all contribute."""
        new = (members for members in sets if members and tuple(sorted(members)) not in self.found)
        starts = ((list(members), estimate(equations, members)[0]) for members in new)
        return list(islice((start for start in starts if all_contribute(equations, *start)), most))

    def _distinct(self, sets: Sequence[tuple[int, ...]], discs: bool = False) -> list[tuple[int, ...]]:
        """First set of each combination of names, or of names and ``discs``."""
        first: dict[tuple[tuple[str, str], ...], tuple[int, ...]] = {}
        for members in sets:
            some = [self.library.candidates[i] for i in members]
            kind = sorted((c.name, str(c.choice.get("disc")) if discs else "") for c in some)
            first.setdefault(tuple(kind), members)
        return list(first.values())

    def _proposed(
        self, equations: NormalEquations, proposals: Sequence[Scored], members: int, short: bool
    ) -> list[Start]:
        """Sets to fit about a best set with ``members`` members."""
        reach = _CLOSE
        if short:
            # The error of linear evidence grows with the evidence.
            reach = max(reach, _LINEAR_ERROR * proposals[0].log_evidence)
        close = [s.members for s in proposals[:_MAX_CANDIDATES] if s.log_evidence > proposals[0].log_evidence - reach]
        wanted = self._new(equations, self._distinct(close), _FINALISTS)
        if short and self._prefilter is not None:
            # Linear evidence favours sets with one member too many, so several sizes are fitted.
            for size, most in ((members, _AS_MANY), (members + 1, _ONE_MORE), (members + 2, _SIMPLER)):
                own = [s.members for s in proposals if len(s.members) == size][:_MAX_CANDIDATES]
                wanted += self._new(equations, self._distinct(own, discs=True), most)
        for size in range(1, members):
            # One effect at another location may replace two. Linear evidence can miss that.
            fewer = [s.members for s in proposals if len(s.members) == size]
            wanted += self._new(equations, fewer[: 4 * _SIMPLER], _SIMPLER)
        return wanted

    def _at_other_locations(self, equations: NormalEquations, places: list[int]) -> list[tuple[int, ...]]:
        """Sets with one member at another location whose linear evidence is close: cranks and discs act on the output
        in nearly the same way.
        """
        candidates, priors = self.library.candidates, self.library.priors
        least = linear_evidence(equations, priors, places) - _LOCATIONS_REACH
        sets = []
        for place in places:
            others = [p for p in places if p != place]
            same = [i for i, c in enumerate(candidates) if c.name == candidates[place].name and i != place]
            scores = [(linear_evidence(equations, priors, [*others, i]), i) for i in same]
            near = sorted((score for score in scores if score[0] > least), reverse=True)
            sets += [(*others, i) for _, i in near[:_LOCATIONS]]
        return sets

    def _neighbours(self, equations: NormalEquations, places: list[int]) -> list[tuple[int, ...]]:
        """Sets without one member, and sets with one member replaced by its best alternatives."""
        candidates = self.library.candidates
        shown = [i for i in range(len(candidates)) if equations.R[2 * i, 2 * i] > 1e-2]
        sets = [tuple(p for p in places if p != place) for place in places]
        for place in places:
            # The same effect on another crank or disc is nearly identical to first order.
            same = [i for i, c in enumerate(candidates) if c.name == candidates[place].name and i != place]
            if len(same) < _FEW_VARIANTS:
                sets += [(*(p for p in places if p != place), i) for i in same if i in shown]
        for place in places:
            others = [p for p in places if p != place]
            taken = {candidates[p].name for p in others}
            scores = [
                (linear_evidence(equations, self.library.priors, [*others, i]), i)
                for i in shown
                if i not in places and candidates[i].name not in taken
            ]
            sets += [(*others, i) for _, i in sorted(scores, reverse=True)[:_SWAPPED]]
        return sets


def empty_optimum(model: ExactModel) -> Optimum:
    """Optimum of the empty set."""
    none = np.zeros(0)
    state = model.baseline
    rows = sum(block.z.size for block in state.blocks)
    return Optimum((), none, np.zeros((0, 0)), np.zeros((0, 0)), state.chi2, rows, 0.0, True)


def equations_about(model: ExactModel, library: Library, optimum: Optimum) -> NormalEquations:
    """Equations of the library, linearised about an optimum and referred to zero."""
    equations = normal_equations(model.at(optimum).blocks, library.candidates)
    return equations.about(library.places(optimum.members), optimum.u)


def leaves_residual(model: ExactModel, optimum: Optimum, deviations: float = _MORE_THAN_NOISE) -> bool:
    """Whether chi² of some file exceeds its expectation by more than ``deviations`` standard deviations."""
    blocks = model.at(optimum).blocks
    return any(block.chi2 - block.z.size > deviations * float(np.sqrt(8.0 * block.z.size)) for block in blocks)


def contributes(model: ExactModel, optimum: Optimum) -> bool:
    """Whether every member of an optimum explains more than the accuracy of the simulation in some file.

    Linear about the optimum. Where a small change of a member has no effect, the exact model without the member
    decides: an effect that takes a disc out of contact saturates.
    """
    state = model.at(optimum)
    equations = normal_equations(state.blocks, optimum.members)
    everyone = list(range(len(optimum.members)))
    for i in everyone:
        if equations.contribution(everyone, optimum.u, i) >= LEAST_CONTRIBUTION:
            continue
        changes_nothing = equations.contribution([i], optimum.u[2 * i : 2 * i + 2], 0) < LEAST_CONTRIBUTION
        if not (changes_nothing and _worse_without(model, optimum, state, equations, i)):
            return False
    return True


def _worse_without(model: ExactModel, optimum: Optimum, state: State, equations: NormalEquations, i: int) -> bool:
    """Whether some file fits worse without member ``i`` by more than the accuracy of the simulation."""
    others = [m for j, m in enumerate(optimum.members) if j != i]
    without = model.state(others, np.delete(optimum.u, [2 * i, 2 * i + 1]))
    if without is None:
        return False
    files = zip(without.blocks, state.blocks, equations.parts, strict=True)
    return any(part.over_accuracy(a.chi2 - b.chi2) >= LEAST_CONTRIBUTION for a, b, part in files)


def all_contribute(equations: NormalEquations, members: list[int], u: FloatArray) -> bool:
    """The same for linear equations at coordinates ``u``."""
    return all(equations.contribution(members, u, i) >= LEAST_CONTRIBUTION for i in range(len(members)))
