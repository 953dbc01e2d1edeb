"""Registration of a scan on its disc: angular zero, and origin where the datum is free (docs/rig.md, "Comparing")."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import BoolArray, ComplexArray, FloatArray
from cycloid_profile.contact.mesh import nearest_foot
from cycloid_profile.errors import MeasurementError
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.measurement import Measurement

LARGEST_DISTANCE = 0.2  # mm; a scan at a larger distance belongs to another disc
_ROUNDS = 20  # most of Gauss–Newton; fewer by ``_CONVERGED``
_STARTS = 4  # turns within a lobe from which the fit of a free scan starts
_NEAR_ENOUGH = 0.05  # mm; no other start is tried
_TABLE = 2001  # start phases of a lobe; Newton refines the feet
_NEARBY, _CONVERGED = 1e-3, 1e-11  # rad or mm
_SINGLE_POINTS = 0.02  # share of points that may be gross errors of reading


@dataclass(frozen=True, eq=False)
class RegisteredScan:
    """A scan registered on a tooth, arrays of shape (points,).

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
        """Phase of the foot point counted along the whole disc, foot + 2π·lobe, shape (points,) [rad]."""
        return np.asarray(self.foot + 2.0 * math.pi * self.lobe)

    def motions(self, free: bool) -> FloatArray:
        """Removal per turn, and per shift in x and y of a ``free`` origin, shape (points, 1 or 3)."""
        return np.stack([self.lever, self.normal.real, self.normal.imag] if free else [self.lever], axis=1)


def register_scan(
    tooth: ToothProfile, measurement: Measurement, keep: BoolArray | None = None, near: RegisteredScan | None = None
) -> RegisteredScan:
    """Fit a scan to ``tooth`` by least squares over the points that ``keep`` chooses (all of them if None).

    Where the lobes of the tooth differ every lobe is tried as the first one, and the best is taken; with ``near`` the
    fit starts from that earlier registration, and stays on its lobe.

    Raises ``MeasurementError`` if the points are not those of this disc.
    """
    points: ComplexArray = measurement["x_mm"] + 1j * measurement["y_mm"]
    chosen = points if keep is None else points[keep]
    fit = _Fit(tooth, chosen, measurement.datum_free)
    if near is not None:
        turn, shift = fit.refined(near.turn, near.shift)
    else:
        turn, shift = fit.from_scratch(_coarse_turn(tooth, points - fit.first_origin))
        if not tooth.identical_lobes:
            turn, shift = fit.refined(fit.best_lobe(turn, shift), shift)
    found = _projected(tooth, points, turn, shift)
    distance = np.sort(np.abs(found.removal if keep is None else found.removal[keep]))
    typical = float(distance[-1 - int(_SINGLE_POINTS * distance.size)])
    if not typical < LARGEST_DISTANCE:
        raise MeasurementError(
            f"{measurement.name or 'scan'}: distance from the tooth",
            f"{typical:.3f} mm",
            f"is more than {LARGEST_DISTANCE} mm",
            "check unit, tooth count and drive: this is a scan of another disc",
        )
    return found


@dataclass(frozen=True, eq=False)
class _Fit:
    """Least-squares fit of ``points`` [mm] to a tooth, with the shift of the origin if it is ``free``."""

    tooth: ToothProfile
    points: ComplexArray
    free: bool

    @property
    def first_origin(self) -> complex:
        """Origin of the least-squares circle of a free scan, approximate for partial scans."""
        if not self.free:
            return 0j
        A = np.stack([self.points.real, self.points.imag, np.ones(self.points.size)], axis=1)
        x, y, _ = np.linalg.lstsq(A, np.abs(self.points) ** 2, rcond=None)[0]
        return complex(0.5 * x, 0.5 * y)

    def from_scratch(self, turn: float) -> tuple[float, complex]:
        """Rotation and translation of the best fit, from a ``turn`` within one lobe pitch [rad].

        The first origin is off where only part of a disc was scanned: several turns within a lobe are tried.
        """
        shift = self.first_origin
        if not self.free:
            return self.refined(turn, shift)
        best = (math.inf, turn, shift)
        for part in range(_STARTS):
            found = self.refined(turn + part * 2.0 * math.pi / self.tooth.trochoid.lobes / _STARTS, shift)
            typical = float(np.median(np.abs(_projected(self.tooth, self.points, *found).removal)))
            if typical < best[0]:
                best = (typical, *found)
            if typical < _NEAR_ENOUGH:
                break
        return best[1], best[2]

    def refined(self, turn: float, shift: complex) -> tuple[float, complex]:
        """Rotation and translation of least squares, from a start within one lobe pitch of them."""
        along = None
        for _ in range(_ROUNDS):
            at = _projected(self.tooth, self.points, turn, shift, along)
            change, *_ = np.linalg.lstsq(at.motions(self.free), -at.removal, rcond=None)
            turn += float(change[0])
            if self.free:
                shift += complex(change[1], change[2]) * np.exp(1j * turn)
            largest = float(np.max(np.abs(change)))
            if largest < _CONVERGED:
                break
            along = at.along if largest < _NEARBY else None
        return turn, shift

    def best_lobe(self, turn: float, shift: complex) -> float:
        """The turn by whole lobes with the least residual; the smallest of those that tie."""
        lobes = self.tooth.trochoid.lobes
        turns = turn + 2.0 * math.pi / lobes * (np.mod(np.arange(lobes) + lobes // 2, lobes) - lobes // 2)
        squares = []
        for candidate in turns:
            at = _projected(self.tooth, self.points, float(candidate), shift)
            # Turn and shift are still free: only the form is compared.
            motions = at.motions(self.free)
            change, *_ = np.linalg.lstsq(motions, at.removal, rcond=None)
            squares.append(float(np.sum((at.removal - motions @ change) ** 2)))
        return float(turns[int(np.argmin(squares))])


def _projected(
    tooth: ToothProfile, points: ComplexArray, turn: float, shift: complex, along: FloatArray | None = None
) -> RegisteredScan:
    """The points with their feet on the tooth; ``along``, phases along the disc near the feet where these are known."""
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
        from_lobe, period = along - 2.0 * math.pi * lobe, tooth.trochoid.phase_period
        start = from_lobe - period * np.round(from_lobe / period)
    lobe = np.mod(lobe, tooth.trochoid.lobes)
    which = None if tooth.identical_lobes else lobe
    foot, side = nearest_foot(tooth, in_lobe, start, which)
    found = tooth.at(foot, side, which)
    away = in_lobe - found.position
    removal: FloatArray = -(np.conj(found.normal) * away).real
    lever: FloatArray = (np.conj(found.position) * found.normal).imag
    return RegisteredScan(tooth, placed, turn, shift, foot, side, lobe, removal, found.normal * np.conj(spin), lever)


def _coarse_turn(tooth: ToothProfile, points: ComplexArray) -> float:
    """Rotation of the scan modulo one lobe pitch, from the phase of the z_c-th harmonic of the radius [rad]."""
    z_c = tooth.trochoid.lobes
    radius = np.abs(points)
    wave = np.mean((radius - np.mean(radius)) * np.exp(-1j * z_c * np.angle(points)))
    # Unturned, the radius is least at angle 0 and every lobe on, so that the wave is negative there.
    return float(np.angle(-np.conj(wave)) / z_c)
