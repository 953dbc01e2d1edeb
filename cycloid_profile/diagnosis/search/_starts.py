"""Starts from responses of finite size: a flank that lifts off, or comes to bear, has no linear response.

Near zero the response of a lightly loaded reducer may even have the other sign. Pairs of effects start there, too.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.optimum import FARTHEST, Attempt, Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened
from cycloid_profile.diagnosis.search._proposals import Proposal, equations_about, with_one_more
from cycloid_profile.diagnosis.search._second_order import (
    change_of_predictions,
    chi2_reduction,
    product,
    whitened_parts,
)
from cycloid_profile.geometry import Trochoid

_SIZES = (0.5, 2.0)  # prior widths: a flank that lifts off at one of them may bear at the other
_ANGLES = 16  # per turn: the next pin bears after about one of them
_LEAST_SIZE, _LARGEST_SIZE = 0.25, 2.0  # prior widths, of the responses at all places of the turn
_FEW = 16  # places and shapes of one effect that are all tried
_REACH = 1.5  # lobes or pins
_LEAST, _MOST = 0.1, 5.0  # times this size: range of the starts
_NOT_LINEAR = 0.1  # share of the square of a response: an error of a third
# Places of an effect round the turn, each with the direction of its coordinates there, shape (2,).
_Places = list[tuple[Candidate, FloatArray]]


@dataclass(frozen=True, eq=False)
class _Directed:
    """A candidate, its direction in linear equations, of unit size, and the reduction of chi² that they promise."""

    candidate: Candidate
    direction: FloatArray
    gain: float


def of_finite_size(
    model: ExactModel, library: Library, equations: NormalEquations, offsets: tuple[int, ...]
) -> list[Proposal]:
    """Single effects that explain most by a multiple of their response at half a prior width or two, best first."""
    if model.only_scans:
        return []
    directed = _directed(library, equations)
    first = _best_of_each_variety(directed)
    found = sorted(_responses(model, first, offsets), key=lambda one: -one[0])
    leading = list(dict.fromkeys(one.members[0].variety for _, one in found))[: tuned.BEAM]
    count = Counter(one.variety for one in library.candidates)
    same = {key for key in leading if count[key] <= _FEW}
    more = [one for one in directed if one.candidate.variety in same and one not in first and not one.candidate.angle]
    found += _responses(model, more, offsets)
    found.sort(key=lambda one: -one[0])
    best: dict[Variety, Proposal] = {}
    for _, proposal in found:
        best.setdefault(proposal.members[0].variety, proposal)
    kept = list(best.values())[: tuned.FINITE]
    if not model.only_loops:
        return kept
    return [*kept, *_at_other_places(model, _around(model, library.candidates), offsets)]


def _symmetric(model: ExactModel) -> bool:
    """Whether a rotation by 180° exchanges two discs and leaves pins where pins are."""
    return model.reducer.discs == 2 and model.reducer.case.drive.trochoid.pins % 2 == 0


def _around(model: ExactModel, candidates: Sequence[Candidate]) -> Iterator[list[_Places]]:
    """Effects of the whole turn that depend on an angle, or on the lobe where wear begins: the places of each.

    One list of places for each sign of an effect, in order round the turn.
    """
    symmetric = _symmetric(model)
    # The other disc responds as the first does to the effect rotated by 180°. Cranks stay where they are.
    tried = [one for one in candidates if not symmetric or one.choice.get("disc") != 2 or "crank" in one.choice]
    for one in tried:
        if one.angle is not None:
            # Over half a turn if a rotation by 180° changes nearly nothing.
            number = _ANGLES // 2 if symmetric and one.same_at_180 else _ANGLES
            turns = 2.0 * np.pi * np.arange(number) / _ANGLES
            yield [[(one, np.array([np.cos(turn), np.sin(turn)])) for turn in turns]]
    begins: dict[tuple[Variety, object], list[Candidate]] = {}
    for one in tried:
        # Wear from an even lobe on is found from the odd one next to it (``moved_nearby``).
        if "first_lobe" in one.choice and one.along is not None and one.along % 2.0 == 1.0:
            begins.setdefault((one.variety, one.choice.get("disc")), []).append(one)
    for some in begins.values():
        signs = (1.0,) if some[0].one_sided else (1.0, -1.0)
        yield [[(one, np.array([sign, 0.0])) for one in some] for sign in signs]


def _at_other_places(model: ExactModel, effects: Iterable[list[_Places]], offsets: tuple[int, ...]) -> list[Proposal]:
    """Effects at each place of the turn where a multiple of their response explains most, the best of each first.

    At the one pose of a loop few pins bear, and which of them depends on the place: several may fit. It depends on the
    size, too.
    """
    ranked = []
    for by_sign in effects:
        starts = [start for places in by_sign for start in _at_peaks(model, places, offsets)]
        starts.sort(key=lambda start: start[0])
        ranked += [(rank, chi2, proposal) for rank, (chi2, proposal) in enumerate(starts)]
    return [proposal for *_, proposal in sorted(ranked, key=lambda start: start[:2])[: tuned.FINITE_AROUND]]


def _size_of_gap(model: ExactModel, places: _Places) -> float:
    """Size at which the response to an effect is about as large as the gap, 0 if loops do not show it.

    Between a quarter of a prior width and two, from the responses at one at four places of the turn.
    """
    blocks = model.baseline.blocks
    gap = sum(block.chi2 - block.z.size for block in blocks)
    quarters = [places[len(places) * i // 4] for i in range(4)]
    states = (model.state([one], direction) for one, direction in quarters)
    responses = [change_of_predictions(model.baseline, state) for state in states if state is not None]
    parts = [whitened_parts(blocks, response[:, np.newaxis]) for response in responses]
    shown = [float(product(blocks, part, part)[0, 0]) for part in parts]
    seen = max(shown, default=0.0) > tuned.LEAST_GAIN and gap > 0.0
    return float(np.clip(np.sqrt(gap / np.mean(shown)), _LEAST_SIZE, _LARGEST_SIZE)) if seen else 0.0


def _at_peaks(model: ExactModel, places: _Places, offsets: tuple[int, ...]) -> list[tuple[float, Proposal]]:
    """Starts at the places where a multiple of the response at the size of the gap reduces chi² most, with their chi².

    The start is that size, or the multiple if it fits better.
    """
    size = _size_of_gap(model, places)
    if not size:
        return []
    drop, multiple = np.zeros(len(places)), np.ones(len(places))
    for i, (one, direction) in enumerate(places):
        state = model.state([one], size * direction)
        if state is not None:
            whole, amount = _explained(model.baseline, state)
            multiple[i] = np.clip(amount, _LEAST, _MOST)
            share = multiple[i] / amount if amount else 0.0
            drop[i] = whole * share * (2.0 - share)
    found = []
    peaks = (drop >= np.roll(drop, 1)) & (drop >= np.roll(drop, -1)) & (drop > tuned.LEAST_GAIN)
    for i in np.flatnonzero(peaks).tolist():
        one, direction = places[i]
        states = ((model.state([one], start), start) for start in (size * direction, multiple[i] * size * direction))
        fits = [(state.chi2, start) for state, start in states if state is not None]
        if fits:
            chi2, start = min(fits, key=lambda fit: fit[0])
            found.append((chi2, Proposal((one,), start, offsets)))
    return found


def with_another_effect(
    model: ExactModel, library: Library, starts: Iterable[Proposal], least: float
) -> list[Proposal]:
    """Single effects at their starts, each with the second one that promises most, if that is at least ``least``.

    Of each kind of pair the one that leaves least, best first, and not more than ``FINITE``. Few pins bear in a loop,
    and one of two effects alone may fit worst where it is in truth.
    """
    found = []
    for one in starts:
        there = model.optimum(Attempt(one.members, one.start, steps=0), library.prior(one.members))
        if there is None:
            continue
        equations = equations_about(model, library, there, rest=True)
        two = with_one_more(equations, library, there, one.offsets)
        if two is None or two.promised < least:
            continue
        state = model.state(two.members, two.start)
        if state is not None:
            found.append((state.misfit_with_prior, two))
    best: dict[frozenset[Variety], Proposal] = {}
    for _, two in sorted(found, key=lambda one: one[0]):
        best.setdefault(frozenset(member.variety for member in two.members), replace(two, promised=math.inf))
    return list(best.values())[: tuned.FINITE]


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
    model: ExactModel, tried: Iterable[_Directed], offsets: tuple[int, ...]
) -> Iterator[tuple[float, Proposal]]:
    """Each candidate at that of the trial sizes where a multiple of its response explains most, with the reduction of
    chi² by that multiple. A linear response in the right direction needs no further trial. Friction starts at what the
    loops show of it: a stage that sticks throughout has no other response, and explains as much by its error.
    """
    blocks = model.baseline.blocks
    shown = max((one.shown_friction_nm for one in model.recordings), default=0.0)
    for candidate, direction in ((one.candidate, one.direction) for one in tried):
        best, start = 0.0, direction
        both = not candidate.one_sided and candidate.angle is None
        known = min(shown / candidate.width, FARTHEST) if candidate.is_friction_torque else 0.0
        sizes = (known,) if known else _SIZES
        for u in [sign * size * direction for size in sizes for sign in ((1.0, -1.0) if both else (1.0,))]:
            state = model.state([candidate], u)
            if state is None:
                continue
            response = change_of_predictions(model.baseline, state)[:, np.newaxis]
            drop, (amount,) = chi2_reduction(blocks, response)
            if amount > 0.0 and drop > best:
                best, start = drop, u if known else np.clip(amount, _LEAST, _MOST) * u
            if amount > 0.0 and _is_linear(blocks, response, candidate, u):
                break
        if best > 0.0:
            yield best, Proposal((candidate,), start, offsets)


def _is_linear(blocks: Sequence[Whitened], response: FloatArray, candidate: Candidate, u: FloatArray) -> bool:
    """Whether the linear response at ``u`` is the ``response``, but for a small share of its square."""
    exact = whitened_parts(blocks, response)
    error = [one - (block.columns([candidate]) @ u)[:, np.newaxis] for one, block in zip(exact, blocks, strict=True)]
    wrong, whole = (float(product(blocks, one, one)[0, 0]) for one in (error, exact))
    return wrong < _NOT_LINEAR * whole


def _explained(before: State, after: State) -> tuple[float, float]:
    """Reduction of chi² by a multiple of the response from ``before`` to ``after``, and the multiple."""
    drop, (amount,) = chi2_reduction(before.blocks, change_of_predictions(before, after)[:, np.newaxis])
    return drop, float(amount)


def _directed(library: Library, equations: NormalEquations) -> list[_Directed]:
    """Every candidate with its direction in linear equations."""
    found = []
    for i, candidate in enumerate(library.candidates):
        where = slice(2 * i, 2 * i + 2)
        u = np.asarray(np.linalg.lstsq(equations.R[where, where], equations.b[where], rcond=1e-9)[0])
        seen = np.any(u) and not candidate.one_sided
        direction = u / float(np.hypot(*u)) if seen else np.array([1.0, 0.0])
        found.append(_Directed(candidate, direction, float(u @ equations.b[where])))
    return found


def _best_of_each_variety(directed: Iterable[_Directed]) -> list[_Directed]:
    """The candidate of each variety that explains most in linear equations."""
    best: dict[Variety, _Directed] = {}
    for one in directed:
        if one.gain >= best.setdefault(one.candidate.variety, one).gain:
            best[one.candidate.variety] = one
    return list(best.values())
