"""Log evidence of a set of effects against no effect (docs/theory.md, Eq. 53).

    ln B = ½ bᵀ(1 + R)⁻¹b − ½ ln|1 + R| + Σ [ln π/(1 − π) − ln N] + Σ ln 2Φ(û/σ)

Coordinates are in units of their prior widths. π is the prior probability of an effect, N its number of locations. The
last sum covers one-sided members, whose prior is a half-normal distribution.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations, pairwise
from typing import Any, NamedTuple

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.diagnosis.model.candidate import IMPLAUSIBLE, Candidate, Variety, places
from cycloid_profile.diagnosis.model.whitened import NormalEquations, coordinates

CHANCE = 0.05  # prior probability of each effect: two of forty are expected
_INVISIBLE = 0.01  # least information of one prior width, in (standard deviations)²
_LEAST_VARIANCE = 1e-20  # prior widths²
ALIAS = 0.999  # cosine above which no data of these kinds separate two effects


@dataclass(frozen=True)
class Scored:
    """Set of candidates, by index, with its log evidence against no effect."""

    members: tuple[int, ...]
    log_evidence: float


def log_priors(candidates: Sequence[Candidate], frequencies: int = 1) -> FloatArray:
    """ln π/(1 − π) − ln N of every candidate; ``frequencies``: number of waves that chatter could have."""
    count = places(candidates)
    count["grinding_chatter"] = frequencies
    odds = math.log(CHANCE / (1.0 - CHANCE))
    return np.array([odds - math.log(count[one.name]) + one.log_odds for one in candidates])


def estimate(equations: NormalEquations, members: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Coordinates of ``members`` in units of their widths, and their covariance."""
    where = coordinates(members)
    covariance = np.linalg.inv(np.eye(where.size) + equations.R[np.ix_(where, where)])
    return covariance @ equations.b[where], covariance


def linear_evidence(equations: NormalEquations, priors: FloatArray, members: Sequence[int]) -> float:
    """Evidence of a set from linearised equations."""
    if not members:
        return 0.0
    where = coordinates(members)
    u, covariance = estimate(equations, members)
    B = np.eye(where.size) + equations.R[np.ix_(where, where)]
    value = 0.5 * u @ equations.b[where] - 0.5 * np.linalg.slogdet(B)[1] + priors[list(members)].sum()
    one_sided = np.array([equations.candidates[i].one_sided for i in members])
    return float(value + _of_half_priors(u, covariance, one_sided))


def is_plausible(members: Sequence[Candidate], u: FloatArray) -> bool:
    """Whether every coordinate pair of ``u`` is within the plausible size, and on the permitted side of zero."""
    parts = u.reshape(-1, 2)
    negative = [c.one_sided and x <= 0.0 for c, x in zip(members, parts[:, 0], strict=True)]
    return bool(np.all(np.hypot(parts[:, 0], parts[:, 1]) <= IMPLAUSIBLE)) and not any(negative)


def best_extension_or_self(equations: NormalEquations, priors: FloatArray, members: Sequence[int]) -> Scored:
    """The better of a set and its best extension by one candidate."""
    others = [i for i in range(len(equations.candidates)) if i not in members]
    sets = np.array([[*members, i] for i in others], dtype=np.intp)
    scored = scores(equations, priors, of_different_names(equations, sets)) if others else []
    alone = Scored(tuple(members), linear_evidence(equations, priors, members))
    return max([alone, *scored], key=lambda s: s.log_evidence)


def log_evidence_at(
    fall: float, u: FloatArray, covariance: FloatArray, prior: float, members: Sequence[Candidate]
) -> float:
    """Log evidence at an exact optimum: ``fall`` of chi², coordinates ``u``, covariance (1 + R)⁻¹."""
    _, log_det = np.linalg.slogdet(covariance)
    half = _of_half_priors(u, covariance, np.array([c.one_sided for c in members], dtype=bool))
    return 0.5 * (fall - float(u @ u)) + 0.5 * float(log_det) + prior + float(half)


