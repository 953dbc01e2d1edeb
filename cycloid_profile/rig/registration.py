"""Where a scan lies on its disc: angular zero, and origin where the datum is free (docs/rig.md, "Comparing")."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray
from cycloid_profile.contact.gap import nearest_foot
from cycloid_profile.errors import MeasurementError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.measurement.files import Measurement

LARGEST_DISTANCE = 0.2  # mm; a scan this far off is one of another disc
_ROUNDS = 20
_STARTS = 4  # turns within a lobe from which a free scan is laid
_NEAR_ENOUGH = 0.05  # mm; no other turn is tried
_TABLE = 2001
_NEARBY, _SETTLED = 1e-3, 1e-11  # rad or mm
_SINGLE_POINTS = 0.02  # share of points that may be gross errors of reading


@dataclass(frozen=True, eq=False)
class PlacedScan:
    """A scan laid on a tooth, arrays of shape (points,).

    ``placed`` points in the frame of the disc [mm]; ``turn`` of the scan on the table [rad] and ``shift`` of its
    origin [mm]; ``foot`` phase of the nearest point of the tooth [rad] on lobe ``lobe`` (whole number in [0, z_c));
    ``removal`` along the normal, positive where material is missing [mm]; ``normal`` outwards, complex, and ``lever``
    of a turn about the origin [mm], both in the frame of the disc.
    """

    tooth: ToothProfile
    placed: ComplexArray
    turn: float
    shift: complex
    foot: FloatArray
    side: FloatArray
    lobe: FloatArray
    removal: FloatArray
    normal: ComplexArray
    lever: FloatArray

    @property
    def along(self) -> FloatArray:
        """Phase along the disc, foot + 2π·lobe, shape (points,) [rad]."""
        phase: FloatArray = self.foot + 2.0 * math.pi * self.lobe
        return phase


def place_scan(
    tooth: ToothProfile, measurement: Measurement, keep: BoolArray | None = None, near: PlacedScan | None = None
) -> PlacedScan:
    """Lay a scan on ``tooth`` by least squares over the points that ``keep`` chooses (all of them if None).

    Where the lobes of the tooth differ every lobe is tried as the first one, and the best is taken; with ``near`` the
    search starts from where the scan was laid before, and stays on that lobe.

    Raises
    ------
    MeasurementError
        If the points are not those of this disc.
    """
    points: ComplexArray = measurement["x_mm"] + 1j * measurement["y_mm"]
    chosen = np.ones(points.size, dtype=bool) if keep is None else keep
    free = measurement.keys.get("datum", "bore") == "free"
    if near is None:
        turn, shift = _begin(tooth, points, chosen, free)
    else:
        turn, shift = _fit(tooth, points, chosen, near.turn, near.shift, free)
    if near is None and not tooth.lobes_alike:
        turn = _best_lobe(tooth, points, chosen, turn, shift, free)
        turn, shift = _fit(tooth, points, chosen, turn, shift, free)
    found = _laid(tooth, points, turn, shift)
    distance = np.sort(np.abs(found.removal[chosen]))
    typical = float(distance[-1 - int(_SINGLE_POINTS * distance.size)])
    if not typical < LARGEST_DISTANCE:
        raise MeasurementError(
            f"{measurement.name}: distance from the tooth",
            f"{typical:.3f} mm",
            f"is more than {LARGEST_DISTANCE} mm",
            "check unit, tooth count and drive: this is a scan of another disc",
        )
    return found


def _begin(tooth: ToothProfile, points: ComplexArray, chosen: BoolArray, free: bool) -> tuple[float, complex]:
    """Turn and shift from nothing known.

    A free origin begins at the middle of the circle through the points. Where only a part of the disc was scanned that
    is off, so that several turns within a lobe are tried.
    """
    shift = _middle(points[chosen]) if free else 0j
    turn = _coarse_turn(tooth, points - shift)
    if not free:
        return _fit(tooth, points, chosen, turn, shift, free)
    best = (math.inf, turn, shift)
    for part in range(_STARTS):
        begun = turn + part * 2.0 * math.pi / tooth.trochoid.lobes / _STARTS
        found = _fit(tooth, points, chosen, begun, shift, free)
        left = float(np.median(np.abs(_laid(tooth, points[chosen], *found).removal)))
        if left < best[0]:
            best = (left, *found)
        if left < _NEAR_ENOUGH:
            break
    return best[1], best[2]


def _middle(points: ComplexArray) -> complex:
    """Middle of the circle of least squares, exact for whole discs, near for parts of them."""
    A = np.stack([points.real, points.imag, np.ones(points.size)], axis=1)
    x, y, _ = np.linalg.lstsq(A, np.abs(points) ** 2, rcond=None)[0]
    return complex(0.5 * x, 0.5 * y)


def _fit(
    tooth: ToothProfile, points: ComplexArray, chosen: BoolArray, turn: float, shift: complex, free: bool
) -> tuple[float, complex]:
    """Turn and shift of least squares, from a place within a lobe of it."""
    some, along = points[chosen], None
    for _ in range(_ROUNDS):
        at = _laid(tooth, some, turn, shift, along)
        columns = [at.lever, at.normal.real, at.normal.imag] if free else [at.lever]
        change, *_ = np.linalg.lstsq(np.stack(columns, axis=1), -at.removal, rcond=None)
        turn += float(change[0])
        if free:
            shift += complex(change[1], change[2]) * np.exp(1j * turn)
        largest = float(np.max(np.abs(change)))
        if largest < _SETTLED:
            break
        along = at.along if largest < _NEARBY else None
    return turn, shift


def _best_lobe(
    tooth: ToothProfile, points: ComplexArray, chosen: BoolArray, turn: float, shift: complex, free: bool
) -> float:
    """The turn by whole lobes that leaves least; the smallest of those that tie."""
    lobes = tooth.trochoid.lobes
    turns = turn + 2.0 * math.pi / lobes * (np.mod(np.arange(lobes) + lobes // 2, lobes) - lobes // 2)
    left = []
    for candidate in turns:
        at = _laid(tooth, points[chosen], float(candidate), shift)
        # What may move is taken off: the form is compared.
        moves = [at.lever, at.normal.real, at.normal.imag] if free else [at.lever]
        columns = np.stack(moves, axis=1)
        change, *_ = np.linalg.lstsq(columns, at.removal, rcond=None)
        left.append(float(np.sum((at.removal - columns @ change) ** 2)))
    return float(turns[int(np.argmin(left))])


def _laid(
    tooth: ToothProfile, points: ComplexArray, turn: float, shift: complex, along: FloatArray | None = None
) -> PlacedScan:
    """The points on the tooth; ``along``, phases along the disc near their feet where these are known."""
    placed: ComplexArray = (points - shift) * np.exp(-1j * turn)
    lobe_angle = 2.0 * math.pi / tooth.trochoid.lobes
    lobe = np.round(-np.angle(placed) / lobe_angle)
    spin = np.exp(1j * lobe * lobe_angle)
    in_lobe = placed * spin
    if along is None:
        psi = np.linspace(-math.pi, math.pi, _TABLE)
        start = np.interp(-np.angle(in_lobe), -np.angle(tooth.at(psi).position), psi)
    else:
        # A point that crossed the tip between two lobes has its foot at the other end of a lobe.
        start = _within_a_turn(along - 2.0 * math.pi * lobe, tooth.trochoid.phase_period)
    lobe = np.mod(lobe, tooth.trochoid.lobes)
    which = None if tooth.lobes_alike else lobe
    foot, side = nearest_foot(tooth, in_lobe, start, which)
    found = tooth.at(foot, side, which)
    away = in_lobe - found.position
    removal: FloatArray = -(np.conj(found.normal) * away).real
    lever: FloatArray = (np.conj(found.position) * found.normal).imag
    return PlacedScan(tooth, placed, turn, shift, foot, side, lobe, removal, found.normal * np.conj(spin), lever)


def _within_a_turn(phase: FloatArray, period: float) -> FloatArray:
    """The same phase along the disc, the one nearest to zero [rad]."""
    found: FloatArray = phase - period * np.round(phase / period)
    return found


def _coarse_turn(tooth: ToothProfile, points: ComplexArray) -> float:
    """Turn of the scan within a lobe, by the phase of its radius wave [rad]."""
    z_c = tooth.trochoid.lobes
    radius = np.abs(points)
    wave = np.mean((radius - np.mean(radius)) * np.exp(-1j * z_c * np.angle(points)))
    # Unturned, the radius is least at angle 0 and every lobe on, so that the wave is negative there.
    return float(np.angle(-np.conj(wave)) / z_c)
