"""Triangles of a disc, fine along its edges and coarse inside."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray

_GROWTH = 0.3  # of the size of a triangle per distance from the edge; 0.2 moves the compliance by 0.3 %
_NEAREST = 0.55  # of the spacing of the edge: closer points would make flat triangles there
_SMOOTHINGS = 4  # moves of each inner point to the mean of its neighbours; more change nothing


def triangulated(rings: Sequence[ComplexArray], largest: float) -> tuple[FloatArray, IntArray]:
    """Points, shape (points, 2) [mm], and triangles, shape (triangles, 3), of the area inside the first ring and
    outside the others; the points of all rings come first, in order.

    Delaunay's triangles of the rings and of inner points whose spacing grows with the distance from the rings up to
    ``largest`` [mm].
    """
    import shapely
    from scipy.sparse import csr_array
    from scipy.spatial import Delaunay

    polygon = shapely.Polygon(xy(rings[0]), [xy(ring) for ring in rings[1:]])
    shapely.prepare(polygon)
    edge = np.concatenate([xy(ring) for ring in rings])
    spacing = np.concatenate([np.minimum(np.abs(z - np.roll(z, 1)), np.abs(z - np.roll(z, -1))) for z in rings])

    def inside(points: FloatArray) -> FloatArray:
        within: FloatArray = points[shapely.contains_xy(polygon, points[:, 0], points[:, 1])]
        return within

    def connected(inner: FloatArray) -> tuple[FloatArray, IntArray]:
        points = np.concatenate([edge, inner])
        found = Delaunay(points).simplices
        middle = points[found].mean(axis=1)
        return points, found[shapely.contains_xy(polygon, middle[:, 0], middle[:, 1])]

    inner = inside(_graded(edge, spacing, largest))
    for _ in range(_SMOOTHINGS):
        points, triangles = connected(inner)
        pairs = triangles[:, [0, 1, 2, 1, 2, 0]].ravel(), triangles[:, [1, 2, 0, 0, 1, 2]].ravel()
        next_to = csr_array((np.ones(pairs[0].size), pairs), shape=(len(points), len(points)))
        next_to.data[:] = 1.0
        neighbours = next_to.sum(axis=1)
        moved = (next_to @ points) / np.maximum(neighbours, 1.0)[:, np.newaxis]
        inner = moved[len(edge) :][neighbours[len(edge) :] > 0.0]
    return connected(inner)


def _graded(edge: FloatArray, spacing: FloatArray, largest: float) -> FloatArray:
    """Middles of squares that are halved until they are as small as their distance from the edge asks for."""
    from scipy.spatial import cKDTree

    tree = cKDTree(edge)
    low, high = edge.min(axis=0), edge.max(axis=0)
    count = math.ceil(float(np.max(high - low)) / largest)
    size = float(np.max(high - low)) / count
    middles = low + size * (np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2) + 0.5)
    quarters = 0.25 * np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
    found = []
    while len(middles):
        distance, nearest = tree.query(middles)
        large = size > spacing[nearest] + _GROWTH * distance
        wanted = ~large & (distance > _NEAREST * spacing[nearest])
        found.append(middles[wanted])
        middles = (middles[large][:, np.newaxis] + size * quarters).reshape(-1, 2)
        size *= 0.5
    return np.concatenate(found)


def xy(z: ComplexArray) -> FloatArray:
    """x and y of complex points, shape (points, 2)."""
    return np.stack([z.real, z.imag], axis=-1)