def scores(equations: NormalEquations, priors: FloatArray, sets: IntArray) -> list[Scored]:
    """Evidence of sets of one size, ``sets`` of shape (sets, size); implausible sets are omitted."""
    if not len(sets):
        return []
    count, size = sets.shape
    where = (2 * sets[:, :, np.newaxis] + np.arange(2)).reshape(count, 2 * size)
    b = equations.b[where]
    B = np.eye(2 * size) + equations.R[where[:, :, np.newaxis], where[:, np.newaxis, :]]
    u = np.linalg.solve(B, b[..., np.newaxis])[..., 0]
    _, log_det = np.linalg.slogdet(B)
    value = 0.5 * np.sum(b * u, axis=1) - 0.5 * log_det + priors[sets].sum(axis=1)
    parts = u.reshape(count, size, 2)
    one_sided = np.array([c.one_sided for c in equations.candidates])
    half = np.any(one_sided[sets], axis=1)
    if np.any(half):
        value[half] += _of_half_priors(u[half], np.linalg.inv(B[half]), one_sided[sets[half]])
    allowed = np.all(np.hypot(parts[..., 0], parts[..., 1]) <= IMPLAUSIBLE, axis=1)
    allowed &= ~np.any(one_sided[sets] & (parts[..., 0] <= 0.0), axis=1)
    return [Scored(tuple(int(i) for i in row), float(v)) for row, v, ok in zip(sets, value, allowed, strict=True) if ok]


def _of_half_priors(u: FloatArray, covariance: FloatArray, one_sided: BoolArray) -> FloatArray:
    """Σ ln 2Φ(û/σ) of one-sided members, broadcast over sets: shapes (…, 2n), (…, 2n, 2n), (…, n)."""
    from scipy.special import log_ndtr

    # Rounding takes the variance of a size that is known to many digits below zero.
    sigma = np.sqrt(np.maximum(np.diagonal(covariance, axis1=-2, axis2=-1), _LEAST_VARIANCE))
    gained = math.log(2.0) + log_ndtr(u / sigma)
    found: FloatArray = np.sum(np.where(one_sided, gained[..., 0::2], 0.0), axis=-1)
    return found


def distinct(equations: NormalEquations, keep: Sequence[int]) -> IntArray:
    """Indices of visible candidates, without those whose pattern is identical to an earlier one of the same name."""
    n = len(equations.candidates)
    blocks = equations.R.reshape(n, 2, n, 2)
    own = np.einsum("icid->icd", blocks)
    size = own[:, 0, 0] + own[:, 1, 1]
    visible = np.flatnonzero(size > _INVISIBLE)
    order = [*keep, *(int(i) for i in visible if i not in set(keep))]
    names: dict[tuple[str, bool], list[int]] = {}
    for i in order:
        names.setdefault((equations.candidates[i].name, equations.candidates[i].is_change), []).append(i)
    chosen: list[int] = []
    for twins in names.values():
        identical = _identical(blocks, own, np.array(twins, dtype=np.intp))
        kept: list[int] = []
        for place in range(len(twins)):
            if not np.any(identical[place, kept]):
                kept.append(place)
        chosen += [twins[place] for place in kept]
    return np.array(sorted(chosen), dtype=np.intp)


def _identical(blocks: FloatArray, own: FloatArray, some: IntArray) -> BoolArray:
    """Whether two candidates span identical patterns of equal size, for all pairs of ``some``; shape (n, n)."""
    cross = blocks[some][:, :, some].transpose(0, 2, 1, 3)
    inverse = np.linalg.pinv(own[some], rcond=1e-9, hermitian=True)
    size = np.trace(own[some], axis1=1, axis2=2)
    left = size[:, np.newaxis] - np.einsum("ijcd,jde,ijce->ij", cross, inverse, cross, optimize=True)
    as_large = np.abs(size[:, np.newaxis] - size) <= 0.02 * size[:, np.newaxis]
    found: BoolArray = as_large & (left < 2.0 * (1.0 - ALIAS) * size[:, np.newaxis])
    return found


