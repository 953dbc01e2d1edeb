"""Baseline for the blind test: registration fitted first, then stepwise least squares over all effects with BIC.

No priors, no accuracy of the simulation, no exact model, no ambiguity groups, no "unknown" verdict.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.diagnosis import Residuals
from cycloid_profile.diagnosis.data.recording import record, use_all_rows
from cycloid_profile.diagnosis.model.candidate import candidates
from cycloid_profile.diagnosis.model.whitened import Whitened, coordinates, normal_equations
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import PROFILE_SCAN, Measurement

_MOST = 5


def named_by_bic(reducer: AsBuiltReducer, measurements: Sequence[Measurement], discs: Sequence[int]) -> list[str]:
    """Names of the effects selected by stepwise least squares."""
    recordings = [use_all_rows(record(reducer, m, d)) for m, d in zip(measurements, discs, strict=True)]
    scanned = frozenset(r.disc for r in recordings if r.kind is PROFILE_SCAN)
    library = candidates(reducer, scanned, any(r.kind.is_curve for r in recordings))
    equations = normal_equations([Whitened(Residuals(r, reducer)) for r in recordings], library)
    penalty = math.log(equations.rows)
    chosen: list[int] = []
    best = 0.0
    while len(chosen) < _MOST:
        scores = [(_gain(equations, [*chosen, i], penalty), i) for i in range(len(library)) if i not in chosen]
        value, i = max(scores)
        if value <= best:
            break
        best, chosen = value, [*chosen, i]
    for i in list(chosen):
        fewer = [j for j in chosen if j != i]
        if fewer and _gain(equations, fewer, penalty) > best:
            best, chosen = _gain(equations, fewer, penalty), fewer
    return [library[i].name for i in chosen]


def _gain(equations, members: list[int], penalty: float) -> float:
    """Fall of chi² minus the penalty of BIC."""
    where = [w for w in coordinates(members) if equations.R[w, w] > 1e-9]
    if not where:
        return -math.inf
    b, R = equations.b[where], equations.R[np.ix_(where, where)]
    return float(b @ np.linalg.lstsq(R, b, rcond=1e-10)[0]) - penalty * len(where)
