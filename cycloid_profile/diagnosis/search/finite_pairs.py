"""Starting pairs with one member at a finite size.

The response to a size may be strongly nonlinear: linear equations about zero can even have the wrong sign.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate, Variety
from cycloid_profile.diagnosis.model.evidence import estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import NormalEquations, coordinates
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search.identical_effects import always_identical
from cycloid_profile.diagnosis.search.local_search import Start, equations_about

LINEAR_LIMIT = 0.05  # widths: linear equations hold below this size
_COMBINED_SINGLES = 5  # ranked single effects of different shape that are combined
_LEAST, _MOST = 0.3, 2.0  # widths: range of starting sizes


def pairs_of_finite_size(model: ExactModel, library: Library, ranked_singles: Sequence[Optimum]) -> list[Start]:
    """Starting pairs of each ranked single effect with each effect without direction of another name.

    Only effects that keep most poses equivalent are tried. A fit may stop if a member falls below ``LINEAR_LIMIT``
    widths.
    """
    amounts = _of_distinct_shapes(
        model, (c for c in library.candidates if _is_amount(c) and model.solves_few_poses([c]))
    )
    starts = list[Start]()
    for one in _of_distinct_variety(model, ranked_singles):
        equations = equations_about(model, library, one)
        (first,) = library.places(one.members)
        for partner in amounts:
            if partner.name == one.members[0].name or always_identical(model.reducer, partner, one.members[0]):
                continue
            (i,) = library.places([partner])
            u = float(estimate(equations, [first, i])[0][2])
            sign = 1.0 if partner.one_sided or u > 0.0 else -1.0
            partner_u = np.array([sign * float(np.clip(sign * u, _LEAST, _MOST)), 0.0])
            starts.append(([first, i], np.concatenate([_first_given_other(equations, first, i, partner_u), partner_u])))
    return starts


def _first_given_other(equations: NormalEquations, first: int, other: int, u: FloatArray) -> FloatArray:
    """Coordinates of ``first`` given coordinates ``u`` of ``other``, limited to the largest starting size."""
    own, others = coordinates([first]), coordinates([other])
    R = equations.R[np.ix_(own, own)]
    found = np.linalg.solve(np.eye(own.size) + R, equations.b[own] - equations.R[np.ix_(own, others)] @ u)
    return np.asarray(found / max(float(np.hypot(*found)) / _MOST, 1.0), dtype=np.float64)


def _of_distinct_variety(model: ExactModel, ranked_singles: Sequence[Optimum]) -> list[Optimum]:
    """First of each variety among the ranked effects that keep most poses equivalent."""
    first: dict[Variety, Optimum] = {}
    for one in ranked_singles:
        if len(one.members) == 1 and model.solves_few_poses(one.members):
            first.setdefault(one.members[0].variety, one)
    unlike = {id(c) for c in _of_distinct_shapes(model, (one.members[0] for one in first.values()))}
    return [one for one in first.values() if id(one.members[0]) in unlike][:_COMBINED_SINGLES]


def _of_distinct_shapes(model: ExactModel, some: Iterable[Candidate]) -> list[Candidate]:
    """Candidates with different flank shapes, the first of each shape."""
    kept = list[Candidate]()
    for candidate in some:
        if not any(always_identical(model.reducer, candidate, other) for other in kept):
            kept.append(candidate)
    return kept


def _is_amount(candidate: Candidate) -> bool:
    """Whether the effect has no direction and few locations; of single cranks only the first."""
    apart = {"lobe", "first_lobe", "pin", "waves_per_turn"} & candidate.choice.keys()
    return candidate.angle is None and not apart and candidate.choice.get("crank") in (None, 1)
