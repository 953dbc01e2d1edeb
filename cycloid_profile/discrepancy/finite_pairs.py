"""A single effect that leads beside an amount of another, tried at a size that shows.

What a little of an amount does need not be what more of it does: equations about none of it may even have its sign
wrong.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.alias import always_alike
from cycloid_profile.discrepancy.candidates import Candidate, Variety
from cycloid_profile.discrepancy.climbing import Start, about
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, coordinates
from cycloid_profile.discrepancy.optimum import Optimum

A_LITTLE = 0.05  # widths, below which linear equations do not err
_LEADS = 5  # single effects of unlike names, beside which others are tried
_LEAST, _MOST = 0.3, 2.0  # widths that they are tried at


def pairs_of_finite_size(model: ExactModel, library: Library, lead: Sequence[Optimum]) -> list[Start]:
    """Where to begin with each single effect that leads beside each amount of another name; only of those that few
    poses stand for. One that falls below ``A_LITTLE`` widths need not be followed.
    """
    amounts = _of_unlike_shapes(model, (c for c in library.candidates if _is_amount(c) and model.solves_few_poses([c])))
    starts = list[Start]()
    for one in _leading(model, lead):
        equations = about(model, library, one)
        (first,) = library.places(one.members)
        for partner in amounts:
            if partner.name == one.members[0].name or always_alike(model.built, partner, one.members[0]):
                continue
            (i,) = library.places([partner])
            u = float(estimate(equations, [first, i])[0][2])
            sign = 1.0 if partner.one_sided or u > 0.0 else -1.0
            beside = np.array([sign * float(np.clip(sign * u, _LEAST, _MOST)), 0.0])
            starts.append(([first, i], np.concatenate([_beside(equations, first, i, beside), beside])))
    return starts


def _beside(equations: Normal, first: int, other: int, u: FloatArray) -> FloatArray:
    """Coordinates of the ``first`` where the ``other`` has coordinates ``u``, no further off than a workshop makes."""
    own, others = coordinates([first]), coordinates([other])
    R = equations.R[np.ix_(own, own)]
    found = np.linalg.solve(np.eye(own.size) + R, equations.b[own] - equations.R[np.ix_(own, others)] @ u)
    return np.asarray(found / max(float(np.hypot(*found)) / _MOST, 1.0), dtype=np.float64)


def _leading(model: ExactModel, lead: Sequence[Optimum]) -> list[Optimum]:
    """The first of each name, of one disc and of all, that few poses stand for."""
    first: dict[Variety, Optimum] = {}
    for one in lead:
        if len(one.members) == 1 and model.solves_few_poses(one.members):
            first.setdefault(one.members[0].variety, one)
    unlike = {id(c) for c in _of_unlike_shapes(model, (one.members[0] for one in first.values()))}
    return [one for one in first.values() if id(one.members[0]) in unlike][:_LEADS]


def _of_unlike_shapes(model: ExactModel, some: Iterable[Candidate]) -> list[Candidate]:
    """The first of those that make the same flanks."""
    kept = list[Candidate]()
    for candidate in some:
        if not any(always_alike(model.built, candidate, other) for other in kept):
            kept.append(candidate)
    return kept


def _is_amount(candidate: Candidate) -> bool:
    """Whether it has no direction, and few places; of single cranks, which turn alike, the first."""
    apart = {"lobe", "first_lobe", "pin", "waves_per_turn"} & candidate.choice.keys()
    return candidate.angle is None and not apart and candidate.choice.get("crank") in (None, 1)
