"""Starting points of the search: single effects fitted on a subsample with the exact model."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cycloid_profile.diagnosis.model.evidence import estimate, rank_sets
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.search.local_search import Start
from cycloid_profile.diagnosis.search.second_order import change_of_predictions, chi2_reduction, second_order

_STARTS = 12  # kinds of effects; a loop needs more, see below
_STEPS_OF_TRIAL, _STEPS_OF_REFINEMENT = 2, 4  # two steps rank the starts, four converge most
_REFINED = 3  # the local search exchanges members anyway
# A loop has few rows, so that every location can be fitted. Many effects change it in nearly the same way.
_STARTS_AT_PLACES = 40
_REFINED_AT_PLACES = 10
_PLACES = ("disc", "crank", "flank", "form")
_LINEAR = 0.995  # share of the gap explained by linear effects, above which second-order effects are not tried
_BOTH_SIGNS = 8  # starts at a finite size, besides the linear ones
_MANY = frozenset({"lobe", "first_lobe", "pin"})  # parts with too many locations for separate fits
_TRIAL = 0.5  # of the width of a coordinate
_SAME = 0.01  # of the width of a coordinate


def rank_initial_singles(
    coarse: ExactModel,
    library: Library,
    equations: NormalEquations,
    gain: float,
    progress: Callable[[str], None],
    thorough: bool = False,
) -> list[Optimum]:
    """Single effects with the largest evidence, fitted on a subsample, best first.

    ``equations``: all rows, ``gain``: chi² gain of their best set. For loops alone, or if ``thorough``, each disc,
    crank and flank counts as a separate effect.
    """
    apart = thorough or coarse.only_loops
    singles: dict[tuple[object, ...], Start] = {}
    for scored in rank_sets(equations, library.priors, 1):
        candidate = library.candidates[scored.members[0]]
        # Cranks are equivalent to first order; the exact model separates them.
        kind = (candidate.name, *(candidate.choice.get(place) for place in _PLACES if apart or place == "crank"))
        if kind not in singles and scored.log_evidence > 0.0:
            singles[kind] = (list(scored.members), estimate(equations, scored.members)[0])
    starts = list(singles.values())[: _STARTS_AT_PLACES if apart else _STARTS]
    if thorough:
        starts += _both_signs(coarse, library)
    if apart or gain < _LINEAR * (equations.chi2 - equations.rows):
        starts += second_order(coarse, library, gain / max(equations.rows, 1))
    progress(f"fitting single effects, {len(starts)}")
    optima = _fitted(coarse, library, starts, _STEPS_OF_TRIAL)
    if not thorough:
        # The best are fitted with more steps and with the opposite sign: contact changes act in both directions.
        refined = [(members, optimum.u) for members, optimum in optima[: _REFINED_AT_PLACES if apart else _REFINED]]
        if not apart:
            refined += [(members, -u) for members, u in refined if not library.candidates[members[0]].one_sided]
        progress(f"refining the best single effects, {len(refined)}")
        optima = _fitted(coarse, library, refined, _STEPS_OF_REFINEMENT)
    return [optimum for _, optimum in optima if optimum.log_evidence > 0.0]


def _fitted(
    coarse: ExactModel, library: Library, starts: Sequence[Start], steps: int
) -> list[tuple[list[int], Optimum]]:
    """Optima reached from the starts, best first."""
    attempts = [Attempt(library.members(members), u, steps=steps) for members, u in starts]
    found = [
        (members, optimum)
        for (members, _), optimum in zip(starts, coarse.optima(attempts, library.prior), strict=True)
        if optimum is not None and not optimum.implausible
    ]
    return _distinct(sorted(found, key=lambda o: -o[1].log_evidence))


def _distinct(optima: Sequence[tuple[list[int], Optimum]]) -> list[tuple[list[int], Optimum]]:
    """Distinct optima, best first; different starts may reach the same optimum."""
    found: list[tuple[list[int], Optimum]] = []
    for members, optimum in optima:
        twins = [other for known, other in found if known == members]
        if not any(float(np.max(np.abs(optimum.u - twin.u))) < _SAME for twin in twins):
            found.append((members, optimum))
    return found


def _both_signs(coarse: ExactModel, library: Library) -> list[Start]:
    """Starts at a finite size of either sign, for effects that change the pins in contact."""
    before, found = coarse.baseline, []
    for i, candidate in enumerate(library.candidates):
        if candidate.angle is not None or _MANY & candidate.choice.keys():
            continue
        for sign in (1.0,) if candidate.one_sided else (1.0, -1.0):
            u = np.array([sign * _TRIAL, 0.0])
            state = coarse.state([candidate], u)
            if state is not None:
                drop, (share,) = chi2_reduction(before.blocks, change_of_predictions(before, state)[:, np.newaxis])
                if share > 0.0:
                    found.append((drop, [i], u * min(max(float(share), 0.05), 4.0)))
    found.sort(key=lambda f: -f[0])
    return [(members, u) for _, members, u in found[:_BOTH_SIGNS]]
