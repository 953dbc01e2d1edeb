"""Path of a grinding wheel round the tooth in the axes C and X: the disc rotates, the wheel moves along X.

The wheel of radius R touches the flank at P with its centre at W = P + R n. The wheel stays on the machine's X axis,
so that X = |W| and C = −arg W, which rises because phase runs clockwise. Both axes interpolate linearly in a step.
"""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.errors import ExportError
from cycloid_profile.export.curves import Piece, flanks, intersection, tolerance_error
from cycloid_profile.export.nc.wheel import clearance
from cycloid_profile.geometry import ToothProfile, equidistribute

_FINE = 2048  # table over a stretch of the path
# Steps of a stretch: the first trial, growth from trial to trial, and the limit of a tolerance that cannot be kept.
_FEWEST, _GROWTH, _MOST = 4, 1.03, 20_000
_CHECKS = (0.2, 0.35, 0.5, 0.65, 0.8)  # of a step; its ends are exact
_OVERLAP = 1e-9  # mm, attributed to rounding
_TANGENT = 1e-6  # rad; a smaller corner counts as smooth, with an error of some 1e-11 mm
# Nodes and weights of Gauss's rule on [0, 1], for lengths between two steps.
_GAUSS = ((0.5 - math.sqrt(0.15), 5 / 18), (0.5, 4 / 9), (0.5 + math.sqrt(0.15), 5 / 18))


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class PolarPath(Described):
    """The wheel round the disc, arrays of shape (n + 1,), the last node one turn after the first.

    ``phase`` along the disc [rad]; ``contact`` point x + iy [mm] with its ``normal`` and ``curvature`` [1/mm]; axis
    positions ``c`` [rad] and ``x`` [mm]; ``arc_length`` of the contact along the flank [mm], or of the wheel's centre
    where it rolls about a corner. First and second derivatives of the axes by arc length at start and end of every
    step, shape (n, 2): ``c_rate`` [rad/mm], ``x_rate``, ``c_second`` [rad/mm²], ``x_second`` [1/mm].
    """

    radius: float
    phase: FloatArray
    contact: ComplexArray
    normal: ComplexArray
    curvature: FloatArray
    c: FloatArray
    x: FloatArray
    arc_length: FloatArray
    c_rate: FloatArray
    x_rate: FloatArray
    c_second: FloatArray
    x_second: FloatArray

    def _key_figures(self) -> dict[str, str]:
        return {
            "wheel radius": f"{self.radius:.6g} mm",
            "steps": f"{self.c.size - 1}",
            "X": f"{np.min(self.x):.6g} to {np.max(self.x):.6g} mm",
            "arc length": f"{self.arc_length[-1]:.6g} mm",
        }

    @property
    def centre(self) -> ComplexArray:
        """Centre of the wheel in the disc frame [mm]."""
        centre: ComplexArray = self.x * np.exp(-1j * self.c)
        return centre


@dataclass(frozen=True, eq=False, slots=True)
class _Stretch:
    """A smooth part of the wheel's path, arrays of shape (n + 1,).

    ``rate`` dW/ds of the wheel's centre W, complex; ``arc_length`` s of the contact from the start [mm].
    """

    phase: FloatArray
    contact: ComplexArray
    normal: ComplexArray
    curvature: FloatArray
    centre: ComplexArray
    rate: ComplexArray
    arc_length: FloatArray


def polar_path(profile: ToothProfile, radius: float, tolerance: float) -> PolarPath:
    """The path from a tip round the disc to the same tip, steps within ``tolerance`` of tangency [mm].

    The wheel never overlaps the tooth: at a groove it changes flanks where it touches both, and it rolls about a
    ridge.

    Raises ``ExportError`` if the wheel does not fit, or the tolerance takes more than 20,000 steps per flank.
    """
    parts = flanks(profile)
    lobes = profile.trochoid.lobes
    count = len(parts) // lobes if profile.identical_lobes else len(parts)
    stretches = _stretches(parts, count, radius, tolerance)
    if profile.identical_lobes:
        stretches = [_rotated(one, m, lobes) for m in range(lobes) for one in stretches]
    path = _joined(_from_tip(stretches, profile), radius)
    least = float(np.min(clearance(profile, path.centre[:-1]))) - radius
    if least < -_OVERLAP or not np.all(np.diff(path.c) > 0.0):
        raise _does_not_fit(radius, f"overlaps a neighbouring flank by {-least:.4f} mm")
    return path


