"""Balance and first touch of very many reducers, compiled by numba; ``loaded`` and ``clearance`` hold the readable
references.

Imported only where numba can be had (not on every platform). One thread a call, free of the
interpreter's lock, so that chunks run beside each other.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cycloid_profile.arrays import FloatArray, IntArray

_NEWTON_STEPS, _HALVINGS, _ARMIJO, _ROUNDING, _DAMPING = 80, 40, 1e-4, 1e-13, 1e-9
_ABREAST = 8  # reducers side by side: as many numbers as the processor keeps at hand


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def least_turns(  # pragma: no cover - compiled, out of the sight of the coverage tool
    begin: IntArray, column: IntArray, weight: FloatArray, base: FloatArray, x: FloatArray, least: FloatArray
) -> None:
    """Fill ``least``, shape (reducers, flanks), with the least closing turn of each flank over its contacts.

    The matrix of turns per unit in rows by contact and flank: row r has ``weight`` at the coordinates ``column`` from
    ``begin[r]`` on; ``base`` shape (contacts, flanks); ``x`` shape (reducers, coordinates).
    """
    contacts, flanks = base.shape
    reducers, coordinates = x.shape
    some, found = np.empty((coordinates, _ABREAST)), np.empty((flanks, _ABREAST))
    for first in range(0, reducers, _ABREAST):
        count = min(_ABREAST, reducers - first)
        for s in range(_ABREAST):
            for c in range(coordinates):
                some[c, s] = x[first + min(s, count - 1), c]
        found[:] = np.inf
        for k in range(contacts):
            for f in range(flanks):
                # Without a sign an index needs no look at numbers counted from the end.
                row = np.uint64(k * flanks + f)
                t0 = t1 = t2 = t3 = t4 = t5 = t6 = t7 = base[k, f]
                for entry in range(np.uint64(begin[row]), np.uint64(begin[row + np.uint64(1)])):
                    w, at = weight[entry], np.uint64(column[entry])
                    # Eight names, not eight places of an array: twice as fast.
                    t0 += w * some[at, 0]
                    t1 += w * some[at, 1]
                    t2 += w * some[at, 2]
                    t3 += w * some[at, 3]
                    t4 += w * some[at, 4]
                    t5 += w * some[at, 5]
                    t6 += w * some[at, 6]
                    t7 += w * some[at, 7]
                found[f, 0] = min(found[f, 0], t0)
                found[f, 1] = min(found[f, 1], t1)
                found[f, 2] = min(found[f, 2], t2)
                found[f, 3] = min(found[f, 3], t3)
                found[f, 4] = min(found[f, 4], t4)
                found[f, 5] = min(found[f, 5], t5)
                found[f, 6] = min(found[f, 6], t6)
                found[f, 7] = min(found[f, 7], t7)
        for s in range(count):
            for f in range(flanks):
                least[first + s, f] = found[f, s]


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def balanced(  # pragma: no cover - compiled, out of the sight of the coverage tool
    factor: float,
    constant: FloatArray,
    gap: FloatArray,
    frame: FloatArray,
    own: IntArray,
    spring_stretch: FloatArray,
    stretch: FloatArray,
    bearing_stiffness: float,
    play: FloatArray,
    torque: FloatArray,
    rotation: FloatArray,
    arm: FloatArray,
    per_root_force: FloatArray,
    start: FloatArray,
    tolerance: float,
    turned: FloatArray,
    pressure: FloatArray,
) -> None:
    """Fill ``turned`` and ``pressure``, shape (reducers, loads).

    The law is δ = factor·F·(K − ln F) with ``constant`` K + ln factor for each contact, shape (loads, discs, pins).
    ``gap`` shape (reducers, loads, discs, pins); ``frame`` (3, loads, discs, pins): normal and
    lever; ``spring_stretch`` (loads, bearings, 2, unknowns); ``stretch`` (reducers, loads, bearings, 2); ``play``
    (reducers,); ``start`` (reducers, loads, unknowns); the others as in ``StageEnergy``.
    """
    reducers, loads, discs, pins = gap.shape
    bearings, unknowns = spring_stretch.shape[1], arm.size
    step, trial, direction = np.empty(unknowns), np.empty(unknowns), np.empty(unknowns)
    gradient, found = np.empty(unknowns), np.empty(unknowns)
    hessian = np.empty((unknowns, unknowns))
    force, stiffness = np.zeros((discs, pins)), np.zeros((discs, pins))
    now = np.empty((bearings, 2))
    for i in range(reducers):
        for p in range(loads):
            step[:] = start[i, p]
            energy = _point(factor, constant[p], gap[i, p], frame[:, p], own, spring_stretch[p],
                            stretch[i, p], bearing_stiffness, play[i], torque[p], rotation[p], step, gradient, force,
                            stiffness, now)  # fmt: skip
            off = _imbalance(gradient, arm, torque[p])
            for _ in range(_NEWTON_STEPS):
                if not off >= tolerance:
                    break
                _hessian(frame[:, p], own, spring_stretch[p], bearing_stiffness, play[i], stiffness, now, hessian)
                largest = 0.0
                for a in range(unknowns):
                    largest = max(largest, hessian[a, a])
                for a in range(unknowns):
                    hessian[a, a] += _DAMPING * largest / (arm[a] * arm[a])
                _solve(hessian, gradient, direction)
                slope = 0.0
                for a in range(unknowns):
                    slope += gradient[a] * direction[a]
                slack = _ROUNDING * (abs(energy) + abs(torque[p] * rotation[p]))
                fraction = 1.0
                lower = energy
                for _ in range(_HALVINGS):
                    for a in range(unknowns):
                        trial[a] = step[a] + fraction * direction[a]
                    lower = _point(factor, constant[p], gap[i, p], frame[:, p], own, spring_stretch[p],
                                   stretch[i, p], bearing_stiffness, play[i], torque[p], rotation[p], trial, found,
                                   force, stiffness, now)  # fmt: skip
                    if not lower > energy + _ARMIJO * fraction * slope + slack:
                        break
                    fraction *= 0.5
                energy = lower
                for a in range(unknowns):
                    step[a], gradient[a] = trial[a], found[a]
                off = _imbalance(gradient, arm, torque[p])
            highest = 0.0
            for d in range(discs):
                for k in range(pins):
                    if force[d, k] > 0.0:
                        highest = max(highest, math.sqrt(force[d, k]) * per_root_force[p, d, k])
            lost = not off < 100.0 * tolerance
            turned[i, p] = np.nan if lost else rotation[p] + step[0]
            pressure[i, p] = np.nan if lost else highest


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def _imbalance(gradient: FloatArray, arm: FloatArray, torque: float) -> float:  # pragma: no cover
    worst = 0.0
    for a in range(arm.size):
        worst = max(worst, abs(gradient[a]) * arm[a])
        if math.isnan(gradient[a]):
            return np.inf
    return worst / abs(torque)


@njit(cache=True, nogil=True, error_model="numpy")  # type: ignore[untyped-decorator, unused-ignore]
def _point(  # pragma: no cover
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
def _hessian(  # pragma: no cover
    frame: FloatArray,
    own: IntArray,
    spring_stretch: FloatArray,
    bearing_stiffness: float,
    play: float,
    stiffness: FloatArray,
    now: FloatArray,
    hessian: FloatArray,
) -> None:
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
def _solve(matrix: FloatArray, right: FloatArray, found: FloatArray) -> None:  # pragma: no cover
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
