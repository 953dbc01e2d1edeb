"""How far a measured file lies from what the rig predicts of a reducer (docs/rig.md, "Comparing").

What no measurement can know is taken off first: the angular zero of a scan, and its origin when the datum is free;
the zero of an angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.contact.gap import nearest_foot
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError, SolveError
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.hysteresis import stage_torque
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM

_UNITS = {"profile_scan": "um", "hysteresis": "arcmin", "transmission_error": "arcsec", "lost_motion_map": "arcmin"}
_LARGEST_SCAN_GAP = 0.2  # mm; a scan this far off is one of another disc
_ROUNDS = 20
_TABLE = 2001
# Inside the backlash the angle is whatever the last push left: these torques are not compared.
_AFLOAT = 0.03


@dataclass(frozen=True, eq=False)
class Gap:
    """Measured minus predicted, registration taken off, in the unit of the measured column (µm, ′ or ″).

    ``where`` is what the rows stand over, in ``axis``'s unit; ``noise`` the white noise of the data, estimated from
    neighbouring rows or stated in the file; ``removed`` tells what registration took off.
    """

    built: Built
    measurement: Measurement
    axis: str
    where: FloatArray
    residual: FloatArray
    noise: float
    removed: dict[str, float]

    @property
    def unit(self) -> str:
        """Unit of residual and noise."""
        return _UNITS[self.measurement.kind]

    @property
    def rms(self) -> float:
        """Root mean square of the residual; rows that cannot be compared are NaN and left out."""
        return float(np.sqrt(np.nanmean(self.residual**2)))


def gap(built: Built, measurement: Measurement, disc: int = 0) -> Gap:
    """Lay a measured file beside the prediction; ``disc`` of a scan counted from 0.

    Raises
    ------
    MeasurementError
        If the file cannot be of this reducer at all.
    """
    compare = {
        "profile_scan": _scan_gap,
        "hysteresis": _loop_gap,
        "transmission_error": _transmission_gap,
        "lost_motion_map": _lost_motion_gap,
    }[measurement.kind]
    return compare(built, measurement, disc)


def _scan_gap(built: Built, measurement: Measurement, disc: int) -> Gap:
    if not 0 <= disc < built.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {built.discs} discs", "count from 1")
    tooth = built.teeth[disc]
    points: ComplexArray = measurement["x_mm"] + 1j * measurement["y_mm"]
    free = measurement.keys.get("datum", "bore") == "free"
    shift, turn = (complex(np.mean(points)) if free else 0j), 0.0
    turn = _coarse_turn(tooth, points - shift)
    for _ in range(_ROUNDS):
        placed = (points - shift) * np.exp(-1j * turn)
        removal, normal, lever = _deviation(tooth, placed)
        columns = [lever, normal.real, normal.imag] if free else [lever]
        change, *_ = np.linalg.lstsq(np.stack(columns, axis=1), -removal, rcond=None)
        turn += float(change[0])
        if free:
            shift += complex(change[1], change[2]) * np.exp(1j * turn)
        if float(np.max(np.abs(change))) < 1e-11:
            break
    placed = (points - shift) * np.exp(-1j * turn)
    removal, _, _ = _deviation(tooth, placed)
    worst = float(np.max(np.abs(removal)))
    if not worst < _LARGEST_SCAN_GAP:
        raise MeasurementError(
            f"{measurement.name}: largest distance from the tooth",
            f"{worst:.3f} mm",
            f"is more than {_LARGEST_SCAN_GAP} mm",
            "check unit, tooth count and drive: this is a scan of another disc",
        )
    residual = removal / UM
    removed = {"turn_deg": turn / DEGREE}
    if free:
        removed |= {"x_um": shift.real / UM, "y_um": shift.imag / UM}
    stated = measurement.number("noise_um")
    return Gap(
        built, measurement, "polar angle [°]", np.angle(placed) / DEGREE, residual, _noise(residual, stated), removed
    )


def _deviation(tooth: ToothProfile, points: ComplexArray) -> tuple[FloatArray, ComplexArray, FloatArray]:
    """Removal at each point [mm], the normal there, and the lever of a turn about the origin [mm]."""
    lobe_angle = 2.0 * math.pi / tooth.trochoid.lobes
    lobe = np.round(-np.angle(points) / lobe_angle)
    spin = np.exp(1j * lobe * lobe_angle)
    in_lobe = points * spin
    psi = np.linspace(-math.pi, math.pi, _TABLE)
    start = np.interp(-np.angle(in_lobe), -np.angle(tooth.at(psi).position), psi)
    which = None if tooth.lobes_alike else np.mod(lobe, tooth.trochoid.lobes)
    foot, side = nearest_foot(tooth, in_lobe, start, which)
    found = tooth.at(foot, side, which)
    away = in_lobe - found.position
    removal: FloatArray = -(np.conj(found.normal) * away).real
    lever: FloatArray = (np.conj(found.position) * found.normal).imag
    return removal, found.normal * np.conj(spin), lever


def _coarse_turn(tooth: ToothProfile, points: ComplexArray) -> float:
    """Turn of the scan within a lobe, by the phase of its radius wave [rad]."""
    z_c = tooth.trochoid.lobes
    radius = np.abs(points)
    wave = np.mean((radius - np.mean(radius)) * np.exp(-1j * z_c * np.angle(points)))
    # Unturned, the radius is least at angle 0 and every lobe on, so that the wave is negative there.
    return float(np.angle(-np.conj(wave)) / z_c)


def _transmission_gap(built: Built, measurement: Measurement, disc: int) -> Gap:
    del disc
    angle = measurement["output_angle_deg"] * DEGREE
    torque = _torque(measurement)
    predicted = _rotation(built, angle, np.full(angle.size, torque)) / ARCSEC
    return _curve(built, measurement, "output angle [°]", angle / DEGREE, measurement["error_arcsec"] - predicted)


def _lost_motion_gap(built: Built, measurement: Measurement, disc: int) -> Gap:
    del disc
    angle = measurement["output_angle_deg"] * DEGREE
    torque = np.full(angle.size, _torque(measurement))
    predicted = (_rotation(built, angle, torque) - _rotation(built, angle, -torque)) / ARCMIN
    residual = measurement["lost_motion_arcmin"] - predicted
    return _curve(built, measurement, "output angle [°]", angle / DEGREE, residual, offset=False)


def _loop_gap(built: Built, measurement: Measurement, disc: int) -> Gap:
    del disc
    torque = measurement["torque_nm"] * NEWTON_METRE
    angle = (measurement.number("output_angle_deg") or 0.0) * DEGREE
    # The first row of a loop that starts at zero follows a push the other way.
    before = -1.0 if torque[min(1, torque.size - 1)] >= torque[0] else 1.0
    left = stage_torque(torque, built.coulomb_torque, built.proportional_friction, before)
    afloat = np.abs(left) < _AFLOAT * abs(built.case.torque)
    pressed = np.where(afloat, _AFLOAT * abs(built.case.torque), left)
    predicted = _rotation(built, np.full(torque.size, angle), pressed, series_torque=left) / ARCMIN
    residual = np.where(afloat, np.nan, measurement["angle_arcmin"] - predicted)
    return _curve(built, measurement, "row of the loop", np.arange(float(torque.size)), residual)


def _curve(
    built: Built, measurement: Measurement, axis: str, where: FloatArray, residual: FloatArray, offset: bool = True
) -> Gap:
    if np.all(np.isnan(residual)):
        raise SolveError(measurement.name, "without", "an equilibrium to compare with", "make the effects smaller", " ")
    removed: dict[str, float] = {}
    if offset:
        zero = float(np.nanmean(residual))
        residual, removed = residual - zero, {f"zero_{_UNITS[measurement.kind]}": zero}
    stated = measurement.number(f"noise_{_UNITS[measurement.kind]}")
    return Gap(built, measurement, axis, where, residual, _noise(residual, stated), removed)


def _rotation(
    built: Built, output_angle: FloatArray, torque: FloatArray, series_torque: FloatArray | None = None
) -> FloatArray:
    """Angle read at each output angle and torque [rad]."""
    crank = -output_angle * built.case.drive.trochoid.lobes
    solved = StageEquilibrium(as_built=built.parts).at(built.case, crank, torque)
    turned = np.where(solved.settled, solved.rotation, np.nan)
    through = torque if series_torque is None else series_torque
    read: FloatArray = turned + built.series_compliance * through + (built.encoder * np.exp(-1j * output_angle)).real
    return read


def _torque(measurement: Measurement) -> float:
    torque = (measurement.number("torque_nm") or 0.0) * NEWTON_METRE
    if torque == 0.0:
        raise MeasurementError(
            f"{measurement.name}: torque_nm", 0, "leaves the angle undefined within the backlash", "measure under load"
        )
    return torque


def _noise(residual: FloatArray, stated: float | None) -> float:
    """White noise: the stated one, or from third differences of neighbours, which a smooth effect hardly shows."""
    if stated is not None:
        return stated
    third = np.diff(residual, 3)
    third = third[np.isfinite(third)]
    # The median of |x| over σ is 0.6745, and third differences of white noise have variance 20.
    return float(np.median(np.abs(third)) / 0.6745 / math.sqrt(20.0)) if third.size else math.nan
