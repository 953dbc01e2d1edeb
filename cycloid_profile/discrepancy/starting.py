"""Where a search begins: single effects that lead on few rows of the exact model."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.climbing import Start, about
from cycloid_profile.discrepancy.evidence import estimate, search
from cycloid_profile.discrepancy.exact import ExactModel, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, Whitened
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.effects.effect import Place

_STARTS = 12
_STEPS_OF_A_LOOK, _STEPS_OF_LEADING = 2, 4
_LEADING = 3
# A loop has so few rows that every place of an effect can be looked at, and bends alike for many of them.
_STARTS_AT_PLACES = 40
_LEADING_AT_PLACES = 10
_PLACES = ("disc", "crank", "flank", "form")
_LINEAR = 0.995  # share of the gap that linear effects explain, above which none of second order is sought
_SECOND_ORDER = 3
_EITHER_WAY = 8
_MANY = frozenset({"lobe", "first_lobe", "pin"})  # places too many to look at one by one
_TRIED = 0.5  # of the width of a coordinate
_SAME = 0.01  # of the width of a coordinate
_PAIRED, _PAIR_STEPS = 16, 3


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
        starts += _second_order(coarse, library, gain / max(equations.rows, 1))
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


def leading_pairs(
    few: ExactModel, library: Library, singles: Sequence[Optimum], tell: Callable[[str], None]
) -> list[Optimum]:
    """Pairs of the leading ``singles`` of different names, fitted on a model of few rows, best first.

    Two effects of like size need not lead with one of them; and what another place of one of them costs, linear
    equations do not say.
    """
    if not singles:
        return []
    leading = list({library.places(one.members)[0]: one for one in reversed(singles)})[::-1][:_PAIRED]
    pairs = [[i, j] for i, j in combinations(leading, 2) if library.candidates[i].name != library.candidates[j].name]
    tell(f"pairs of effects on the exact model, {len(pairs)}")
    equations = about(few, library, singles[0])
    attempts = [
        Attempt(library.members(pair), estimate(equations, pair)[0], steps=_PAIR_STEPS, beat=singles[0].misfit)
        for pair in pairs
    ]
    found = [one for one in few.optima(attempts, library.prior) if one is not None and not one.implausible]
    return sorted(found, key=lambda one: -one.log_evidence)


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
                drop, (share,) = _fall(before.blocks, _change(before, state)[:, np.newaxis])
                if share > 0.0:
                    found.append((drop, [i], u * min(max(float(share), 0.05), 4.0)))
    found.sort(key=lambda f: -f[0])
    return [(members, u) for _, members, u in found[:_EITHER_WAY]]


def _change(before: State, after: State) -> FloatArray:
    """What the predictions gain, all rows of all recordings."""
    return np.concatenate([a.residual - b.residual for a, b in zip(before.laid, after.laid, strict=True)])


def _second_order(coarse: ExactModel, library: Library, gain_per_row: float) -> list[Start]:
    """Starts for what all discs or pins share: it cancels to first order, the rest turns with twice its angle."""
    if coarse.only_scans:
        return []
    found = []
    before = coarse.nothing
    least = 0.2 * gain_per_row * sum(block.z.size for block in before.blocks)
    for i, candidate in enumerate(library.candidates):
        alike = candidate.kind.place is Place.RING or candidate.choice.get("disc", 0) is None
        if candidate.angle is None or not alike or candidate.kind.place is Place.SENSOR:
            continue
        shown = []
        for angle in np.deg2rad([0.0, 90.0, 45.0, 135.0]):
            state = coarse.state([candidate], _TRIED * np.array([np.cos(angle), np.sin(angle)]))
            if state is None:
                break
            shown.append(_change(before, state))
        if len(shown) < 4:
            continue
        even, first, second = 0.25 * sum(shown), 0.5 * (shown[0] - shown[1]), 0.5 * (shown[2] - shown[3])
        drop, y = _fall(before.blocks, np.stack([first, second, even], axis=1))
        if drop < least:
            continue
        size = _TRIED * min(max(float(np.hypot(y[0], y[1])), 0.05) ** 0.7, 4.0)
        angle = 0.5 * float(np.arctan2(y[1], y[0]))
        found.append((drop, [i], size * np.array([np.cos(angle), np.sin(angle)])))
    found.sort(key=lambda f: -f[0])
    return [(members, u) for _, members, u in found[:_SECOND_ORDER]]


def _fall(blocks: Sequence[Whitened], columns: FloatArray) -> tuple[float, FloatArray]:
    """Fall of chi² by free amounts of ``columns`` over all rows of all recordings, and the amounts."""
    b, R, at = np.zeros(columns.shape[1]), np.zeros((columns.shape[1],) * 2), 0
    for block in blocks:
        rows = block.laid.residual.size
        G = block.white(np.nan_to_num(columns[at : at + rows]))
        at += rows
        b += block.product(G, block.z)
        R += block.product(G, G)
    amounts = np.asarray(np.linalg.lstsq(R, b, rcond=1e-9)[0], dtype=np.float64)
    return float(amounts @ b), amounts
