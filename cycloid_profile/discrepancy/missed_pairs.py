"""Pairs of effects that few rows do not tell from what fits them as well: asked again on all rows.

One effect may bend the curves so much like two others that what it leaves is within the scatter of chi², and still
stands out of all rows, at the order of the mesh most of all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cycloid_profile.discrepancy.candidates import Variety
from cycloid_profile.discrepancy.climbing import Start
from cycloid_profile.discrepancy.evidence import log_evidence_at
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.left_over import detect_beside, worst_left
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.starting_pairs import fitted_pairs, likely_pairs

_ASKED, _STARTS = 40, 4  # pairs that all rows are asked about, and unlike ones that are fitted on them
_SAME = 0.01  # of chi²: of discs that show alike one is enough

_Kind = tuple[Variety, ...]


def may_hide_a_pair(model: ExactModel, best: Optimum) -> bool:
    """Whether two other effects could be behind the best set.

    Where something stands out of what it leaves. Amounts bend the curves so much alike that nothing need be left: of
    these always where few poses stand for all rows, and no scan tells more.
    """
    amounts = any(member.angle is None for member in best.members)
    scans = any(recording.kind == "profile_scan" for recording in model.recordings)
    return (amounts and not scans and model.solves_few_poses(best.members)) or stands_out(model, best)


def stands_out(model: ExactModel, best: Optimum) -> bool:
    """Whether what the best set leaves is more than chance and the error of the simulation, however little of chi²."""
    left = detect_beside(model.at(best).blocks, best.members)
    return worst_left(left, model.nothing.blocks) is not None


def missed_pairs(
    model: ExactModel,
    few: ExactModel,
    library: Library,
    lead: Sequence[Optimum],
    tell: Callable[[str], None],
) -> list[Start]:
    """Where to begin on all rows with pairs that may do better than the best set.

    Of those that few poses stand for every one that could; of the others, fitted on ``few`` rows, those that the
    equations of all rows promise most of. ``lead``, the single effects that do best on the few rows.
    """
    quick, slow = list[Start](), list[Start]()
    for start in likely_pairs(few, library):
        (quick if model.solves_few_poses(library.members(start[0])) else slow).append(start)
    beat = lead[0].misfit if lead else few.nothing.chi2
    promised = _promised(model, library, fitted_pairs(few, library, slow, beat, tell)) if slow else []
    return [*quick, *promised]


def _promised(model: ExactModel, library: Library, pairs: Sequence[Optimum]) -> list[Start]:
    """Where to begin with the pairs that the equations of all rows promise most of, about where few rows put them."""
    promised = list[tuple[float, Optimum]]()
    for pair in _unlike(pairs)[:_ASKED]:
        state = model.state(pair.members, pair.u)
        if state is None:
            continue
        everyone = list(range(len(pair.members)))
        own = normal(state.blocks, pair.members).about(everyone, pair.u)
        covariance = np.asarray(np.linalg.inv(np.eye(pair.u.size) + own.R), dtype=np.float64)
        u = covariance @ own.b
        fall = model.nothing.chi2 - float(own.chi2 - 2.0 * u @ own.b + u @ own.R @ u)
        value = log_evidence_at(fall, u, covariance, library.prior(pair.members), pair.members)
        promised.append((value, pair))
    best: dict[_Kind, Optimum] = {}
    for _, pair in sorted(promised, key=lambda p: -p[0]):
        best.setdefault(_kind(pair), pair)
    return [(library.places(pair.members), pair.u) for pair in list(best.values())[:_STARTS]]


def _unlike(pairs: Sequence[Optimum]) -> list[Optimum]:
    """Without those that differ by their disc alone and fit the same."""
    seen: dict[_Kind, list[float]] = {}
    kept = []
    for pair in pairs:
        known = seen.setdefault(_kind(pair), [])
        if all(abs(pair.misfit - other) > _SAME for other in known):
            known.append(pair.misfit)
            kept.append(pair)
    return kept


def _kind(pair: Optimum) -> _Kind:
    return tuple(sorted((member.variety for member in pair.members), key=str))
