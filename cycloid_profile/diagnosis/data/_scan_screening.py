"""Refusal of scans in a wrong unit, of another disc, about another origin, or with the ball of the probe left on."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import numpy as np

from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import Measurement
from cycloid_profile.modification import Equidistant
from cycloid_profile.rig import register_scan

_RATIO_TOLERANCE = 0.03  # relative tolerance for the ratio of two units
_LEAST_PER_LOBE = 8  # points: four on each flank
_MOST_LOBES = 400  # beyond any cycloid disc
# Median distances beyond any grinding error: of the points from the tooth, and about their median.
_ANOTHER_DISC = 0.05  # mm
_ANOTHER_FORM = 0.025  # mm
_PLAIN = re.compile(r"[\w=.,-]+")  # what every shell takes as one word
_LENGTHS = {1.0 / 25.4: "inch", 1e3: "µm", 1e-3: "m", 0.1: "cm"}
_OPTION_UNITS = {"µm": "um"}
# Radii of balls of common styli [mm]; a ball that was not compensated moves every point outwards by its radius.
_PROBE_RADII = (0.15, 0.25, 0.3, 0.35, 0.4, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0)


def screen_scan(reducer: AsBuiltReducer, measurement: Measurement) -> None:
    """Raise ``MeasurementError`` if a scan is not one of this disc in mm."""
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    trochoid = reducer.case.drive.trochoid
    points = np.unique(z).size
    if points < _LEAST_PER_LOBE * trochoid.lobes // 4:
        raise refusal(
            measurement, "points", points, f"are too few for {trochoid.lobes} lobes",
            f"scan at least {_LEAST_PER_LOBE} points on a lobe, on a quarter of the lobes",
        )  # fmt: skip
    distance, spread = _distance(reducer, measurement)
    if _fits((distance, spread)):
        return
    hint = _likely_cause(reducer, measurement)
    if hint is not None:
        raise hint
    _check_size(reducer, measurement, z)
    if not math.isfinite(distance):
        raise refusal(
            measurement, "the points", "lie", "nowhere near the tooth",
            "check drive, origin and whether the radius of the ball is taken off: this is a scan of another disc", " ",
        )  # fmt: skip
    far, limit, of = (
        (distance, _ANOTHER_DISC, "median distance from the tooth")
        if distance >= _ANOTHER_DISC
        else (spread, _ANOTHER_FORM, "median deviation from the form of the tooth")
    )
    raise refusal(
        measurement, of, f"{far:.3f} mm", f"is more than {limit:g} mm",
        "check eccentricity, pins and modification of the spec: this is a scan of another disc",
    )  # fmt: skip


def _check_size(reducer: AsBuiltReducer, measurement: Measurement, z: np.ndarray) -> None:
    """Raise ``MeasurementError`` if radius or number of lobes of the points ``z`` [mm] are not those of this disc."""
    trochoid = reducer.case.drive.trochoid
    if measurement.keys.get("datum") == "free":
        z = z - _centre(z)
    radius = np.abs(z)
    drawn = np.abs(reducer.case.profile.at(np.linspace(0.0, 2.0 * np.pi, 361)).position)
    middle = float(np.median(radius))
    ratio = middle / float(np.median(drawn))
    for factor, unit in _LENGTHS.items():
        if abs(ratio / factor - 1.0) < _RATIO_TOLERANCE:
            raise refusal(
                measurement, "median radius", f"{middle:.5g}", f"is that of this disc in {unit}, not in mm",
                f"convert the columns to mm{option(measurement, f'unit={_OPTION_UNITS.get(unit, unit)}')}",
            )  # fmt: skip
    if abs(ratio - 1.0) > _RATIO_TOLERANCE:
        raise refusal(
            measurement, "median radius", f"{middle:.5g} mm",
            f"is not that of this disc, {drawn.min():.3f} to {drawn.max():.3f} mm",
            "check drive, unit and origin: this is a scan of another disc",
        )  # fmt: skip
    lobes = _count_lobes(z)
    if lobes != trochoid.lobes:
        raise refusal(
            measurement, "lobes", lobes, f"are not the {trochoid.lobes} of this drive",
            "check drive and tooth count: this is a scan of another disc",
        )  # fmt: skip


def _likely_cause(reducer: AsBuiltReducer, measurement: Measurement) -> MeasurementError | None:
    """The refusal of a scan that fits about another origin, or at the radius of a probe from the tooth; else None."""
    z = measurement["x_mm"] + 1j * measurement["y_mm"]
    centred, nominal = z - _centre(z), reducer.case.profile
    if _count_lobes(centred) != nominal.trochoid.lobes:
        return None
    else_another = ", else this is a scan of another disc"
    free = replace(measurement, keys={**measurement.keys, "datum": "free"})
    if not measurement.datum_free and _fits(_distance(reducer, free)):
        off = abs(register_scan(nominal, free).shift)
        remedy = f"state '# datum: free'{option(measurement, 'datum=free')}{else_another}"
        return refusal(measurement, "origin", f"{off:.3f} mm", "off the bore axis fits the tooth", remedy)
    drawn = np.abs(nominal.at(np.linspace(0.0, 2.0 * np.pi, 361)).position)
    larger = float(np.median(np.abs(centred)) - np.median(drawn))
    # The normals of the flanks lean away from the radius: the points grow by a part of the ball's radius.
    for radius in (r for r in _PROBE_RADII if larger < 1.1 * r < 4.0 * larger and r < nominal.pin_radius):
        if _fits(_distance(reducer, measurement, radius)):
            remedy = f"remove it along the normals{option(measurement, f'probe_radius_mm={radius:g}')}{else_another}"
            limit = "outside the tooth all round is the radius of a likely probe"
            return refusal(measurement, "distance", f"{radius:g} mm", limit, remedy)
    return None


def screen_deviations(reducer: AsBuiltReducer, given: Measurement) -> None:
    """Raise ``MeasurementError`` if the coordinates of a refused file fit the tooth and the deviations next to them do
    not: their unit is another one. ``given``: the file before the deviations were added."""
    steps = given.pending
    if steps is None or steps.deviation is None or not _fits(_distance(reducer, replace(given, pending=None))):
        return
    size = float(np.sqrt(np.mean(steps.deviation**2)))
    found = column_of(given, "deviation")
    stated = option(given, f"deviation={found[2]}[um]") if found else ""
    limit = "do not belong to these coordinates, which fit the tooth"
    remedy = f"check the unit of the deviations{stated}"
    raise refusal(given, "deviations", f"of {size:.4g} mm rms", limit, remedy, " ")


def _fits(found: tuple[float, float]) -> bool:
    return found[0] < _ANOTHER_DISC and found[1] < _ANOTHER_FORM


def _distance(reducer: AsBuiltReducer, measurement: Measurement, outside: float = 0.0) -> tuple[float, float]:
    """Median distance of the points from the disc that fits best, and their median deviation about the median distance
    [mm]. Both are infinite if no disc fits. ``outside``: distance of a parallel curve that takes the place of the tooth
    [mm]."""
    best = (math.inf, math.inf)
    for nominal in {id(tooth): tooth for tooth in reducer.teeth}.values():
        tooth = Equidistant(-outside).apply(nominal) if outside else nominal
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
    orders = np.arange(3, min(_MOST_LOBES, z.size // 2) + 1)  # more cannot be distinguished from fewer
    anomaly = radius - np.mean(radius)
    wave = np.exp(-1j * angle)
    rotated = wave**2
    strength = np.empty(orders.size)
    for i in range(orders.size):
        rotated = rotated * wave
        strength[i] = abs(anomaly @ rotated)
    return int(orders[int(np.argmax(strength))])


def column_of(measurement: Measurement, role: str) -> re.Match[str] | None:
    """Quantity, column and unit in brackets that a file of another program was read by; ``role`` is a pattern."""
    return re.search(rf"\b({role})=([^,;\[\]]+)(\[[^\]]*\])?(?=[,;])", " ".join(measurement.notes))


def option(measurement: Measurement, text: str) -> str:
    """How to say it on the command line, for a file of another program; in quotes where a shell needs them."""
    quoted = text if _PLAIN.fullmatch(text) else f"'{text}'"
    return f", or add --columns {quoted}" if measurement.notes else ""


def refusal(
    measurement: Measurement, what: str, value: object, limit: str, remedy: str, joint: str = " = "
) -> MeasurementError:
    """The error about a file; for one of another program it says how the file was understood."""
    if measurement.notes:
        remedy = f"{remedy} (the file was {measurement.notes[0]})"
    return MeasurementError(f"{measurement.name}: {what}", value, limit, remedy, joint)
