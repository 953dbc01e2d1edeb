"""Lobes of a scan counted beside effects that were fitted on the exact model.

Linear equations count them first (``lobes``), and do not know what all discs share: that cancels on the bench to first
order, and half a turn on hardly differs there at all.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.evidence import search
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import recounted
from cycloid_profile.discrepancy.normal import normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.starting import leading_singles
from cycloid_profile.discrepancy.thinning import fewest

_LEADING = 2  # single effects, each with itself half a turn on
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


def counted_by_curves(
    model: ExactModel, library: Library, best: Optimum, gain: float, tell: Callable[[str], None]
) -> tuple[ExactModel, Optimum]:
    """The model with its lobes counted by a single effect that the other files show alone, with that effect; or the
    model itself and ``best``, the best single effect in the present count, where that explains as much.

    Judged on few rows, as many as show a ``gain`` in chi².

    An effect fitted to a scan of the wrong count comes to rest between what the scan and what the other files say.
    """
    counting = Library(tuple(c for c in library.candidates if _counts_lobes(model, c)), library.frequencies)
    others = model.without_scans()
    if not counting.candidates or not others.recordings:
        return model, best
    few, few_others = fewest(model, gain), fewest(others, gain)
    equations = normal(others.nothing.blocks, counting.candidates)
    tell("which lobe is the first: single effects on the other files")
    linear = search(equations, counting.priors, 1)
    shown = 2.0 * linear[0].log_evidence if linear else 0.0
    shown_by_best = few_others.state(best.members, best.u)
    hopeless = np.inf if shown_by_best is None else shown_by_best.chi2
    singles = [
        single
        for single in leading_singles(few_others, counting, equations, shown, lambda _: None)
        if single.chi2 < hopeless
    ]
    leading = list({single.members[0]: single for single in reversed(singles)}.values())[::-1][:_LEADING]
    found = model
    for one in [each for single in leading for each in (single, *(turned for _, turned in single.turned_round()))]:
        alike = Library(tuple(c for c in counting.candidates if c.name == one.members[0].name), library.frequencies)
        if few.state(one.members, one.u) is None:
            continue
        counted = recounted(model, few, alike, one)
        optimum = fewest(counted, gain).optimum(Attempt(one.members, one.u), library.prior(one.members))
        if optimum is not None and optimum.log_evidence > best.log_evidence:
            found, best = counted, optimum
    return found, best


def _counts_lobes(model: ExactModel, candidate: Candidate) -> bool:
    """Whether the candidate shows on a scan, and otherwise from another lobe on."""
    choice, turn = candidate.turned(1, model.built.case.drive.trochoid.lobes)
    if (choice == candidate.choice and turn == 0.0) or "waves_per_turn" in choice:
        return False
    scans = (r.disc for r in model.recordings if r.kind == "profile_scan")
    return any(model.probes.touches(candidate, disc) for disc in scans)
