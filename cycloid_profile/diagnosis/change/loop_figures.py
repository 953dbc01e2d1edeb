"""Figures of the hysteresis loop before and after: they do not depend on the name that play or compliance gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import CycloidError
from cycloid_profile.measurement import HYSTERESIS
from cycloid_profile.rig import evaluate_loop, hysteresis_loop
from cycloid_profile.units import ARCMIN, NEWTON_METRE

_STEP = 0.2  # standard deviations of each coordinate
_POINTS = 120
NAMES = ("friction_torque_nm", "compliance_arcmin_per_nm", "lost_motion_arcmin")


@dataclass(frozen=True)
class FigureChange:
    """A figure of the loop before and after; ``uncertainty``: one standard deviation of the change."""

    name: str
    before: float
    after: float
    uncertainty: float

    @property
    def change(self) -> float:
        """After minus before."""
        return self.after - self.before

    @property
    def significance(self) -> float:
        """The change in standard deviations."""
        return abs(self.change) / self.uncertainty if self.uncertainty > 0.0 else float("inf") if self.change else 0.0


def figures_of_loop(
    model: ExactModel, members: Sequence[Candidate], u: FloatArray, covariance: FloatArray
) -> tuple[FigureChange, ...]:
    """Friction, compliance and lost motion at both times, with ``members`` at coordinates ``u`` and their covariance.

    Empty without a loop. A change has a further error of ``FORM`` of itself, as that of an effect.
    """
    peak = min((r.peak_torque_nm for r in model.recordings if r.kind is HYSTERESIS), default=0.0) * NEWTON_METRE
    state = model.state(members, u) if peak else None
    now = None if state is None else _both(state, peak)
    if now is None:
        return ()
    slopes = np.zeros((len(NAMES), u.size))
    for k in (k for k in range(u.size) if k % 2 < members[k // 2].coordinates):
        step = _STEP * float(np.sqrt(covariance[k, k]))
        moved = model.state(members, u + step * (np.arange(u.size) == k))
        found = None if moved is None else _both(moved, peak)
        if found is not None:
            slopes[:, k] = ((found[1] - found[0]) - (now[1] - now[0])) / step
    change = now[1] - now[0]
    error = np.sqrt(np.einsum("fi,ij,fj->f", slopes, covariance, slopes) + (tuned.FORM * change) ** 2)
    return tuple(
        FigureChange(*values) for values in zip(NAMES, now[0].tolist(), now[1].tolist(), error.tolist(), strict=True)
    )


def _both(state: State, peak: float) -> tuple[FloatArray, FloatArray] | None:
    earlier, later = (
        next(one.reducer for one in state.residuals if one.recording.later == time) for time in (False, True)
    )
    try:
        return _figures(earlier, peak), _figures(later, peak)
    except CycloidError:
        return None


def _figures(reducer: AsBuiltReducer, peak: float) -> FloatArray:
    """Friction at zero torque [N·m], compliance from half to full torque [′/(N·m)] and lost motion [′] without
    friction, shape (3,).

    Zero torque is the middle of the loop: at its ends reversals hide how friction grows with the load.
    """
    friction = reducer.coulomb_torque / NEWTON_METRE
    smooth = replace(reducer, coulomb_torque=0.0, proportional_friction=0.0, breakaway_torque=0.0, friction_spread=0.0)
    loop = hysteresis_loop(smooth, peak, _POINTS)
    found = evaluate_loop(loop.torque, loop.angle)
    compliance = NEWTON_METRE / ARCMIN / found.torsional_rigidity
    return np.array([friction, compliance, found.lost_motion / ARCMIN])
