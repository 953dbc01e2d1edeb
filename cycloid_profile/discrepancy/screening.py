"""Mistakes in a measured file that no effect explains: another unit, another drive, rows in disorder.

Told in one sentence each, before anything is fitted.
"""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.gap import COLUMN
from cycloid_profile.rig.prediction import predict_curve
from cycloid_profile.units import NEWTON_METRE

_LEAST_PER_LOBE = 8
_NEAR = 0.03  # of a size: within that a ratio is taken for the one of two units
_MOST_LOBES = 400
_FAR = 25.0  # times more or less than predicted: no reducer, a unit
_LENGTHS = {1.0 / 25.4: "inch", 1e3: "µm", 1e-3: "m", 0.1: "cm"}
_ANGLES = {
    "hysteresis": {60.0: "arcsec", 1.0 / 60.0: "degrees", math.radians(1.0 / 60.0): "rad"},
    "lost_motion_map": {60.0: "arcsec", 1.0 / 60.0: "degrees", math.radians(1.0 / 60.0): "rad"},
}
_UNIT_NAMES = {"hysteresis": "arcmin", "lost_motion_map": "arcmin"}


def screen(built: Built, measurement: Measurement) -> None:
    """Raise ``MeasurementError`` where a file cannot be what it says."""
    if measurement.kind == "profile_scan":
        _scan(built, measurement)
        return
    if measurement.kind == "hysteresis":
        _loop(built, measurement)
    else:
        _turn(measurement)
    if measurement.kind in _ANGLES:
        _angles(built, measurement)


def _scan(built: Built, measurement: Measurement) -> None:
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    trochoid = built.case.drive.trochoid
    if z.size < _LEAST_PER_LOBE * trochoid.lobes // 4:
        raise _wrong(
            measurement, "points", z.size, f"are too few for {trochoid.lobes} lobes",
            f"scan at least {_LEAST_PER_LOBE} points on a lobe, on a quarter of the lobes",
        )  # fmt: skip
    if measurement.keys.get("datum") == "free":
        z = z - _centre(z)
    radius = np.abs(z)
    drawn = np.abs(built.case.profile.at(np.linspace(0.0, 2.0 * np.pi, 361)).position)
    middle = float(np.median(radius))
    ratio = middle / float(np.median(drawn))
    for factor, unit in _LENGTHS.items():
        if abs(ratio / factor - 1.0) < _NEAR:
            raise _wrong(
                measurement, "median radius", f"{middle:.5g}", f"is that of this disc in {unit}, not in mm",
                "convert the columns to mm",
            )  # fmt: skip
    if abs(ratio - 1.0) > _NEAR:
        raise _wrong(
            measurement, "median radius", f"{middle:.5g} mm",
            f"is not that of this disc, {drawn.min():.3f} to {drawn.max():.3f} mm",
            "check drive, unit and origin: this is a scan of another disc",
        )  # fmt: skip
    lobes = _count_lobes(z)
    if lobes != trochoid.lobes:
        raise _wrong(
            measurement, "lobes", lobes, f"are not the {trochoid.lobes} of this drive",
            "check drive and tooth count: this is a scan of another disc",
        )  # fmt: skip


def _centre(z: np.ndarray) -> complex:
    """Centre of the circle that fits best, for scans that do not go all the way round."""
    A = np.stack([z.real, z.imag, np.ones(z.size)], axis=1)
    x, y, _ = np.linalg.lstsq(A, np.abs(z) ** 2, rcond=None)[0]
    return complex(0.5 * x, 0.5 * y)


def _count_lobes(z: np.ndarray) -> int:
    """The strongest wave of the radius round the disc."""
    angle, radius = np.angle(z), np.abs(z)
    orders = np.arange(3, _MOST_LOBES + 1)
    anomaly = radius - np.mean(radius)
    wave = np.exp(-1j * angle)
    turned = wave**2
    strength = np.empty(orders.size)
    for i in range(orders.size):
        turned = turned * wave
        strength[i] = abs(np.sum(anomaly * turned))
    return int(orders[int(np.argmax(strength))])


