"""Measured files as the rig would write them, one simulator for each kind (docs/rig.md, "Files")."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError, SolveError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.hysteresis import hysteresis_loop
from cycloid_profile.rig.maps import LOST_MOTION_SHARE, lost_motion_map
from cycloid_profile.rig.scan import profile_scan
from cycloid_profile.rig.transmission import transmission_error
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE, UM

_LEAST_POINTS = 4


@dataclass(frozen=True, slots=True)
class Settings:
    """How to measure; None takes what is usual for the kind.

    ``torque`` [N·mm]; ``output_angle`` of a loop [rad]; ``points``; ``disc`` of a scan, counted from 0; ``noise``, a
    standard deviation in the unit of the measured column, with the ``seed`` of its draw.
    """

    torque: float | None = None
    output_angle: float = 0.0
    points: int | None = None
    disc: int = 0
    noise: float = 0.0
    seed: int = 0


def simulate(built: Built, kind: str, settings: Settings | None = None) -> Measurement:
    """What the rig would read.

    Raises
    ------
    MeasurementError
        If the kind is not known, or noise, points or seed cannot be.
    SolveError
        If the reducer finds no equilibrium somewhere.
    """
    wanted = Settings() if settings is None else settings
    if kind not in SIMULATORS:
        known = ", ".join(SIMULATORS)
        raise MeasurementError("kind", f"'{kind}'", "is not known", f"choose from {known}")
    if not 0.0 <= wanted.noise < np.inf:
        raise MeasurementError("noise", wanted.noise, "is no finite number from 0 on", "give a standard deviation")
    if wanted.points is not None and wanted.points < _LEAST_POINTS:
        raise MeasurementError("points", wanted.points, f"are fewer than {_LEAST_POINTS}", "measure more points")
    if wanted.seed < 0:
        raise MeasurementError("seed", wanted.seed, "is negative", "give a whole number from 0 on")
    measured = SIMULATORS[kind](built, wanted, np.random.default_rng(wanted.seed))
    lost = np.count_nonzero(~np.isfinite(np.stack(list(measured.columns.values()))))
    if lost:
        raise SolveError(f"{lost} rows of the {kind}", "without", "an equilibrium", "make the effects smaller", " ")
    return measured


def _scan(built: Built, settings: Settings, draw: np.random.Generator) -> Measurement:
    scan = profile_scan(built, settings.disc, settings.points or 5000)
    x_noise, y_noise = settings.noise * UM * draw.normal(0.0, 1.0, (2, scan.points.size))
    z = scan.points + x_noise + 1j * y_noise
    keys = {"datum": "bore", "specimen": f"disc {settings.disc + 1}"} | _noise("noise_um", settings)
    return Measurement("profile_scan", {"x_mm": z.real, "y_mm": z.imag}, keys)


def _loop(built: Built, settings: Settings, draw: np.random.Generator) -> Measurement:
    loop = hysteresis_loop(built, settings.torque, settings.points or 400, settings.output_angle)
    angle = loop.angle / ARCMIN + draw.normal(0.0, 1.0, loop.angle.size) * settings.noise
    keys = {"output_angle_deg": _number(settings.output_angle / DEGREE), "input": "locked"}
    columns = {"torque_nm": loop.torque / NEWTON_METRE, "angle_arcmin": angle}
    return Measurement("hysteresis", columns, keys | _noise("noise_arcmin", settings))


def _transmission(built: Built, settings: Settings, draw: np.random.Generator) -> Measurement:
    torque = abs(built.case.torque) if settings.torque is None else settings.torque
    found = transmission_error(built, torque, settings.points or 3000)
    error = found.error / ARCSEC + draw.normal(0.0, 1.0, found.error.size) * settings.noise
    keys = {"torque_nm": _number(torque / NEWTON_METRE)} | _noise("noise_arcsec", settings)
    columns = {"output_angle_deg": found.output_angle / DEGREE, "error_arcsec": error}
    return Measurement("transmission_error", columns, keys)


def _lost_motion(built: Built, settings: Settings, draw: np.random.Generator) -> Measurement:
    torque = LOST_MOTION_SHARE * abs(built.case.torque) if settings.torque is None else settings.torque
    found = lost_motion_map(built, torque, settings.points or 600)
    value = found.value / ARCMIN + draw.normal(0.0, 1.0, found.value.size) * settings.noise
    keys = {"torque_nm": _number(torque / NEWTON_METRE)} | _noise("noise_arcmin", settings)
    columns = {"output_angle_deg": found.output_angle / DEGREE, "lost_motion_arcmin": value}
    return Measurement("lost_motion_map", columns, keys)


SIMULATORS: dict[str, Callable[[Built, Settings, np.random.Generator], Measurement]] = {
    "profile_scan": _scan,
    "hysteresis": _loop,
    "transmission_error": _transmission,
    "lost_motion_map": _lost_motion,
}


def _noise(key: str, settings: Settings) -> dict[str, str]:
    return {key: _number(settings.noise)} if settings.noise else {}


def _number(value: float) -> str:
    return f"{value:.10g}"
