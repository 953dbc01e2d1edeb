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
from cycloid_profile.contact.compiled_energy import least_energy

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
    step, work = np.empty(unknowns), np.empty((4 + unknowns, unknowns))
    force, stiffness = np.zeros((discs, pins)), np.zeros((discs, pins))
    now = np.empty((bearings, 2))
    for i in range(reducers):
        for p in range(loads):
            step[:] = start[i, p]
            off = least_energy(factor, constant[p], gap[i, p], frame[:, p], own, spring_stretch[p], stretch[i, p],
                               bearing_stiffness, play[i], torque[p], rotation[p], arm, tolerance, step, force,
                               stiffness, now, work)  # fmt: skip
            highest = 0.0
            for d in range(discs):
                for k in range(pins):
                    if force[d, k] > 0.0:
                        highest = max(highest, math.sqrt(force[d, k]) * per_root_force[p, d, k])
            lost = not off < 100.0 * tolerance
            turned[i, p] = np.nan if lost else rotation[p] + step[0]
            pressure[i, p] = np.nan if lost else highest
