"""The tooth as tangent-continuous circular arcs, for machines that know only lines and arcs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.deviation import distances
from cycloid_profile.export.disc_path import Piece, pieces
from cycloid_profile.geometry.profile import ToothPoints, ToothProfile
from cycloid_profile.geometry.sampling import equidistribute, smooth_pieces

_FINE = 4096
_CHECKS_PER_ARC = 7
_LEAST_COUNT, _FIRST_COUNT, _LARGEST_COUNT = 3, 8, 2000
_ROUNDS = 7
_HASTE = 0.25  # power of an error by which nodes move; 1/3 would move them at once, and swing


@dataclass(frozen=True, slots=True)
class Arcs:
    """A chain of arcs: ``ends`` complex, shape (n + 1,) [mm]; ``bend`` signed curvature of each, shape (n,) [1/mm].

    Positive bend turns left. Each arc starts where the last one ended.
    """

    ends: ComplexArray
    bend: FloatArray

    @property
    def centres(self) -> ComplexArray:
        """Centre of each arc [mm]; meaningless where the bend is zero."""
        chord = np.diff(self.ends)
        half = 0.5 * np.abs(chord)
        radius = 1.0 / np.where(self.bend == 0.0, np.nan, self.bend)
        sagittal = np.sign(radius) * np.sqrt(np.maximum(radius**2 - half**2, 0.0))
        centre: ComplexArray = 0.5 * (self.ends[1:] + self.ends[:-1]) + 1j * chord / np.abs(chord) * sagittal
        return centre

    def points(self, per_arc: int = _CHECKS_PER_ARC) -> ComplexArray:
        """Points inside every arc, shape (n·per_arc,) [mm]."""
        return self._at((np.arange(per_arc) + 0.5) / per_arc).ravel()

    def rows(self, per_arc: int) -> ComplexArray:
        """Points along every arc from end to end, shape (n, per_arc) [mm]."""
        return self._at(np.linspace(0.0, 1.0, per_arc))

    def _at(self, fraction: FloatArray) -> ComplexArray:
        chord = np.diff(self.ends)[:, np.newaxis]
        half_turn = np.arcsin(np.clip(0.5 * self.bend[:, np.newaxis] * np.abs(chord), -1.0, 1.0))
        # A point at the fraction t of an arc seen from its start: chord·sin(tα)/sin α · e^{i(t−1)α}.
        safe = np.where(np.abs(half_turn) < 1e-12, 1.0, half_turn)
        ratio = np.where(np.abs(half_turn) < 1e-12, fraction, np.sin(fraction * safe) / np.sin(safe))
        on_arc: ComplexArray = self.ends[:-1, np.newaxis] + chord * ratio * np.exp(1j * (fraction - 1.0) * half_turn)
        return on_arc


def lobe_arcs(profile: ToothProfile, tolerance: float) -> Arcs:
    """Arcs of one lobe from root to root, within ``tolerance`` of the exact curve [mm].

    Raises
    ------
    ExportError
        If the tolerance cannot be reached with a sensible number of arcs.
    """
    chains = [_arcs(piece, _nodes(piece, tolerance)) for piece in _first_lobe(profile)]
    ends = np.concatenate([chains[0].ends[:1], *(chain.ends[1:] for chain in chains)])
    return Arcs(ends, np.concatenate([chain.bend for chain in chains]))


def disc_arcs(profile: ToothProfile, tolerance: float) -> Arcs:
    """Closed chain of arcs round the whole disc: those of one lobe, turned, or lobe by lobe where they differ.

    Raises
    ------
    ExportError
        If the tolerance cannot be reached with a sensible number of arcs.
    """
    if not profile.lobes_alike:
        return _lobe_by_lobe(profile, tolerance)
    lobe = lobe_arcs(profile, tolerance)
    lobes = profile.trochoid.lobes
    turn = np.exp(-2j * math.pi * np.arange(lobes) / lobes)
    ends = (lobe.ends[:-1] * turn[:, np.newaxis]).ravel()
    return Arcs(np.append(ends, ends[0]), np.tile(lobe.bend, lobes))


def _lobe_by_lobe(profile: ToothProfile, tolerance: float) -> Arcs:
    """Nodes are first tried where they are on lobe 1: lobes differ little in their bending."""
    first = [_nodes(piece, tolerance) for piece in _first_lobe(profile)]
    chains = []
    for i, piece in enumerate(pieces(profile)):
        nodes = first[i % len(first)] + 2.0 * math.pi * piece.lobe
        # The piece's own ends, which are those of its neighbours to the last bit.
        nodes[0], nodes[-1] = piece.a, piece.b
        chain = _arcs(piece, nodes)
        chains.append(chain if _worst(piece, chain) <= tolerance else _arcs(piece, _nodes(piece, tolerance)))
    ends = np.concatenate([chain.ends[:-1] for chain in chains])
    return Arcs(np.append(ends, ends[0]), np.concatenate([chain.bend for chain in chains]))


def _first_lobe(profile: ToothProfile) -> list[Piece]:
    return [Piece(profile, 0, a, b) for a, b in smooth_pieces(profile)]


def _nodes(piece: Piece, tolerance: float) -> FloatArray:
    """Phases of the fewest nodes through which biarcs keep the tolerance."""
    failed, count = _LEAST_COUNT - 1, _FIRST_COUNT
    nodes, error = _even(piece, count)
    while error > tolerance:
        if count >= _LARGEST_COUNT:
            raise ExportError(
                "export tolerance",
                f"{tolerance * 1e6:g} nm",
                f"needs more than {_LARGEST_COUNT} nodes a piece",
                "raise export.chord_tolerance_um",
            )
        # The error falls with the third power of their number.
        failed, wanted = count, math.ceil(count * (error / tolerance) ** (1.0 / 3.0))
        count = min(max(count + 1, wanted), _LARGEST_COUNT)
        nodes, error = _even(piece, count)
    while count - failed > 1:
        middle = (failed + count) // 2
        fewer, error = _even(piece, middle)
        if error <= tolerance:
            nodes, count = fewer, middle
        else:
            failed = middle
    return nodes


def _even(piece: Piece, count: int) -> tuple[FloatArray, float]:
    """Phases of the nodes of ``count`` biarcs of nearly one error, and the largest of these [mm].

    The error goes with the change of curvature times the third power of the length, which spaces the nodes at
    first; what is then measured moves them.
    """
    grid, side = piece.grid(_FINE)
    points = piece.profile.at(grid, side)
    change = np.abs(np.gradient(points.curvature, grid)) / np.abs(points.first)
    density = np.cbrt(np.maximum(change, 0.02 * float(np.max(change)))) * np.abs(points.first)
    best, least = grid[:: _FINE - 1], math.inf
    for _ in range(_ROUNDS):
        nodes = equidistribute(grid, density, count)
        chain = _arcs(piece, nodes)
        error = np.max(np.abs(distances(piece.profile, chain.points())).reshape(count, -1), axis=1)
        if float(np.max(error)) < least:
            best, least = nodes, float(np.max(error))
        which = np.clip(np.searchsorted(nodes, grid, side="right") - 1, 0, count - 1)
        floor = max(float(np.mean(error)), 1e-15)
        density = density * np.maximum(error / floor, 1e-3)[which] ** _HASTE
    return best, least


def _worst(piece: Piece, chain: Arcs) -> float:
    return float(np.max(np.abs(distances(piece.profile, chain.points()))))


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
    return Arcs(ends, np.stack([_bend(t1, joint - ends[0:-1:2]), -_bend(-t2, joint - ends[2::2])], axis=-1).ravel())


def _bend(tangent: ComplexArray, chord: ComplexArray) -> FloatArray:
    """Curvature of the arc that leaves along ``tangent`` and ends at ``chord``."""
    bend: FloatArray = 2.0 * (np.conj(tangent) * chord).imag / np.abs(chord) ** 2
    return bend
