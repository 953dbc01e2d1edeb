"""A disc as a closed triangle mesh: the outline in chords, extruded, and the outline found again in a mesh."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.export.disc_path import chord_phases
from cycloid_profile.geometry.outline import DiscOutline
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.sampling import ChordTolerance, sample

_POINTS_PER_CHORD = 5


@dataclass(frozen=True, slots=True)
class Mesh:
    """``corners`` x, y, z, shape (n, 3) [mm]; ``triangles`` as rows of corners, outward anticlockwise, shape (m, 3)."""

    corners: FloatArray
    triangles: IntArray


def extruded(outline: DiscOutline, height: float, chord_error: float) -> Mesh:
    """The disc from z = 0 to ``height``, chords within ``chord_error`` of tooth and openings; lengths in mm."""
    rings = [_tooth(outline.profile, chord_error)[::-1]]
    rings += [contour.points(chord_error)[::-1] for contour in outline.contours]
    flat = np.concatenate(rings)
    cap = _triangulated(rings, flat)
    low = np.arange(flat.size)
    # Material lies to the left of every ring, the teeth anticlockwise and the openings clockwise.
    following = np.concatenate([start + np.roll(np.arange(size), -1) for start, size in _spans(rings)])
    high, high_following = low + flat.size, following + flat.size
    sides = [np.stack([low, following, high_following], axis=-1), np.stack([low, high_following, high], axis=-1)]
    z = np.repeat([0.0, height], flat.size)
    corners = np.stack([np.tile(flat.real, 2), np.tile(flat.imag, 2), z], axis=-1)
    return Mesh(corners, np.concatenate([cap[:, ::-1], cap + flat.size, *sides]))


def tooth_chords(mesh: Mesh) -> ComplexArray:
    """Points along every chord of the outermost edge at the foot of a mesh, shape (chords, points) [mm].

    Found from the mesh alone: the edges where its flat foot meets its sides, of which the longest ring counts.
    """
    at_foot = mesh.corners[:, 2] == np.min(mesh.corners[:, 2])
    foot = mesh.triangles[np.all(at_foot[mesh.triangles], axis=1)]
    edges = {(int(a), int(b)) for a, b in np.concatenate([np.roll(foot, -k, axis=1)[:, :2] for k in range(3)])}
    following = {b: a for a, b in edges if (b, a) not in edges}
    rings: list[list[int]] = []
    while following:
        ring = [next(iter(following))]
        while (corner := following.pop(ring[-1], None)) is not None:
            ring.append(corner)
        rings.append(ring)
    z: ComplexArray = mesh.corners[:, 0] + 1j * mesh.corners[:, 1]
    outer = z[max(rings, key=lambda ring: float(np.max(np.abs(z[ring]))))]
    share = np.linspace(0.0, 1.0, _POINTS_PER_CHORD)
    chords: ComplexArray = outer[:-1, np.newaxis] + np.diff(outer)[:, np.newaxis] * share
    return chords


def open_edges(mesh: Mesh) -> int:
    """Edges that do not lie between exactly two triangles that agree on what is outside; 0 for a closed mesh."""
    directed = np.concatenate([np.roll(mesh.triangles, -k, axis=1)[:, :2] for k in range(3)])
    _, there = np.unique(directed, axis=0, return_counts=True)
    forth = {(int(a), int(b)) for a, b in directed}
    return int(np.sum(there - 1)) + sum((b, a) not in forth for a, b in forth)


def _tooth(profile: ToothProfile, chord_error: float) -> ComplexArray:
    if profile.lobes_alike:
        return sample(profile, ChordTolerance(chord_error)).position
    return profile.at(*chord_phases(profile, chord_error)).position


def _spans(rings: list[ComplexArray]) -> list[tuple[int, int]]:
    sizes = [ring.size for ring in rings]
    return list(zip(np.cumsum([0, *sizes[:-1]]).tolist(), sizes, strict=True))


def _triangulated(rings: list[ComplexArray], flat: ComplexArray) -> IntArray:
    """Triangles between the rings, anticlockwise, as rows of corners; no corner is added."""
    import shapely

    xy = [np.stack([ring.real, ring.imag], axis=-1) for ring in rings]
    parts = shapely.constrained_delaunay_triangles(shapely.Polygon(xy[0], xy[1:]))
    triangles = shapely.get_coordinates(shapely.orient_polygons(shapely.get_parts(parts))).reshape(-1, 4, 2)[:, :3]
    found = triangles[..., 0] + 1j * triangles[..., 1]
    order = np.argsort(flat)
    which: IntArray = order[np.searchsorted(flat, found, sorter=order)]
    return which
