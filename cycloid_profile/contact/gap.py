"""Exact distance from a pin to the tooth curve, by Newton on the foot point (docs/theory.md, Eqs. 21–22)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.contact.meshing import Meshing
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import flank_side

_MAX_STEPS = 60
# Near the root the tooth bends almost like the pin, and a pin beyond the centre of curvature has a foot on
# either side: starts this far out find both.
_ROOT_REACH, _ROOT_STARTS = 0.8, (-0.3, 0.3)  # rad
_STEP_LIMIT = 0.2  # rad; keeps Newton on the lobe it started from


@dataclass(frozen=True, slots=True)
class Gaps:
    """Gaps between pins and disc with the contact frame, all of one shape (…, pins).

    ``gap`` [mm], negative where they overlap; ``foot`` phase of the foot point [rad]; ``normal`` outward
    unit normal in the housing frame (complex); ``lever`` arm of the normal about the disc centre, positive
    where an anticlockwise disc closes the gap [mm]; ``curvature`` of the tooth at the foot [1/mm].
    """

    gap: FloatArray
    foot: FloatArray
    normal: ComplexArray
    lever: FloatArray
    curvature: FloatArray


def gaps(
    profile: ToothProfile,
    pin_radius: float,
    meshing: Meshing,
    displacement: ComplexArray | complex = 0.0,
    rotation: ArrayLike = 0.0,
) -> Gaps:
    """Gap of every pin for discs moved by ``displacement`` [mm, complex] and ``rotation`` [rad].

    Shapes as in ``Meshing.pin_in_lobe``. The result is exact to rounding: |p − P(ψ*)| − r_rp with the
    foot ψ* where (p − P)·P' = 0.
    """
    turn = np.asarray(rotation, dtype=np.float64)
    centre = meshing.pin_in_lobe(displacement, turn)
    foot, side = nearest_foot(profile, centre, meshing.phase)
    point = profile.at(foot, side)
    # The pin's own direction, not the curve's normal: they differ where the foot is a corner.
    away = centre - point.position
    outside = np.where((np.conj(point.normal) * away).real < 0.0, -1.0, 1.0)
    distance = outside * np.abs(away)
    normal = away / distance
    outward = normal * np.exp(1j * turn)[..., np.newaxis] * np.conj(meshing.into_lobe)
    return Gaps(
        gap=distance - pin_radius,
        foot=foot,
        normal=outward,
        lever=(np.conj(point.position) * normal).imag,
        curvature=point.curvature,
    )


def nearest_foot(profile: ToothProfile, centre: ComplexArray, start: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Phase of the foot point nearest to ``centre``, and its flank (±1), in the shape of ``centre``.

    Where a pin can have several feet all are sought and the nearest is taken: on both flanks beside a
    corner, and on both sides of a root.
    """
    side = flank_side(start)
    foot = _foot_on(profile, centre, start, side)
    if profile.corners:
        foot, side = _nearer(profile, centre, (foot, side), (_foot_on(profile, centre, start, -side), -side))
    from_root = start - 2.0 * math.pi * np.round(start / (2.0 * math.pi))
    beyond = np.abs(centre - profile.at(foot, side).position) > _root_radius(profile)
    at_root = beyond & (np.abs(from_root) < _ROOT_REACH)
    if np.any(at_root):
        here, best = centre[at_root], (foot[at_root], side[at_root])
        for offset in _ROOT_STARTS:
            begin = (start - from_root)[at_root] + offset
            flank = flank_side(begin)
            best = _nearer(profile, here, best, (_foot_on(profile, here, begin, flank), flank))
        foot, side = foot.copy(), side.copy()
        foot[at_root], side[at_root] = best
    return foot, side


def _root_radius(profile: ToothProfile) -> float:
    """Least concave radius near the root [mm]: a point nearer than this to a foot has no other foot there."""
    psi = np.linspace(0.0, _ROOT_REACH, 65)
    bend = float(np.max(profile.at(psi, np.ones_like(psi)).curvature))
    return 0.999 / bend if bend > 0.0 else math.inf


def _nearer(
    profile: ToothProfile,
    centre: ComplexArray,
    one: tuple[FloatArray, FloatArray],
    other: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, FloatArray]:
    """Of two candidate feet (phase, flank) the nearer, element by element; the first where they tie."""
    near, far = (np.abs(centre - profile.at(foot, side).position) for foot, side in (one, other))
    swap = far < near - 1e-15
    return np.where(swap, other[0], one[0]), np.where(swap, other[1], one[1])


def _foot_on(profile: ToothProfile, centre: ComplexArray, start: FloatArray, side: FloatArray) -> FloatArray:
    """Newton from ``start``; with corners it stays within the flank ``side``."""
    low, high = np.asarray(-math.inf), np.asarray(math.inf)
    psi = start
    if profile.corners:
        # The flank next to the start: [0, π] or [−π, 0], moved by a turn where the start lies past a tip.
        middle = start - side * (0.5 * math.pi)
        middle = side * (0.5 * math.pi) + 2.0 * math.pi * np.round(middle / (2.0 * math.pi))
        low, high = middle - 0.5 * math.pi, middle + 0.5 * math.pi
        psi = np.clip(start, low, high)
    for _ in range(_MAX_STEPS):
        point = profile.at(psi, side)
        away = np.conj(centre - point.position)
        slope = (away * point.first).real
        bend = (away * point.second).real - np.abs(point.first) ** 2
        # Where the distance is not convex the full Newton step would run to a farthest point.
        step = -slope / np.where(bend < 0.0, bend, -(np.abs(point.first) ** 2))
        nxt = np.clip(psi + np.clip(step, -_STEP_LIMIT, _STEP_LIMIT), low, high)
        moved = float(np.max(np.abs(nxt - psi), initial=0.0))
        psi = nxt
        if moved < 1e-12:
            break
    return psi
