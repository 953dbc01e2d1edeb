"""Starting points for effects that cancel to first order, because all discs or all pins share them.

Their response grows with the square of the size and turns with twice the angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.evidence import Library, is_plausible
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, files_together
from cycloid_profile.effects import EffectLocation
from cycloid_profile.measurement import PROFILE_SCAN

Start = tuple[list[int], FloatArray]  # library indices and coordinates

_SINGLES, _PAIRS = 3, 6  # starts kept; few effects cancel to first order
_TRIAL = 0.5  # prior widths
_LEAST, _LARGEST = 0.05, 4.0  # times the response at the trial size
# Between a square-root and a proportional relation of size and response.
_POWER = 0.7


def second_order(model: ExactModel, library: Library, equations: NormalEquations) -> list[Start]:
    """Starts of single second-order effects that explain most, and of pairs with one first-order effect, the best of
    each two names.

    ``equations`` of the library about no effect. Neither of the two effects of a pair need be the best single effect.
    Effects that a scan shows are of first order.
    """
    if model.only_scans:
        return []
    blocks, hypotheses = model.baseline.blocks, library.candidates
    G = [block.columns(hypotheses) for block in blocks]
    alone: list[tuple[float, list[int], FloatArray]] = []
    best: dict[tuple[str, str], tuple[float, list[int], FloatArray]] = {}
    for i, columns in _second_order_responses(model, library):
        drop, amounts = chi2_reduction(blocks, columns)
        alone.append((drop, [i], _coordinates(amounts)))
        own = library.candidates[i]
        if any(r.kind is PROFILE_SCAN and model.flank_grid.touches(own, r.disc) for r in model.recordings):
            continue
        for both, k, amounts, u in _given_first_order(equations, blocks, G, columns):
            names = (own.name, library.candidates[k].name)
            if names[0] != names[1] and both > best.get(names, (0.0,))[0]:
                best[names] = (both, [i, k], np.concatenate([_coordinates(amounts), u]))
    singles = sorted(alone, key=lambda f: -f[0])[:_SINGLES]
    pairs = sorted(best.values(), key=lambda f: -f[0])[:_PAIRS]
    return [(members, u) for _, members, u in (*singles, *pairs)]


def _given_first_order(
    first: NormalEquations, blocks: Sequence[Whitened], G: Sequence[FloatArray], columns: FloatArray
) -> Iterator[tuple[float, int, FloatArray, FloatArray]]:
    """For each first-order candidate: reduction of chi² with ``columns``, its index, amounts of the columns, its
    coordinates.
    """
    S = whitened_parts(blocks, columns)
    ridge = np.eye(columns.shape[1]) / _LARGEST**2
    R_s, b_s = ridge + product(blocks, S, S), product(blocks, S, [block.z for block in blocks])
    cross = product(blocks, S, G)
    alone = np.linalg.solve(R_s, b_s)
    carried = np.linalg.solve(R_s, cross)
    left = first.b - cross.T @ alone
    for k, candidate in enumerate(first.candidates):
        where = slice(2 * k, 2 * k + 2)
        R = np.eye(2) + first.R[where, where] - cross[:, where].T @ carried[:, where]
        u = np.asarray(np.linalg.solve(R, left[where]), dtype=np.float64)
        if is_plausible([candidate], u):
            amounts = np.asarray(alone - carried[:, where] @ u, dtype=np.float64)
            yield float(b_s @ alone + u @ left[where]), k, amounts, u


def _second_order_responses(coarse: ExactModel, library: Library) -> Iterator[tuple[int, FloatArray]]:
    """Each candidate that cancels to first order, with its response patterns at half a prior width, shape (rows, 3).

    The patterns vary with cosine and sine of twice its angle; the third is constant.
    """
    before = coarse.baseline
    for i, candidate in enumerate(library.candidates):
        if candidate.angle is None or not candidate.on_all_discs or candidate.kind.location is EffectLocation.SENSOR:
            continue
        shown = []
        for angle in np.deg2rad([0.0, 90.0, 45.0, 135.0]):
            state = coarse.state([candidate], _TRIAL * np.array([np.cos(angle), np.sin(angle)]))
            if state is None:
                break
            shown.append(change_of_predictions(before, state))
        else:
            yield (
                i,
                np.stack(
                    [0.5 * (shown[0] - shown[1]), 0.5 * (shown[2] - shown[3]), 0.25 * np.sum(shown, axis=0)], axis=1
                ),
            )


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
