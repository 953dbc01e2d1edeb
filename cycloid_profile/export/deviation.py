"""How far a file's curve lies from the exact tooth curve, and the exact curve from it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.gap import nearest_foot
from cycloid_profile.geometry.profile import ToothProfile

_TABLE = 4001
_JOINED = 1e-9  # rad; rows whose ends are nearer than this leave nothing of the curve out
_SIDE_BY_SIDE = 0.3  # rad of the 2π of a lobe


@dataclass(frozen=True, slots=True)
class Deviation:
    """Largest and root-mean-square distance from the exact curve [mm], with the polar angle of the worst [rad].

    ``from_curve`` is the largest distance the other way, of the exact curve from what is in the file [mm]:
    the one that tells of a piece left out. None where only points were measured.
    """

    largest: float
    rms: float
    worst_angle: float
    points: int
    from_curve: float | None = None


@dataclass(frozen=True, slots=True)
class _Feet:
    """Nearest points of the exact curve, arrays of one shape: on ``lobe``, at ``phase`` in it [rad]."""

    lobe: FloatArray
    phase: FloatArray
    offset: FloatArray


def deviation(profile: ToothProfile, points: ComplexArray) -> Deviation:
    """Deviation of ``points`` [mm, complex] from the tooth curve."""
    return _largest(points, distances(profile, points))


def deviation_both_ways(profile: ToothProfile, pieces: ComplexArray) -> Deviation:
    """Deviation of a closed curve from the tooth, and of the tooth from the curve.

    ``pieces`` complex, shape (pieces, points ≥ 3) [mm]: each row runs along one smooth piece of the curve
    from end to end, a spline span, an arc or a chord; rows in any order and direction.
    """
    feet = _feet(profile, pieces)
    back = max(_within(profile, pieces, feet), _between(profile, pieces, feet))
    return replace(_largest(pieces, feet.offset), from_curve=back)


def distances(profile: ToothProfile, points: ComplexArray) -> FloatArray:
    """Signed distance of each point along the outward normal, in the shape of ``points`` [mm]; exact feet.

    Points must lie near the curve: each is first matched by its polar angle, and so to its lobe where lobes differ.
    """
    return _feet(profile, points).offset


def _largest(points: ComplexArray, offset: FloatArray) -> Deviation:
    off = np.abs(offset).ravel()
    worst = int(np.argmax(off))
    rms = float(np.sqrt(np.mean(off**2)))
    return Deviation(float(off[worst]), rms, float(np.angle(points.flat[worst])), off.size)


def _feet(profile: ToothProfile, points: ComplexArray) -> _Feet:
    lobe_angle = 2.0 * math.pi / profile.trochoid.lobes
    # A lobe is centred on its root at polar angle 0 and is run through clockwise.
    lobe = np.round(-np.angle(points) / lobe_angle)
    in_lobe = points * np.exp(1j * lobe * lobe_angle)
    psi = np.linspace(-math.pi, math.pi, _TABLE)
    angle = np.angle(profile.at(psi).position)
    start = np.interp(-np.angle(in_lobe), -angle, psi)
    which = np.mod(lobe, profile.trochoid.lobes)
    known = None if profile.lobes_alike else which
    foot, side = nearest_foot(profile, in_lobe, start, known)
    on_curve = profile.at(foot, side, known)
    return _Feet(which, foot, (np.conj(on_curve.normal) * (in_lobe - on_curve.position)).real)


def _within(profile: ToothProfile, pieces: ComplexArray, feet: _Feet) -> float:
    """Largest distance of the exact curve from the rows, halfway between the feet of neighbouring points [mm].

    There the two run side by side, as far apart one way as the other; only over a step too wide for that the
    straight way is taken.
    """
    before, after = np.s_[:, :-1], np.s_[:, 1:]
    beside = np.abs(0.5 * (feet.offset[before] + feet.offset[after]))
    wide = np.abs(_step(profile, feet, before, after)) > _SIDE_BY_SIDE
    apart = np.where(wide, _from_straight(profile, pieces, feet, before, after), beside)
    return float(np.max(apart))


def _between(profile: ToothProfile, pieces: ComplexArray, feet: _Feet) -> float:
    """Largest distance of the exact curve from the straight ways between the rows [mm]."""
    forward = _step(profile, feet, np.s_[:, 0], np.s_[:, -1]) > 0.0
    first, last = np.where(forward, 0, -1), np.where(forward, -1, 0)
    row = np.arange(len(pieces))
    order = np.argsort(2.0 * math.pi * feet.lobe[row, first] + feet.phase[row, first])
    ends, starts = (row[order], last[order]), (np.roll(row[order], -1), first[np.roll(order, -1)])
    missing = _step(profile, feet, ends, starts) > _JOINED
    return float(np.max(_from_straight(profile, pieces, feet, ends, starts), initial=0.0, where=missing))


def _from_straight(profile: ToothProfile, pieces: ComplexArray, feet: _Feet, before: Any, after: Any) -> FloatArray:
    """Distance of the exact curve, halfway between two feet, from the straight way between their points [mm]."""
    halfway = feet.phase[before] + 0.5 * _step(profile, feet, before, after)
    lobe = feet.lobe[before]
    turn = np.exp(2j * math.pi * lobe / profile.trochoid.lobes)
    exact = profile.at(halfway, None, None if profile.lobes_alike else lobe).position
    start, end = pieces[before] * turn - exact, pieces[after] * turn - exact
    way = end - start
    share = np.clip(-(start * np.conj(way)).real / np.maximum(np.abs(way) ** 2, 1e-300), 0.0, 1.0)
    apart: FloatArray = np.abs(start + share * way)
    return apart


def _step(profile: ToothProfile, feet: _Feet, before: Any, after: Any) -> FloatArray:
    """Phase from one foot to another, the short way round the disc [rad]."""
    along = 2.0 * math.pi * feet.lobe + feet.phase
    turn = 2.0 * math.pi * profile.trochoid.lobes
    step = along[after] - along[before]
    short: FloatArray = step - turn * np.round(step / turn)
    return short
