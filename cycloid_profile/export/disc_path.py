"""Paths round a disc whose lobes differ: points and arcs placed lobe by lobe (docs/exports.md)."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.drive import Drive
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.sampling import chord_error, equidistribute, piece_side, smooth_pieces
from cycloid_profile.spec.model import Spec

_FINE = 2048
_GROWTH = 1.05


class Ground(Protocol):
    """What the writers of paths need of a design: its spec, its drive and the tooth to be ground."""

    @property
    def spec(self) -> Spec:
        """The spec, for its name and its ``[export]``."""
        ...

    @property
    def drive(self) -> Drive:
        """The nominal drive."""
        ...

    @property
    def profile(self) -> ToothProfile:
        """The tooth to be ground."""
        ...


@dataclass(frozen=True, slots=True)
class DiscPath:
    """One tooth to be ground, without the design behind it."""

    spec: Spec
    drive: Drive
    profile: ToothProfile


@dataclass(frozen=True, slots=True)
class Piece:
    """A smooth part of the curve between phases ``a`` and ``b`` along the disc [rad], on ``lobe`` counted from 0."""

    profile: ToothProfile
    lobe: int
    a: float
    b: float

    def grid(self, count: int) -> tuple[FloatArray, FloatArray]:
        """``count`` even phases along the disc and the flank whose branch holds there, shape (count,)."""
        return np.linspace(self.a, self.b, count), self.side(np.linspace(self.a, self.b, count))

    def side(self, phase: FloatArray) -> FloatArray:
        """Flank whose smooth branch holds on the piece, in the shape of ``phase``."""
        start = 2.0 * math.pi * self.lobe
        return piece_side(self.a - start, self.b - start, phase - start)


def pieces(profile: ToothProfile) -> list[Piece]:
    """All smooth parts of a whole disc, in order of phase; each ends at the very phase where the next begins."""
    edges = [2.0 * math.pi * lobe + a for lobe in range(profile.trochoid.lobes) for a, _ in smooth_pieces(profile)] + [
        profile.trochoid.phase_period
    ]
    each = len(smooth_pieces(profile))
    return [Piece(profile, i // each, a, b) for i, (a, b) in enumerate(itertools.pairwise(edges))]


def flanks(profile: ToothProfile) -> list[Piece]:
    """As ``pieces``, but divided at every root and tip, whether there is a corner or not."""
    edges = sorted({0.0, math.pi, 2.0 * math.pi, *profile.corners})
    return [
        Piece(profile, lobe, 2.0 * math.pi * lobe + a, 2.0 * math.pi * lobe + b)
        for lobe in range(profile.trochoid.lobes)
        for a, b in itertools.pairwise(edges)
    ]


def chord_phases(profile: ToothProfile, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Phases along the whole disc whose chords stay within ``tolerance`` of the curve [mm], end not repeated [rad].

    With the flank of each, as ``ToothProfile.at`` takes it; shape (points,) both.
    """
    found = [(piece, _chords(piece, tolerance)[:-1]) for piece in pieces(profile)]
    return np.concatenate([psi for _, psi in found]), np.concatenate([piece.side(psi) for piece, psi in found])


def _chords(piece: Piece, tolerance: float) -> FloatArray:
    psi, side = piece.grid(_FINE)
    points = piece.profile.at(psi, side)
    bend = np.abs(points.curvature)
    # The floor stands in for the cubic term near an inflection, as where lobes are alike.
    density = np.sqrt(np.maximum(bend, 0.02 * float(np.max(bend))) / (8.0 * tolerance)) * np.abs(points.first)

    def through(count: int) -> FloatArray:
        return equidistribute(psi, density, count)

    first = max(2, math.ceil(float(np.trapezoid(density, psi))))
    return _first(through, first, lambda nodes: chord_error(piece.profile, nodes) <= tolerance)


def _first(through: Callable[[int], FloatArray], count: int, good: Callable[[FloatArray], bool]) -> FloatArray:
    while not good(nodes := through(count)):
        count = math.ceil(_GROWTH * count) + 1
    return nodes
