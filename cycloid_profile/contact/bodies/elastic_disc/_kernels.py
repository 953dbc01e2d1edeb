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
