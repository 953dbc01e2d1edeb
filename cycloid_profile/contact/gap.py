"""Exact distance from a pin to the tooth curve, by Newton on the foot point (docs/theory.md, Eqs. 21–22)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.contact.meshing import Meshing
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import flank_side

_MAX_STEPS = 30
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
    normal = point.normal
    distance = (np.conj(normal) * (centre - point.position)).real
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

    A profile with corners has one candidate on either flank beside a corner; the nearer is taken.
    """
    side = flank_side(start)
    foot = _foot_on(profile, centre, start, side)
    if not profile.corners:
        return foot, side
    other = _foot_on(profile, centre, start, -side)
    near, far = (np.abs(centre - profile.at(f, s).position) for f, s in ((foot, side), (other, -side)))
    swap = far < near
    return np.where(swap, other, foot), np.where(swap, -side, side)


def _foot_on(profile: ToothProfile, centre: ComplexArray, start: FloatArray, side: FloatArray) -> FloatArray:
    """Newton from ``start``; with corners it stays within the flank ``side``."""
    low, high = -math.inf, math.inf
    psi = start
    if profile.corners:
        # The flank next to the start: [0, π] or [−π, 0], moved by a turn where the start lies past a tip.
        middle = start - side * (0.5 * math.pi)
        middle = side * (0.5 * math.pi) + 2.0 * math.pi * np.round(middle / (2.0 * math.pi))
        low, high = middle - 0.5 * math.pi, middle + 0.5 * math.pi  # type: ignore[assignment]
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
