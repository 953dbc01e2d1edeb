"""How densely to sample a tooth: by chord error, or by equal arc, polar angle or angle of the normal.

Every strategy places phases on one lobe, corners always among them; ``sample`` repeats them on all lobes.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import ToothPoints, ToothProfile
from cycloid_profile.geometry.removal import flank_side

_FINE = 2048  # grid per smooth piece on which densities are integrated


class Sampling(Protocol):
    """Where to sample one lobe."""

    def phases(self, profile: ToothProfile) -> FloatArray:
        """Increasing phases from 0 (the root) up to, not including, 2π [rad]."""
        ...


@dataclass(frozen=True, slots=True)
class ChordTolerance:
    """Fewest points whose straight chords stay within ``tolerance`` of the curve [mm]."""

    tolerance: float

    def phases(self, profile: ToothProfile) -> FloatArray:
        """See ``Sampling.phases``; the chord error is measured, not only estimated."""
        if not self.tolerance > 0.0:
            raise GeometryError(
                "chord tolerance", f"{self.tolerance} mm", "is not positive", "give a tolerance such as 0.05 µm"
            )
        pieces = [self._piece(profile, a, b) for a, b in smooth_pieces(profile)]
        return np.concatenate([piece[:-1] for piece in pieces])

    def _piece(self, profile: ToothProfile, a: float, b: float) -> FloatArray:
        psi = np.linspace(a, b, _FINE)
        points = profile.at(psi, piece_side(a, b, psi))
        arc_rate = np.abs(points.first)
        # Sagitta of a chord is κ s²/8 (Eq. 41). Near an inflection κ vanishes but its slope does not: the floor
        # stands in for the cubic term there.
        bend = np.maximum(np.abs(points.curvature), 0.02 * float(np.max(np.abs(points.curvature))))
        density = np.sqrt(bend / (8.0 * self.tolerance)) * arc_rate
        count = max(2, math.ceil(_total(psi, density)))
        while True:
            nodes = equidistribute(psi, density, count)
            if chord_error(profile, nodes) <= self.tolerance:
                return nodes
            count = math.ceil(count * 1.02) + 1


@dataclass(frozen=True, slots=True)
class EqualArc:
    """``points_per_lobe`` points at equal arc length; with corners, equal on each smooth piece."""

    points_per_lobe: int

    def phases(self, profile: ToothProfile) -> FloatArray:
        """See ``Sampling.phases``."""
        return _spread(profile, self.points_per_lobe, lambda points: np.abs(points.first))


@dataclass(frozen=True, slots=True)
class EqualAngle:
    """``points_per_lobe`` points at equal polar angle about the disc's centre."""

    points_per_lobe: int

    def phases(self, profile: ToothProfile) -> FloatArray:
        """See ``Sampling.phases``."""
        return _spread(profile, self.points_per_lobe, lambda points: np.abs((points.first / points.position).imag))


@dataclass(frozen=True, slots=True)
class EqualNormalAngle:
    """``points_per_lobe`` points between which the normal turns by equal angles, either way.

    Dense where the tooth bends, sparse about an inflection.
    """

    points_per_lobe: int

    def phases(self, profile: ToothProfile) -> FloatArray:
        """See ``Sampling.phases``."""
        return _spread(profile, self.points_per_lobe, lambda points: np.abs(points.curvature * points.first))


def sample(profile: ToothProfile, sampling: Sampling) -> ToothPoints:
    """Points all round the disc, in order of phase, first point not repeated.

    The phases are those of one lobe. Where lobes are alike that one is computed and turned by −2π/z_c, so
    that they are alike to the last bit of the turn.
    """
    psi = sampling.phases(profile)
    lobes = profile.trochoid.lobes
    m = np.arange(lobes, dtype=np.float64)[:, np.newaxis]
    phase = psi + 2.0 * math.pi * m
    turn = np.exp(-2j * math.pi * m / lobes)
    each = np.broadcast_arrays(psi, flank_side(psi), m)
    points = profile.at(psi) if profile.lobes_alike else profile.at(*each)

    def round_disc(value: FloatArray | None) -> FloatArray | None:
        return None if value is None else np.broadcast_to(value, phase.shape).ravel()

    return ToothPoints(
        phase=phase.ravel(),
        position=(points.position * turn).ravel(),
        frame=(points.frame * turn).ravel(),
        turn=np.broadcast_to(points.turn, phase.shape).ravel(),
        along=np.broadcast_to(points.along, phase.shape).ravel(),
        along_rate=np.broadcast_to(points.along_rate, phase.shape).ravel(),
        rise=round_disc(points.rise),
        rise_rate=round_disc(points.rise_rate),
    )


def smooth_pieces(profile: ToothProfile) -> list[tuple[float, float]]:
    """Phase intervals of one lobe between corners, [(0, 2π)] for a smooth tooth [rad]."""
    inner = [c for c in profile.corners if 0.0 < c < 2.0 * math.pi]
    edges = [0.0, *inner, 2.0 * math.pi]
    return list(itertools.pairwise(edges))


def piece_side(a: float, b: float, psi: FloatArray) -> FloatArray:
    """Flank whose smooth branch covers the piece [a, b], in the shape of ``psi``: one branch on a half lobe."""
    if b - a < 1.5 * math.pi:
        return np.full_like(psi, 1.0 if 0.5 * (a + b) < math.pi else -1.0)
    return np.where(psi < math.pi, 1.0, -1.0)


def chord_error(profile: ToothProfile, nodes: FloatArray) -> float:
    """Largest distance between the curve and the chords that join ``nodes`` [mm]."""
    ends = profile.at(nodes).position
    chord = np.diff(ends)
    direction = chord / np.abs(chord)
    worst = 0.0
    for fraction in (0.3, 0.4, 0.5, 0.6, 0.7):
        psi = nodes[:-1] + fraction * np.diff(nodes)
        offset = (np.conj(direction) * (profile.at(psi).position - ends[:-1])).imag
        worst = max(worst, float(np.max(np.abs(offset))))
    return worst


def _total(psi: FloatArray, density: FloatArray) -> float:
    return float(np.trapezoid(density, psi))


def equidistribute(psi: FloatArray, density: FloatArray, count: int) -> FloatArray:
    """``count + 1`` phases between which the integral of ``density`` is equal; ends exact."""
    steps = 0.5 * (density[1:] + density[:-1]) * np.diff(psi)
    integral = np.concatenate([[0.0], np.cumsum(steps)])
    nodes = np.interp(np.linspace(0.0, integral[-1], count + 1), integral, psi)
    nodes[0], nodes[-1] = psi[0], psi[-1]
    return nodes


def _spread(profile: ToothProfile, points_per_lobe: int, rate: Callable[[ToothPoints], FloatArray]) -> FloatArray:
    pieces = smooth_pieces(profile)
    if points_per_lobe < 2 * len(pieces):
        raise GeometryError(
            "points per lobe", points_per_lobe, f"is below {2 * len(pieces)}", "ask for more points per lobe"
        )
    share = [points_per_lobe // len(pieces)] * len(pieces)
    share[0] += points_per_lobe - sum(share)
    placed = []
    for (a, b), count in zip(pieces, share, strict=True):
        psi = np.linspace(a, b, 8 * _FINE)
        density = rate(profile.at(psi, piece_side(a, b, psi)))
        placed.append(equidistribute(psi, density, count)[:-1])
    return np.concatenate(placed)
