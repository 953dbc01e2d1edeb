"""Sets of effects that linear equations propose about an optimum, and the moves that lead to them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import (
    Library,
    NeighbouringShapes,
    Scored,
    distinct,
    estimate,
    linear_evidence,
    of_different_names,
    scores,
)
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations, normal_equations

_LEADING = 24  # effects whose pairs are scored with all others


@dataclass(frozen=True, eq=False)
class Proposal:
    """A set to fit exactly, from coordinates ``start``, with the lobe index of each file raised by ``offsets``.

    ``promised``: its linear log evidence, infinite where linear equations say nothing.
    """

    members: tuple[Candidate, ...]
    start: FloatArray
    offsets: tuple[int, ...]
    promised: float = math.inf


@dataclass(frozen=True, eq=False)
class Move:
    """A way from one set to others: ``sets`` of library indices, of which ``most`` kinds are proposed."""

    sets: IntArray
    most: int
    of_a_kind: int = 1


def equations_about(model: ExactModel, library: Library, optimum: Optimum, rest: bool = False) -> NormalEquations:
    """Equations of the library, linearised about an optimum and referred to zero.

    ``rest``: without a slope along its members. Where the misfit jumps it has its least value where linear equations
    show a slope, and they would move the members away.
    """
    members = library.places(optimum.members)
    equations = normal_equations(model.at(optimum).blocks, library.candidates)
    if rest:
        equations = equations.at_rest(members, optimum.u)
    return equations.about(members, optimum.u)


def linear_proposals(
    equations: NormalEquations, library: Library, optimum: Optimum, offsets: tuple[int, ...], keep: bool = False
) -> list[Proposal]:
    """Best sets of each move about an optimum, most promising first.

    ``equations`` of the whole library, linearised about the optimum and referred to zero. ``keep``: start with the
    members of the optimum where they are, and the others estimated next to them.
    """
    base = library.places(optimum.members)
    scored = {one for move in _moves(equations, library, base) for one in _best(equations, library, move)}
    return _proposed(scored, equations, library, optimum, offsets, keep)


def with_one_more(
    equations: NormalEquations, library: Library, optimum: Optimum, offsets: tuple[int, ...]
) -> Proposal | None:
    """The best set with one effect more than an optimum, whose members start where they are; None without one."""
    base = library.places(optimum.members)
    more = np.array([i for i in distinct(equations, base) if i not in base], dtype=np.intp)
    scored = _best(equations, library, Move(_each(base, more), 1))
    return next(iter(_proposed(scored, equations, library, optimum, offsets, keep=True)), None)


def _proposed(
    scored: Iterable[Scored],
    equations: NormalEquations,
    library: Library,
    optimum: Optimum,
    offsets: tuple[int, ...],
    keep: bool,
) -> list[Proposal]:
    """Proposals of scored sets, most promising first; arguments as those of ``linear_proposals``."""
    level = _level(equations, library, optimum)
    base = library.places(optimum.members)
    kept = dict(zip(base, optimum.u.reshape(-1, 2), strict=True)) if keep else {}
    return [
        Proposal(library.members(one.members), _start(equations, one.members, kept), offsets, level + one.log_evidence)
        for one in sorted(scored, key=lambda s: -s.log_evidence)
    ]


def _start(equations: NormalEquations, members: Sequence[int], kept: Mapping[int, FloatArray]) -> FloatArray:
    """Coordinates of a set: the ``kept`` ones, and the others estimated next to them."""
    given = [i for i in members if i in kept]
    others = [i for i in members if i not in kept]
    fixed = np.concatenate([np.zeros(0), *(kept[i] for i in given)])
    u, _ = estimate(equations.about(given, -fixed), others)
    found = {**kept, **dict(zip(others, u.reshape(-1, 2), strict=True))}
    return np.concatenate([found[i] for i in members])


def shapes_between(
    equations: NormalEquations, library: Library, optimum: Optimum, offsets: tuple[int, ...]
) -> list[Proposal]:
    """Sets with an effect whose shape lies between two of the library: one more, or one of the optimum reshaped.

    Arguments as those of ``linear_proposals``. The effect at both neighbouring shapes promises what the one between
    reaches. An effect of the optimum is also moved by one proposed step.
    """
    base = library.places(optimum.members)
    names = {library.candidates[i].name for i in base}
    shapes, level = library.neighbouring_shapes, _level(equations, library, optimum)
    more = [one for one in shapes if one.name not in names]
    found = _between(equations, library, base, more, offsets, level)
    for j, member in zip(base, optimum.members, strict=True):
        others = [i for i in base if i != j]
        same = [one for one in shapes if one.name == member.name]
        found += _between(equations, library, others, same, offsets, level)
        near = np.array([[*others, i] for i in library.places(member.near_shapes(1.0))], dtype=np.intp)
        stepped = max(scores(equations, library.priors, near), key=lambda one: one.log_evidence, default=None)
        if stepped is not None and stepped.log_evidence > linear_evidence(equations, library.priors, base):
            start = estimate(equations, stepped.members)[0]
            members = library.members(stepped.members)
            found.append(Proposal(members, start, offsets, level + stepped.log_evidence))
    return found


def _level(equations: NormalEquations, library: Library, optimum: Optimum) -> float:
    """Evidence of the optimum above its linear one.

    Linear evidence is in units of the error of the model at this optimum. That error grows with the effects, so that
    only changes of evidence compare with other optima.
    """
    return optimum.log_evidence - linear_evidence(equations, library.priors, library.places(optimum.members))


def _between(
    equations: NormalEquations,
    library: Library,
    others: Sequence[int],
    neighbours: Sequence[NeighbouringShapes],
    offsets: tuple[int, ...],
    level: float,
) -> list[Proposal]:
    """The best sets of ``others`` and one effect between two ``neighbours``, one of each variety."""
    of = {(one.first, one.second): one for one in neighbours}
    sets = np.array([(*others, *two) for two in of], dtype=np.intp).reshape(-1, len(others) + 2)
    found: dict[Variety, Proposal] = {}
    for one in sorted(scores(equations, library.priors, sets), key=lambda s: -s.log_evidence):
        two = of[one.members[-2], one.members[-1]]
        first, second = library.members((two.first, two.second))
        u = estimate(equations, one.members)[0]
        a, b = u[-4:-2], u[-2:]
        if a @ b > 0.0 and first.variety not in found and len(found) < tuned.EXCHANGES:
            share = float(np.hypot(*b) / (np.hypot(*a) + np.hypot(*b)))
            members = (*library.members(others), first.between(two.shape, second, share))
            # One effect is as probable as one, not as two.
            promised = level + one.log_evidence - library.priors[two.second]
            found[first.variety] = Proposal(members, np.concatenate([u[:-4], a + b]), offsets, promised)
    return [*found.values()]


def _moves(equations: NormalEquations, library: Library, base: Sequence[int]) -> Iterator[Move]:
    """Additions of one and two effects, removals, exchanges of one effect, and one effect in place of two."""
    visible = distinct(equations, base)
    more = np.array([i for i in visible if i not in base], dtype=np.intp)
    yield Move(_each(base, more), tuned.ADDITIONS, 2)
    yield Move(_pairs(equations, library, base, more), tuned.ADDITIONS)
    if not base:
        return
    for j in base:
        others = [i for i in base if i != j]
        same = library.of_name(library.candidates[j].name)
        if others:
            yield Move(np.array([others], dtype=np.intp), 1)
        yield Move(_each(others, np.array([i for i in more if i not in same], dtype=np.intp)), tuned.EXCHANGES)
        elsewhere = np.array([i for i in same if i != j], dtype=np.intp)
        yield Move(_each(others, elsewhere), tuned.EXCHANGES, tuned.EXCHANGES)
    for two in combinations(base, 2):
        yield Move(_each([i for i in base if i not in two], more), tuned.EXCHANGES)


def _each(base: Sequence[int], more: IntArray) -> IntArray:
    """The base with each of ``more``, shape (sets, size)."""
    return np.concatenate(
        [np.broadcast_to(np.array(base, dtype=np.intp), (more.size, len(base))), more[:, None]], axis=1
    )


def _pairs(equations: NormalEquations, library: Library, base: Sequence[int], more: IntArray) -> IntArray:
    """The base with two more effects: all pairs of an empty base, else those with a leading effect."""
    first = more
    if base:
        alone = scores(equations, library.priors, of_different_names(equations, _each(base, more)))
        ranked = sorted(alone, key=lambda s: -s.log_evidence)[:_LEADING]
        first = np.array([s.members[-1] for s in ranked], dtype=np.intp)
    pairs = {tuple(sorted((int(i), int(j)))) for i in first for j in more if i != j}
    if not pairs:
        return np.zeros((0, len(base) + 2), dtype=np.intp)
    both = np.array(sorted(pairs), dtype=np.intp)
    return np.concatenate([np.broadcast_to(np.array(base, dtype=np.intp), (len(both), len(base))), both], axis=1)


def _best(equations: NormalEquations, library: Library, move: Move) -> list[Scored]:
    """Sets of a move by decreasing evidence, at most some of each kind."""
    if not move.sets.size:
        return []
    sets = of_different_names(equations, move.sets)
    ranked = sorted(scores(equations, library.priors, sets), key=lambda s: -s.log_evidence)
    kinds: Counter[tuple[int, ...]] = Counter()
    chosen: list[Scored] = []
    for one in ranked:
        kind = tuple(sorted(library.varieties[i] for i in one.members))
        if kinds[kind] < move.of_a_kind:
            kinds[kind] += 1
            chosen.append(one)
        if len(chosen) == move.most:
            break
    return chosen
