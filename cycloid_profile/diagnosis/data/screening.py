"""Refusal of files with wrong units, of another drive, with unordered rows, or given twice, before any fit.

These are the rules of every command that reads measured files.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cycloid_profile.diagnosis.data._scan_screening import column_of, option, refusal, screen_deviations, screen_scan
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN, TRANSMISSION_ERROR, Measurement
from cycloid_profile.rig import LEAST_COMPARED_SHARE, predict_curve, tooth_points
from cycloid_profile.units import ARCMIN, NEWTON_METRE

_RATIO_TOLERANCE = 0.03  # relative tolerance for the ratio of two units
_MEDIAN_ROWS = 64  # rows solved for a check of the unit: a median needs no more
_OPTION_ANGLES = {60.0: "arcsec", 1.0 / 60.0: "deg", math.radians(1.0 / 60.0): "rad"}
_LARGEST_RATIO = 25.0  # times the prediction: a larger twist indicates another unit
_CLEARANCE = 0.05  # mm of clearance on each flank that is accepted beyond that
_LEAST_TWIST = 0.35  # share of the elastic twist; covers rigid bearings and large friction
_OVERLOAD = 20.0  # times the rated torque
_LEAST_ERROR = 0.01  # arcsec rms; no encoder resolves less
_LEAST_ROWS = 12  # three for each quarter of a loop
LEAST_ANGLES = 8  # rows at different output angles
_UNITS = {60.0: "arcsec", 1.0 / 60.0: "degrees", math.radians(1.0 / 60.0): "rad"}  # of a twist, in arcmin


def screen_files(
    reducer: AsBuiltReducer, measurements: Sequence[Measurement], held_out: Sequence[Measurement] = ()
) -> tuple[list[Measurement], list[Measurement]]:
    """The files and the ``held_out`` ones as points of the tooth, ready to be compared.

    Raises ``MeasurementError`` if a file was given twice, also as held out, or ``screen`` refuses one.
    """
    files = [tooth_points(reducer, measurement) for measurement in (*measurements, *held_out)]
    for number, second in enumerate(files):
        for first in files[:number]:
            if _same_rows(first, second):
                remedy = "name each file once" if number < len(measurements) else "hold out another file"
                raise refusal(second, "rows", "are", f"those of {first.name or 'another file'}", remedy, " ")
    for given, measurement in zip((*measurements, *held_out), files, strict=True):
        try:
            screen(reducer, measurement)
        except MeasurementError:
            screen_deviations(reducer, given)
            raise
    return files[: len(measurements)], files[len(measurements) :]


def require_new_rows(before: Sequence[Measurement], after: Sequence[Measurement]) -> None:
    """Raise ``MeasurementError`` where a file of one time is that of the other: the change would be certain, and 0."""
    for one in before:
        for other in after:
            if _same_rows(one, other):
                raise refusal(one, "rows", "are", f"those of {other.name}", "name the file of the other time", " ")


def _same_rows(first: Measurement, second: Measurement) -> bool:
    return first.kind is second.kind and all(np.array_equal(first[name], second[name]) for name in first.kind.columns)


def screen(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    """Raise ``MeasurementError`` if a file contradicts its header or the drive."""
    if measurement.kind is PROFILE_SCAN:
        screen_scan(reducer, measurement)
        return
    if measurement.kind is HYSTERESIS:
        _loop(reducer, measurement)
    else:
        _turn(reducer, measurement)
    if measurement.kind.unit == "arcmin":
        _angles(reducer, measurement)


def _inverted(measurement: Measurement) -> str:
    """The option that inverts the measured column of a file of another program."""
    role = "angle|output_angle" if measurement.kind is HYSTERESIS else "lost_motion"
    found = column_of(measurement, role)
    return option(measurement, f"{found[1]}=-{found[2]}{found[3] or ''}") if found else ""


def _loop(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    rated = abs(reducer.case.torque) / NEWTON_METRE
    peak = float(np.max(np.abs(torque)))
    _overload(reducer, measurement, "largest torque", peak)
    if torque.size < _LEAST_ROWS:
        raise refusal(
            measurement, "rows", torque.size, f"are fewer than {_LEAST_ROWS}", "measure the loop in smaller steps"
        )
    if peak < 0.05 * rated:
        raise refusal(
            measurement, "largest torque", f"{peak:.5g} N·m", f"is below 5 % of the rated {rated:.5g} N·m",
            "check the unit, which may be kN·m, or load the reducer further",
        )  # fmt: skip
    if np.ptp(torque) < 0.05 * rated:
        raise refusal(
            measurement, "torque", "hardly changes,", "so that nothing is loaded and relieved",
            "give a loop of 0 → +T → −T → +T", " ",
        )  # fmt: skip
    step = float(np.median(np.abs(np.diff(torque))))
    if step > 0.15 * np.ptp(torque):
        raise refusal(
            measurement, "torque", f"jumps by {step:.4g} N·m from row to row,", "which no loop does",
            "give the rows in the order of measurement", " ",
        )  # fmt: skip
    stiffness = float(np.polyfit(torque, angle, 1)[0])
    if stiffness < 0.0:
        raise refusal(
            measurement, "angle", "falls as the torque rises,", "which no reducer does",
            f"check the signs of torque and angle{_inverted(measurement)}", " ",
        )  # fmt: skip


def _overload(reducer: AsBuiltReducer, measurement: Measurement, what: str, torque: float) -> None:
    rated = abs(reducer.case.torque) / NEWTON_METRE
    if abs(torque) > _OVERLOAD * rated:
        raise refusal(
            measurement, what, f"{torque:.5g} N·m", f"is over {_OVERLOAD:g} times the rated {rated:.5g} N·m",
            "check the unit, which may be N·mm, and the drive",
        )  # fmt: skip


def _turn(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    torque = measurement.number("torque_nm") or 0.0
    if torque == 0.0:
        raise refusal(
            measurement, "torque_nm", 0, "leaves the angle undefined within the backlash", "measure under load"
        )
    _overload(reducer, measurement, "torque_nm", torque)
    angle = measurement["output_angle_deg"]
    span = float(np.ptp(angle))
    different = np.unique(angle).size
    if different < LEAST_ANGLES:
        raise refusal(
            measurement, "output angles", different, "are too few to compare",
            f"measure at least {LEAST_ANGLES} angles of one revolution",
        )  # fmt: skip
    if span > 10.0 * 360.0:
        raise refusal(
            measurement, "output angle", f"spans {span:.5g}°,", "which is more than ten revolutions",
            "check the unit, which may be arcmin, or give one revolution", " ",
        )  # fmt: skip
    if angle.size > 50 and abs(span / (2.0 * math.pi) - 1.0) < _RATIO_TOLERANCE:
        raise refusal(
            measurement, "output angle", f"spans {span:.5g},", "which is one revolution in rad, not in degrees",
            "convert the column to degrees", " ",
        )  # fmt: skip
    if measurement.kind is TRANSMISSION_ERROR:
        error = measurement["error_arcsec"]
        rms = float(np.std(error))
        if rms < _LEAST_ERROR and rms < max(
            0.1 * _LEAST_ERROR, 0.3 * float(np.nanstd(predict_curve(reducer, measurement).value))
        ):
            raise refusal(
                measurement, "transmission error", f"{rms:.3g} rms", "is smaller than any encoder sees in arcsec",
                "check the unit, which may be rad or degrees",
            )  # fmt: skip
        if rms > 3600.0:
            raise refusal(
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
            raise refusal(
                measurement, "lost motion", f"is {found:.4g}′ at a torque that makes it {expected:.4g}′,",
                "so that load would rotate the output back",
                f"give the angle at +torque minus that at −torque{_inverted(measurement)}",
                " ",
            )  # fmt: skip
        found, expected = abs(found), abs(expected)
        least = expected / _LARGEST_RATIO
    most = _LARGEST_RATIO * expected + 2.0 * _CLEARANCE / reducer.case.drive.trochoid.longest_lever / ARCMIN
    if least <= found <= most:
        return
    ratio = found / max(expected, 1e-9)
    likely = min(_UNITS, key=lambda factor: abs(math.log(ratio / factor)) if ratio else math.inf)
    stated = option(measurement, f"unit={_OPTION_ANGLES[likely]}")
    unit = f"; it may be in {_UNITS[likely]}{stated}" if ratio else ""
    raise refusal(
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