def _loop(built: Built, measurement: Measurement) -> None:
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    rated = abs(built.case.torque) / NEWTON_METRE
    peak = float(np.max(np.abs(torque)))
    if peak > 20.0 * rated:
        raise _wrong(
            measurement, "largest torque", f"{peak:.5g} N·m", f"is over 20 times the rated {rated:.5g} N·m",
            "check the unit, which may be N·mm, and the drive",
        )  # fmt: skip
    if peak < 0.05 * rated:
        raise _wrong(
            measurement, "largest torque", f"{peak:.5g} N·m", f"is below 5 % of the rated {rated:.5g} N·m",
            "check the unit, which may be kN·m, or load the reducer further",
        )  # fmt: skip
    step = float(np.median(np.abs(np.diff(torque))))
    if step > 0.15 * np.ptp(torque):
        raise _wrong(
            measurement, "torque", f"jumps by {step:.4g} N·m from row to row", "which no loop does",
            "give the rows in the order of measurement", " ",
        )  # fmt: skip
    stiffness = float(np.polyfit(torque, angle, 1)[0])
    if stiffness < 0.0:
        raise _wrong(
            measurement, "angle", "falls as the torque rises", "which no reducer does",
            "check the signs of torque and angle", " ",
        )  # fmt: skip


def _turn(measurement: Measurement) -> None:
    angle = measurement["output_angle_deg"]
    span = float(np.ptp(angle))
    if span > 10.0 * 360.0:
        raise _wrong(
            measurement, "output angle", f"spans {span:.5g}°", "which is more than ten turns",
            "check the unit, which may be arcmin, or give one turn", " ",
        )  # fmt: skip
    if angle.size > 50 and abs(span / (2.0 * math.pi) - 1.0) < _NEAR:
        raise _wrong(
            measurement, "output angle", f"spans {span:.5g}", "which is one turn in rad, not in degrees",
            "convert the column to degrees", " ",
        )  # fmt: skip
    if measurement.kind == "transmission_error":
        error = measurement["error_arcsec"]
        rms = float(np.std(error))
        if rms < 1e-3:
            raise _wrong(
                measurement, "transmission error", f"{rms:.3g} rms", "is smaller than any encoder sees in arcsec",
                "check the unit, which may be rad or degrees",
            )  # fmt: skip
        if rms > 3600.0:
            raise _wrong(
                measurement, "transmission error", f"{rms:.4g}″ rms", "is over a degree",
                "check the unit, and that the column holds the error and not the angle",
            )  # fmt: skip


def _angles(built: Built, measurement: Measurement) -> None:
    measured = measurement[COLUMN[measurement.kind]]
    predicted = predict_curve(built, measurement).value
    if measurement.kind == "hysteresis":
        ratio = float(np.ptp(measured) / np.nanmax([np.nanmax(predicted) - np.nanmin(predicted), 1e-9]))
    else:
        ratio = float(np.median(measured) / np.nanmedian(predicted))
    if 1.0 / _FAR < abs(ratio) < _FAR:
        return
    units = _ANGLES[measurement.kind]
    likely = min(units, key=lambda factor: abs(math.log(abs(ratio) / factor)) if ratio else math.inf)
    raise _wrong(
        measurement, "angle", f"is {ratio:.3g} times what the simulation gives", "which is no reducer but a unit",
        f"check the column, which must be in {_UNIT_NAMES[measurement.kind]}; it may be in {units[likely]}", " ",
    )  # fmt: skip


def _wrong(
    measurement: Measurement, what: str, value: object, limit: str, remedy: str, joint: str = " = "
) -> MeasurementError:
    return MeasurementError(f"{measurement.name}: {what}", value, limit, remedy, joint)
