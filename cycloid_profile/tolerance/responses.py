"""The counted quantities about one reducer as built, each with its exact slope by many coordinates.

Poses and torques are those of ``quantities``, so that a slope is that of the number a study scatters.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.effects.built import Built
from cycloid_profile.rig.maps import LOST_MOTION_SHARE
from cycloid_profile.tolerance.clearance import spread
from cycloid_profile.tolerance.loaded_slopes import loaded_slopes
from cycloid_profile.tolerance.patterns import UnitChange
from cycloid_profile.tolerance.quantities import BACKLASH_POSES, LOST_MOTION_POSES, QUANTITIES, TURN_POSES
from cycloid_profile.tolerance.slopes import Slope, Smooth, Weighted, largest, least
from cycloid_profile.tolerance.touch_slopes import touch_slopes
from cycloid_profile.units import ARCMIN, ARCSEC

# Poses that mirror each other agree within the rounding of a balance.
_TIE_ANGLE, _TIE_PRESSURE = 1e-12, 1e-7  # rad, MPa

# Quantities with a slope: those counted, and means over the turn, which no single pose decides.
RESPONSES = {
    "backlash_arcmin": QUANTITIES["backlash_arcmin"],
    "least_backlash_arcmin": QUANTITIES["least_backlash_arcmin"],
    "backlash_mean_arcmin": "backlash, crank locked, mean over a turn",
    "lost_motion_arcmin": QUANTITIES["lost_motion_arcmin"],
    "lost_motion_mean_arcmin": "lost motion at ±3 % of rated torque, mean over a turn",
    "transmission_error_arcsec": QUANTITIES["transmission_error_arcsec"],
    "peak_pressure_mpa": QUANTITIES["peak_pressure_mpa"],
}


@dataclass(frozen=True)
class Response:
    """A quantity at the working point: ``value``, and ``slope`` by the coordinates, in the unit of its ``name``."""

    name: str
    value: float
    slope: Slope


def responses(built: Built, changes: list[UnitChange]) -> tuple[Response, ...]:
    """All of ``RESPONSES``, in their order.

    Raises
    ------
    SolveError
        If a disc finds no first touch, or the stage no equilibrium.
    """
    trochoid, torque = built.case.drive.trochoid, abs(built.case.torque)

    def turn(poses: int) -> FloatArray:
        return output_turn(trochoid, spread(poses, trochoid.lobes * trochoid.pins))

    touch = touch_slopes(built, changes, turn(BACKLASH_POSES))
    crank = turn(LOST_MOTION_POSES)
    count = len(crank)
    light = np.repeat([LOST_MOTION_SHARE * torque, -LOST_MOTION_SHARE * torque], count)
    swing = loaded_slopes(built, changes, np.tile(crank, 2), light)
    lost = swing.rotation[:count] - swing.rotation[count:]
    lost_by_unit = swing.rotation_by_unit[:count] - swing.rotation_by_unit[count:]
    crank = turn(TURN_POSES)
    rated = loaded_slopes(built, changes, crank, np.full(len(crank), torque))
    ahead, behind = _rows(rated.rotation_by_unit), _rows(-rated.rotation_by_unit)
    error = Weighted((largest(rated.rotation, ahead, _TIE_ANGLE), largest(-rated.rotation, behind, _TIE_ANGLE)))
    found: tuple[tuple[float, Slope, float], ...] = (
        (touch.values.max(), largest(touch.values, touch.slopes, _TIE_ANGLE), ARCMIN),
        (touch.values.min(), least(touch.values, touch.slopes, _TIE_ANGLE), ARCMIN),
        (touch.values.mean(), Weighted(touch.slopes, 1.0 / len(touch.slopes)), ARCMIN),
        (lost.max(), largest(lost, _rows(lost_by_unit), _TIE_ANGLE), ARCMIN),
        (lost.mean(), Smooth(np.mean(lost_by_unit, axis=0)), ARCMIN),
        (np.ptp(rated.rotation), error, ARCSEC),
        (rated.pressure.max(), largest(rated.pressure, _rows(rated.pressure_by_unit), _TIE_PRESSURE), 1.0),
    )
    return tuple(
        Response(name, float(value) / unit, Weighted((slope,), 1.0 / unit))
        for name, (value, slope, unit) in zip(RESPONSES, found, strict=True)
    )


def _rows(by_unit: FloatArray) -> list[Slope]:
    return [Smooth(row) for row in by_unit]
