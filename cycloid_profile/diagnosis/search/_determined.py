"""Members of a set whose size the files determine."""

from __future__ import annotations

import numpy as np

from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.search._second_order import change_of_predictions, product, whitened_parts


def misfit_jumps(model: ExactModel) -> bool:
    """Whether friction of any size may move rows of loops to the other flank.

    Comparisons start from diagnoses that know the friction.
    """
    return model.only_loops and not model.is_comparison


def determined(model: ExactModel, optimum: Optimum) -> list[int]:
    """Numbers of the members whose size is clearly not zero, by their linear or, on loops, by their whole response.

    Friction moves rows from flank to flank at once: on stiff parts with play the slope at a row shows nothing of it.
    """
    found = optimum.linearly_determined
    rest = [i for i in range(len(optimum.members)) if i not in found]
    if rest and misfit_jumps(model):
        state = model.at(optimum)
        found = sorted([*found, *(i for i in rest if _whole_response(model, optimum, state, i) > tuned.DETERMINED**2)])
    return found


def _whole_response(model: ExactModel, optimum: Optimum, state: State, member: int) -> float:
    """Response to a member at its size, in standard deviations, squared: what small changes of the others leave.

    ``state`` of the optimum. The deviations are those of the noise and of what the model errs in the size.
    """
    others, u = optimum.part([i for i in range(len(optimum.members)) if i != member])
    without = model.state(others, u)
    if without is None:
        return 0.0
    blocks = state.blocks
    response = whitened_parts(blocks, change_of_predictions(without, state)[:, np.newaxis])
    columns = [block.columns(others) for block in blocks]
    cross, R = product(blocks, columns, response), product(blocks, columns, columns)
    left = float((product(blocks, response, response) - cross.T @ np.linalg.solve(np.eye(len(R)) + R, cross))[0, 0])
    one, size = optimum.part([member])
    return left / (1.0 + left * one[0].size_error ** 2 / float(size @ size))
