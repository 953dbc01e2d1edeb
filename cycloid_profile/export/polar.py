"""The centre of a grinding wheel round the tooth, as the axes C and X see it: the disc turns, the wheel moves in X.

The wheel of radius R touches the flank at P with its centre at W = P + R n. The wheel stays on the machine's X
axis, so that X = |W| and C = −arg W, which rises because the curve is run through clockwise. Between two steps
both axes move in proportion.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.disc_path import Piece, flanks
from cycloid_profile.export.wheel import clearance
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.sampling import equidistribute

_FINE = 2048
_FEWEST, _GROWTH, _MOST = 4, 1.03, 20_000
_CHECKS = (0.2, 0.35, 0.5, 0.65, 0.8)
_NEWTON_STEPS = 30
_OVERLAP = 1e-9  # mm, of rounding
_TANGENT = 1e-6  # rad; flanks that meet with a smaller turn are smooth: it is worth some 1e-11 mm
# Nodes and weights of Gauss's rule on [0, 1], for lengths between two steps.
_GAUSS = ((0.5 - math.sqrt(0.15), 5 / 18), (0.5, 4 / 9), (0.5 + math.sqrt(0.15), 5 / 18))


@dataclass(frozen=True, slots=True)
class PolarPath:
    """The wheel round the disc, all of shape (n + 1,), last step one turn after the first.

    ``phase`` along the disc [rad], ``contact`` x + iy [mm] and ``normal`` where the wheel touches, ``curvature``
    there [1/mm]; ``c`` [rad] and ``x`` [mm] of the axes; ``way`` of the contact along the flank [mm], or of the
    wheel's centre where it rolls about a corner.
    Of every step, shape (n, 2), at its start and at its end: ``c_rate`` [rad/mm], ``x_rate``, and their derivatives
    by the way ``c_bend`` [rad/mm²], ``x_bend`` [1/mm].
    """

    radius: float
    phase: FloatArray
    contact: ComplexArray
    normal: ComplexArray
    curvature: FloatArray
    c: FloatArray
    x: FloatArray
    way: FloatArray
    c_rate: FloatArray
    x_rate: FloatArray
    c_bend: FloatArray
    x_bend: FloatArray

    @property
    def centre(self) -> ComplexArray:
        """Centre of the wheel in the disc frame [mm]."""
        centre: ComplexArray = self.x * np.exp(-1j * self.c)
        return centre


@dataclass(frozen=True, slots=True)
class _Stretch:
    """A smooth part of the wheel's path, arrays of shape (n + 1,).

    ``rate`` dW/dway of the wheel's centre W, complex; ``way`` of the contact from the start [mm].
    """

    phase: FloatArray
    contact: ComplexArray
    normal: ComplexArray
    curvature: FloatArray
    centre: ComplexArray
    rate: ComplexArray
    way: FloatArray


def polar_path(profile: ToothProfile, radius: float, tolerance: float) -> PolarPath:
    """The path from a tip round the disc to the same tip, steps within ``tolerance`` of tangency [mm].

    The wheel never overlaps the tooth: where flanks meet in a groove it goes from one to the other at the
    place where it touches both, and it rolls about a ridge.

    Raises
    ------
    ExportError
        If the wheel does not fit somewhere, or the tolerance takes more steps than is sensible.
    """
    parts = flanks(profile)
    lobes = profile.trochoid.lobes
    count = len(parts) // lobes if profile.lobes_alike else len(parts)
    stretches = _round(parts, count, radius, tolerance)
    if profile.lobes_alike:
        stretches = [_turned(one, m, lobes) for m in range(lobes) for one in stretches]
    path = _joined(_from_tip(stretches, profile), radius)
    least = float(np.min(clearance(profile, path.centre[:-1]))) - radius
    if least < -_OVERLAP or not np.all(np.diff(path.c) > 0.0):
        raise _does_not_fit(radius, f"overlaps a neighbouring flank by {-least:.4f} mm")
    return path


def _round(parts: list[Piece], count: int, radius: float, tolerance: float) -> list[_Stretch]:
    """Stretches along the first ``count`` parts, cut back beside grooves, with arcs about ridges between them."""
    a, b = [flank.a for flank in parts[:count]], [flank.b for flank in parts[:count]]
    ridge: dict[int, float] = {}
    for k in range(count):
        following = parts[(k + 1) % len(parts)]
        turn = cmath.phase(_at(following, following.a)[1] / _at(parts[k], parts[k].b)[1])
        if turn > _TANGENT:
            b[k], begin = _crossing(parts[k], following, turn, radius)
            a[(k + 1) % count] += begin - following.a
        elif turn < -_TANGENT:
            ridge[k] = -turn
    stretches = []
    for k in range(count):
        stretches.append(_along(parts[k], a[k], b[k], radius, tolerance))
        if k in ridge:
            stretches.append(_about(stretches[-1], ridge[k], radius, tolerance))
    return stretches


def _at(flank: Piece, phase: float) -> tuple[complex, complex, complex, float]:
    """Position, derivative by phase, normal and curvature on a flank."""
    psi = np.array([phase])
    points = flank.profile.at(psi, flank.side(psi))
    return tuple(v[0] for v in (points.position, points.first, points.normal, points.curvature))


def _crossing(one: Piece, other: Piece, turn: float, radius: float) -> tuple[float, float]:
    """Phases on two flanks that meet in a groove where the wheel touches both, by Newton."""
    u, v = one.b, other.a
    _, first, _, bend = _at(one, u)
    back = radius * math.tan(0.5 * turn) / ((1.0 - bend * radius) * abs(first))
    u, v = u - back, v + back
    for _ in range(_NEWTON_STEPS):
        (p, p_first, p_normal, p_bend), (q, q_first, q_normal, q_bend) = _at(one, u), _at(other, v)
        A, B = p_first * (1.0 - p_bend * radius), q_first * (1.0 - q_bend * radius)
        miss = (q + radius * q_normal) - (p + radius * p_normal)
        cross = (A.conjugate() * B).imag
        du, dv = -(B.conjugate() * miss).imag / cross, -(A.conjugate() * miss).imag / cross
        u, v = u + du, v + dv
        if abs(du) + abs(dv) < 1e-13:
            break
    if not (one.a < u <= one.b and other.a <= v < other.b):
        raise _does_not_fit(radius, "does not fit between the flanks beside a groove")
    return u, v


def _along(flank: Piece, a: float, b: float, radius: float, tolerance: float) -> _Stretch:
    """As many steps along a flank as keep the wheel tangent within the tolerance, by measurement."""
    grid = np.linspace(a, b, _FINE)
    fine = _stretch(flank, grid, radius)
    x, c = np.abs(fine.centre), -np.unwrap(np.angle(fine.centre))
    ratio = (np.conj(fine.centre) * fine.rate).real / -(np.conj(fine.centre) * fine.rate).imag * x
    # A straight step in C and X strays by X″ΔC²/8 along X, of which the part along the normal counts.
    bend = np.abs(np.gradient(ratio, c) * (np.conj(fine.centre) * fine.normal).real / x)
    density = np.sqrt(np.maximum(bend, 0.02 * float(np.max(bend))) / (8.0 * tolerance)) * np.gradient(c, grid)
    count = max(_FEWEST, math.ceil(float(np.trapezoid(density, grid))))
    while count <= _MOST:
        found = _stretch(flank, equidistribute(grid, density, count), radius)
        if _strays(flank, found, radius) <= tolerance:
            return found
        count = math.ceil(_GROWTH * count) + 1
    raise ExportError(
        "export tolerance",
        f"{tolerance * 1e6:g} nm",
        f"needs more than {_MOST} steps a flank",
        "raise export.chord_tolerance_um",
    )


def _strays(flank: Piece, found: _Stretch, radius: float) -> float:
    """The most by which the wheel leaves tangency between steps [mm]."""
    lobes = flank.profile.trochoid.lobes
    x, c = np.abs(found.centre), -np.unwrap(np.angle(found.centre))
    worst = 0.0
    for t in _CHECKS:
        between = [v[:-1] + t * np.diff(v) for v in (x, c, found.phase)]
        in_lobe = between[0] * np.exp(-1j * (between[1] - 2.0 * math.pi * flank.lobe / lobes))
        psi, side = between[2] - 2.0 * math.pi * flank.lobe, flank.side(between[2])
        which = None if flank.profile.lobes_alike else np.full_like(psi, flank.lobe)
        # One step of Newton from a foot that is as near as this is exact to rounding.
        for _ in range(2):
            points = flank.profile.at(psi, side, which)
            off = in_lobe - points.position
            along = (np.conj(points.first) * off).real / np.abs(points.first) ** 2
            bend = 1.0 - points.curvature * (np.conj(points.normal) * off).real
            psi = psi + along / bend
        points = flank.profile.at(psi, side, which)
        worst = max(worst, float(np.max(np.abs(np.abs(in_lobe - points.position) - radius))))
    return worst


def _stretch(flank: Piece, psi: FloatArray, radius: float) -> _Stretch:
    points = flank.profile.at(psi, flank.side(psi))
    steps = np.diff(psi)
    way = np.zeros_like(psi)
    for node, weight in _GAUSS:
        between = psi[:-1] + node * steps
        way[1:] += weight * steps * np.abs(flank.profile.at(between, flank.side(between)).first)
    return _Stretch(
        phase=psi,
        contact=points.position,
        normal=points.normal,
        curvature=points.curvature,
        centre=points.position + radius * points.normal,
        rate=points.first / np.abs(points.first) * (1.0 - points.curvature * radius),
        way=np.cumsum(way),
    )


def _about(before: _Stretch, turn: float, radius: float, tolerance: float) -> _Stretch:
    """The wheel rolling about the ridge at the end of a stretch, by the angle ``turn`` [rad]."""
    count = max(_FEWEST, math.ceil(turn * math.sqrt(radius / (4.0 * tolerance))))
    angle = np.linspace(0.0, turn, count + 1)
    normal = before.normal[-1] * np.exp(-1j * angle)
    contact = np.full(angle.shape, before.contact[-1])
    # Curvature without bound: the wheel turns about a point.
    return _Stretch(
        np.full(angle.shape, before.phase[-1]), contact, normal, np.full(angle.shape, -math.inf),
        contact + radius * normal, -1j * normal, radius * angle,
    )  # fmt: skip


def _turned(one: _Stretch, lobe: int, lobes: int) -> _Stretch:
    turn = cmath.exp(-2j * math.pi * lobe / lobes)
    return replace(
        one,
        phase=one.phase + 2.0 * math.pi * lobe,
        contact=one.contact * turn,
        normal=one.normal * turn,
        centre=one.centre * turn,
        rate=one.rate * turn,
    )


def _from_tip(stretches: list[_Stretch], profile: ToothProfile) -> list[_Stretch]:
    """The same stretches begun at the tip of lobe 1, or at the highest where lobes differ."""
    half_turns = [float(one.phase[0]) / math.pi for one in stretches]
    tips = [k for k, turns in enumerate(half_turns) if round(turns) % 2 == 1 and abs(turns - round(turns)) < 0.1]
    first = tips[0] if profile.lobes_alike else max(tips, key=lambda k: abs(stretches[k].contact[0]))
    period = profile.trochoid.phase_period
    return stretches[first:] + [replace(one, phase=one.phase + period) for one in stretches[:first]]


def _joined(stretches: list[_Stretch], radius: float) -> PolarPath:
    def nodes(field: str) -> list[Any]:
        return [getattr(one, field) for one in stretches]

    def closed(field: str) -> Any:
        # A joint belongs to what follows it; the last one is the first again.
        values = [v[:-1] for v in nodes(field)]
        return np.concatenate([*values, values[0][:1]])

    centre = closed("centre")
    c = -np.unwrap(np.angle(centre))
    c[-1] = c[0] + 2.0 * math.pi
    begin = np.cumsum([0.0, *(float(one.way[-1]) for one in stretches)])
    way = np.concatenate([*(v[:-1] + w for v, w in zip(nodes("way"), begin[:-1], strict=True)), begin[-1:]])
    phase = closed("phase")
    phase[-1] = stretches[-1].phase[-1]
    rates = [_rates(one) for one in stretches]
    c_rate, x_rate, c_bend, x_bend = (np.concatenate([each[i] for each in rates]) for i in range(4))
    return PolarPath(
        radius, phase, closed("contact"), closed("normal"), closed("curvature"), c, np.abs(centre), way,
        c_rate, x_rate, c_bend, x_bend,
    )  # fmt: skip


def _rates(one: _Stretch) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Rates of C and X by the way and their derivatives, of every step at both its ends, shape (n, 2)."""
    swept = np.conj(one.centre) * one.rate
    x = np.abs(one.centre)
    rates = (-swept.imag / x**2, swept.real / x)
    both = (*rates, *(np.gradient(rate, one.way, edge_order=2) for rate in rates))
    return tuple(np.stack([v[:-1], v[1:]], axis=-1) for v in both)  # type: ignore[return-value]


def _does_not_fit(radius: float, how: str) -> ExportError:
    return ExportError("export.wheel_radius_mm", f"{radius:g}", how, "take a smaller wheel")
