"""Lobes of a scan counted beside effects that were fitted on the exact model.

Linear equations count them first (``lobes``), and do not know what all discs share: that cancels on the bench to first
order, and half a turn on hardly differs there at all.
"""

from __future__ import annotations

from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import recounted
from cycloid_profile.discrepancy.optimum import Attempt, Optimum

_STEPS = 3
_OPEN = 10.0  # of the evidence: a model of few rows that has less is right


def counted_anew(model: ExactModel, few: ExactModel, library: Library, best: Optimum) -> tuple[ExactModel, Optimum]:
    """The model with its lobes counted as the ``best`` set has them, or as it has them half a turn on if that fits
    better, and where to begin on it; the same model where the count stays.

    ``few``, the same model of fewer rows, suspects another count; the model itself decides on it.
    """
    if not best.members:
        return model, best
    mine = _again(few, best, library)
    if mine is None or recounted(few, few, library, mine) is not few:
        counted = recounted(model, model, library, best)
        if counted is not model:
            return counted, best
    for _, other in best.turned_round():
        if mine is not None and not _as_good(few, library, other, mine):
            continue
        if model.state(other.members, other.u) is None:
            continue
        counted = recounted(model, model, library, other)
        if counted is not model:
            attempt = Attempt(other.members, other.u, beat=best.misfit)
            found = counted.optimum(attempt, library.prior(other.members))
            if found is not None and found.log_evidence > best.log_evidence:
                return counted, found
    return model, best


def _again(few: ExactModel, best: Optimum, library: Library) -> Optimum | None:
    """A set on few rows, from where it came to rest on more."""
    return few.optimum(Attempt(best.members, best.u, _STEPS), library.prior(best.members))


def _as_good(few: ExactModel, library: Library, other: Optimum, mine: Optimum) -> bool:
    """Whether few rows leave open that a set fits better than ``mine`` with the lobes counted as it has them."""
    if few.state(other.members, other.u) is None:
        return False
    found = _again(recounted(few, few, library, other), other, library)
    return found is not None and found.log_evidence > mine.log_evidence - _OPEN