def _stretches(parts: list[Piece], count: int, radius: float, tolerance: float) -> list[_Stretch]:
    """Stretches along the first ``count`` flanks, trimmed at grooves, with arcs about ridges between them."""
    a, b = [flank.a for flank in parts[:count]], [flank.b for flank in parts[:count]]
    ridge: dict[int, float] = {}
    for k in range(count):
        successor = parts[(k + 1) % len(parts)]
        turn = cmath.phase(_at(successor, successor.a)[1] / _at(parts[k], parts[k].b)[1])
        if turn > _TANGENT:
            b[k], begin = _crossing(parts[k], successor, turn, radius)
            a[(k + 1) % count] += begin - successor.a
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
    """Phases on the two flanks of a groove at which the wheel touches both, by Newton."""

    def centre(flank: Piece, phase: float) -> tuple[complex, complex]:
        position, first, normal, curvature = _at(flank, phase)
        return position + radius * normal, first * (1.0 - curvature * radius)

    # Trimmed length of a straight flank, as a phase.
    back = radius * math.tan(0.5 * turn) / abs(centre(one, one.b)[1])
    u, v = intersection(partial(centre, one), partial(centre, other), one.b - back, other.a + back)
    if not (one.a < u <= one.b and other.a <= v < other.b):
        raise _does_not_fit(radius, "does not fit between the flanks of a groove")
    return u, v


def _along(flank: Piece, a: float, b: float, radius: float, tolerance: float) -> _Stretch:
    """The fewest steps along a flank that keep the wheel tangent within the measured ``tolerance`` [mm]."""
    grid = np.linspace(a, b, _FINE)
    fine = _stretch(flank, grid, radius)
    x, c = np.abs(fine.centre), -np.unwrap(np.angle(fine.centre))
    ratio = (np.conj(fine.centre) * fine.rate).real / -(np.conj(fine.centre) * fine.rate).imag * x
    # A linear step in C and X deviates by X″ΔC²/8 along X, of which the component along the normal counts.
    second = np.abs(np.gradient(ratio, c) * (np.conj(fine.centre) * fine.normal).real / x)
    density = np.sqrt(np.maximum(second, 0.02 * float(np.max(second))) / (8.0 * tolerance)) * np.gradient(c, grid)
    count = max(_FEWEST, math.ceil(float(np.trapezoid(density, grid))))
    while count <= _MOST:
        found = _stretch(flank, equidistribute(grid, density, count), radius)
        if _tangency_error(flank, found, radius) <= tolerance:
            return found
        count = math.ceil(_GROWTH * count) + 1
    raise tolerance_error(tolerance, f"{_MOST} steps per flank")


def _tangency_error(flank: Piece, found: _Stretch, radius: float) -> float:
    """Largest distance of the wheel from tangency between steps [mm]."""
    lobes = flank.profile.trochoid.lobes
    x, c = np.abs(found.centre), -np.unwrap(np.angle(found.centre))
    worst = 0.0
    for t in _CHECKS:
        between = [v[:-1] + t * np.diff(v) for v in (x, c, found.phase)]
        in_lobe = between[0] * np.exp(-1j * (between[1] - 2.0 * math.pi * flank.lobe / lobes))
        psi, side = between[2] - 2.0 * math.pi * flank.lobe, flank.side(between[2])
        which = None if flank.profile.identical_lobes else np.full_like(psi, flank.lobe)
        # Newton from such a near foot is exact to rounding after one step.
        for _ in range(2):
            points = flank.profile.at(psi, side, which)
            off = in_lobe - points.position
            along = (np.conj(points.first) * off).real / np.abs(points.first) ** 2
            psi = psi + along / (1.0 - points.curvature * (np.conj(points.normal) * off).real)
        points = flank.profile.at(psi, side, which)
        worst = max(worst, float(np.max(np.abs(np.abs(in_lobe - points.position) - radius))))
    return worst


