"""Where a search begins: single effects that lead on few rows of the exact model."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cycloid_profile.discrepancy.climbing import Start
from cycloid_profile.discrepancy.evidence import estimate, search
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.second_order import change, fall, second_order

_STARTS = 12
_STEPS_OF_A_LOOK, _STEPS_OF_LEADING = 2, 4
_LEADING = 3
# A loop has so few rows that every place of an effect can be looked at, and bends alike for many of them.
_STARTS_AT_PLACES = 40
_LEADING_AT_PLACES = 10
_PLACES = ("disc", "crank", "flank", "form")
_LINEAR = 0.995  # share of the gap that linear effects explain, above which none of second order is sought
_EITHER_WAY = 8
_MANY = frozenset({"lobe", "first_lobe", "pin"})  # places too many to look at one by one
_TRIED = 0.5  # of the width of a coordinate
_SAME = 0.01  # of the width of a coordinate


def leading_singles(
    coarse: ExactModel,
    library: Library,
    equations: Normal,
    gain: float,
    tell: Callable[[str], None],
    thorough: bool = False,
) -> list[Optimum]:
    """Single effects of the leading names, fitted on a model of few rows, best first.

    ``equations`` of all rows, whose best set gains ``gain`` in chi². Of loops alone, or if ``thorough``, each disc,
    crank and flank counts as a name of its own.
    """
    apart = thorough or coarse.only_loops
    singles: dict[tuple[object, ...], Start] = {}
    for scored in search(equations, library.priors, 1):
        candidate = library.candidates[scored.members[0]]
        # Cranks turn alike to first order, and only the exact model tells one from another.
        kind = (candidate.name, *(candidate.choice.get(place) for place in _PLACES if apart or place == "crank"))
        if kind not in singles and scored.log_evidence > 0.0:
            singles[kind] = (list(scored.members), estimate(equations, scored.members)[0])
    starts = list(singles.values())[: _STARTS_AT_PLACES if apart else _STARTS]
    if thorough:
        starts += _either_way(coarse, library)
    if apart or gain < _LINEAR * (equations.chi2 - equations.rows):
        starts += second_order(coarse, library, gain / max(equations.rows, 1))
    tell(f"single effects on the exact model, {len(starts)}")
    optima = _fitted(coarse, library, starts, _STEPS_OF_A_LOOK)
    if not thorough:
        # The leading ones to the end, and from the other side: what loads pins when it grows does so when it shrinks.
        leading = [(members, optimum.u) for members, optimum in optima[: _LEADING_AT_PLACES if apart else _LEADING]]
        if not apart:
            leading += [(members, -u) for members, u in leading if not library.candidates[members[0]].one_sided]
        tell(f"leading effects on the exact model, {len(leading)}")
        optima = _fitted(coarse, library, leading, _STEPS_OF_LEADING)
    return [optimum for _, optimum in optima if optimum.log_evidence > 0.0]


def _fitted(
    coarse: ExactModel, library: Library, starts: Sequence[Start], steps: int
) -> list[tuple[list[int], Optimum]]:
    """Where the starts lead, best first."""
    attempts = [Attempt(library.members(members), u, steps=steps) for members, u in starts]
    found = [
        (members, optimum)
        for (members, _), optimum in zip(starts, coarse.optima(attempts, library.prior), strict=True)
        if optimum is not None and not optimum.implausible
    ]
    return _unlike(sorted(found, key=lambda o: -o[1].log_evidence))


def _unlike(optima: Sequence[tuple[list[int], Optimum]]) -> list[tuple[list[int], Optimum]]:
    """Without those that came to the same place from another start; best first."""
    found: list[tuple[list[int], Optimum]] = []
    for members, optimum in optima:
        twins = [other for known, other in found if known == members]
        if not any(float(np.max(np.abs(optimum.u - twin.u))) < _SAME for twin in twins):
            found.append((members, optimum))
    return found


def _either_way(coarse: ExactModel, library: Library) -> list[Start]:
    """Starts for what acts otherwise when it grows than when it shrinks, as all does that takes pins out of contact:
    by the exact change at some size of either sign.
    """
    before, found = coarse.nothing, []
    for i, candidate in enumerate(library.candidates):
        if candidate.angle is not None or _MANY & candidate.choice.keys():
            continue
        for sign in (1.0,) if candidate.one_sided else (1.0, -1.0):
            u = np.array([sign * _TRIED, 0.0])
            state = coarse.state([candidate], u)
            if state is not None:
                drop, (share,) = fall(before.blocks, change(before, state)[:, np.newaxis])
                if share > 0.0:
                    found.append((drop, [i], u * min(max(float(share), 0.05), 4.0)))
    found.sort(key=lambda f: -f[0])
    return [(members, u) for _, members, u in found[:_EITHER_WAY]]
