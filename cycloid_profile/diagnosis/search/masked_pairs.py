"""Pairs of effects that one other effect imitates on a subsample: repeated on all rows.

One effect may change the curves almost like two others. The residual is then within the scatter of chi², but exceeds
its threshold at single orders, mostly the mesh order.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cycloid_profile.diagnosis.model.candidate import Variety
from cycloid_profile.diagnosis.model.detection import detect_given, worst_residual
from cycloid_profile.diagnosis.model.evidence import log_evidence_at
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import normal_equations
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search.initial_pairs import fitted_pairs, likely_pairs
from cycloid_profile.diagnosis.search.local_search import Start
from cycloid_profile.measurement import PROFILE_SCAN

_COMPARED, _STARTS = 40, 4  # pairs compared on all rows, and pairs of different variety fitted on them
_SAME = 0.01  # of chi²: discs with identical fits count once

_Kind = tuple[Variety, ...]


def may_mask_pair(model: ExactModel, best: Optimum) -> bool:
    """Whether two other effects could explain the data as well as the best set.

    True where the residual is significant. Effects without direction can imitate others completely: with them the
    answer is true wherever all rows are cheap and no scan exists.
    """
    amounts = any(member.angle is None for member in best.members)
    scans = any(recording.kind is PROFILE_SCAN for recording in model.recordings)
    return (amounts and not scans and model.solves_few_poses(best.members)) or residual_is_significant(model, best)


def residual_is_significant(model: ExactModel, best: Optimum) -> bool:
    """Whether the residual of the best set is significant and exceeds the accuracy of the simulation."""
    left = detect_given(model.at(best).blocks, best.members)
    return worst_residual(left, model.baseline.blocks) is not None


def masked_pairs(
    model: ExactModel,
    subsampled: ExactModel,
    library: Library,
    ranked_singles: Sequence[Optimum],
    progress: Callable[[str], None],
) -> list[Start]:
    """Starting pairs on all rows that may be better than the best set.

    All pairs that keep most poses equivalent. The others are fitted on the subsample, and the most promising by the
    equations of all rows are kept. ``ranked_singles``: best single effects on the subsample.
    """
    quick, slow = list[Start](), list[Start]()
    for start in likely_pairs(subsampled, library):
        (quick if model.solves_few_poses(library.members(start[0])) else slow).append(start)
    beat = ranked_singles[0].misfit if ranked_singles else subsampled.baseline.chi2
    promised = _most_promising(model, library, fitted_pairs(subsampled, library, slow, beat, progress)) if slow else []
    return [*quick, *promised]


def _most_promising(model: ExactModel, library: Library, pairs: Sequence[Optimum]) -> list[Start]:
    """Pairs with the largest evidence expected on all rows, linearised at their optimum on the subsample."""
    promised = list[tuple[float, Optimum]]()
    for pair in _distinct(pairs)[:_COMPARED]:
        state = model.state(pair.members, pair.u)
        if state is None:
            continue
        everyone = list(range(len(pair.members)))
        own = normal_equations(state.blocks, pair.members).about(everyone, pair.u)
        covariance = np.asarray(np.linalg.inv(np.eye(pair.u.size) + own.R), dtype=np.float64)
        u = covariance @ own.b
        fall = model.baseline.chi2 - float(own.chi2 - 2.0 * u @ own.b + u @ own.R @ u)
        value = log_evidence_at(fall, u, covariance, library.prior(pair.members), pair.members)
        promised.append((value, pair))
    best: dict[_Kind, Optimum] = {}
    for _, pair in sorted(promised, key=lambda p: -p[0]):
        best.setdefault(_kind(pair), pair)
    return [(library.places(pair.members), pair.u) for pair in list(best.values())[:_STARTS]]


def _distinct(pairs: Sequence[Optimum]) -> list[Optimum]:
    """Pairs without those that differ in the disc only and fit equally well."""
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
