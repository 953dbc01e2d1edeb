"""Deviation of a file's curve from the exact tooth curve, and of the exact curve from the file."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.mesh import nearest_foot
from cycloid_profile.geometry import ToothProfile

_TABLE = 4001  # start phases of a lobe; Newton refines the feet
_JOINED = 1e-9  # rad, largest gap between rows that counts as joined
_NARROW_STEP = 0.3  # rad of the 2π of a lobe
_ROUNDING = 1e-12  # mm


@dataclass(frozen=True, slots=True)
class Deviation:
    """Largest and root-mean-square distance from the exact curve [mm], with the polar angle of the largest [rad],
    the greatest angle where several are equally large.

    ``from_curve`` is the largest distance of the exact curve from the curve in the file [mm], which detects missing
    pieces; None where only points were measured. ``points`` is the number of measured points.
    """

    largest: float
    rms: float
    worst_angle: float
    points: int
    from_curve: float | None = None

    @classmethod
    def of(cls, points: ComplexArray, offset: FloatArray) -> Deviation:
        """Summary of the signed distances ``offset`` at ``points``, equal shapes [mm]."""
        off = np.abs(offset).ravel()
        largest = float(np.max(off))
        # Mirrored points are equally far: processors differ in which is further by rounding.
        worst = np.angle(points.ravel()[off > largest - _ROUNDING])
        return cls(largest, float(np.sqrt(np.mean(off**2))), float(np.max(worst)), off.size)


@dataclass(frozen=True, eq=False, slots=True)
class _Feet:
    """Nearest points of the exact curve: ``lobe``, ``phase`` in it [rad], signed distance ``offset`` [mm]."""

    lobe: FloatArray
    phase: FloatArray
    offset: FloatArray


def deviation(profile: ToothProfile, points: ComplexArray) -> Deviation:
    """Deviation of ``points`` [mm, complex] from the tooth curve."""
    return Deviation.of(points, distances(profile, points))


def deviation_both_ways(profile: ToothProfile, pieces: ComplexArray) -> Deviation:
    """Deviation of a closed curve from the tooth, and of the tooth from the curve.

    ``pieces`` complex, shape (pieces, points ≥ 3) [mm]: each row holds points along one spline span, arc or chord
    from end to end; rows in any order and direction.
    """
    feet = _feet(profile, pieces)
    back = max(_within(profile, pieces, feet), _between(profile, pieces, feet))
    return replace(Deviation.of(pieces, feet.offset), from_curve=back)


def distances(profile: ToothProfile, points: ComplexArray) -> FloatArray:
    """Signed distance of each point along the outward normal, in the shape of ``points`` [mm], from exact foot points.

    Points must lie near the curve: the polar angle selects the lobe and the start of the search.
    """
    return _feet(profile, points).offset


def _feet(profile: ToothProfile, points: ComplexArray) -> _Feet:
    lobe_angle = 2.0 * math.pi / profile.trochoid.lobes
    # A lobe is centred on its root; phase rises clockwise.
    lobe = np.round(-np.angle(points) / lobe_angle)
    in_lobe = points * np.exp(1j * lobe * lobe_angle)
    psi = np.linspace(-math.pi, math.pi, _TABLE)
    angle = np.angle(profile.at(psi).position)
    start = np.interp(-np.angle(in_lobe), -angle, psi)
    which = np.mod(lobe, profile.trochoid.lobes)
    known = None if profile.identical_lobes else which
    foot, side = nearest_foot(profile, in_lobe, start, known)
    on_curve = profile.at(foot, side, known)
    return _Feet(which, foot, (np.conj(on_curve.normal) * (in_lobe - on_curve.position)).real)


def _within(profile: ToothProfile, pieces: ComplexArray, feet: _Feet) -> float:
    """Largest distance of the exact curve from the rows of points, halfway between neighbouring foot points [mm].

    The mean of the two offsets approximates this distance. Over wide steps the distance is measured from the chord.
    """
    before, after = np.s_[:, :-1], np.s_[:, 1:]
    mean = np.abs(0.5 * (feet.offset[before] + feet.offset[after]))
    wide = np.abs(_step(profile, feet, before, after)) > _NARROW_STEP
    distance = np.where(wide, _from_chord(profile, pieces, feet, before, after), mean)
    return float(np.max(distance))


def _between(profile: ToothProfile, pieces: ComplexArray, feet: _Feet) -> float:
    """Largest distance of the exact curve from the chords that join the rows [mm]."""
    forward = _step(profile, feet, np.s_[:, 0], np.s_[:, -1]) > 0.0
    first, last = np.where(forward, 0, -1), np.where(forward, -1, 0)
    row = np.arange(len(pieces))
    order = np.argsort(2.0 * math.pi * feet.lobe[row, first] + feet.phase[row, first])
    ends, starts = (row[order], last[order]), (np.roll(row[order], -1), first[np.roll(order, -1)])
    missing = _step(profile, feet, ends, starts) > _JOINED
    return float(np.max(_from_chord(profile, pieces, feet, ends, starts), initial=0.0, where=missing))


def _from_chord(profile: ToothProfile, pieces: ComplexArray, feet: _Feet, before: Any, after: Any) -> FloatArray:
    """Distance of the exact curve, halfway between two feet, from the chord between their points [mm]."""
    halfway = feet.phase[before] + 0.5 * _step(profile, feet, before, after)
    lobe = feet.lobe[before]
    turn = np.exp(2j * math.pi * lobe / profile.trochoid.lobes)
    exact = profile.at(halfway, None, None if profile.identical_lobes else lobe).position
    start, end = pieces[before] * turn - exact, pieces[after] * turn - exact
    chord = end - start
    share = np.clip(-(start * np.conj(chord)).real / np.maximum(np.abs(chord) ** 2, 1e-300), 0.0, 1.0)
    distance: FloatArray = np.abs(start + share * chord)
    return distance


def _step(profile: ToothProfile, feet: _Feet, before: Any, after: Any) -> FloatArray:
    """Phase difference of two feet, wrapped to ± half a revolution of the disc [rad]."""
    along = 2.0 * math.pi * feet.lobe + feet.phase
    turn = 2.0 * math.pi * profile.trochoid.lobes
    step = along[after] - along[before]
    short: FloatArray = step - turn * np.round(step / turn)
    return short
