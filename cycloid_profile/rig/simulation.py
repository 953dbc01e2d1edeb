"""Measured files as the rig would write them, and their key figures, by kind (docs/rig.md, "Files")."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import singledispatch

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import LoadError, MeasurementError, SolveError
from cycloid_profile.geometry import EqualArc, sample
from cycloid_profile.measurement import (
    Hysteresis,
    LostMotionMap,
    Measurement,
    MeasurementKind,
    ProfileScan,
    TransmissionErrorCurve,
    kind_named,
)
from cycloid_profile.resources import Need
from cycloid_profile.rig.curves_over_turn import (
    MAP_POSES,
    TRANSMISSION_POSES,
    lost_motion_map,
    spectrum,
    transmission_error,
)
from cycloid_profile.rig.hysteresis import LOST_MOTION_SHARE, POINTS, evaluate_loop, hysteresis_loop
from cycloid_profile.rig.prediction import curve_need
from cycloid_profile.units import ARCMIN, DEGREE, NEWTON_METRE

# Fewest rows of a curve, and points of a scan on a lobe, four on each flank.
_LEAST_POINTS, LEAST_POINTS_PER_LOBE = 4, 8
_SCAN_ROW = 500.0  # bytes of memory, with its picture
_SCAN_POINTS = 5000  # 128 a lobe of 39, as of a scanning probe


@dataclass(frozen=True, slots=True)
class Settings:
    """How to measure; None selects the default of the kind.

    ``torque`` [N·mm]; ``output_angle`` of a loop [rad]; ``points``; ``disc`` of a scan, counted from 0; ``noise``, a
    standard deviation in the unit of the kind, with the ``seed`` of its draw.
    """

    torque: float | None = None
    output_angle: float = 0.0
    points: int | None = None
    disc: int = 0
    noise: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for what, value in (("torque", self.torque), ("output angle", self.output_angle)):
            if value is not None and not math.isfinite(value):
                raise MeasurementError(what, value, "is no finite number", f"give a finite {what}")
        if not 0.0 <= self.noise < np.inf:
            raise MeasurementError("noise", self.noise, "is no finite number from 0 on", "give a standard deviation")
        if self.points is not None and self.points < _LEAST_POINTS:
            raise MeasurementError("points", self.points, f"are fewer than {_LEAST_POINTS}", "measure more points")
        if self.seed < 0:
            raise MeasurementError("seed", self.seed, "is negative", "give a whole number from 0 on")

    def noise_of(self, shape: int | tuple[int, int], unit: float = 1.0) -> FloatArray:
        """A draw of the noise, in the unit of the kind times ``unit``."""
        return self.noise * unit * np.random.default_rng(self.seed).normal(0.0, 1.0, shape)


def simulate(reducer: AsBuiltReducer, kind: MeasurementKind | str, settings: Settings | None = None) -> Measurement:
    """The file that the rig would write; ``kind`` may be given by its name.

    Raises ``MeasurementError`` if the kind is not known, ``ResourceError`` if the points need more memory or time than
    allowed, and ``SolveError`` if the reducer finds no equilibrium somewhere.
    """
    wanted = Settings() if settings is None else settings
    kind = kind_named(kind) if isinstance(kind, str) else kind
    rows = wanted.points or 0
    scan = Need("points", rows, "measure fewer points", memory=_SCAN_ROW * rows)
    (curve_need("points", rows, reducer.case) if kind.is_curve else scan).require()
    columns, keys = _readings(kind, reducer, wanted)
    lost = np.count_nonzero(~np.isfinite(np.stack(columns)))
    if lost:
        raise SolveError(f"{lost} rows of the {kind}", "without", "an equilibrium", reducer.smaller_effects, " ")
    noise = {kind.noise_key: _number(wanted.noise)} if wanted.noise else {}
    return Measurement(kind, dict(zip(kind.columns, columns, strict=True)), keys | noise)


def profile_scan(
    reducer: AsBuiltReducer, disc: int = 0, points: int = _SCAN_POINTS, turned: float = 0.0
) -> ComplexArray:
    """Points of a disc, x + iy with the bore axis as origin, clockwise, ball radius taken off, shape (points,) [mm].

    About ``points`` of equal arc on ``disc``, counted from 0, that is rotated on the table by ``turned`` [rad].

    Raises ``LoadError`` if there is no such disc, or there would be fewer than 8 points on a lobe.
    """
    if not 0 <= disc < reducer.discs:
        raise LoadError("disc", disc + 1, f"is not one of the {reducer.discs} discs", "count from 1")
    tooth = reducer.teeth[disc]
    lobes = tooth.trochoid.lobes
    per_lobe = math.ceil(points / lobes)
    if per_lobe < LEAST_POINTS_PER_LOBE:
        least = LEAST_POINTS_PER_LOBE
        raise LoadError("points", points, f"are fewer than {least} on a lobe", f"give at least {least * lobes}")
    return np.asarray(sample(tooth, EqualArc(per_lobe)).position * np.exp(1j * turned))


Readings = tuple[tuple[FloatArray, FloatArray], dict[str, str]]


@singledispatch
def _readings(kind: MeasurementKind, reducer: AsBuiltReducer, settings: Settings) -> Readings:
    """Both columns of a file in the units of the kind, with noise, and the keys of its header."""
    raise NotImplementedError(f"the rig cannot measure a {kind.title}")


@_readings.register
def _scan_readings(kind: ProfileScan, reducer: AsBuiltReducer, settings: Settings) -> Readings:
    points = profile_scan(reducer, settings.disc, settings.points or _SCAN_POINTS)
    x_noise, y_noise = settings.noise_of((2, points.size), kind.unit_size)
    z = points + x_noise + 1j * y_noise
    return (z.real, z.imag), {"datum": "bore", "specimen": f"disc {settings.disc + 1}"}


@_readings.register
def _loop_readings(kind: Hysteresis, reducer: AsBuiltReducer, settings: Settings) -> Readings:
    loop = hysteresis_loop(reducer, settings.torque, settings.points or POINTS, settings.output_angle)
    angle = loop.angle / kind.unit_size + settings.noise_of(loop.angle.size)
    keys = {"output_angle_deg": _number(settings.output_angle / DEGREE), "input": "locked"}
    return (loop.torque / NEWTON_METRE, angle), keys


@_readings.register
def _transmission_error_readings(kind: TransmissionErrorCurve, reducer: AsBuiltReducer, settings: Settings) -> Readings:
    torque = abs(reducer.case.torque) if settings.torque is None else settings.torque
    curve = transmission_error(reducer, torque, settings.points or TRANSMISSION_POSES)
    return _over_turn(kind, torque, curve.output_angle, curve.error, settings)


@_readings.register
def _lost_motion_readings(kind: LostMotionMap, reducer: AsBuiltReducer, settings: Settings) -> Readings:
    torque = LOST_MOTION_SHARE * abs(reducer.case.torque) if settings.torque is None else settings.torque
    curve = lost_motion_map(reducer, torque, settings.points or MAP_POSES)
    return _over_turn(kind, torque, curve.output_angle, curve.value, settings)


def _over_turn(
    kind: MeasurementKind, torque: float, output_angle: FloatArray, value: FloatArray, settings: Settings
) -> Readings:
    column = value / kind.unit_size + settings.noise_of(value.size)
    return (output_angle / DEGREE, column), {"torque_nm": _number(torque / NEWTON_METRE)}


def _number(value: float) -> str:
    return f"{value:.10g}"


def key_figures(measurement: Measurement) -> dict[str, float]:
    """Key figures of a measured or simulated file by name; the unit is the end of the name."""
    return _key_figures(measurement.kind, measurement)


@singledispatch
def _key_figures(kind: MeasurementKind, measurement: Measurement) -> dict[str, float]:
    """Key figures of a file of this ``kind`` by name."""
    raise NotImplementedError(f"a {kind.title} has no key figures")


@_key_figures.register
def _scan_figures(_: ProfileScan, measurement: Measurement) -> dict[str, float]:
    radius = np.hypot(measurement["x_mm"], measurement["y_mm"])
    return {"points": float(radius.size), "root_radius_mm": float(radius.min()), "tip_radius_mm": float(radius.max())}


@_key_figures.register
def _loop_figures(_: Hysteresis, measurement: Measurement) -> dict[str, float]:
    found = evaluate_loop(measurement["torque_nm"] * NEWTON_METRE, measurement.value * ARCMIN)
    return {
        "lost_motion_arcmin": found.lost_motion / ARCMIN,
        "hysteresis_loss_arcmin": found.hysteresis_loss / ARCMIN,
        "torsional_rigidity_nm_per_arcmin": found.torsional_rigidity * ARCMIN / NEWTON_METRE,
        "loss_energy_nm_arcmin": found.loss_energy / ARCMIN / NEWTON_METRE,
    }


@_key_figures.register
def _transmission_error_figures(_: TransmissionErrorCurve, measurement: Measurement) -> dict[str, float]:
    amplitude = spectrum(measurement.value)
    largest = np.argsort(amplitude[1:])[::-1][:3] + 1
    orders = {f"order_{order}_amplitude_arcsec": float(amplitude[order]) for order in largest}
    return {"peak_to_peak_arcsec": float(np.ptp(measurement.value))} | orders


@_key_figures.register
def _lost_motion_figures(_: LostMotionMap, measurement: Measurement) -> dict[str, float]:
    value = measurement.value
    figures = {"mean_arcmin": np.mean(value), "largest_arcmin": np.max(value), "peak_to_peak_arcmin": np.ptp(value)}
    return {name: float(figure) for name, figure in figures.items()}
