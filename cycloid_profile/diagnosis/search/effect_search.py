"""Search for the set of effects that explains the data best: subsample, all rows, swaps, pairs, chatter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.lobe_index import reindexed_for
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search.chatter_candidates import (
    significant_chatter,
    with_alternative_waves,
    with_masked_waves,
    with_refitted_waves,
    with_waves_given_others,
)
from cycloid_profile.diagnosis.search.finite_pairs import LINEAR_LIMIT, pairs_of_finite_size
from cycloid_profile.diagnosis.search.local_search import (
    LocalSearch,
    Start,
    contributes,
    empty_optimum,
    equations_about,
    leaves_residual,
)
from cycloid_profile.diagnosis.search.masked_pairs import masked_pairs, may_mask_pair
from cycloid_profile.diagnosis.search.member_swaps import swap_members
from cycloid_profile.diagnosis.search.scan_led_search import indexed_from_scans
from cycloid_profile.diagnosis.search.seam import indexed_from_seams
from cycloid_profile.diagnosis.search.subsampled_search import search_subsampled
from cycloid_profile.diagnosis.search.subsampling import smallest_subsample
from cycloid_profile.measurement import HYSTERESIS

_RESCORINGS = 8  # exact fits of one local search on all rows
_FINAL_ROUNDS = 2  # the starts are optima of a subsample, near those of all rows
_REINDEXINGS = 2  # a search that keeps its lobe index is the last
_FEW_MEMBERS = 2  # largest set that two other effects may replace


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Best set, the equations linearised about it and referred to zero, and all fitted sets by decreasing evidence.

    ``model`` has the lobe index of the best set.
    """

    best: Optimum
    model: ExactModel
    library: Library
    equations: NormalEquations
    rescored: tuple[Optimum, ...]

    def start(self, members: Sequence[Candidate]) -> FloatArray:
        """Start of another set, from the equations about the best."""
        return estimate(self.equations, self.library.places(members))[0]


def search_effects(
    model: ExactModel, candidates: Sequence[Candidate], progress: Callable[[str], None], thorough: bool = False
) -> SearchResult:
    """Best set of ``candidates`` and of significant chatter.

    ``thorough``: treat every location as a separate effect, and try the neighbours of each best set even if its
    residual is within the scatter of chi².
    """
    model = indexed_from_scans(model, candidates)
    frequencies = max((r.rows.size for r in model.recordings if r.kind is not HYSTERESIS), default=2)
    library = Library((*candidates, *significant_chatter(model)), frequencies)
    initial = search_subsampled(model, library, progress, thorough)
    model, starts, subsampled = initial.model, initial.starts, smallest_subsample(initial.model, initial.gain)
    local_search = initial.local_search or LocalSearch(
        model, library, _RESCORINGS, progress, thorough=thorough, prefilter=subsampled
    )
    for number in range(_REINDEXINGS + 1):
        progress("fitting the exact model to all rows")
        local_search.run(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(local_search)
        if best.members and _has_turns(model):
            progress("replacing members of the best set")
            swap_members(local_search, subsampled, best)
            best = _first_that_contributes(local_search)
        reindexed, begin = reindexed_for(model, subsampled, library, best)
        if reindexed is model or number == _REINDEXINGS:
            break
        model, starts = reindexed, [(library.places(best.members), begin.u)]
        subsampled = smallest_subsample(model, initial.gain)
        local_search = LocalSearch(model, library, _RESCORINGS, progress, thorough=thorough, prefilter=subsampled)
    local_search, waved = _extended(local_search, with_masked_waves, best)
    if waved is best and _needs_pair_search(model, best):
        _search_pairs(local_search, subsampled, best, initial.ranked_singles, progress)
        local_search, waved = _extended(local_search, with_masked_waves, _first_that_contributes(local_search))
    best = waved
    for other in (partial(with_waves_given_others, ranked_singles=initial.ranked_singles), with_refitted_waves):
        local_search, best = _extended(local_search, other, best)
    reindexed = indexed_from_seams(model, best)
    if reindexed is not model:
        return search_effects(reindexed, candidates, progress, thorough)
    library = with_alternative_waves(model, local_search.library, best)
    return SearchResult(best, model, library, equations_about(model, library, best), tuple(local_search.ranked))


def _has_turns(model: ExactModel) -> bool:
    return not (model.only_scans or model.only_loops)


def _needs_pair_search(model: ExactModel, best: Optimum) -> bool:
    return _has_turns(model) and 0 < len(best.members) <= _FEW_MEMBERS and may_mask_pair(model, best)


def _search_pairs(
    local_search: LocalSearch,
    subsampled: ExactModel,
    best: Optimum,
    ranked_singles: Sequence[Optimum],
    progress: Callable[[str], None],
) -> None:
    """Fit pairs that may be better than the ``best`` set; the local search keeps them."""
    masked = masked_pairs(local_search.model, subsampled, local_search.library, ranked_singles, progress)
    finite = pairs_of_finite_size(local_search.model, local_search.library, ranked_singles)
    progress(f"fitting pairs of effects to all rows, {len(masked) + len(finite)}")
    better = local_search.best_of_starts(finite, local_search.best_of_starts(masked, best), LINEAR_LIMIT)
    if better is not best:
        local_search.run([(local_search.library.places(better.members), better.u)], _FINAL_ROUNDS)
    swap_members(local_search, subsampled, _first_that_contributes(local_search))


_Extension = Callable[[ExactModel, Library, Optimum], tuple[Library, list[Start]]]


def _extended(local_search: LocalSearch, more: _Extension, best: Optimum) -> tuple[LocalSearch, Optimum]:
    """Search extended by the candidates and starts of ``more``, and its best set."""
    model = local_search.model
    library, starts = more(model, local_search.library, best)
    if starts:
        local_search = local_search.with_library(library, _RESCORINGS)
        best = local_search.run(starts, 0)
        if model.only_scans or leaves_residual(model, best):
            local_search.run(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(local_search)
    return local_search, best


def _first_that_contributes(local_search: LocalSearch) -> Optimum:
    found = (o for o in local_search.ranked if o.log_evidence > 0.0 and contributes(local_search.model, o))
    return next(found, empty_optimum(local_search.model))
