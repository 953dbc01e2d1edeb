"""Members of a set whose size the files determine."""

from __future__ import annotations

import numpy as np

from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search._second_order import change_of_predictions, product, whitened_parts


def determined(model: ExactModel, optimum: Optimum) -> list[int]:
    """Numbers of the members whose size is clearly not zero, by their linear or, on loops, by their whole response.

    Friction moves rows from flank to flank at once: on stiff parts with play the slope at a row shows nothing of it.
    """
    found = optimum.determined
    if model.only_loops:
        some = [i for i in range(len(optimum.members)) if i not in found]
        found = sorted([*found, *(i for i in some if _whole_response(model, optimum, i) > tuned.DETERMINED**2)])
    return found


def _whole_response(model: ExactModel, optimum: Optimum, member: int) -> float:
    """Response to a member at its size, in standard deviations, squared: what small changes of the others leave."""
    others, u = optimum.part([i for i in range(len(optimum.members)) if i != member])
    state, without = model.at(optimum), model.state(others, u)
    if without is None:
        return 0.0
    blocks = state.blocks
    response = whitened_parts(blocks, change_of_predictions(without, state)[:, np.newaxis])
    columns = [block.columns(others) for block in blocks]
    cross, R = product(blocks, columns, response), product(blocks, columns, columns)
    left = product(blocks, response, response) - cross.T @ np.linalg.solve(np.eye(len(R)) + R, cross)
    return float(left[0, 0])
