"""Sampling of a tooth: by chord error, or by equal arc length, polar angle or angle of the normal; point clouds.

A sampling places phases on one lobe, corners always among them; ``sample`` repeats them on all lobes.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from cycloid_profile.arrays import ArrayLike, FloatArray
from cycloid_profile.errors import GeometryError
from cycloid_profile.geometry.profile import PointCloud, ToothPoints, ToothProfile, flank_side

_FINE = 2048  # grid per smooth piece on which densities are integrated
_BLOCK = 16_384  # points; a block and its temporaries stay in the cache


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
        grids = [(np.linspace(a, b, _FINE), a, b) for a, b in smooth_pieces(profile)]
        nodes = [chord_nodes(profile, psi, flank_of_interval(a, b, psi), self.tolerance) for psi, a, b in grids]
        return np.concatenate([piece[:-1] for piece in nodes])


@dataclass(frozen=True, slots=True)
class _EqualSpacing(ABC):
    """``points_per_lobe`` points at equal steps of one quantity; with corners, equal on each smooth piece."""

    points_per_lobe: int

    @abstractmethod
    def _rate(self, points: ToothPoints) -> FloatArray:
        """Magnitude of the quantity's derivative by phase."""

    def phases(self, profile: ToothProfile) -> FloatArray:
        """See ``Sampling.phases``."""
        pieces = smooth_pieces(profile)
        least = 2 * len(pieces)
        if self.points_per_lobe < least:
            raise GeometryError(
                "points per lobe", self.points_per_lobe, f"is below {least}", "ask for more points per lobe"
            )
        share = [self.points_per_lobe // len(pieces)] * len(pieces)
        share[0] += self.points_per_lobe - sum(share)
        nodes = []
        for (a, b), count in zip(pieces, share, strict=True):
            psi = np.linspace(a, b, 8 * _FINE)
            nodes.append(equidistribute(psi, self._rate(profile.at(psi, flank_of_interval(a, b, psi))), count)[:-1])
        return np.concatenate(nodes)


class EqualArc(_EqualSpacing):
    """``points_per_lobe`` points at equal arc length; with corners, equal on each smooth piece."""

    __slots__ = ()

    def _rate(self, points: ToothPoints) -> FloatArray:
        return np.abs(points.first)


class EqualAngle(_EqualSpacing):
    """``points_per_lobe`` points at equal polar angle about the disc's centre."""

    __slots__ = ()

    def _rate(self, points: ToothPoints) -> FloatArray:
        return np.abs((points.first / points.position).imag)


class EqualNormalAngle(_EqualSpacing):
    """``points_per_lobe`` points between which the normal turns by equal angles: dense where curvature is large."""

    __slots__ = ()

    def _rate(self, points: ToothPoints) -> FloatArray:
        return np.abs(points.curvature * points.first)


def sample(profile: ToothProfile, sampling: Sampling) -> ToothPoints:
    """Points all round the disc in order of phase, the first point not repeated, each array of shape (points,).

    ``sampling`` gives the phases of one lobe. Identical lobes are computed once and rotated by −2π/z_c.
    """
    psi = sampling.phases(profile)
    lobes = profile.trochoid.lobes
    m = np.arange(lobes, dtype=np.float64)[:, np.newaxis]
    phase = psi + 2.0 * math.pi * m
    turn = np.exp(-2j * math.pi * m / lobes)
    each = np.broadcast_arrays(psi, flank_side(psi), m)
    points = profile.at(psi) if profile.identical_lobes else profile.at(*each)

    def on_disc(value: FloatArray | None) -> Any:
        return None if value is None else np.broadcast_to(value, phase.shape).ravel()

    return ToothPoints(
        phase=phase.ravel(),
        position=(points.position * turn).ravel(),
        frame=(points.frame * turn).ravel(),
        turn=on_disc(points.turn),
        along=on_disc(points.along),
        along_rate=on_disc(points.along_rate),
        rise=on_disc(points.rise),
        rise_rate=on_disc(points.rise_rate),
    )


def smooth_pieces(profile: ToothProfile) -> list[tuple[float, float]]:
    """Phase intervals of one lobe between corners, [(0, 2π)] for a smooth tooth [rad]."""
    inner = [c for c in profile.corners if 0.0 < c < 2.0 * math.pi]
    edges = [0.0, *inner, 2.0 * math.pi]
    return list(itertools.pairwise(edges))


def flank_of_interval(a: float, b: float, psi: FloatArray) -> FloatArray:
    """Flank (±1) whose smooth branch covers the piece [a, b], in the shape of ``psi``."""
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


def chord_nodes(
    profile: ToothProfile, grid: FloatArray, side: FloatArray, tolerance: float, growth: float = 1.02
) -> FloatArray:
    """Fewest phases along one smooth piece whose measured chord error stays within ``tolerance`` [mm].

    ``grid`` holds phases from end to end of the piece [rad], ``side`` their flank, both of shape (points,); the number
    of chords rises by the factor ``growth`` until the tolerance is met.
    """
    points = profile.at(grid, side)
    curvature = np.abs(points.curvature)
    # Sagitta of a chord is κ s²/8 (Eq. 41). Near an inflection κ vanishes but its slope does not: the lower
    # limit replaces the cubic term there.
    floored = np.maximum(curvature, 0.02 * float(np.max(curvature)))
    density = np.sqrt(floored / (8.0 * tolerance)) * np.abs(points.first)
    count = max(2, math.ceil(float(np.trapezoid(density, grid))))
    while chord_error(profile, nodes := equidistribute(grid, density, count)) > tolerance:
        count = math.ceil(growth * count) + 1
    return nodes


def equidistribute(psi: FloatArray, density: FloatArray, count: int) -> FloatArray:
    """``count + 1`` phases between which the integral of ``density`` is equal; ends exact."""
    steps = 0.5 * (density[1:] + density[:-1]) * np.diff(psi)
    integral = np.concatenate([[0.0], np.cumsum(steps)])
    nodes = np.interp(np.linspace(0.0, integral[-1], count + 1), integral, psi)
    nodes[0], nodes[-1] = psi[0], psi[-1]
    return nodes


def point_cloud(profile: ToothProfile, phase: ArrayLike) -> PointCloud:
    """Points at the given phases, shape (points,) [rad], computed in blocks; equal to ``ToothProfile.at``."""
    psi = np.asarray(phase, dtype=np.float64)
    position, normal = (np.empty(psi.shape, dtype=np.complex128) for _ in range(2))
    curvature = np.empty(psi.shape)
    for start in range(0, psi.size, _BLOCK):
        cut = slice(start, start + _BLOCK)
        points = profile.at(psi[cut])
        position[cut], normal[cut], curvature[cut] = points.position, points.normal, points.curvature
    return PointCloud(psi, position, normal, curvature)
