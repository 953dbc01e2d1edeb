"""Exact distance from a pin to the tooth curve, by Newton on the foot point (docs/theory.md, Eqs. 21–22)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ArrayLike, BoolArray, ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.mesh.meshing import Meshing
from cycloid_profile.geometry import ToothProfile, flank_side
from cycloid_profile.units import UM

_MAX_STEPS = 60
# A last step this small is followed along the tangent, which errs by its square.
_LAST_STEP = 1e-8  # rad
_STEP_LIMIT = 0.2  # rad; keeps Newton on the lobe it started from
# Where the curvature of the tooth is almost that of the pin, further feet lie away from the phase of the pin: starts
# at this distance on either side find them.
_REACH = 0.8  # rad from a root
_STARTS = (-0.3, 0.3)  # rad
# A wave on the flank can put a foot on each of its flanks, within the capture width of the pin.
_CAPTURE_WIDTH = 0.35  # rad
_MOST_STARTS = 81


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Gaps(Described):
    """Gaps between pins and disc with the contact frame, all of one shape (…, pins).

    ``gap`` [mm], negative where they overlap, NaN where no foot was found; ``foot`` phase of the foot point
    [rad]; ``normal`` outward unit normal in the housing frame (complex); ``lever`` arm of the normal about
    the disc centre, positive where an anticlockwise disc closes the gap [mm]; ``curvature`` of the tooth at
    the foot [1/mm].
    """

    gap: FloatArray
    foot: FloatArray
    normal: ComplexArray
    lever: FloatArray
    curvature: FloatArray

    def _key_figures(self) -> Mapping[str, str]:
        return {"shape": " × ".join(map(str, self.gap.shape)), "least gap": f"{np.nanmin(self.gap) / UM:.3f} µm"}

    @staticmethod
    def of_discs(discs: list[Gaps]) -> Gaps:
        """Gaps of several discs, each of shape (poses, 1, pins), as one of shape (poses, discs, pins)."""
        joined = ([getattr(disc, field.name) for disc in discs] for field in fields(Gaps))
        return Gaps(*(np.concatenate(parts, axis=1) for parts in joined))

    def poses(self, which: IntArray) -> Gaps:
        """The gaps at some of the poses."""
        return Gaps(*(getattr(self, field.name)[which] for field in fields(Gaps)))

    def put(self, poses: IntArray, others: Gaps) -> None:
        """Overwrite the gaps of some poses with recomputed ones."""
        for field in fields(Gaps):
            getattr(self, field.name)[poses] = getattr(others, field.name)


@dataclass(frozen=True, eq=False, slots=True)
class _Foot:
    """Foot points, arrays of one shape.

    ``phase`` [rad]; ``side``, flank (±1) on which Newton searches; ``position`` of the foot and vector ``away`` from it
    to the pin centre, complex [mm]; ``outside``, side of the curve on which the pin is (±1); ``curvature`` [1/mm].
    """

    phase: FloatArray
    side: FloatArray
    position: ComplexArray
    away: ComplexArray
    outside: FloatArray
    curvature: FloatArray

    @property
    def distance(self) -> FloatArray:
        """From the foot to the pin centre, negative inside the disc [mm]."""
        signed: FloatArray = self.outside * np.abs(self.away)
        return signed

    def at(self, which: BoolArray) -> _Foot:
        """The feet where ``which`` is true, as one row."""
        return self._each(lambda field: field[which])

    def nearer(self, other: _Foot) -> _Foot:
        """Of two candidate feet the nearer, element by element; the first where they tie."""
        near, far = np.abs(self.away), np.abs(other.away)
        swap: BoolArray = (far < near - 1e-15) | (np.isnan(near) & ~np.isnan(far))
        if not np.any(swap):
            return self
        return _Foot(*(np.where(swap, getattr(other, f.name), getattr(self, f.name)) for f in fields(_Foot)))

    def replaced(self, which: BoolArray, others: _Foot) -> _Foot:
        """A copy with the feet where ``which`` is true taken from the row ``others``."""
        copy = self._each(np.copy)
        for f in fields(_Foot):
            getattr(copy, f.name)[which] = getattr(others, f.name)
        return copy

    def _each(self, change: Callable[[Any], Any]) -> _Foot:
        return _Foot(*(change(getattr(self, f.name)) for f in fields(_Foot)))


def gaps(
    profile: ToothProfile,
    pin_radius: ArrayLike,
    meshing: Meshing,
    displacement: ComplexArray | complex = 0.0,
    rotation: ArrayLike = 0.0,
    pin_shift: ComplexArray | complex = 0.0,
    start: FloatArray | None = None,
) -> Gaps:
    """Gap of every pin for discs moved by ``displacement`` [mm, complex] and ``rotation`` [rad].

    Shapes, and ``pin_shift``, as in ``Meshing.pin_in_lobe``; ``pin_radius`` is one for all or one for each
    pin [mm]. ``start`` is a phase near each foot, such as the foot before a small move; the pin's own phase
    when None. The result is exact to rounding: |p − P(ψ*)| − r_rp with the foot ψ* where (p − P)·P' = 0.
    """
    turn = np.asarray(rotation, dtype=np.float64)
    centre = meshing.pin_in_lobe(displacement, turn, pin_shift)
    lobe = None if profile.identical_lobes else meshing.lobe
    foot = _nearest(profile, centre, meshing.phase if start is None else start, lobe)
    # The pin's own direction, not the curve's normal: they differ where the foot is a corner.
    distance = foot.distance
    with np.errstate(invalid="ignore"):  # a foot that was not found is NaN, and stays so
        normal = foot.away / distance
    outward = normal * np.exp(1j * turn)[..., np.newaxis] * np.conj(meshing.into_lobe)
    return Gaps(
        gap=distance - np.asarray(pin_radius, dtype=np.float64),
        foot=foot.phase,
        normal=outward,
        lever=foot.position.real * normal.imag - foot.position.imag * normal.real,
        curvature=foot.curvature,
    )


def nearest_foot(
    profile: ToothProfile, centre: ComplexArray, start: FloatArray, lobe: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Phase of the foot point nearest to ``centre``, and its flank (±1), in the shape of ``centre``.

    Where a pin can have several feet all are sought and the nearest is taken: on both flanks at a
    corner, on both sides of a root, and on every wave of a measured curve. NaN where Newton finds none.
    """
    foot = _nearest(profile, centre, start, lobe)
    return foot.phase, foot.side


