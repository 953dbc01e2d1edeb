"""How much more likely the data are with some effects than with none (docs/theory.md, Eq. 53).

    ln B = ½ bᵀ(1 + R)⁻¹b − ½ ln|1 + R| + Σ [ln π/(1 − π) − ln N] + Σ ln 2Φ(û/σ)

with coordinates in units of their prior widths, π the chance that an effect is there and N the places it could be at;
the last sum over members that cannot be negative, whose prior is the upper half of a normal distribution.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.special import log_ndtr

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.discrepancy.candidates import IMPLAUSIBLE, Candidate, places
from cycloid_profile.discrepancy.normal import Normal, coordinates

CHANCE = 0.05
_LEADERS = 40
_INVISIBLE = 0.01  # (standard deviations)² that a whole width of an effect shows
ALIAS = 0.999  # cosine above which no data of these kinds tell two effects apart


@dataclass(frozen=True)
class Scored:
    """A set of candidates, by number, with its evidence against no effect."""

    members: tuple[int, ...]
    log_evidence: float


def log_priors(candidates: Sequence[Candidate], frequencies: int = 1) -> FloatArray:
    """ln π/(1 − π) − ln N of every candidate; ``frequencies``, how many chatter could have."""
    count = places(candidates)
    count["grinding_chatter"] = frequencies
    odds = math.log(CHANCE / (1.0 - CHANCE))
    return np.array([odds - math.log(count[candidate.name]) for candidate in candidates])


def search(equations: Normal, priors: FloatArray, deepest: int = 3, keep: Sequence[int] = ()) -> list[Scored]:
    """All singles and pairs, and triples of the leading pairs with everything, best first.

    Of candidates of one name that show alike only the first takes part, or the one in ``keep``.
    """
    visible = _unlike(equations, keep)
    if not visible.size:
        return []
    singles = visible[:, np.newaxis]
    scored = scores(equations, priors, singles)
    if visible.size > 1 and deepest > 1:
        pairs = np.array(list(combinations(visible.tolist(), 2)), dtype=np.intp)
        pairs = _of_different_names(equations, pairs)
        scored += scores(equations, priors, pairs)
    best = sorted(scored, key=lambda s: -s.log_evidence)
    if deepest > 2 and visible.size > 2:
        leading = [s.members for s in best if len(s.members) == 2][:_LEADERS]
        triples = {tuple(sorted((*pair, int(i)))) for pair in leading for i in visible if i not in pair}
        if triples:
            chosen = _of_different_names(equations, np.array(sorted(triples), dtype=np.intp))
            best = sorted(best + scores(equations, priors, chosen), key=lambda s: -s.log_evidence)
    return best


def estimate(equations: Normal, members: Sequence[int]) -> tuple[FloatArray, FloatArray]:
    """Coordinates of ``members`` in units of their widths, and their covariance."""
    where = coordinates(members)
    covariance = np.linalg.inv(np.eye(where.size) + equations.R[np.ix_(where, where)])
    return covariance @ equations.b[where], covariance


def linear_evidence(equations: Normal, priors: FloatArray, members: Sequence[int]) -> float:
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
    """Whether no coordinate pair of ``u`` is one that no workshop makes, or on the wrong side of zero."""
    parts = u.reshape(-1, 2)
    negative = [c.one_sided and x <= 0.0 for c, x in zip(members, parts[:, 0], strict=True)]
    return bool(np.all(np.hypot(parts[:, 0], parts[:, 1]) <= IMPLAUSIBLE)) and not any(negative)


def with_one_more(equations: Normal, priors: FloatArray, members: Sequence[int]) -> Scored:
    """The likelier of a set and of that set with the one candidate more that helps it most."""
    others = [i for i in range(len(equations.candidates)) if i not in members]
    sets = np.array([[*members, i] for i in others], dtype=np.intp)
    scored = scores(equations, priors, _of_different_names(equations, sets)) if others else []
    alone = Scored(tuple(members), linear_evidence(equations, priors, members))
    return max([alone, *scored], key=lambda s: s.log_evidence)


def log_evidence_at(
    fall: float, u: FloatArray, covariance: FloatArray, prior: float, members: Sequence[Candidate]
) -> float:
    """Evidence of an exact optimum: ``fall`` of chi², coordinates ``u`` with their covariance (1 + R)⁻¹."""
    _, log_det = np.linalg.slogdet(covariance)
    half = _of_half_priors(u, covariance, np.array([c.one_sided for c in members], dtype=bool))
    return 0.5 * (fall - float(u @ u)) + 0.5 * float(log_det) + prior + float(half)


def scores(equations: Normal, priors: FloatArray, sets: IntArray) -> list[Scored]:
    """Evidence of sets of one size, shape (sets, size), those left out that no workshop makes."""
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
    """Σ ln 2Φ(û/σ) of members that cannot be negative, over any sets: shapes (…, 2n), (…, 2n, 2n), (…, n)."""
    sigma = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    gained = math.log(2.0) + log_ndtr(u / sigma)
    found: FloatArray = np.sum(np.where(one_sided, gained[..., 0::2], 0.0), axis=-1)
    return found


def _unlike(equations: Normal, keep: Sequence[int]) -> IntArray:
    """Candidates that show at all, those left out that show like an earlier one of their name."""
    n = len(equations.candidates)
    blocks = equations.R.reshape(n, 2, n, 2)
    own = np.einsum("icid->icd", blocks)
    size = own[:, 0, 0] + own[:, 1, 1]
    visible = np.flatnonzero(size > _INVISIBLE)
    order = [*keep, *(int(i) for i in visible if i not in set(keep))]
    names: dict[str, list[int]] = {}
    for i in order:
        names.setdefault(equations.candidates[i].name, []).append(i)
    chosen: list[int] = []
    for twins in names.values():
        alike = _alike(blocks, own, np.array(twins, dtype=np.intp))
        kept: list[int] = []
        for place in range(len(twins)):
            if not np.any(alike[place, kept]):
                kept.append(place)
        chosen += [twins[place] for place in kept]
    return np.array(sorted(chosen), dtype=np.intp)


def _alike(blocks: FloatArray, own: FloatArray, some: IntArray) -> BoolArray:
    """Whether all that one of some candidates shows another can show too, and the other way round; shape (n, n)."""
    cross = blocks[some][:, :, some].transpose(0, 2, 1, 3)
    inverse = np.linalg.pinv(own[some], rcond=1e-9, hermitian=True)
    size = np.trace(own[some], axis1=1, axis2=2)
    left = size[:, np.newaxis] - np.einsum("ijcd,jde,ijce->ij", cross, inverse, cross, optimize=True)
    as_large = np.abs(size[:, np.newaxis] - size) <= 0.02 * size[:, np.newaxis]
    found: BoolArray = as_large & (left < 2.0 * (1.0 - ALIAS) * size[:, np.newaxis])
    return found


def _of_different_names(equations: Normal, sets: IntArray) -> IntArray:
    """Without sets that name an effect twice, two bad lobes apart: one effect at one place is the simpler story."""
    where = [(c.name, str(c.choice.get("lobe"))) for c in equations.candidates]
    names = {place: i for i, place in enumerate(sorted(set(where)))}
    of = np.array([names[place] for place in where])
    twice = np.zeros(len(sets), dtype=bool)
    for i, j in combinations(range(sets.shape[1]), 2):
        twice |= of[sets[:, i]] == of[sets[:, j]]
    kept: IntArray = sets[~twice]
    return kept
