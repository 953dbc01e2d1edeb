"""Energy of one pose of a stage, compiled by numba: the arithmetic of ``StageEnergy``, which is its readable reference.

Imported only where numba can be had (not on every platform). Pins follow the law δ = factor·F·(K − ln F).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.contact.energy import ARMIJO, DAMPING, HALVINGS, NEWTON_STEPS, ROUNDING


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def least_energy(  # pragma: no cover - compiled, out of the sight of the coverage tool
    factor: float,
    constant: FloatArray,
    gap: FloatArray,
    frame: FloatArray,
    own: IntArray,
    spring_stretch: FloatArray,
    stretch: FloatArray,
    bearing_stiffness: float,
    play: float,
    torque: float,
    rotation: float,
    arm: FloatArray,
    tolerance: float,
    step: FloatArray,
    force: FloatArray,
    stiffness: FloatArray,
    now: FloatArray,
    work: FloatArray,
) -> float:
    """Newton of ``minimise`` from ``step``, which becomes the step to the least energy; the imbalance there.

    ``constant`` K + ln factor of each pin, ``gap``, ``force``, ``stiffness`` shape (discs, pins); ``frame`` (3, discs,
    pins): normal and lever; ``now``, stretch of the bearings there; ``work`` shape (4 + unknowns, unknowns).
    """
    trial, direction, gradient, found, hessian = work[0], work[1], work[2], work[3], work[4:]
    energy = energy_at(factor, constant, gap, frame, own, spring_stretch, stretch, bearing_stiffness, play, torque,
                       rotation, step, gradient, force, stiffness, now)  # fmt: skip
    off: float = imbalance(gradient, arm, torque)
    for _ in range(NEWTON_STEPS):
        if not (off >= tolerance and off < np.inf):
            break
        fill_hessian(frame, own, spring_stretch, bearing_stiffness, play, stiffness, now, hessian)
        largest = 0.0
        for a in range(arm.size):
            largest = max(largest, hessian[a, a])
        for a in range(arm.size):
            hessian[a, a] += DAMPING * largest / (arm[a] * arm[a])
        solve(hessian, gradient, direction)
        slope = 0.0
        for a in range(arm.size):
            slope += gradient[a] * direction[a]
        slack = ROUNDING * (abs(energy) + abs(torque * rotation))
        fraction, lower = 1.0, energy
        for _ in range(HALVINGS):
            for a in range(arm.size):
                trial[a] = step[a] + fraction * direction[a]
            lower = energy_at(factor, constant, gap, frame, own, spring_stretch, stretch, bearing_stiffness, play,
                              torque, rotation, trial, found, force, stiffness, now)  # fmt: skip
            if not lower > energy + ARMIJO * fraction * slope + slack:
                break
            fraction *= 0.5
        energy = lower
        for a in range(arm.size):
            step[a], gradient[a] = trial[a], found[a]
        off = imbalance(gradient, arm, torque)
    return off


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def imbalance(gradient: FloatArray, arm: FloatArray, torque: float) -> float:  # pragma: no cover
    """Largest generalised force out of balance, as a moment over the torque; infinite where one is NaN."""
    worst: float = 0.0
    for a in range(arm.size):
        worst = max(worst, abs(gradient[a]) * arm[a])
        if math.isnan(gradient[a]):
            return np.inf
    relative: float = worst / abs(torque)
    return relative


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def energy_at(  # pragma: no cover
    factor: float,
    constant: FloatArray,
    gap: FloatArray,
    frame: FloatArray,
    own: IntArray,
    spring_stretch: FloatArray,
    stretch: FloatArray,
    bearing_stiffness: float,
    play: float,
    torque: float,
    rotation: float,
    step: FloatArray,
    gradient: FloatArray,
    force: FloatArray,
    stiffness: FloatArray,
    now: FloatArray,
) -> float:
    """Energy at a step; fills gradient, pin forces and stiffnesses, and the stretch of the bearings ``now``."""
    discs, pins = gap.shape
    gradient[:] = 0.0
    energy: float = -torque * (rotation + step[0])
    gradient[0] = -torque
    for d in range(discs):
        x, y, t = step[own[d, 0]], step[own[d, 1]], step[own[d, 2]]
        fx, fy, m = 0.0, 0.0, 0.0
        for k in range(pins):
            delta = frame[0, d, k] * x + frame[1, d, k] * y + frame[2, d, k] * t - gap[d, k]
            if not delta > 0.0:
                force[d, k], stiffness[d, k] = 0.0, 0.0
                continue
            c = max(constant[d, k] - math.log(delta), 1.0 + 1e-9)
            v = c + math.log(c) * c / (c - 1.0)
            for _ in range(3):
                error, rise = v - math.log(v) - c, 1.0 - 1.0 / v
                v -= error / (rise - 0.5 * error / (v * v * rise))
            F = delta / (factor * v)
            rate = 1.0 / (factor * (v - 1.0))
            energy += 0.5 * factor * F * F * (v - 0.5)
            force[d, k], stiffness[d, k] = F, rate
            fx += F * frame[0, d, k]
            fy += F * frame[1, d, k]
            m += F * frame[2, d, k]
        gradient[own[d, 0]] += fx
        gradient[own[d, 1]] += fy
        gradient[own[d, 2]] += m
    for s in range(len(spring_stretch)):
        sx, sy = stretch[s, 0], stretch[s, 1]
        for a in range(step.size):
            sx += spring_stretch[s, 0, a] * step[a]
            sy += spring_stretch[s, 1, a] * step[a]
        now[s, 0], now[s, 1] = sx, sy
        length = math.sqrt(sx * sx + sy * sy)
        if length > play:
            beyond = length - play
            energy += 0.5 * bearing_stiffness * beyond * beyond
            share = bearing_stiffness * beyond / length
            for a in range(step.size):
                gradient[a] += share * (spring_stretch[s, 0, a] * sx + spring_stretch[s, 1, a] * sy)
    return energy


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def fill_hessian(  # pragma: no cover
    frame: FloatArray,
    own: IntArray,
    spring_stretch: FloatArray,
    bearing_stiffness: float,
    play: float,
    stiffness: FloatArray,
    now: FloatArray,
    hessian: FloatArray,
) -> None:
    """Fill the second derivative of the energy, where ``energy_at`` left stiffnesses and stretch."""
    hessian[:] = 0.0
    discs, pins = stiffness.shape
    unknowns = len(hessian)
    for d in range(discs):
        for k in range(pins):
            rate = stiffness[d, k]
            if rate > 0.0:
                for a in range(3):
                    for b in range(3):
                        hessian[own[d, a], own[d, b]] += rate * frame[a, d, k] * frame[b, d, k]
    for s in range(len(spring_stretch)):
        sx, sy = now[s, 0], now[s, 1]
        length = math.sqrt(sx * sx + sy * sy)
        pressed = length > play and length > 0.0
        across = 1.0 - play / length if pressed else (1.0 if play == 0.0 else 0.0)
        ux, uy = (sx / length, sy / length) if pressed else (0.0, 0.0)
        xx = bearing_stiffness * (across + (1.0 - across) * ux * ux)
        yy = bearing_stiffness * (across + (1.0 - across) * uy * uy)
        xy = bearing_stiffness * (1.0 - across) * ux * uy
        for a in range(unknowns):
            ax, ay = spring_stretch[s, 0, a], spring_stretch[s, 1, a]
            if ax == 0.0 and ay == 0.0:
                continue
            bx, by = xx * ax + xy * ay, xy * ax + yy * ay
            for b in range(unknowns):
                hessian[a, b] += bx * spring_stretch[s, 0, b] + by * spring_stretch[s, 1, b]


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def solve(matrix: FloatArray, right: FloatArray, found: FloatArray) -> None:  # pragma: no cover
    """``found`` = −matrix⁻¹·``right`` by Cholesky's factors, written over the lower half of ``matrix``."""
    n = right.size
    for a in range(n):
        for b in range(a + 1):
            total = matrix[a, b]
            for c in range(b):
                total -= matrix[a, c] * matrix[b, c]
            if a == b:
                matrix[a, a] = math.sqrt(total)
            else:
                matrix[a, b] = total / matrix[b, b]
    for a in range(n):
        total = -right[a]
        for c in range(a):
            total -= matrix[a, c] * found[c]
        found[a] = total / matrix[a, a]
    for a in range(n - 1, -1, -1):
        total = found[a]
        for c in range(a + 1, n):
            total -= matrix[c, a] * found[c]
        found[a] = total / matrix[a, a]