def _nearest(profile: ToothProfile, centre: ComplexArray, start: FloatArray, lobe: FloatArray | None) -> _Foot:
    side = _flank(profile, start)
    best = _foot_on(profile, centre, start, side, lobe)
    if profile.corners:
        best = best.nearer(_foot_on(profile, centre, start, -side, lobe))
    capture = capture_radius(profile, start, lobe)
    # A point nearer to a foot than the least concave radius has no other foot there. One without a foot is not below
    # any capture radius, and is sought further only where there may be another.
    beyond = ~(np.abs(best.away) < capture) & np.isfinite(capture)
    if not np.any(beyond):
        return best
    _, offsets = _capture_radii(profile)
    from_root = _from_root(start)
    found = best.at(beyond)
    at_lobe = None if lobe is None else np.broadcast_to(lobe, centre.shape)[beyond]
    for begin in _further_starts(profile, centre[beyond], start[beyond], from_root[beyond], at_lobe, offsets):
        found = found.nearer(_foot_on(profile, centre[beyond], begin, _flank(profile, begin), at_lobe))
    return best.replaced(beyond, found)


def capture_radius(profile: ToothProfile, phase: FloatArray, lobe: FloatArray | None) -> FloatArray:
    """Distance below which a foot near ``phase`` is the nearest, in its shape: the least concave radius of the lobe,
    infinite where no other foot can lie [mm].
    """
    radii, offsets = _capture_radii(profile)
    capture = radii[0] if lobe is None or len(radii) == 1 else radii[np.mod(lobe, len(radii)).astype(np.intp)]
    if offsets is not None:
        return np.broadcast_to(capture, phase.shape)
    return np.where(np.abs(_from_root(phase)) < _REACH, capture, np.inf)


def _from_root(phase: FloatArray) -> FloatArray:
    """Phase counted from the nearest root [rad]."""
    from_root: FloatArray = phase - 2.0 * math.pi * np.round(phase / (2.0 * math.pi))
    return from_root


