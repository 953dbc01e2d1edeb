"""Balance and first touch of very many reducers, compiled by numba; imported inside functions only.

Each call uses one thread and releases the interpreter lock, so that chunks run in parallel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.compiled import inner, kernel
from cycloid_profile.contact.stage._kernels import PoseProblem, StageArrays, least_energy, width_at, workspace

_ABREAST = 8  # reducers side by side: as many numbers as the processor keeps in registers


class SearchStart(NamedTuple):
    """Where the search for the equilibrium of a reducer starts: to first order about the drawing.

    ``place`` of contacts loaded as drawn and of bearing forces, shape (loads, some), counted over all forces;
    ``motion`` of carrier and discs, shape (loads, unknowns, some), and ``force`` there, shape (loads, some, some), per
    deformation [mm].
    """

    place: IntArray
    motion: FloatArray
    force: FloatArray


@kernel
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


def balanced_reducers(
    drawn: StageArrays,
    load: FloatArray,
    gap: FloatArray,
    stretch: FloatArray,
    play: FloatArray,
    pressure_per_root_force: FloatArray,
    start: SearchStart,
    tolerance: float,
    chosen: IntArray,
    contact: IntArray | None = None,
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Rotation of the output [rad], highest peak pressure [MPa], that of one ``contact`` of each load, and the contact
    with the highest, counted over all discs; shape (reducers, loads). NaN without equilibrium.

    The stage as ``drawn``, under any contact law, its poses all loads, of which each reducer has those ``chosen``,
    shape (reducers, loads), and the forces ``load`` that deform its elastic discs; ``gap`` (reducers, loads, discs,
    pins) and ``stretch`` (reducers, loads, bearings, 2) of each reducer in place of those as drawn [mm]; ``play`` of
    its bearings, shape (reducers,) [mm]; ``pressure_per_root_force``, peak pressure of each contact under 1 N [MPa];
    ``start`` of the search; ``tolerance`` of the imbalance over the torque; ``contact``: the one with the highest
    pressure unless given.
    """
    turned, pressure, followed = np.empty((3, *gap.shape[:2]))
    first = np.full(gap.shape[:2], -1, np.int64)
    asked = first if contact is None else np.ascontiguousarray(contact)
    _balanced(
        drawn, load, gap, stretch, play, pressure_per_root_force, start, tolerance, chosen, asked, turned, pressure,
        followed, first,
    )  # fmt: skip
    return turned, pressure, followed, first


@kernel
def _balanced(  # pragma: no cover - compiled, out of the sight of the coverage tool
    drawn: StageArrays,
    load: FloatArray,
    gap: FloatArray,
    stretch: FloatArray,
    play: FloatArray,
    per_root_force: FloatArray,
    start: SearchStart,
    tolerance: float,
    chosen: IntArray,
    contact: IntArray,
    turned: FloatArray,
    pressure: FloatArray,
    followed: FloatArray,
    first: IntArray,
) -> None:
    """Fill ``turned``, ``pressure``, ``followed`` and ``first``, shape (reducers, loads).

    The stage as ``drawn``, its poses the loads, and the forces ``load`` that deform its elastic discs; the others as in
    ``balanced_reducers``.
    """
    reducers, loads, discs, pins = gap.shape
    step, forces, apart = np.empty(drawn.arm.size), np.empty(load.shape[1]), np.empty(start.place.shape[1])
    work = workspace(discs, pins, stretch.shape[2], step.size, forces.size > 0)
    # Reducers one after another at a load: its compliance is then in the cache of the processor.
    for p in range(loads):
        for i in range(reducers):
            at = chosen[i, p]
            problem = PoseProblem(
                drawn.law, drawn.constant[at], gap[i, p], drawn.frame[at], drawn.own, drawn.spring_stretch[at],
                stretch[i, p], drawn.bearing, play[i], drawn.torque[at], drawn.rotation[at], drawn.arm,
                drawn.compliance[at], width_at(drawn.width, drawn.width.slope[at]),
            )  # fmt: skip
            search_start(
                problem, start, drawn.gap[at], drawn.stretch[at], drawn.play[at], load[at], at, apart, step, forces
            )
            off = least_energy(problem, tolerance, step, forces, work)
            highest, one, asked, own = 0.0, -1, contact[i, p], 0.0
            for d in range(discs):
                for k in range(pins):
                    force = work.force[d * pins + k]
                    if force > 0.0:
                        here = math.sqrt(force) * per_root_force[at, d, k]
                        if here > highest:
                            highest, one = here, d * pins + k
                        if d * pins + k == asked:
                            own = here
            lost = not off < 100.0 * tolerance
            turned[i, p] = np.nan if lost else drawn.rotation[at] + step[0]
            pressure[i, p] = np.nan if lost else highest
            followed[i, p] = np.nan if lost else (own if asked >= 0 else highest)
            first[i, p] = one


@inner
def search_start(  # pragma: no cover - compiled, out of the sight of the coverage tool
    problem: PoseProblem,
    start: SearchStart,
    gap: FloatArray,
    stretch: FloatArray,
    play: float,
    load: FloatArray,
    at: int,
    apart: FloatArray,
    step: FloatArray,
    forces: FloatArray,
) -> None:
    """Fill ``step``, and in elastic discs ``forces``, with the start of the search.

    ``gap``, ``stretch``, ``play`` and ``load`` as drawn; ``apart`` is room for the deformation that the errors bring.
    """
    discs, pins = gap.shape
    for j in range(apart.size):
        one = start.place[at, j]
        if one < discs * pins:
            d, k = one // pins, one % pins
            apart[j] = gap[d, k] - problem.gap[d, k]
        else:
            s, i = (one - discs * pins) // 2, (one - discs * pins) % 2
            length = math.hypot(stretch[s, 0], stretch[s, 1])
            taken = (problem.play - play) / length if length > 0.0 else 0.0  # more play lets a bearing follow its load
            apart[j] = problem.stretch[s, i] - (1.0 + taken) * stretch[s, i]
    for a in range(step.size):
        step[a] = 0.0
        for j in range(apart.size):
            step[a] += start.motion[at, a, j] * apart[j]
    for i in range(load.size):  # as in ``elastic_direction``, a slice would take longer to compile
        forces[i] = load[i]
    for i in range(apart.size if forces.size > 0 else 0):
        one = start.place[at, i]
        for j in range(apart.size):
            forces[one] += start.force[at, i, j] * apart[j]
        if one < discs * pins:
            forces[one] = max(forces[one], 0.0)


@kernel
def chosen_rows(  # pragma: no cover - compiled, out of the sight of the coverage tool
    begin: IntArray, column: IntArray, weight: FloatArray, x: FloatArray, chosen: IntArray, found: FloatArray
) -> None:
    """Add the product of some rows of a sparse matrix with each row of ``x`` to ``found``.

    ``found`` shape (reducers, loads, rows of a load); ``chosen`` the loads of each reducer, shape (reducers, loads).
    """
    reducers, loads, rows = found.shape
    for i in range(reducers):
        for p in range(loads):
            for r in range(rows):
                row = np.uint64(chosen[i, p] * rows + r)
                added = 0.0
                for entry in range(np.uint64(begin[row]), np.uint64(begin[row + np.uint64(1)])):
                    added += weight[entry] * x[i, np.uint64(column[entry])]
                found[i, p, r] += added
