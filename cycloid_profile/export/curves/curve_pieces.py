"""Smooth pieces of the tooth curve, lobe by lobe, and the chords along them (docs/exports.md)."""

from __future__ import annotations

import itertools
import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from typing import Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.geometry import (
    ChordTolerance,
    Contour,
    DiscOutline,
    Drive,
    ToothPoints,
    ToothProfile,
    chord_nodes,
    flank_of_interval,
    sample,
    smooth_pieces,
)
from cycloid_profile.spec.model import Spec

_FINE = 2048  # table over a smooth piece, far finer than its pieces
_GROWTH = 1.05  # of the number of pieces from trial to trial: at most 5 % too many
_KEPT = 4  # results of a curve fit: arcs and splines of one tooth at two tolerances or degrees
P = ParamSpec("P")
T = TypeVar("T")


class ProfileSource(Protocol):
    """A disc to be made with its spec; ``DesignRecord`` and ``SpecifiedProfile`` implement it."""

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

    @property
    def outline(self) -> DiscOutline:
        """The tooth with the openings."""
        ...

    @property
    def disc(self) -> int:
        """Number of the disc, counted from 1."""
        ...

    @property
    def openings_turn(self) -> float:
        """Turn of the openings against the teeth, compared with disc 1, anticlockwise [rad]."""
        ...

    @property
    def label(self) -> str:
        """Addition to the names of its files, empty for the nominal disc 1."""
        ...


@dataclass(frozen=True, slots=True)
class SpecifiedProfile:
    """A ``ProfileSource`` without a design record, such as a corrected disc; see there.

    ``contours`` round the openings of the disc, as turned by ``openings_turn``.
    """

    spec: Spec
    drive: Drive
    profile: ToothProfile
    contours: tuple[Contour, ...] = ()
    disc: int = 1
    openings_turn: float = 0.0
    label: str = ""

    @property
    def outline(self) -> DiscOutline:
        """The tooth with the openings."""
        return DiscOutline(self.profile, self.contours)


def kept_for_its_profile(
    fit: Callable[Concatenate[ToothProfile, P], T],
) -> Callable[Concatenate[ToothProfile, P], T]:
    """The function with its last results kept: all discs of a stage have one tooth, and several formats one fit of it.

    Profiles count as equal only if they are the same object, because some cannot be compared.
    """
    kept: deque[tuple[ToothProfile, object, T]] = deque(maxlen=_KEPT)

    @wraps(fit)
    def remembered(profile: ToothProfile, /, *args: P.args, **kwargs: P.kwargs) -> T:
        for known, settings, found in kept:
            if known is profile and settings == (args, kwargs):
                return found
        result = fit(profile, *args, **kwargs)
        kept.append((profile, (args, kwargs), result))
        return result

    return remembered


@dataclass(frozen=True, slots=True)
class Piece:
    """A smooth piece of the curve between phases ``a`` and ``b`` along the disc [rad], on ``lobe`` ≥ 0."""

    profile: ToothProfile
    lobe: int
    a: float
    b: float

    def grid(self, count: int) -> tuple[FloatArray, FloatArray]:
        """``count`` equally spaced phases along the disc [rad] and the flank (±1) of each, shape (count,)."""
        phase = np.linspace(self.a, self.b, count)
        return phase, self.side(phase)

    def side(self, phase: FloatArray) -> FloatArray:
        """Flank (±1) whose smooth branch covers the piece, in the shape of ``phase``."""
        start = 2.0 * math.pi * self.lobe
        return flank_of_interval(self.a - start, self.b - start, phase - start)


def first_lobe(profile: ToothProfile) -> list[Piece]:
    """Smooth pieces of lobe 0."""
    return [Piece(profile, 0, a, b) for a, b in smooth_pieces(profile)]


def pieces(profile: ToothProfile) -> list[Piece]:
    """All smooth pieces of the disc in order of phase; each ends at the exact phase where the next begins."""
    return _divided(profile, [a for a, _ in smooth_pieces(profile)])


def flanks(profile: ToothProfile) -> list[Piece]:
    """As ``pieces``, divided in addition at smooth roots and tips."""
    return _divided(profile, sorted({0.0, math.pi, *profile.corners}))


def _divided(profile: ToothProfile, starts: list[float]) -> list[Piece]:
    phases = [2.0 * math.pi * lobe + a for lobe in range(profile.trochoid.lobes) for a in starts]
    edges = itertools.pairwise([*phases, profile.trochoid.phase_period])
    return [Piece(profile, i // len(starts), a, b) for i, (a, b) in enumerate(edges)]


def chord_points(profile: ToothProfile, tolerance: float) -> ToothPoints:
    """Points round the disc in order of phase whose chords stay within ``tolerance`` [mm] of the curve."""
    if profile.identical_lobes:
        return sample(profile, ChordTolerance(tolerance))
    found = []
    for piece in pieces(profile):
        nodes = chord_nodes(profile, *piece.grid(_FINE), tolerance, _GROWTH)[:-1]
        found.append((nodes, piece.side(nodes)))
    return profile.at(*(np.concatenate(parts) for parts in zip(*found, strict=True)))


def tolerance_error(tolerance: float, limit: str) -> ExportError:
    """The error of a fit whose ``tolerance`` [mm] needs more than the ``limit``, such as "2000 nodes per piece"."""
    what = f"{tolerance * 1e6:g} nm"
    return ExportError("export tolerance", what, f"needs more than {limit}", "raise export.chord_tolerance_um")
