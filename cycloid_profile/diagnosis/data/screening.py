"""Refusal of files with wrong units, of another drive, or with unordered rows, before any fit."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN, TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import LEAST_COMPARED_SHARE, predict_curve, register_scan
from cycloid_profile.units import ARCMIN, NEWTON_METRE

_LEAST_PER_LOBE = 8  # points: four on each flank
_RATIO_TOLERANCE = 0.03  # relative tolerance for the ratio of two units
_MOST_LOBES = 400  # beyond any cycloid disc
# Median distances beyond any grinding error: of the points from the tooth, and about their median.
_ANOTHER_DISC = 0.05  # mm
_ANOTHER_FORM = 0.025  # mm
_MEDIAN_ROWS = 64  # rows solved for a check of the unit: a median needs no more
_LARGEST_RATIO = 25.0  # times the prediction: a larger twist indicates another unit
_CLEARANCE = 0.05  # mm of clearance on each flank that is accepted beyond that
_LEAST_TWIST = 0.35  # share of the elastic twist; covers rigid bearings and large friction
_OVERLOAD = 20.0  # times the rated torque
_LEAST_ERROR = 0.01  # arcsec rms; no encoder resolves less
_LEAST_ROWS = 12  # three for each quarter of a loop
_LENGTHS = {1.0 / 25.4: "inch", 1e3: "µm", 1e-3: "m", 0.1: "cm"}
_UNITS = {60.0: "arcsec", 1.0 / 60.0: "degrees", math.radians(1.0 / 60.0): "rad"}  # of a twist, in arcmin


def screen(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    """Raise ``MeasurementError`` if a file contradicts its header or the drive."""
    if measurement.kind is PROFILE_SCAN:
        _scan(reducer, measurement)
        return
    if measurement.kind is HYSTERESIS:
        _loop(reducer, measurement)
    else:
        _turn(reducer, measurement)
    if measurement.kind.unit == "arcmin":
        _angles(reducer, measurement)


def _scan(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    trochoid = reducer.case.drive.trochoid
    points = np.unique(z).size
    if points < _LEAST_PER_LOBE * trochoid.lobes // 4:
        raise _wrong(
            measurement, "points", points, f"are too few for {trochoid.lobes} lobes",
            f"scan at least {_LEAST_PER_LOBE} points on a lobe, on a quarter of the lobes",
        )  # fmt: skip
    distance, spread = _distance(reducer, measurement)
    if distance < _ANOTHER_DISC and spread < _ANOTHER_FORM:
        return
    if measurement.keys.get("datum") == "free":
        z = z - _centre(z)
    radius = np.abs(z)
    drawn = np.abs(reducer.case.profile.at(np.linspace(0.0, 2.0 * np.pi, 361)).position)
    middle = float(np.median(radius))
    ratio = middle / float(np.median(drawn))
    for factor, unit in _LENGTHS.items():
        if abs(ratio / factor - 1.0) < _RATIO_TOLERANCE:
            raise _wrong(
                measurement, "median radius", f"{middle:.5g}", f"is that of this disc in {unit}, not in mm",
                "convert the columns to mm",
            )  # fmt: skip
    if abs(ratio - 1.0) > _RATIO_TOLERANCE:
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
    if not math.isfinite(distance):
        raise _wrong(
            measurement, "the points", "lie", "nowhere near the tooth",
            "check drive, origin and whether the radius of the ball is taken off: this is a scan of another disc", " ",
        )  # fmt: skip
    far, limit, of = (
        (distance, _ANOTHER_DISC, "median distance from the tooth")
        if distance >= _ANOTHER_DISC
        else (spread, _ANOTHER_FORM, "median deviation from the form of the tooth")
    )
    raise _wrong(
        measurement, of, f"{far:.3f} mm", f"is more than {limit:g} mm",
        "check eccentricity, pins and modification of the spec: this is a scan of another disc",
    )  # fmt: skip


def _distance(reducer: AsBuiltReducer, measurement: Measurement) -> tuple[float, float]:
    """Median distance of the points from the disc that fits best, and their median deviation about the median distance
    [mm]. Both are infinite if no disc fits."""
    best = (math.inf, math.inf)
    for tooth in {id(tooth): tooth for tooth in reducer.teeth}.values():
        try:
            with np.errstate(all="ignore"):
                removal = register_scan(tooth, measurement).removal
        except (MeasurementError, np.linalg.LinAlgError):
            continue
        found = float(np.median(np.abs(removal))), float(np.median(np.abs(removal - np.median(removal))))
        best = min(best, found)
    return best


def _centre(z: np.ndarray) -> complex:
    """Centre of the least-squares circle, also for incomplete scans."""
    A = np.stack([z.real, z.imag, np.ones(z.size)], axis=1)
    x, y, _ = np.linalg.lstsq(A, np.abs(z) ** 2, rcond=None)[0]
    return complex(0.5 * x, 0.5 * y)


def _count_lobes(z: np.ndarray) -> int:
    """Number of lobes: the strongest order of the radius round the disc."""
    angle, radius = np.angle(z), np.abs(z)
    orders = np.arange(3, _MOST_LOBES + 1)
    anomaly = radius - np.mean(radius)
    wave = np.exp(-1j * angle)
    rotated = wave**2
    strength = np.empty(orders.size)
    for i in range(orders.size):
        rotated = rotated * wave
        strength[i] = abs(np.sum(anomaly * rotated))
    return int(orders[int(np.argmax(strength))])


def _loop(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    rated = abs(reducer.case.torque) / NEWTON_METRE
    peak = float(np.max(np.abs(torque)))
    _overload(reducer, measurement, "largest torque", peak)
    if torque.size < _LEAST_ROWS:
        raise _wrong(
            measurement, "rows", torque.size, f"are fewer than {_LEAST_ROWS}", "measure the loop in smaller steps"
        )
    if peak < 0.05 * rated:
        raise _wrong(
            measurement, "largest torque", f"{peak:.5g} N·m", f"is below 5 % of the rated {rated:.5g} N·m",
            "check the unit, which may be kN·m, or load the reducer further",
        )  # fmt: skip
    if np.ptp(torque) < 0.05 * rated:
        raise _wrong(
            measurement, "torque", "hardly changes,", "so that nothing is loaded and relieved",
            "give a loop of 0 → +T → −T → +T", " ",
        )  # fmt: skip
    step = float(np.median(np.abs(np.diff(torque))))
    if step > 0.15 * np.ptp(torque):
        raise _wrong(
            measurement, "torque", f"jumps by {step:.4g} N·m from row to row,", "which no loop does",
            "give the rows in the order of measurement", " ",
        )  # fmt: skip
    stiffness = float(np.polyfit(torque, angle, 1)[0])
    if stiffness < 0.0:
        raise _wrong(
            measurement, "angle", "falls as the torque rises,", "which no reducer does",
            "check the signs of torque and angle", " ",
        )  # fmt: skip


def _overload(reducer: AsBuiltReducer, measurement: Measurement, what: str, torque: float) -> None:
    rated = abs(reducer.case.torque) / NEWTON_METRE
    if abs(torque) > _OVERLOAD * rated:
        raise _wrong(
            measurement, what, f"{torque:.5g} N·m", f"is over {_OVERLOAD:g} times the rated {rated:.5g} N·m",
            "check the unit, which may be N·mm, and the drive",
        )  # fmt: skip


def _turn(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    _overload(reducer, measurement, "torque_nm", measurement.number("torque_nm") or 0.0)
    angle = measurement["output_angle_deg"]
    span = float(np.ptp(angle))
    if span > 10.0 * 360.0:
        raise _wrong(
            measurement, "output angle", f"spans {span:.5g}°,", "which is more than ten revolutions",
            "check the unit, which may be arcmin, or give one revolution", " ",
        )  # fmt: skip
    if angle.size > 50 and abs(span / (2.0 * math.pi) - 1.0) < _RATIO_TOLERANCE:
        raise _wrong(
            measurement, "output angle", f"spans {span:.5g},", "which is one revolution in rad, not in degrees",
            "convert the column to degrees", " ",
        )  # fmt: skip
    if measurement.kind is TRANSMISSION_ERROR:
        error = measurement["error_arcsec"]
        rms = float(np.std(error))
        if rms < _LEAST_ERROR and rms < max(
            0.1 * _LEAST_ERROR, 0.3 * float(np.nanstd(predict_curve(reducer, measurement).value))
        ):
            raise _wrong(
                measurement, "transmission error", f"{rms:.3g} rms", "is smaller than any encoder sees in arcsec",
                "check the unit, which may be rad or degrees",
            )  # fmt: skip
        if rms > 3600.0:
            raise _wrong(
                measurement, "transmission error", f"{rms:.4g}″ rms", "is over a degree",
                "check the unit, and that the column holds the error and not the angle",
            )  # fmt: skip


def _angles(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    """Raise ``MeasurementError`` for angles in a wrong unit: beyond any clearance, or below the elastic twist."""
    # A map is compared by its median, which a sample of rows gives; a loop by its range.
    count = measurement.value.size
    loop = measurement.kind is HYSTERESIS
    rows = np.arange(0, count, 1 if loop else max(count // _MEDIAN_ROWS, 1))
    measured, predicted = measurement.value[rows], predict_curve(reducer, measurement, rows).value
    there = np.isfinite(predicted)
    if not np.any(there):
        return
    if loop:
        found, expected = float(np.ptp(measured)), float(np.ptp(predicted[there]))
        least = _LEAST_TWIST * _elastic(measurement["torque_nm"], predicted)
    else:
        found, expected = float(np.median(measured)), float(np.median(predicted[there]))
        if found * expected < 0.0:
            raise _wrong(
                measurement, "lost motion", f"is {found:.4g}′ at a torque that makes it {expected:.4g}′,",
                "so that load would rotate the output back", "give the angle at +torque minus that at −torque", " ",
            )  # fmt: skip
        found, expected = abs(found), abs(expected)
        least = expected / _LARGEST_RATIO
    most = _LARGEST_RATIO * expected + 2.0 * _CLEARANCE / reducer.case.drive.trochoid.longest_lever / ARCMIN
    if least <= found <= most:
        return
    ratio = found / max(expected, 1e-9)
    likely = min(_UNITS, key=lambda factor: abs(math.log(ratio / factor)) if ratio else math.inf)
    unit = f"; it may be in {_UNITS[likely]}" if ratio else ""
    raise _wrong(
        measurement, "angle", f"is {ratio:.3g} times what the simulation gives,", "which is no reducer but a unit",
        f"check the column, which must be in arcmin{unit}", " ",
    )  # fmt: skip


def _elastic(torque: np.ndarray, predicted: np.ndarray) -> float:
    """Elastic twist of a predicted loop: the sum of both flanks, without backlash."""
    twist = 0.0
    for side in (1.0, -1.0):
        loaded = np.isfinite(predicted) & (side * torque > LEAST_COMPARED_SHARE * np.max(np.abs(torque)))
        if np.count_nonzero(loaded) > 1:
            twist += float(np.ptp(predicted[loaded]))
    return twist


def _wrong(
    measurement: Measurement, what: str, value: object, limit: str, remedy: str, joint: str = " = "
) -> MeasurementError:
    return MeasurementError(f"{measurement.name}: {what}", value, limit, remedy, joint)
