"""What a quick analyst would do: fit and forget the registration, then least squares with all effects and BIC.

No priors, no simulation accuracy, no exact model, no groups, no "unknown": the yardstick of the blind test.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.discrepancy.candidates import candidates
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.normal import Whitened, coordinates, normal
from cycloid_profile.discrepancy.recording import hold_nothing_out, record
from cycloid_profile.effects.built import Built
from cycloid_profile.measurement.files import Measurement

_MOST = 5


def named_by_bic(built: Built, measurements: Sequence[Measurement], discs: Sequence[int]) -> list[str]:
    """Names of the effects that stepwise least squares keeps."""
    recordings = [hold_nothing_out(record(built, m, d)) for m, d in zip(measurements, discs, strict=True)]
    scanned = frozenset(r.disc for r in recordings if r.kind == "profile_scan")
    library = candidates(built, scanned, any(r.kind != "profile_scan" for r in recordings))
    equations = normal([Whitened(Laid(r, built)) for r in recordings], library)
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
    """Fall of chi² less the penalty of BIC."""
    where = [w for w in coordinates(members) if equations.R[w, w] > 1e-9]
    if not where:
        return -math.inf
    b, R = equations.b[where], equations.R[np.ix_(where, where)]
    return float(b @ np.linalg.lstsq(R, b, rcond=1e-10)[0]) - penalty * len(where)
