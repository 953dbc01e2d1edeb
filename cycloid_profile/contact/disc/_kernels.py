"""Moment balance of one disc on a rigid crank at very many poses, compiled by numba; imported inside functions only.

``balance_moments`` holds the numpy reference. Loading the compiled code takes a third of a second.
"""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.compiled import kernel
from cycloid_profile.contact.laws._kernels import approach_bound, contact_constant, force_step
from cycloid_profile.contact.laws.compiled import CompiledLaw


@kernel
def balance(  # pragma: no cover - compiled, out of the sight of the coverage tool
    law: CompiledLaw,
    gap: FloatArray,
    lever: FloatArray,
    curvature: FloatArray,
    torque: FloatArray,
    tolerance: float,
    rotation: FloatArray,
    approach: FloatArray,
    force: FloatArray,
    stiffness: FloatArray,
    residual: FloatArray,
    converged: BoolArray,
    begin: int,
    end: int,
) -> None:
    """Newton for the rotation and the logarithms of all forces together: one logarithm a pin and step.

    Fills ``rotation``, ``residual`` and ``converged``, shape (poses,), and ``approach``, ``force`` and ``stiffness`` of
    loaded pins, shape (poses, pins), of the poses from ``begin`` to ``end``.
    """
    _, pins = gap.shape
    for p in range(begin, end):
        longest = 0.0
        for i in range(pins):
            longest = max(longest, lever[p, i])
        # A pin that closes early and could carry all alone bounds the rotation from above.
        first, least = 0, np.inf
        for i in range(pins):
            if lever[p, i] >= 0.5 * longest and gap[p, i] < least * lever[p, i]:
                first, least = i, gap[p, i] / lever[p, i]
        reached = np.empty(pins, np.int64)
        K, F, delta, rate = np.empty(pins), np.zeros(pins), np.zeros(pins), np.ones(pins)
        alone = approach_bound(law, contact_constant(law, curvature[p, first]), torque[p] / lever[p, first])
        beta = (gap[p, first] + alone) / lever[p, first]
        count = 0
        for i in range(pins):
            if beta * lever[p, i] > gap[p, i]:
                K[count], reached[count] = contact_constant(law, curvature[p, i]), i
                count += 1
        found = np.inf
        for _ in range(60):
            moment, known, slope, off = 0.0, 0.0, 0.0, 0.0
            for q in range(count):
                i = reached[q]
                d = beta * lever[p, i] - gap[p, i]
                if d <= 0.0:
                    F[q] = 0.0
                    continue
                F[q], delta[q], rate[q] = force_step(law, K[q], d, F[q], delta[q], rate[q])
                turning = lever[p, i] * F[q]
                moment += turning
                known += turning * (gap[p, i] + delta[q] - rate[q]) / rate[q]
                slope += turning * lever[p, i] / rate[q]
                off = max(off, abs(delta[q] - d))
            found = abs(moment / torque[p] - 1.0)
            if (found < tolerance and off < 1e-13 * beta * longest) or not slope > 0.0:
                break
            beta = (torque[p] + known) / slope
        rotation[p], residual[p] = beta, found
        converged[p] = found < tolerance
        for q in range(count):
            if F[q] > 0.0:
                i = reached[q]
                approach[p, i], force[p, i], stiffness[p, i] = delta[q], F[q], F[q] / rate[q]
