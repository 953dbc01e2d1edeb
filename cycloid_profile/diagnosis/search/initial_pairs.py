"""Starting points for two effects: pairs fitted on a subsample with the exact model.

Neither of the two effects need be the best single effect. Linear equations about the best single effect mix the other
effects with it; about no effect they are accurate as long as both sizes are small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, islice, product

import numpy as np

from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import estimate, rank_sets, scores
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations, normal_equations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.local_search import Start, equations_about, leaves_residual
from cycloid_profile.diagnosis.search.second_order import second_order_with_first

_STEPS = 3  # enough to rank pairs; the best are fitted again
_LINEAR = 32  # combinations of names
_LINEAR_ERROR = 0.02  # of the evidence
_LEAST_REACH = 40.0  # of the evidence: allows for the error of a linear ranking
_PLACES = 6  # location combinations of each pair
_SINGLES = 16  # 120 pairs


def rank_initial_pairs(
    subsampled: ExactModel,
    library: Library,
    singles: Sequence[Optimum],
    progress: Callable[[str], None],
    thorough: bool,
) -> list[Optimum]:
    """Pairs of effects with different names, fitted on a subsample, best first.

    The best pairs of linear equations, pairs of a second-order and a first-order effect, and, if ``thorough``, all
    pairs of the best ``singles``.
    """
    starts = likely_pairs(subsampled, library)
    if thorough and singles:
        starts += _of_singles(equations_about(subsampled, library, singles[0]), library, singles)
    return fitted_pairs(
        subsampled, library, starts, singles[0].misfit if singles else subsampled.baseline.chi2, progress
    )


def likely_pairs(subsampled: ExactModel, library: Library) -> list[Start]:
    """Starting pairs: the best of linear equations, and pairs of a second-order with a first-order effect."""
    equations = normal_equations(subsampled.baseline.blocks, library.candidates)
    return [*_of_linear(equations, library), *second_order_with_first(subsampled, library)]


def fitted_pairs(
    subsampled: ExactModel, library: Library, starts: Sequence[Start], beat: float, progress: Callable[[str], None]
) -> list[Optimum]:
    """Pairs fitted from ``starts`` on the subsample that come near ``beat``, chi² with priors; best first."""
    progress(f"fitting pairs of effects, {len(starts)}")
    # Teeth given by points are several times as slow and rarely needed.
    quick, slow = list[Start](), list[Start]()
    for start in starts:
        (slow if _by_points(subsampled, library.members(start[0])) else quick).append(start)
    found = list[Optimum]()
    for some in (quick, slow):
        attempts = [Attempt(library.members(members), u, _STEPS, beat) for members, u in some]
        found += [one for one in subsampled.optima(attempts, library.prior) if one is not None and not one.implausible]
        found.sort(key=lambda one: -one.log_evidence)
        if found and not leaves_residual(subsampled, found[0]):
            break
    return found


def _by_points(subsampled: ExactModel, members: Sequence[Candidate]) -> bool:
    """Whether a member creates a tooth given by points, or one with many waves."""
    reducer = [subsampled.flank_grid.after(member, 0, subsampled.reducer)[0] for member in members]
    return any(r.point_spacing is not None for one in reducer for tooth in one.teeth for r in tooth.removals)


def _of_linear(equations: NormalEquations, library: Library) -> Iterator[Start]:
    """The best pairs of different names by linear equations about no effect, at each likely pair of locations."""
    pairs = [s for s in rank_sets(equations, library.priors, 2) if len(s.members) == 2]
    reach = max(_LEAST_REACH, _LINEAR_ERROR * pairs[0].log_evidence) if pairs else 0.0
    seen: set[tuple[str, ...]] = set()
    for pair in pairs:
        names = tuple(sorted(library.candidates[i].name for i in pair.members))
        if pair.log_evidence < pairs[0].log_evidence - reach or len(seen) == _LINEAR:
            break
        if names not in seen:
            seen.add(names)
            yield from islice(_at_places(equations, library, pair.members, pair.log_evidence - reach), _PLACES)


def _at_places(equations: NormalEquations, library: Library, pair: Sequence[int], least: float) -> Iterator[Start]:
    """The pair at all locations of its members with evidence of ``least`` or more, best first."""
    same_name = [[i for i, c in enumerate(library.candidates) if c.name == library.candidates[p].name] for p in pair]
    sets = np.array(list(product(*same_name)), dtype=np.intp)
    for scored in sorted(scores(equations, library.priors, sets), key=lambda s: -s.log_evidence):
        if scored.log_evidence >= least:
            yield list(scored.members), estimate(equations, scored.members)[0]


def _of_singles(equations: NormalEquations, library: Library, singles: Sequence[Optimum]) -> Iterator[Start]:
    """All pairs of different names among the best single effects."""
    best_singles = list({library.places(one.members)[0]: one for one in reversed(singles)})[::-1][:_SINGLES]
    for i, j in combinations(best_singles, 2):
        if library.candidates[i].name != library.candidates[j].name:
            yield [i, j], estimate(equations, [i, j])[0]
