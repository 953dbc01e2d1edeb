"""Sets of effects that fewer rows than all leave open: the hopeless take longest to fit on all."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.optimum import Attempt, Optimum


def left_open(
    few: ExactModel,
    attempts: Sequence[Attempt],
    prior: Callable[[Sequence[Candidate]], float],
    best: Optimum,
    reach: float,
) -> list[Optimum]:
    """The attempts that ``few`` rows put at most ``reach`` of chi² above what they leave of the ``best`` set, fitted on
    them, likeliest first.
    """
    mine = few.optimum(Attempt(best.members, best.u), prior(best.members)) if attempts else None
    if mine is None:
        return []
    beat = [Attempt(one.members, one.start, one.steps, mine.misfit) for one in attempts]
    fitted = [one for one in few.optima(beat, prior) if one is not None and one.misfit < mine.misfit + reach]
    return sorted(fitted, key=lambda one: -one.log_evidence)
