"""From one set of effects to the best within reach: rescored on the exact model, sought anew about each optimum.

Linear evidence explains its own error with one effect more, so the search starts anew about each optimum of the exact
model until the best set stays the best.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import islice

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.evidence import Scored, estimate, linear_evidence, search
from cycloid_profile.discrepancy.exact import ExactModel, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.sieve import left_open

_FINALISTS = 4
_SIMPLER = 2  # sets of each smaller number of members, and of two more
_AS_MANY, _ONE_MORE = 4, 8  # sets of as many members and of one more, that few rows are asked about
_LOOKED_AT = 400
_LINEAR_ERROR = 0.01  # of the evidence
_FEW_VARIANTS = 12
_SWAPPED = 2  # rivals for each member
_ELSEWHERE, _ELSEWHERE_REACH = 4, 40.0  # other places of each member, and how much less likely they may seem
_MORE_THAN_NOISE = 3.0  # standard deviations of chi², that of the noise counted
_HOPELESS_ON_FEW = 50.0  # of chi²
_SIEVE_STEPS = 3
_STEPS, _STEPS_AFTER_SIEVE = 8, 4
_CLOSE = 8.0
_BETTER = 0.05
LEAST_CONTRIBUTION = 1.0  # times the accuracy of the simulation

Start = tuple[list[int], FloatArray]
Found = dict[tuple[int, ...], Optimum]


class Climb:
    """A climb on one ``model``. ``found`` holds the sets rescored so far by their numbers in the library, and grows.

    At most ``rescorings`` sets are rescored: a search that leaves something must come to an end. ``thorough``: the
    neighbours of each best set are tried whether chi² is too large or not. ``sieve``, the same model of fewer rows:
    what is hopeless on it need not be rescored, and the worst take longest.
    """

    def __init__(
        self,
        model: ExactModel,
        library: Library,
        rescorings: int,
        tell: Callable[[str], None],
        found: Found | None = None,
        thorough: bool = False,
        sieve: ExactModel | None = None,
    ) -> None:
        self.model, self.library, self.tell = model, library, tell
        self._sieve = sieve
        self.found: Found = {} if found is None else found
        self._rescorings_left = rescorings
        self._thorough = thorough

    def with_library(self, library: Library, rescorings: int) -> Climb:
        """A climb in a larger library, whose first members are those of this one, with what was found so far."""
        return Climb(self.model, library, rescorings, self.tell, self.found, self._thorough, self._sieve)

    @property
    def ranked(self) -> list[Optimum]:
        """All sets rescored, best first; of those as good as each other the one that was found first."""
        return sorted(self.found.values(), key=lambda o: -round(o.log_evidence, 1))

    def up(self, starts: Sequence[Start], rounds: int) -> Optimum:
        """The best set within reach of the best of ``starts``."""
        best = self._rescored(starts, nothing(self.model), self._sieve)
        for number in range(rounds):
            self.tell(f"search about the best set so far, round {number + 1}")
            equations = about(self.model, self.library, best)
            places = self.library.places(best.members)
            proposals = search(equations, self.library.priors, keep=places)
            if not proposals:
                break
            short = self._thorough or leaves_something(self.model, best)
            challenger = self._rescored(self._proposed(equations, proposals, len(places), short), best, self._sieve)
            if short and not challenger.log_evidence > best.log_evidence + _BETTER:
                challenger = self._rescored(
                    self._new(equations, self._neighbours(equations, places)), best, self._sieve
                )
            if not challenger.log_evidence > best.log_evidence + _BETTER and not self.model.only_scans:
                challenger = self._rescored(self._new(equations, self._elsewhere(equations, places)), best, self._sieve)
            if not challenger.log_evidence > best.log_evidence + _BETTER:
                break
            best = challenger
        return best

    def judged(self, optima: Sequence[Optimum], best: Optimum) -> Optimum:
        """The best of sets that few rows leave open, fitted on the exact model, and of what was the best before."""
        return self.judge([(self.library.places(one.members), one.u) for one in optima], best)

    def judge(self, starts: Sequence[Start], best: Optimum, least: float = 0.0) -> Optimum:
        """The best of sets fitted on the exact model from ``starts``, and of what was the best before.

        ``least`` widths, below which a member need not be followed.
        """
        self._rescorings_left = max(self._rescorings_left, len(starts))
        return self._rescored(starts, best, None, least)

    def _rescored(
        self, starts: Sequence[Start], best: Optimum, sieve: ExactModel | None, least: float = 0.0
    ) -> Optimum:
        """The best of sets that pass the ``sieve``, fitted on the exact model, and of what was the best before."""
        asked = {tuple(sorted(members)): (members, u) for members, u in reversed(starts)}
        fresh = [start for key, start in reversed(asked.items()) if key not in self.found]
        if sieve is not None and best.members:
            fresh = self._sieved(sieve, fresh, best)
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
        """What comes through the sieve begins near its end."""
        few = self._sieve is not None and not self.model.solves_few_poses(self.library.members(members))
        return _STEPS_AFTER_SIEVE if few else _STEPS

    def _sieved(self, few: ExactModel, starts: Sequence[Start], best: Optimum) -> list[Start]:
        """Those that do best on few rows beside the best set, and where they do."""
        attempts = [Attempt(self.library.members(members), u, _SIEVE_STEPS) for members, u in starts]
        found = left_open(few, attempts, self.library.prior, best, _HOPELESS_ON_FEW)
        return [(self.library.places(one.members), one.u) for one in found[:_FINALISTS]]

    def _new(self, equations: Normal, sets: Iterable[tuple[int, ...]], most: int | None = None) -> list[Start]:
        """Where to begin with the first sets that were not rescored yet, all members contributing."""
        new = (members for members in sets if members and tuple(sorted(members)) not in self.found)
        starts = ((list(members), estimate(equations, members)[0]) for members in new)
        return list(islice((start for start in starts if all_contribute(equations, *start)), most))

    def _unlike(self, sets: Sequence[tuple[int, ...]], discs: bool = False) -> list[tuple[int, ...]]:
        """The first of the sets of each combination of names, or of names with their ``discs``."""
        first: dict[tuple[tuple[str, str], ...], tuple[int, ...]] = {}
        for members in sets:
            some = [self.library.candidates[i] for i in members]
            kind = sorted((c.name, str(c.choice.get("disc")) if discs else "") for c in some)
            first.setdefault(tuple(kind), members)
        return list(first.values())

    def _proposed(self, equations: Normal, proposals: Sequence[Scored], members: int, short: bool) -> list[Start]:
        """Sets worth to be rescored about a best set of so many ``members``."""
        reach = _CLOSE
        if short:
            # What linear evidence may be wrong by grows with it.
            reach = max(reach, _LINEAR_ERROR * proposals[0].log_evidence)
        close = [s.members for s in proposals[:_LOOKED_AT] if s.log_evidence > proposals[0].log_evidence - reach]
        wanted = self._new(equations, self._unlike(close), _FINALISTS)
        if short and self._sieve is not None:
            # It explains its own error with one effect more: the best of each number, many of one more than there are.
            for size, most in ((members, _AS_MANY), (members + 1, _ONE_MORE), (members + 2, _SIMPLER)):
                own = [s.members for s in proposals if len(s.members) == size][:_LOOKED_AT]
                wanted += self._new(equations, self._unlike(own, discs=True), most)
        for size in range(1, members):
            # One effect of another place may do what two were called for, and linear evidence not see it.
            fewer = [s.members for s in proposals if len(s.members) == size]
            wanted += self._new(equations, fewer[: 4 * _SIMPLER], _SIMPLER)
        return wanted

    def _elsewhere(self, equations: Normal, places: list[int]) -> list[tuple[int, ...]]:
        """Sets with one member at another place, which linear equations do not think much worse: cranks and discs turn
        the output nearly alike.
        """
        candidates, priors = self.library.candidates, self.library.priors
        least = linear_evidence(equations, priors, places) - _ELSEWHERE_REACH
        sets = []
        for place in places:
            others = [p for p in places if p != place]
            same = [i for i, c in enumerate(candidates) if c.name == candidates[place].name and i != place]
            scores = [(linear_evidence(equations, priors, [*others, i]), i) for i in same]
            near = sorted((score for score in scores if score[0] > least), reverse=True)
            sets += [(*others, i) for _, i in near[:_ELSEWHERE]]
        return sets

    def _neighbours(self, equations: Normal, places: list[int]) -> list[tuple[int, ...]]:
        """Sets with one member less, and with one member swapped for the candidates that fit best in its place."""
        candidates = self.library.candidates
        shown = [i for i in range(len(candidates)) if equations.R[2 * i, 2 * i] > 1e-2]
        sets = [tuple(p for p in places if p != place) for place in places]
        for place in places:
            # The same effect on another crank or disc looks much alike to first order.
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


def nothing(model: ExactModel) -> Optimum:
    """No effect at all."""
    none = np.zeros(0)
    state = model.nothing
    rows = sum(block.z.size for block in state.blocks)
    return Optimum((), none, np.zeros((0, 0)), np.zeros((0, 0)), state.chi2, rows, 0.0, True)


def about(model: ExactModel, library: Library, optimum: Optimum) -> Normal:
    """Equations of the library linearised about an optimum, told from zero."""
    equations = normal(model.at(optimum).blocks, library.candidates)
    return equations.about(library.places(optimum.members), optimum.u)


def leaves_something(model: ExactModel, optimum: Optimum, deviations: float = _MORE_THAN_NOISE) -> bool:
    """Whether the chi² of some file says that more than noise is left, by so many of its standard deviations."""
    blocks = model.at(optimum).blocks
    return any(block.chi2 - block.z.size > deviations * float(np.sqrt(8.0 * block.z.size)) for block in blocks)


def contributes(model: ExactModel, optimum: Optimum) -> bool:
    """Whether every member of an optimum explains more than the simulation may err by.

    Linear about the optimum; where a little more of a member changes nothing at all, by the exact model without it: one
    that takes a disc out of contact explains a lot all the same.
    """
    state = model.at(optimum)
    equations = normal(state.blocks, optimum.members)
    everyone = list(range(len(optimum.members)))
    for i in everyone:
        if equations.contribution(everyone, optimum.u, i) >= LEAST_CONTRIBUTION:
            continue
        changes_nothing = equations.contribution([i], optimum.u[2 * i : 2 * i + 2], 0) < LEAST_CONTRIBUTION
        if not (changes_nothing and _missed(model, optimum, state, equations, i)):
            return False
    return True


def _missed(model: ExactModel, optimum: Optimum, state: State, equations: Normal, i: int) -> bool:
    """Whether some file fits worse without member ``i`` by more than the simulation may err by."""
    others = [m for j, m in enumerate(optimum.members) if j != i]
    without = model.state(others, np.delete(optimum.u, [2 * i, 2 * i + 1]))
    if without is None:
        return False
    files = zip(without.blocks, state.blocks, equations.parts, strict=True)
    return any(part.over_accuracy(a.chi2 - b.chi2) >= LEAST_CONTRIBUTION for a, b, part in files)


def all_contribute(equations: Normal, members: list[int], u: FloatArray) -> bool:
    """The same of a set of linear equations at coordinates ``u``."""
    return all(equations.contribution(members, u, i) >= LEAST_CONTRIBUTION for i in range(len(members)))
