"""Starts from responses of finite size: a flank that lifts off, or comes to bear, has no linear response.

Near zero the response of a lightly loaded reducer may even have the other sign.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations
from cycloid_profile.diagnosis.search._proposals import Proposal
from cycloid_profile.diagnosis.search._second_order import change_of_predictions, chi2_reduction
from cycloid_profile.geometry import Trochoid

_SIZE = 0.5  # prior widths
_FEW = 12  # locations of one effect that are all tried
_REACH = 1.5  # lobes or pins
_LEAST, _MOST = 0.1, 5.0  # times this size: range of the starts


def of_finite_size(
    model: ExactModel, library: Library, equations: NormalEquations, offsets: tuple[int, ...]
) -> list[Proposal]:
    """Single effects that explain most by a multiple of their response at half a prior width, best first."""
    if model.only_scans:
        return []
    found = sorted(_responses(model, _of_each_variety(library, equations), offsets), key=lambda one: -one[0])
    names = list(dict.fromkeys(one.members[0].name for _, one in found))[: tuned.BEAM]
    known = {one.members[0] for _, one in found}
    count = Counter(one.variety[:2] for one in library.candidates)
    places = [one for one in library.candidates if one.name in names and count[one.variety[:2]] <= _FEW]
    more = ((one, np.array([1.0, 0.0])) for one in places if one not in known and one.angle is None)
    found = sorted([*found, *_responses(model, more, offsets)], key=lambda one: -one[0])
    return [proposal for _, proposal in found[: tuned.FINITE]]


def moved_nearby(model: ExactModel, library: Library, optimum: Optimum, offsets: tuple[int, ...]) -> list[Proposal]:
    """The set with one member moved to that of the places near its own where it explains most, for each member.

    Where a lobe no longer touches, linear equations do not see that an effect might end there.
    """
    found = []
    for i, member in enumerate(optimum.members):
        own = np.arange(2 * i, 2 * i + 2)
        first, last = optimum.members[:i], optimum.members[i + 1 :]
        near = _places_near(member, library, model.reducer.case.drive.trochoid)
        before = model.state([*first, *last], np.delete(optimum.u, own)) if near else None
        if before is None:
            continue
        tried = []
        for place in (member, *near):
            # At its own place this is the optimum, which has a solution.
            state = model.state([*first, place, *last], optimum.u)
            if state is not None:
                tried.append((*_explained(before, state), place))
        _, amount, place = max(tried, key=lambda one: one[0])
        if place is not member:
            u = optimum.u.copy()
            u[own] *= np.clip(amount, _LEAST, _MOST)
            found.append(Proposal((*first, place, *last), u, offsets))
    return found


def _places_near(member: Candidate, library: Library, trochoid: Trochoid) -> list[Candidate]:
    """The same effect at most ``_REACH`` lobes or pins away on the same part."""
    if member.along is None:
        return []
    of = trochoid.pins if "pin" in member.choice else trochoid.lobes
    same = [library.candidates[i] for i in library.of_name(member.name)]
    return [
        one
        for one in same
        if one.along is not None
        and one.variety == member.variety
        and one.choice.get("disc") == member.choice.get("disc")
        and 0.0 < abs((one.along - member.along + 0.5 * of) % of - 0.5 * of) <= _REACH
    ]


def _responses(
    model: ExactModel, tried: Iterable[tuple[Candidate, FloatArray]], offsets: tuple[int, ...]
) -> Iterator[tuple[float, Proposal]]:
    """Each candidate in its direction, and against it, with the reduction of chi² by a multiple of its response."""
    for candidate, direction in tried:
        for sign in (1.0,) if candidate.one_sided or candidate.angle is not None else (1.0, -1.0):
            u = sign * _SIZE * direction
            state = model.state([candidate], u)
            if state is None:
                continue
            drop, amount = _explained(model.baseline, state)
            if amount > 0.0:
                yield drop, Proposal((candidate,), np.clip(amount, _LEAST, _MOST) * u, offsets)


def _explained(before: State, after: State) -> tuple[float, float]:
    """Reduction of chi² by a multiple of the response from ``before`` to ``after``, and the multiple."""
    drop, (amount,) = chi2_reduction(before.blocks, change_of_predictions(before, after)[:, np.newaxis])
    return drop, float(amount)


def _of_each_variety(library: Library, equations: NormalEquations) -> Iterator[tuple[Candidate, FloatArray]]:
    """The location of each variety that explains most in linear equations, with its direction of unit size."""
    best: dict[Variety, tuple[float, int, FloatArray]] = {}
    for i, candidate in enumerate(library.candidates):
        where = slice(2 * i, 2 * i + 2)
        u = np.asarray(np.linalg.lstsq(equations.R[where, where], equations.b[where], rcond=1e-9)[0])
        gain = float(u @ equations.b[where])
        if gain >= best.get(candidate.variety, (0.0,))[0]:
            best[candidate.variety] = (gain, i, u)
    for _, i, u in best.values():
        candidate = library.candidates[i]
        straight = candidate.angle is None or not np.any(u)
        yield candidate, np.array([1.0, 0.0]) if straight else u / float(np.hypot(*u))