def _further_starts(
    profile: ToothProfile,
    centre: ComplexArray,
    start: FloatArray,
    from_root: FloatArray,
    lobe: FloatArray | None,
    offsets: FloatArray | None,
) -> list[FloatArray]:
    """Starting phases of the search for nearer feet, each in the shape of ``start``."""
    if offsets is None:
        # Further feet near a root lie at fixed phases, independent of the pin position.
        return [(start - from_root) + offset for offset in _STARTS]
    nearest, begin = np.full(start.shape, np.inf), start.copy()
    for offset in offsets:
        psi = start + offset
        distance = np.abs(centre - profile.at(psi, _flank(profile, psi), lobe).position)
        begin = np.where(distance < nearest, psi, begin)
        nearest = np.minimum(distance, nearest)
    return [begin]


def _flank(profile: ToothProfile, phase: FloatArray) -> FloatArray:
    """Flank of each phase; +1 for a tooth without corners, which saves 20 % of the time."""
    return flank_side(phase) if profile.corners else np.ones_like(phase)


@lru_cache(maxsize=64)
def _capture_radii(profile: ToothProfile) -> tuple[FloatArray, FloatArray | None]:
    """Least concave radius where a second foot could lie, for each lobe that differs [mm]; and the offsets at
    which to look along a curve given by points, close enough for its shortest wave, None without one [rad].
    """
    spacing = [removal.point_spacing for removal in profile.removals if removal.point_spacing is not None]
    if spacing:
        psi = np.linspace(-math.pi, math.pi, max(65, math.ceil(4.0 * math.pi / min(spacing))))
        side = flank_side(psi)
        count = min(_MOST_STARTS, 2 * math.ceil(_CAPTURE_WIDTH / min(spacing)) + 1)
        offsets = np.linspace(-_CAPTURE_WIDTH, _CAPTURE_WIDTH, count)
    else:
        psi, offsets = np.linspace(0.0, _REACH, 65), None
        side = np.ones_like(psi)
    lobes = 1 if profile.identical_lobes else profile.trochoid.lobes
    lobe = np.arange(float(lobes))[:, np.newaxis]
    curvature = profile.at(*np.broadcast_arrays(psi, side, lobe)).curvature
    least = 0.999 / np.maximum(np.max(curvature, axis=1), 1e-300)
    return least, offsets


def _foot_on(
    profile: ToothProfile, centre: ComplexArray, start: FloatArray, side: FloatArray, lobe: FloatArray | None
) -> _Foot:
    """Newton from ``start``; with corners it stays within the flank ``side``."""
    low = high = None
    psi = start
    if profile.corners:
        # The flank next to the start: [0, π] or [−π, 0], moved by a turn where the start lies past a tip.
        middle = start - side * (0.5 * math.pi)
        middle = side * (0.5 * math.pi) + 2.0 * math.pi * np.round(middle / (2.0 * math.pi))
        low, high = middle - 0.5 * math.pi, middle + 0.5 * math.pi
        psi = np.clip(start, low, high)
    for _ in range(_MAX_STEPS):
        point = profile.at(psi, side, lobe)
        # In the frame of the trochoid the curve runs along −i, and against 1 where it recedes.
        offset = np.conj(point.frame) * (centre - point.position)
        out, across, g = offset.real, offset.imag, point.along
        if point.rise is None or point.rise_rate is None:
            speed2 = g * g
            slope = -g * across
            second = out * (point.turn * g) - across * point.along_rate - speed2
        else:
            speed2 = g * g + point.rise * point.rise
            slope = -g * across - point.rise * out
            second = (
                out * (point.turn * g - point.rise_rate)
                - across * (point.along_rate + point.turn * point.rise)
                - speed2
            )
        # Where the distance is not convex the full Newton step would run to a farthest point.
        step = np.clip(-slope / np.where(second < 0.0, second, -speed2), -_STEP_LIMIT, _STEP_LIMIT)
        if low is not None and high is not None:
            step = np.clip(psi + step, low, high) - psi
        going = np.abs(step) >= _LAST_STEP
        if not np.any(going):
            break
        # A foot that has been found is kept, so that it does not depend on the other searches.
        psi = np.where(going, psi + step, psi)
    lost = ~(np.abs(step) < _LAST_STEP)  # a NaN is lost, too
    move = point.first * step
    position, away = point.position + move, centre - point.position - move
    if np.any(lost):
        away = np.where(lost, np.nan, away)
    outside = np.where(out * g - (0.0 if point.rise is None else across * point.rise) < 0.0, -1.0, 1.0)
    return _Foot(psi + step, side, position, away, outside, point.curvature)
