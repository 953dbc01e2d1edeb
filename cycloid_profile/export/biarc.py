"""The tooth as tangent-continuous circular arcs, for machines that know only lines and arcs."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.export.disc_path import Piece, pieces
from cycloid_profile.export.refine import refined
from cycloid_profile.geometry.profile import ToothPoints, ToothProfile
from cycloid_profile.geometry.sampling import equidistribute, smooth_pieces

_FINE = 4096
_CHECKS_PER_ARC = 5


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
        """Points on every arc, shape (n·per_arc,) [mm]."""
        fraction = (np.arange(per_arc) + 0.5) / per_arc
        chord = np.diff(self.ends)[:, np.newaxis]
        half_turn = np.arcsin(np.clip(0.5 * self.bend[:, np.newaxis] * np.abs(chord), -1.0, 1.0))
        # A point at the fraction t of an arc seen from its start: chord·sin(tα)/sin α · e^{i(t−1)α}.
        safe = np.where(np.abs(half_turn) < 1e-12, 1.0, half_turn)
        ratio = np.where(np.abs(half_turn) < 1e-12, fraction, np.sin(fraction * safe) / np.sin(safe))
        on_arc = self.ends[:-1, np.newaxis] + chord * ratio * np.exp(1j * (fraction - 1.0) * half_turn)
        flat: ComplexArray = on_arc.ravel()
        return flat


def lobe_arcs(profile: ToothProfile, tolerance: float) -> Arcs:
    """Arcs of one lobe from root to root, within ``tolerance`` of the exact curve [mm].

    Raises
    ------
    ExportError
        If the tolerance cannot be reached with a sensible number of arcs.
    """
    chains = [_fit(Piece(profile, 0, a, b), tolerance) for a, b in smooth_pieces(profile)]
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
        return _closed([_fit(piece, tolerance) for piece in pieces(profile)])
    lobe = lobe_arcs(profile, tolerance)
    lobes = profile.trochoid.lobes
    turn = np.exp(-2j * math.pi * np.arange(lobes) / lobes)
    ends = (lobe.ends[:-1] * turn[:, np.newaxis]).ravel()
    return Arcs(np.append(ends, ends[0]), np.tile(lobe.bend, lobes))


def _closed(chains: list[Arcs]) -> Arcs:
    ends = np.concatenate([chain.ends[:-1] for chain in chains])
    return Arcs(np.append(ends, ends[0]), np.concatenate([chain.bend for chain in chains]))


def _fit(piece: Piece, tolerance: float) -> Arcs:
    return refined(piece.profile, tolerance, lambda count: _through(piece, count), Arcs.points)


def _through(piece: Piece, count: int) -> Arcs:
    """``count`` biarcs; their error goes with the change of curvature, so that sets the spacing."""
    grid, side = piece.grid(_FINE)
    points = piece.profile.at(grid, side)
    change = np.abs(np.gradient(points.curvature, grid)) / np.abs(points.first)
    density = np.cbrt(np.maximum(change, 0.02 * float(np.max(change)))) * np.abs(points.first)
    psi = equidistribute(grid, density, count)
    return _biarcs(piece.profile.at(psi, piece.side(psi)))


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
