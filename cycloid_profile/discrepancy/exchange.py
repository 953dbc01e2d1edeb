"""Members of the best set exchanged for other names, on the exact model.

Some amounts (pins, infeed, plays, compliances) bend the curves so much alike that linear equations about one of them
misjudge the others by more than all rows tell them apart: who is right shows only where each is fitted.
"""

from __future__ import annotations

from cycloid_profile.discrepancy.climbing import Climb, about
from cycloid_profile.discrepancy.evidence import estimate, linear_evidence
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum

_ROUNDS = 2
_RIVALS = 12  # for each member
_LINEAR_ERROR = 0.01  # of what the member explains
_LEAST_REACH = 40.0  # of the evidence
_STEPS = 4
_OPEN = 30.0  # of chi² on few rows


def exchanged(climb: Climb, few: ExactModel, best: Optimum) -> Optimum:
    """The best of a set and of those with one member of another name, which ``few`` rows leave open."""
    for _ in range(_ROUNDS):
        mine = few.optimum(Attempt(best.members, best.u, _STEPS), climb.library.prior(best.members))
        if mine is None:
            break
        equations = about(climb.model, climb.library, best)
        attempts = [
            Attempt(climb.library.members(places), estimate(equations, places)[0], _STEPS, mine.misfit)
            for places in _swaps(climb, equations, climb.library.places(best.members))
        ]
        fitted = few.optima(attempts, climb.library.prior)
        still_open = [one for one in fitted if one is not None and one.misfit < mine.misfit + _OPEN]
        better = climb.judged(still_open, best)
        if not better.log_evidence > best.log_evidence:
            break
        best = better
    return best


def _swaps(climb: Climb, equations: Normal, places: list[int]) -> list[list[int]]:
    """Sets with a member exchanged for the nearest of each other name that linear equations leave open, of one disc
    and of all.
    """
    library, sets = climb.library, []
    whole = linear_evidence(equations, library.priors, places)
    for place in places:
        others = [p for p in places if p != place]
        taken = {library.candidates[p].name for p in places}
        alone = linear_evidence(equations, library.priors, others)
        least = whole - max(_LEAST_REACH, _LINEAR_ERROR * (whole - alone))
        nearest: dict[tuple[str, bool], tuple[float, int]] = {}
        for i, candidate in enumerate(library.candidates):
            score = (linear_evidence(equations, library.priors, [*others, i]), i)
            if candidate.name not in taken and score[0] > least:
                nearest[candidate.name_and_extent] = max(score, nearest.get(candidate.name_and_extent, score))
        sets += [[*others, i] for _, i in sorted(nearest.values(), reverse=True)[:_RIVALS]]
    return sets
