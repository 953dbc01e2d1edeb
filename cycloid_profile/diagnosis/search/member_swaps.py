"""Replacement of members of the best set by other effects, evaluated with the exact model.

Effects without direction (pins, infeed, clearances, compliances) change the curves in nearly the same way. The error of
linear equations exceeds the difference between them, so each replacement is fitted.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import combinations

from cycloid_profile.diagnosis.model.candidate import Variety
from cycloid_profile.diagnosis.model.evidence import estimate, linear_evidence
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.local_search import LocalSearch, Start, equations_about
from cycloid_profile.diagnosis.search.subsampling import prefilter_attempts
from cycloid_profile.diagnosis.search.symmetric_parts import on_other_parts

_ROUNDS = 2  # one member after the other, for two wrong members
_ALTERNATIVES = 16  # for each member
_IN_PLACE_OF_TWO, _PLACES = 16, 3  # sets of each two members, and locations of one name in them
_LINEAR_ERROR = 0.01  # share of the evidence of the member
_LEAST_REACH = 40.0  # least range of evidence
_STEPS = 4  # of a replaced member: the others start at their optimum
_OPEN = 30.0  # of chi² on the subsample


def swap_members(local_search: LocalSearch, subsampled: ExactModel, best: Optimum) -> Optimum:
    """Best of a set and its replacements, repeated until none is better.

    Replacements that keep most poses equivalent are fitted on all rows; the others first pass the ``subsampled`` model.
    """
    for _ in range(_ROUNDS):
        equations = equations_about(local_search.model, local_search.library, best)
        quick, slow = list[Start](), list[Start]()
        for places in _swaps(local_search, equations, local_search.library.places(best.members)):
            at_once = subsampled is local_search.model or local_search.model.solves_few_poses(
                local_search.library.members(places)
            )
            some = quick if at_once else slow
            some.append((places, estimate(equations, places)[0]))
        better = local_search.best_of_starts(quick, best)
        attempts = [Attempt(local_search.library.members(places), u, _STEPS) for places, u in slow]
        better = local_search.best_of_optima(
            prefilter_attempts(subsampled, attempts, local_search.library.prior, best, _OPEN), better
        )
        better = local_search.best_of_starts(on_other_parts(local_search), better)
        if not better.log_evidence > best.log_evidence:
            break
        best = better
    return best


def _swaps(local_search: LocalSearch, equations: NormalEquations, places: list[int]) -> list[list[int]]:
    """Sets with one member replaced by a similar one of another variety, and sets with one member in place of two."""
    library, sets = local_search.library, []
    whole = linear_evidence(equations, library.priors, places)
    for place in places:
        others = [p for p in places if p != place]
        taken = {library.candidates[p].name for p in places}
        alone = linear_evidence(equations, library.priors, others)
        least = whole - max(_LEAST_REACH, _LINEAR_ERROR * (whole - alone))
        sets += _nearest(local_search, equations, others, taken, _ALTERNATIVES, 1, least)
    for two in combinations(places, 2):
        others = [p for p in places if p not in two]
        if local_search.model.solves_few_poses(library.members(others)):
            taken = {library.candidates[p].name for p in others}
            sets += _nearest(local_search, equations, others, taken, _IN_PLACE_OF_TWO, _PLACES)
    return sets


def _nearest(
    local_search: LocalSearch,
    equations: NormalEquations,
    others: list[int],
    taken: set[str],
    most: int,
    places: int,
    least: float = -math.inf,
) -> list[list[int]]:
    """At most ``most`` sets of ``others`` and one candidate whose name is not ``taken``, best linear evidence first.

    At most ``places`` sets of each variety; ``least``: smallest evidence.
    """
    library = local_search.library
    count: Counter[Variety] = Counter()
    found = []
    scored = [
        (linear_evidence(equations, library.priors, [*others, i]), i)
        for i, candidate in enumerate(library.candidates)
        if candidate.name not in taken
    ]
    for value, i in sorted(scored, reverse=True):
        variety = library.candidates[i].variety
        if value > least and count[variety] < places:
            count[variety] += 1
            found.append([*others, i])
    return found[:most]
