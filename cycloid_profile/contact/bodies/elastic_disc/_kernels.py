"""Compliance between all forces on the discs of a stage, compiled by numba; imported inside functions only."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.compiled import inner, kernel


@kernel
def fill_compliances(  # pragma: no cover - compiled, out of the sight of the coverage tool
    matrix: FloatArray, own: FloatArray, along: FloatArray, turned: FloatArray, found: FloatArray
) -> None:
    """``fill_compliance`` of every pose, shape (poses, forces, forces)."""
    for p in range(len(along)):
        fill_compliance(matrix, own, along[p], turned[p], found[p])


@inner
def fill_compliance(  # pragma: no cover
    matrix: FloatArray, own: FloatArray, along: FloatArray, turned: FloatArray, found: FloatArray
) -> None:
    """Fill the compliance of one pose, shape (forces, forces).

    ``matrix`` and ``own`` as in ``DiscCompliance``, discs first; ``along`` shape (discs, pins), place of each pin in
    flank points; ``turned`` shape (discs,), orientation of each disc [rad]. Cubic interpolation between flank points.
    """
    discs, pins = along.shape
    points = own.shape[1]
    bearings = (matrix.shape[1] - points) // 2
    node, weight = np.empty((pins, 4), np.int64), np.empty((pins, 4))
    found[:] = 0.0
    for d in range(discs):
        C, first = matrix[d], d * pins
        for k in range(pins):
            _cubic(along[d, k], points, node[k], weight[k])
        for k in range(pins):
            for i in range(4):
                found[first + k, first + k] += weight[k, i] * own[d, node[k, i]]
            for other in range(k):
                total = 0.0
                for i in range(4):
                    row = 0.0
                    for j in range(4):
                        row += weight[other, j] * C[node[k, i], node[other, j]]
                    total += weight[k, i] * row
                found[first + k, first + other] = total
                found[first + other, first + k] = total
        cos, sin = math.cos(turned[d]), math.sin(turned[d])
        for b in range(bearings):
            at = discs * pins + 2 * (d * bearings + b)
            here = points + 2 * b
            for k in range(pins):
                x, y = 0.0, 0.0
                for i in range(4):
                    x += weight[k, i] * C[node[k, i], here]
                    y += weight[k, i] * C[node[k, i], here + 1]
                found[first + k, at] = found[at, first + k] = cos * x - sin * y
                found[first + k, at + 1] = found[at + 1, first + k] = sin * x + cos * y
            for other in range(bearings):
                column, there = discs * pins + 2 * (d * bearings + other), points + 2 * other
                xx, xy = C[here, there], C[here, there + 1]
                yx, yy = C[here + 1, there], C[here + 1, there + 1]
                # R C Rᵀ with R the rotation of the disc.
                ax, ay = cos * xx - sin * yx, cos * xy - sin * yy
                bx, by = sin * xx + cos * yx, sin * xy + cos * yy
                found[at, column], found[at, column + 1] = ax * cos - ay * sin, ax * sin + ay * cos
                found[at + 1, column], found[at + 1, column + 1] = bx * cos - by * sin, bx * sin + by * cos


@kernel
def fill_displacements(  # pragma: no cover
    matrix: FloatArray,
    own: FloatArray,
    along: FloatArray,
    turned: FloatArray,
    load: FloatArray,
    found: FloatArray,
    begin: int,
    end: int,
) -> None:
    """Fill the product of ``fill_compliance`` and ``load`` at loaded pins and all bearings, shape (poses, forces), of
    the poses from ``begin`` to ``end``.
    """
    _, discs, pins = along.shape
    points = own.shape[1]
    bearings = (matrix.shape[1] - points) // 2
    node, weight = np.empty((pins, 4), np.int64), np.empty((pins, 4))
    where, force = np.empty(4 * pins + 2 * bearings, np.int64), np.empty(4 * pins + 2 * bearings)
    for p in range(begin, end):
        for d in range(discs):
            C, first, at = matrix[d], d * pins, discs * pins + 2 * d * bearings
            cos, sin = math.cos(turned[p, d]), math.sin(turned[p, d])
            count = 0
            for k in range(pins):
                F = load[p, first + k]
                if F != 0.0:
                    _cubic(along[p, d, k], points, node[k], weight[k])
                    for i in range(4):
                        where[count], force[count] = node[k, i], weight[k, i] * F
                        count += 1
            for b in range(bearings):
                x, y = load[p, at + 2 * b], load[p, at + 2 * b + 1]
                where[count], force[count] = points + 2 * b, cos * x + sin * y
                where[count + 1], force[count + 1] = points + 2 * b + 1, cos * y - sin * x
                count += 2
            # A pin's own force moves it by ``own`` alone.
            before = 0
            for k in range(pins):
                F = load[p, first + k]
                if F != 0.0:
                    moved = 0.0
                    for i in range(4):
                        row = own[d, node[k, i]] * F
                        for c in range(count):
                            if not before <= c < before + 4:
                                row += C[node[k, i], where[c]] * force[c]
                        moved += weight[k, i] * row
                    found[p, first + k] = moved
                    before += 4
            for b in range(bearings):
                x, y = 0.0, 0.0
                for c in range(count):
                    x += C[points + 2 * b, where[c]] * force[c]
                    y += C[points + 2 * b + 1, where[c]] * force[c]
                found[p, at + 2 * b], found[p, at + 2 * b + 1] = cos * x - sin * y, sin * x + cos * y


@inner
def _cubic(at: float, points: int, node: IntArray, weight: FloatArray) -> None:  # pragma: no cover
    """The four flank points round a place, and Lagrange's weights of them."""
    begin = math.floor(at)
    s = at - begin
    for i in range(4):
        node[i] = (begin - 1 + i) % points
    weight[0] = -s * (s - 1.0) * (s - 2.0) / 6.0
    weight[1] = (s + 1.0) * (s - 1.0) * (s - 2.0) / 2.0
    weight[2] = -(s + 1.0) * s * (s - 2.0) / 2.0
    weight[3] = (s + 1.0) * s * (s - 1.0) / 6.0