def _stretch(flank: Piece, psi: FloatArray, radius: float) -> _Stretch:
    points = flank.profile.at(psi, flank.side(psi))
    steps = np.diff(psi)
    arc_length = np.zeros_like(psi)
    for node, weight in _GAUSS:
        between = psi[:-1] + node * steps
        arc_length[1:] += weight * steps * np.abs(flank.profile.at(between, flank.side(between)).first)
    return _Stretch(
        phase=psi,
        contact=points.position,
        normal=points.normal,
        curvature=points.curvature,
        centre=points.position + radius * points.normal,
        rate=points.first / np.abs(points.first) * (1.0 - points.curvature * radius),
        arc_length=np.cumsum(arc_length),
    )


def _about(before: _Stretch, turn: float, radius: float, tolerance: float) -> _Stretch:
    """The wheel rolling about the ridge at the end of a stretch, by the angle ``turn`` [rad]."""
    count = max(_FEWEST, math.ceil(turn * math.sqrt(radius / (4.0 * tolerance))))
    angle = np.linspace(0.0, turn, count + 1)
    normal = before.normal[-1] * np.exp(-1j * angle)
    contact = np.full(angle.shape, before.contact[-1])
    # Infinite curvature: the wheel rotates about a point.
    return _Stretch(
        np.full(angle.shape, before.phase[-1]), contact, normal, np.full(angle.shape, -math.inf),
        contact + radius * normal, -1j * normal, radius * angle,
    )  # fmt: skip


def _rotated(one: _Stretch, lobe: int, lobes: int) -> _Stretch:
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
    """The same stretches started at the tip of lobe 1, or at the highest tip where lobes differ."""
    half_turns = [float(one.phase[0]) / math.pi for one in stretches]
    tips = [k for k, turns in enumerate(half_turns) if round(turns) % 2 == 1 and abs(turns - round(turns)) < 0.1]
    first = tips[0] if profile.identical_lobes else max(tips, key=lambda k: abs(stretches[k].contact[0]))
    period = profile.trochoid.phase_period
    return stretches[first:] + [replace(one, phase=one.phase + period) for one in stretches[:first]]


def _joined(stretches: list[_Stretch], radius: float) -> PolarPath:
    def closed(field: str) -> Any:
        # A joint belongs to the following stretch; the last joint is the first.
        values = [getattr(one, field)[:-1] for one in stretches]
        return np.concatenate([*values, values[0][:1]])

    centre = closed("centre")
    c = -np.unwrap(np.angle(centre))
    c[-1] = c[0] + 2.0 * math.pi
    begin = np.cumsum([0.0, *(float(one.arc_length[-1]) for one in stretches)])
    lengths = [one.arc_length[:-1] + start for one, start in zip(stretches, begin[:-1], strict=True)]
    arc_length = np.concatenate([*lengths, begin[-1:]])
    phase = closed("phase")
    phase[-1] = stretches[-1].phase[-1]
    c_rate, x_rate, c_second, x_second = (np.concatenate(parts) for parts in zip(*map(_rates, stretches), strict=True))
    return PolarPath(
        radius, phase, closed("contact"), closed("normal"), closed("curvature"), c, np.abs(centre), arc_length,
        c_rate, x_rate, c_second, x_second,
    )  # fmt: skip


def _rates(one: _Stretch) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """First and second derivatives of C and X by arc length at both ends of every step, shape (n, 2)."""
    swept = np.conj(one.centre) * one.rate
    x = np.abs(one.centre)
    rates = (-swept.imag / x**2, swept.real / x)
    both = (*rates, *(np.gradient(rate, one.arc_length, edge_order=2) for rate in rates))
    return tuple(np.stack([v[:-1], v[1:]], axis=-1) for v in both)  # type: ignore[return-value]


def _does_not_fit(radius: float, how: str) -> ExportError:
    return ExportError("export.wheel_radius_mm", f"{radius:g}", how, "take a smaller wheel")