def of_different_names(equations: NormalEquations, sets: IntArray) -> IntArray:
    """Sets in which no effect occurs twice, except single teeth on different lobes."""
    where = [(c.name, c.is_change, str(c.choice.get("lobe"))) for c in equations.candidates]
    names = {place: i for i, place in enumerate(sorted(set(where)))}
    of = np.array([names[place] for place in where])
    twice = np.zeros(len(sets), dtype=bool)
    for i, j in combinations(range(sets.shape[1]), 2):
        twice |= of[sets[:, i]] == of[sets[:, j]]
    kept: IntArray = sets[~twice]
    return kept


class NeighbouringShapes(NamedTuple):
    """Indices of two candidates of one ``name`` that differ in a ``shape`` alone, by one step up."""

    name: str
    shape: str
    first: int
    second: int


@dataclass(frozen=True, eq=False)
class Library:
    """``candidates``; chatter among them can have any of ``frequencies`` numbers of waves."""

    candidates: tuple[Candidate, ...]
    frequencies: int

    @cached_property
    def priors(self) -> FloatArray:
        """Log prior of each candidate, shape (candidates,)."""
        return log_priors(self.candidates, frequencies=self.frequencies)

    def with_more(self, more: Sequence[Candidate]) -> Library:
        """The library extended by candidates it does not have; existing indices are unchanged."""
        fresh = [one for one in dict.fromkeys(more) if one not in self._numbers]
        return Library((*self.candidates, *fresh), self.frequencies) if fresh else self

    def places(self, members: Sequence[Candidate]) -> list[int]:
        """Indices of candidates."""
        return [self._numbers[member] for member in members]

    def members(self, places: Sequence[int]) -> tuple[Candidate, ...]:
        """Candidates of indices."""
        return tuple(self.candidates[i] for i in places)

    def prior(self, members: Sequence[Candidate]) -> float:
        """Sum of the log priors of members."""
        return float(sum(self.priors[self.places(members)]))

    def where(self, name: str, choice: Mapping[str, Any]) -> Candidate | None:
        """The candidate of a name with this choice of parts, None if absent."""
        return self._by_choice.get((name, _key(choice)))

    @cached_property
    def varieties(self) -> list[int]:
        """Number of the variety of each candidate."""
        numbers: dict[Variety, int] = {}
        return [numbers.setdefault(one.variety, len(numbers)) for one in self.candidates]

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of the effects."""
        return frozenset(candidate.name for candidate in self.candidates)

    def of_name(self, name: str) -> list[int]:
        """Indices of an effect at all its locations."""
        return [i for i, candidate in enumerate(self.candidates) if candidate.name == name]

    @cached_property
    def neighbouring_shapes(self) -> list[NeighbouringShapes]:
        """All pairs of candidates that differ in one shape alone, by one step."""
        found: list[NeighbouringShapes] = []
        orders: dict[tuple[Any, ...], list[tuple[float, int]]] = {}
        for i, candidate in enumerate(self.candidates):
            if candidate.listed and not candidate.is_change:
                for shape in candidate.numeric_shapes:
                    common, value = candidate.shape_order(shape)
                    orders.setdefault((candidate.name, shape, common), []).append((value, i))
        for (name, shape, _), order in orders.items():
            ranked = [i for _, i in sorted(order)]
            if self.candidates[ranked[0]].is_place(shape):
                ranked.append(ranked[0])
            found += [NeighbouringShapes(name, shape, *two) for two in pairwise(ranked)]
        return found

    @cached_property
    def _by_choice(self) -> dict[tuple[str, tuple[tuple[str, Any], ...]], Candidate]:
        return {(one.name, _key(one.choice)): one for one in self.candidates if not one.is_change}

    @cached_property
    def _numbers(self) -> dict[Candidate, int]:
        return {candidate: i for i, candidate in enumerate(self.candidates)}


def _key(choice: Mapping[str, Any]) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(choice.items()))
