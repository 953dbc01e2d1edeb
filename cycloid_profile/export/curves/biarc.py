"""The tooth as tangent-continuous circular arcs, for machines that know only lines and arcs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.curves.audit import distances
from cycloid_profile.export.curves.curve_pieces import (
    Piece,
    first_lobe,
    kept_for_its_profile,
    pieces,
    tolerance_error,
)
from cycloid_profile.geometry import ToothPoints, ToothProfile, equidistribute

_FINE = 4096  # table of curvature over a flank
_CHECKS_PER_ARC = 7  # inside an arc; its ends lie on the curve
# Biarcs of a flank: the fewest, the first trial, and the limit of a tolerance that cannot be kept.
_LEAST_COUNT, _FIRST_COUNT, _LARGEST_COUNT = 3, 8, 2000
_ROUNDS = 7  # relaxations of the nodes towards equal errors
_RELAXATION = 0.25  # power of an error by which nodes move; the asymptotic 1/3 oscillates


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Arcs(Described):
    """A chain of arcs, each starting at the end of the previous one.

    ``ends`` complex, shape (n + 1,) [mm]; signed ``curvature`` of each arc, positive to the left, shape (n,) [1/mm].
    """

    ends: ComplexArray
    curvature: FloatArray

    def _key_figures(self) -> dict[str, str]:
        straight = int(np.count_nonzero(self.curvature == 0.0))
        figures = {"arcs": f"{self.curvature.size - straight}", "lines": f"{straight}"}
        return figures | {"length": f"{float(np.sum(self.lengths)):.6g} mm"}

    @property
    def centres(self) -> ComplexArray:
        """Centre of each arc [mm]; undefined where the curvature is zero."""
        chord = np.diff(self.ends)
        half = 0.5 * np.abs(chord)
        radius = 1.0 / np.where(self.curvature == 0.0, np.nan, self.curvature)
        sagittal = np.sign(radius) * np.sqrt(np.maximum(radius**2 - half**2, 0.0))
        centre: ComplexArray = 0.5 * (self.ends[1:] + self.ends[:-1]) + 1j * chord / np.abs(chord) * sagittal
        return centre

    @property
    def half_sweeps(self) -> FloatArray:
        """Half the angle between start and end tangent of every arc, positive to the left, shape (n,) [rad]."""
        chord = np.abs(np.diff(self.ends))
        return np.arcsin(np.clip(0.5 * self.curvature * chord, -1.0, 1.0))

    @property
    def tangents(self) -> tuple[ComplexArray, ComplexArray]:
        """Unit tangents at start and end of every arc, shape (n,) both."""
        chord, half = np.diff(self.ends), self.half_sweeps
        along = chord / np.abs(chord)
        return along * np.exp(-1j * half), along * np.exp(1j * half)

    @property
    def lengths(self) -> FloatArray:
        """Length of every arc, shape (n,) [mm]."""
        return np.abs(np.diff(self.ends)) / np.sinc(self.half_sweeps / math.pi)

    def points(self, per_arc: int = _CHECKS_PER_ARC) -> ComplexArray:
        """Points inside every arc, shape (n·per_arc,) [mm]."""
        return self._at((np.arange(per_arc) + 0.5) / per_arc).ravel()

    def rows(self, per_arc: int) -> ComplexArray:
        """Points along every arc from end to end, shape (n, per_arc) [mm]."""
        return self._at(np.linspace(0.0, 1.0, per_arc))

    def reversed(self) -> Arcs:
        """The same chain in the opposite direction."""
        return Arcs(self.ends[::-1], -self.curvature[::-1])

    def part(self, first: int, last: int) -> Arcs:
        """The arcs from joint ``first`` to joint ``last``."""
        return Arcs(self.ends[first : last + 1], self.curvature[first:last])

    def started_at(self, first: int) -> Arcs:
        """The same closed chain, started at joint ``first``."""
        ends = np.roll(self.ends[:-1], -first)
        return Arcs(np.append(ends, ends[0]), np.roll(self.curvature, -first))

    def _at(self, fraction: FloatArray) -> ComplexArray:
        chord, half = np.diff(self.ends)[:, np.newaxis], self.half_sweeps[:, np.newaxis]
        # Point at the fraction t of an arc with half sweep α, seen from its start: chord·sin(tα)/sin α · e^{i(t−1)α}.
        safe = np.where(np.abs(half) < 1e-12, 1.0, half)
        ratio = np.where(np.abs(half) < 1e-12, fraction, np.sin(fraction * safe) / np.sin(safe))
        on_arc: ComplexArray = self.ends[:-1, np.newaxis] + chord * ratio * np.exp(1j * (fraction - 1.0) * half)
        return on_arc


def lobe_arcs(profile: ToothProfile, tolerance: float) -> Arcs:
    """Arcs of one lobe from root to root, within ``tolerance`` [mm] of the exact curve.

    Raises ``ExportError`` if the tolerance takes more than 2000 nodes per smooth piece.
    """
    chains = [_arcs(piece, _nodes(piece, tolerance)) for piece in first_lobe(profile)]
    ends = np.concatenate([chains[0].ends[:1], *(chain.ends[1:] for chain in chains)])
    return Arcs(ends, np.concatenate([chain.curvature for chain in chains]))


@kept_for_its_profile
def disc_arcs(profile: ToothProfile, tolerance: float) -> Arcs:
    """Closed chain of arcs round the disc, within ``tolerance`` [mm] of the exact curve; see ``lobe_arcs``."""
    if not profile.identical_lobes:
        return _lobe_by_lobe(profile, tolerance)
    lobe, lobes = lobe_arcs(profile, tolerance), profile.trochoid.lobes
    turn = np.exp(-2j * math.pi * np.arange(lobes) / lobes)
    ends = (lobe.ends[:-1] * turn[:, np.newaxis]).ravel()
    return Arcs(np.append(ends, ends[0]), np.tile(lobe.curvature, lobes))


def _lobe_by_lobe(profile: ToothProfile, tolerance: float) -> Arcs:
    """Arcs of every lobe; the nodes of lobe 1 are tried first, because lobes differ little in curvature."""
    first = [_nodes(piece, tolerance) for piece in first_lobe(profile)]
    chains = []
    for i, piece in enumerate(pieces(profile)):
        nodes = first[i % len(first)] + 2.0 * math.pi * piece.lobe
        # Exact ends, so that neighbouring pieces join to the last bit.
        nodes[0], nodes[-1] = piece.a, piece.b
        chain = _arcs(piece, nodes)
        worst = float(np.max(np.abs(distances(profile, chain.points()))))
        chains.append(chain if worst <= tolerance else _arcs(piece, _nodes(piece, tolerance)))
    ends = np.concatenate([chain.ends[:-1] for chain in chains])
    return Arcs(np.append(ends, ends[0]), np.concatenate([chain.curvature for chain in chains]))


def _nodes(piece: Piece, tolerance: float) -> FloatArray:
    """Phases of the fewest nodes through which biarcs keep the tolerance."""
    failed, count = _LEAST_COUNT - 1, _FIRST_COUNT
    nodes, error = _equal_error_nodes(piece, count)
    while error > tolerance:
        if count >= _LARGEST_COUNT:
            raise tolerance_error(tolerance, f"{_LARGEST_COUNT} nodes per piece")
        # The error falls with the third power of their number.
        failed, wanted = count, math.ceil(count * (error / tolerance) ** (1.0 / 3.0))
        count = min(max(count + 1, wanted), _LARGEST_COUNT)
        nodes, error = _equal_error_nodes(piece, count)
    while count - failed > 1:
        middle = (failed + count) // 2
        fewer, error = _equal_error_nodes(piece, middle)
        if error <= tolerance:
            nodes, count = fewer, middle
        else:
            failed = middle
    return nodes


def _equal_error_nodes(piece: Piece, count: int) -> tuple[FloatArray, float]:
    """Phases of the nodes of ``count`` biarcs of nearly equal error, and the largest error [mm].

    The error is proportional to the derivative of curvature times the third power of the length, which gives the
    first spacing; measured errors then move the nodes.
    """
    grid, side = piece.grid(_FINE)
    points = piece.profile.at(grid, side)
    change = np.abs(np.gradient(points.curvature, grid)) / np.abs(points.first)
    density = np.cbrt(np.maximum(change, 0.02 * float(np.max(change)))) * np.abs(points.first)
    best, least = grid[:: _FINE - 1], math.inf
    for _ in range(_ROUNDS):
        nodes = equidistribute(grid, density, count)
        error = np.max(np.abs(distances(piece.profile, _arcs(piece, nodes).points())).reshape(count, -1), axis=1)
        if float(np.max(error)) < least:
            best, least = nodes, float(np.max(error))
        which = np.clip(np.searchsorted(nodes, grid, side="right") - 1, 0, count - 1)
        floor = max(float(np.mean(error)), 1e-15)
        density = density * np.maximum(error / floor, 1e-3)[which] ** _RELAXATION
    return best, least


def _arcs(piece: Piece, nodes: FloatArray) -> Arcs:
    return _biarcs(piece.profile.at(nodes, piece.side(nodes)))


def _biarcs(nodes: ToothPoints) -> Arcs:
    """Two arcs between neighbouring nodes, tangent to the curve at the nodes and to each other.

    With equal distances d to the joint's control points, d solves
    2(1 − t1·t2) d² + 2 v·(t1 + t2) d − |v|² = 0, v the chord and t1, t2 the unit tangents.
    """
    tangent = nodes.first / np.abs(nodes.first)
    t1, t2 = tangent[:-1], tangent[1:]
    chord = np.diff(nodes.position)
    spread = 2.0 * (1.0 - (np.conj(t1) * t2).real)
    along = 2.0 * (np.conj(chord) * (t1 + t2)).real
    length2 = np.abs(chord) ** 2
    # The root in the form that stays exact for parallel tangents.
    d = 2.0 * length2 / (along + np.sqrt(along**2 + 4.0 * spread * length2))
    joint = nodes.position[:-1] + 0.5 * (chord + d * (t1 - t2))
    ends = np.empty(2 * chord.size + 1, dtype=np.complex128)
    ends[0::2], ends[1::2] = nodes.position, joint
    curvature = _curvature(t1, joint - ends[0:-1:2]), -_curvature(-t2, joint - ends[2::2])
    return Arcs(ends, np.stack(curvature, axis=-1).ravel())


def _curvature(tangent: ComplexArray, chord: ComplexArray) -> FloatArray:
    """Curvature of the arc with the start ``tangent`` and the ``chord`` from start to end."""
    curvature: FloatArray = 2.0 * (np.conj(tangent) * chord).imag / np.abs(chord) ** 2
    return curvature
