"""Search for large effects on a subsample; small effects follow on all rows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cycloid_profile.diagnosis.model.evidence import estimate, rank_sets
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations, normal_equations
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search.initial_pairs import rank_initial_pairs
from cycloid_profile.diagnosis.search.initial_singles import rank_initial_singles
from cycloid_profile.diagnosis.search.local_search import LocalSearch, Start, leaves_residual
from cycloid_profile.diagnosis.search.scan_led_search import search_led_by_scans
from cycloid_profile.diagnosis.search.subsampling import smallest_subsample, subsample

_RESCORINGS, _RESCORINGS_OF_WEAK = 40, 8  # exact fits of one local search
_ROUNDS = 5  # on a subsample a round is cheap
_SUBSAMPLE_ROWS = 360  # nine a pin pitch of 40 pins
_GAIN_KEPT = 500.0  # of chi²: gain that the subsample preserves
_WEAK = 60.0  # below this gain the equations are linear
_SETS, _PAIRS, _PAIRS_OF_THOROUGH = 3, 5, 6  # starting sets of a local search
_EXCESS_ON_SUBSAMPLE = 2.0  # standard deviations of chi²: the noise is no better known on few rows
# Sets fitted on all rows, and their largest deficit in evidence.
_KEPT, _MAX_CANDIDATES = 3, 10
_MAX_DEFICIT, _MAX_DEFICIT_WITH_RESIDUAL = 10.0, 30.0


@dataclass(frozen=True, eq=False)
class _Linear:
    """Linear ``equations`` of all rows about no effect, their ``best`` set and its ``gain`` in chi²."""

    equations: NormalEquations
    best: list[Start]
    gain: float


@dataclass(frozen=True, eq=False)
class _InitialSets:
    """The ``model`` with its lobe index set, its ``subsampled`` version, initial sets ranked on it, and linear
    equations.
    """

    model: ExactModel
    subsampled: ExactModel
    sets: list[Optimum]
    linear: _Linear


@dataclass(frozen=True, eq=False)
class SubsampledResult:
    """Result on the subsample: starts for all rows and single effects by decreasing evidence.

    ``model``: with its lobe index set. ``local_search``: given if it used all rows. ``starts``: sets to fit on all
    rows. ``gain``: chi² gain of the best linear set.
    """

    model: ExactModel
    local_search: LocalSearch | None
    starts: list[Start]
    gain: float
    ranked_singles: list[Optimum]


def search_subsampled(
    model: ExactModel, library: Library, progress: Callable[[str], None], thorough: bool
) -> SubsampledResult:
    """Search on a subsample, whose result starts the search on all rows."""
    initial = _initial_sets(model, library, progress, thorough)
    model, gain = initial.model, initial.linear.gain
    if gain <= _WEAK:
        local_search = LocalSearch(model, library, _RESCORINGS_OF_WEAK, progress, thorough=thorough)
        return SubsampledResult(model, local_search, initial.linear.best, gain, initial.sets)
    subsampled = [subsample(r, _SUBSAMPLE_ROWS, _GAIN_KEPT / gain) for r in model.recordings]
    whole = all(a is b for a, b in zip(subsampled, model.recordings, strict=True))
    coarse = model if whole else model.with_recordings(subsampled)
    same_rows = all(a is b for a, b in zip(initial.subsampled.recordings, coarse.recordings, strict=True))
    known = {tuple(library.places(o.members)): o for o in initial.sets if o.converged and same_rows}
    local_search = LocalSearch(
        coarse, library, _RESCORINGS, progress, known, thorough, None if same_rows else initial.subsampled
    )
    for some in _starts(initial, library, progress, thorough):
        # Subsets of the best set so far have been covered already.
        new = [
            start for start in some if not local_search.ranked or not set(start[0]) <= _places(local_search, library)
        ]
        if new:
            local_search.run(new, _ROUNDS)
        if local_search.found and not leaves_residual(coarse, local_search.ranked[0], _EXCESS_ON_SUBSAMPLE):
            break
    starts_on_all = [(library.places(o.members), o.u) for o in _sets_for_full_fit(local_search)]
    return SubsampledResult(model, local_search if coarse is model else None, starts_on_all, gain, initial.sets)


def _initial_sets(model: ExactModel, library: Library, progress: Callable[[str], None], thorough: bool) -> _InitialSets:
    """Initial sets on the subsample: from the scans, and single effects if a residual remains."""
    linear, sets = _linear(model, library), list[Optimum]()
    if linear.gain <= _WEAK:
        return _InitialSets(model, model, sets, linear)
    reindexed, scan_led = search_led_by_scans(model, library, linear.gain, progress)
    if reindexed is not model:
        model, linear = reindexed, _linear(reindexed, library)
    subsampled = smallest_subsample(model, linear.gain)
    if scan_led is not None:
        sets.append(scan_led)
    if scan_led is None or leaves_residual(subsampled, scan_led):
        sets += rank_initial_singles(subsampled, library, linear.equations, linear.gain, progress, thorough)
        sets.sort(key=lambda one: -one.log_evidence)
    return _InitialSets(model, subsampled, sets, linear)


def _starts(
    initial: _InitialSets, library: Library, progress: Callable[[str], None], thorough: bool
) -> Iterator[list[Start]]:
    """Starts, group by group while a residual remains: neither of two effects need be the best single effect."""
    subsampled, sets = initial.subsampled, initial.sets
    starts = [(library.places(one.members), one.u) for one in sets[:_SETS]]
    if not subsampled.only_scans and (thorough or not sets or leaves_residual(subsampled, sets[0])):
        pairs = rank_initial_pairs(subsampled, library, sets, progress, thorough)
        most = _PAIRS_OF_THOROUGH if thorough else _PAIRS
        yield [*((library.places(one.members), one.u) for one in pairs[:most]), *starts[:1]]
        starts = [] if thorough else starts[1:]
    yield from ([one] for one in starts)
    if not thorough:
        yield initial.linear.best


def _linear(model: ExactModel, library: Library) -> _Linear:
    equations = normal_equations(model.baseline.blocks, library.candidates)
    found = rank_sets(equations, library.priors)
    best = [(list(s.members), estimate(equations, s.members)[0]) for s in found[:1]]
    return _Linear(equations, best, 2.0 * found[0].log_evidence if found else 0.0)


def _places(local_search: LocalSearch, library: Library) -> set[int]:
    return set(library.places(local_search.ranked[0].members))


def _sets_for_full_fit(local_search: LocalSearch) -> list[Optimum]:
    """Best set of the subsample and close sets that do not contain it; more of them if a residual remains."""
    ranked = local_search.ranked
    if not ranked:
        return []
    reach = (
        _MAX_DEFICIT_WITH_RESIDUAL
        if leaves_residual(local_search.model, ranked[0], _EXCESS_ON_SUBSAMPLE)
        else _MAX_DEFICIT
    )
    best = {id(member) for member in ranked[0].members}
    others = [o for o in ranked[1:_MAX_CANDIDATES] if o.log_evidence > ranked[0].log_evidence - reach]
    return [ranked[0], *(o for o in others if not best <= {id(member) for member in o.members})][:_KEPT]
