"""Members of the best set exchanged for other names, on the exact model.

Some amounts (pins, infeed, plays, compliances) bend the curves so much alike that linear equations about one of them
misjudge the others by more than all rows tell them apart: who is right shows only where each is fitted.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import combinations

from cycloid_profile.discrepancy.candidates import Variety
from cycloid_profile.discrepancy.climbing import Climb, Start, about
from cycloid_profile.discrepancy.evidence import estimate, linear_evidence
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.other_parts import of_other_parts
from cycloid_profile.discrepancy.sieve import left_open

_ROUNDS = 2
_RIVALS = 16  # for each member
_IN_PLACE_OF_TWO, _PLACES = 16, 3
_LINEAR_ERROR = 0.01  # of what the member explains
_LEAST_REACH = 40.0  # of the evidence
_STEPS = 4
_OPEN = 30.0  # of chi² on few rows


def exchanged(climb: Climb, few: ExactModel, best: Optimum) -> Optimum:
    """The best of a set and of those with one member of another name: fitted on all rows where few poses stand for
    these, else where ``few`` rows leave them open.
    """
    for _ in range(_ROUNDS):
        equations = about(climb.model, climb.library, best)
        quick, slow = list[Start](), list[Start]()
        for places in _swaps(climb, equations, climb.library.places(best.members)):
            at_once = few is climb.model or climb.model.solves_few_poses(climb.library.members(places))
            some = quick if at_once else slow
            some.append((places, estimate(equations, places)[0]))
        better = climb.judge(quick, best)
        attempts = [Attempt(climb.library.members(places), u, _STEPS) for places, u in slow]
        better = climb.judged(left_open(few, attempts, climb.library.prior, best, _OPEN), better)
        better = climb.judge(of_other_parts(climb), better)
        if not better.log_evidence > best.log_evidence:
            break
        best = better
    return best


def _swaps(climb: Climb, equations: Normal, places: list[int]) -> list[list[int]]:
    """Sets with a member exchanged for the nearest of each other variety that linear equations leave open; and with one
    in place of two where few poses stand for all rows.
    """
    library, sets = climb.library, []
    whole = linear_evidence(equations, library.priors, places)
    for place in places:
        others = [p for p in places if p != place]
        taken = {library.candidates[p].name for p in places}
        alone = linear_evidence(equations, library.priors, others)
        least = whole - max(_LEAST_REACH, _LINEAR_ERROR * (whole - alone))
        sets += _nearest(climb, equations, others, taken, _RIVALS, 1, least)
    for two in combinations(places, 2):
        others = [p for p in places if p not in two]
        if climb.model.solves_few_poses(library.members(others)):
            taken = {library.candidates[p].name for p in others}
            sets += _nearest(climb, equations, others, taken, _IN_PLACE_OF_TWO, _PLACES)
    return sets


def _nearest(
    climb: Climb,
    equations: Normal,
    others: list[int],
    taken: set[str],
    most: int,
    places: int,
    least: float = -math.inf,
) -> list[list[int]]:
    """At ``most`` so many sets of the ``others`` and one more of a name not ``taken``, the likeliest by linear
    equations first, ``places`` of each variety, none less likely than ``least``.
    """
    library = climb.library
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
