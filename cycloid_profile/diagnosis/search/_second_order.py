"""Starting points for effects that cancel to first order, because all discs or all pins share them.

Their response grows with the square of the size and turns with twice the angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, files_together
from cycloid_profile.diagnosis.search._proposals import Proposal
from cycloid_profile.effects import EffectLocation

_KEPT = 3  # starts; few effects cancel to first order
_MOST = 2  # effects of a start: a third effect that cancels is rare, and each costs four solutions
_UNSEEN = 1.0  # standard deviations of the linear response to a prior width
_TRIAL = 0.5  # prior widths
_LEAST, _LARGEST = 0.05, 4.0  # times the response at the trial size
# Between a square-root and a proportional relation of size and response.
_POWER = 0.7


def second_order(
    model: ExactModel, library: Library, equations: NormalEquations, optimum: Optimum, offsets: tuple[int, ...]
) -> list[Proposal]:
    """The set of an optimum with one effect of second order more, those that explain most.

    ``equations`` of the library about the optimum. Effects that a scan shows are of first order.
    """
    if model.only_scans or len(optimum.members) >= _MOST:
        return []
    before, found = model.at(optimum), []
    for candidate in _cancelling(library, equations, optimum):
        columns = _second_order_responses(model, before, candidate)
        if columns is not None:
            drop, amounts = chi2_reduction(before.blocks, columns)
            start = np.concatenate([optimum.u, _coordinates(amounts)])
            found.append((drop, Proposal((*optimum.members, candidate), start, offsets)))
    return [one for _, one in sorted(found, key=lambda one: -one[0])[:_KEPT]]


def _cancelling(library: Library, equations: NormalEquations, optimum: Optimum) -> Iterator[Candidate]:
    """Candidates that linear equations about an optimum do not see because all discs or all pins share them."""
    named = {member.title for member in optimum.members}
    for i, candidate in enumerate(library.candidates):
        turns = candidate.angle is not None and candidate.kind.location is not EffectLocation.SENSOR
        information = float(np.trace(equations.R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]))
        if turns and candidate.on_all_discs and information < _UNSEEN**2 and candidate.title not in named:
            yield candidate


def _second_order_responses(model: ExactModel, before: State, candidate: Candidate) -> FloatArray | None:
    """Response patterns at half a prior width next to the members of a state, shape (rows, 3); None without a solution.

    The patterns vary with cosine and sine of twice its angle; the third is constant.
    """
    shown = []
    for angle in np.deg2rad([0.0, 90.0, 45.0, 135.0]):
        u = np.array([*before.u, _TRIAL * np.cos(angle), _TRIAL * np.sin(angle)])
        state = model.state([*before.members, candidate], u)
        if state is None:
            return None
        shown.append(change_of_predictions(before, state))
    return np.stack([0.5 * (shown[0] - shown[1]), 0.5 * (shown[2] - shown[3]), 0.25 * np.sum(shown, axis=0)], axis=1)


def _coordinates(amounts: FloatArray) -> FloatArray:
    """Coordinates at which a candidate has this response."""
    size = _TRIAL * min(max(float(np.hypot(amounts[0], amounts[1])), _LEAST) ** _POWER, _LARGEST)
    angle = 0.5 * float(np.arctan2(amounts[1], amounts[0]))
    return np.array([size * np.cos(angle), size * np.sin(angle)])


def change_of_predictions(before: State, after: State) -> FloatArray:
    """Change of the predictions at all rows of all recordings, in the order of the blocks."""
    files = zip(files_together(before.residuals), files_together(after.residuals), strict=True)
    return np.concatenate(
        [a.residual - b.residual for first, second in files for a, b in zip(first, second, strict=True)]
    )


def chi2_reduction(blocks: Sequence[Whitened], columns: FloatArray) -> tuple[float, FloatArray]:
    """Reduction of chi² by free amounts of ``columns`` over all rows of all recordings, and the amounts."""
    G = whitened_parts(blocks, columns)
    R, b = product(blocks, G, G), product(blocks, G, [block.z for block in blocks])
    amounts = np.asarray(np.linalg.lstsq(R, b, rcond=1e-9)[0], dtype=np.float64)
    return float(amounts @ b), amounts


def whitened_parts(blocks: Sequence[Whitened], columns: FloatArray) -> list[FloatArray]:
    """Columns over all rows of all recordings, whitened, one array for each block."""
    ends = np.cumsum([block.chosen.size for block in blocks])[:-1]
    parts = np.split(np.nan_to_num(columns), ends)
    return [block.white(part) for block, part in zip(blocks, parts, strict=True)]


def product(blocks: Sequence[Whitened], left: Sequence[FloatArray], right: Sequence[FloatArray]) -> FloatArray:
    """leftᵀ M right over all recordings."""
    parts = [block.product(a, b) for block, a, b in zip(blocks, left, right, strict=True)]
    return np.asarray(np.sum(parts, axis=0), dtype=np.float64)
