"""Moment balance of very many poses, compiled by numba; ``balance_moments`` is its readable reference.

Imported only where numba can be had (not on every platform) and there is enough to do at
once: to import and load the compiled code takes a third of a second, to compile it the first time two.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit, prange

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.contact.hertz import LineContact
from cycloid_profile.contact.law_forms import Logarithmic


def balanced(
    law: Logarithmic, contact: LineContact, gap: FloatArray, lever: FloatArray, torque: FloatArray, tolerance: float
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, BoolArray]:
    """Rotation (poses,), approach, force, stiffness (poses, pins), residual (poses,), and which poses settled."""
    scale = law.scale(contact)
    poses = len(torque)
    rotation, residual, settled = np.empty(poses), np.empty(poses), np.zeros(poses, dtype=np.bool_)
    approach, force, stiffness = (np.zeros_like(gap) for _ in range(3))
    _balance(
        scale.G, scale.K0, scale.by_tooth_radius, 1.0 / contact.radius_cap, 1.0 / contact.pin_radius,
        np.ascontiguousarray(gap), np.ascontiguousarray(lever), np.ascontiguousarray(contact.curvature),
        np.ascontiguousarray(torque), tolerance, rotation, approach, force, stiffness, residual, settled,
    )  # fmt: skip
    return rotation, approach, force, stiffness, residual, settled


@njit(cache=True, parallel=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def _balance(  # pragma: no cover - compiled, out of the sight of the coverage tool
    G: float,
    K0: float,
    by_tooth_radius: bool,
    least_bend: float,
    pin_bend: float,
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
    settled: BoolArray,
) -> None:
    """Newton for the rotation and the logarithms of all forces together: one logarithm a pin and step."""
    poses, pins = gap.shape
    ln_G = math.log(G)
    for p in prange(poses):
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
        F_alone = torque[p] / lever[p, first]
        bend = abs(curvature[p, first])
        K_alone = K0 + math.log(
            abs(pin_bend - curvature[p, first]) / (max(bend, least_bend) if by_tooth_radius else 1.0)
        )
        beta = (gap[p, first] + G * F_alone * (K_alone - math.log(F_alone))) / lever[p, first]
        count = 0
        for i in range(pins):
            if beta * lever[p, i] > gap[p, i]:
                bend = abs(curvature[p, i])
                K[count] = K0 + math.log(
                    abs(pin_bend - curvature[p, i]) / (max(bend, least_bend) if by_tooth_radius else 1.0)
                )
                reached[count] = i
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
                if F[q] == 0.0:
                    # v = K − ln F is c + ln v; ln v is 2.75 within a few hundredths of v for any pin.
                    F[q] = d / (G * (K[q] + ln_G - math.log(d) + 2.75))
                else:
                    F[q] *= max(0.1, 1.0 + (d - delta[q]) / rate[q])
                v = K[q] - math.log(F[q])
                delta[q], rate[q] = G * F[q] * v, G * F[q] * (v - 1.0)
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
        settled[p] = found < tolerance
        for q in range(count):
            if F[q] > 0.0:
                i = reached[q]
                approach[p, i], force[p, i], stiffness[p, i] = delta[q], F[q], F[q] / rate[q]
