"""Where a search for two effects begins: pairs fitted on few rows of the exact model.

Neither of two effects need do best alone, and about the one that does linear equations rank the others by what it made
of them. About no effect at all they hardly err as long as both are small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations, islice, product

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.climbing import Start, about, leaves_something
from cycloid_profile.discrepancy.evidence import estimate, scores, search
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.second_order import second_order_beside_first

_STEPS = 3
_LINEAR = 32  # pairs of names
_LINEAR_ERROR = 0.02  # of the evidence
_LEAST_REACH = 40.0
_PLACES = 6  # of each pair: two discs each, or both
_SINGLES = 16


def leading_pairs(
    few: ExactModel, library: Library, singles: Sequence[Optimum], tell: Callable[[str], None], thorough: bool
) -> list[Optimum]:
    """Pairs of effects of different names, fitted on a model of few rows, best first.

    Those that linear equations have for the best, one effect that cancels to first order beside one that does not,
    and, if ``thorough``, all pairs of the leading ``singles``.
    """
    starts = likely_pairs(few, library)
    if thorough and singles:
        starts += _of_singles(about(few, library, singles[0]), library, singles)
    return fitted_pairs(few, library, starts, singles[0].misfit if singles else few.nothing.chi2, tell)


def likely_pairs(few: ExactModel, library: Library) -> list[Start]:
    """Where to begin with the pairs that linear equations have for the best, and with one effect that cancels to first
    order beside one that does not.
    """
    equations = normal(few.nothing.blocks, library.candidates)
    return [*_of_linear(equations, library), *second_order_beside_first(few, library)]


def fitted_pairs(
    few: ExactModel, library: Library, starts: Sequence[Start], beat: float, tell: Callable[[str], None]
) -> list[Optimum]:
    """Pairs fitted from ``starts`` on few rows, those that come near ``beat``, chi² with priors, best first."""
    tell(f"pairs of effects on the exact model, {len(starts)}")
    # Teeth known by points take several times as long, and are seldom called for.
    quick, slow = list[Start](), list[Start]()
    for start in starts:
        (slow if _by_points(few, library.members(start[0])) else quick).append(start)
    found = list[Optimum]()
    for some in (quick, slow):
        attempts = [Attempt(library.members(members), u, _STEPS, beat) for members, u in some]
        found += [one for one in few.optima(attempts, library.prior) if one is not None and not one.implausible]
        found.sort(key=lambda one: -one.log_evidence)
        if found and not leaves_something(few, found[0]):
            break
    return found


def _by_points(few: ExactModel, members: Sequence[Candidate]) -> bool:
    """Whether a member makes a tooth that is known by points, or one with many waves."""
    built = [few.probes.after(member, 0, few.built)[0] for member in members]
    return any(r.spacing is not None for one in built for tooth in one.teeth for r in tooth.removals)


def _of_linear(equations: Normal, library: Library) -> Iterator[Start]:
    """The best pairs of unlike names by linear equations about no effect, at each place that these leave open."""
    pairs = [s for s in search(equations, library.priors, 2) if len(s.members) == 2]
    reach = max(_LEAST_REACH, _LINEAR_ERROR * pairs[0].log_evidence) if pairs else 0.0
    seen: set[tuple[str, ...]] = set()
    for pair in pairs:
        names = tuple(sorted(library.candidates[i].name for i in pair.members))
        if pair.log_evidence < pairs[0].log_evidence - reach or len(seen) == _LINEAR:
            break
        if names not in seen:
            seen.add(names)
            yield from islice(_at_places(equations, library, pair.members, pair.log_evidence - reach), _PLACES)


def _at_places(equations: Normal, library: Library, pair: Sequence[int], least: float) -> Iterator[Start]:
    """The pair, and it with one or both members at other places, if at ``least`` so likely, the likeliest first."""
    alike = [[i for i, c in enumerate(library.candidates) if c.name == library.candidates[p].name] for p in pair]
    sets = np.array(list(product(*alike)), dtype=np.intp)
    for scored in sorted(scores(equations, library.priors, sets), key=lambda s: -s.log_evidence):
        if scored.log_evidence >= least:
            yield list(scored.members), estimate(equations, scored.members)[0]


def _of_singles(equations: Normal, library: Library, singles: Sequence[Optimum]) -> Iterator[Start]:
    """All pairs of unlike names of the leading single effects."""
    leading = list({library.places(one.members)[0]: one for one in reversed(singles)})[::-1][:_SINGLES]
    for i, j in combinations(leading, 2):
        if library.candidates[i].name != library.candidates[j].name:
            yield [i, j], estimate(equations, [i, j])[0]
