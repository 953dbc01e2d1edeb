"""How far a measured file lies from what the rig predicts of a reducer (docs/rig.md, "Comparing").

What no measurement can know is taken off first: the angular zero of a scan, and its origin when the datum is free;
the zero of an angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import MeasurementError, SolveError
from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.prediction import predict_curve
from cycloid_profile.rig.registration import place_scan
from cycloid_profile.units import DEGREE, UM

UNITS = {"profile_scan": "um", "hysteresis": "arcmin", "transmission_error": "arcsec", "lost_motion_map": "arcmin"}
COLUMN = {
    "hysteresis": "angle_arcmin",
    "transmission_error": "error_arcsec",
    "lost_motion_map": "lost_motion_arcmin",
}


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
        return UNITS[self.measurement.kind]

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
    SolveError
        If no row has an equilibrium to compare with.
    """
    if measurement.kind == "profile_scan":
        return _scan_gap(built, measurement, disc)
    residual = measurement[COLUMN[measurement.kind]] - predict_curve(built, measurement).value
    if np.all(np.isnan(residual)):
        raise SolveError(measurement.name, "without", "an equilibrium to compare with", "make the effects smaller", " ")
    unit = UNITS[measurement.kind]
    removed: dict[str, float] = {}
    # A difference of two angles has no zero.
    if measurement.kind != "lost_motion_map":
        zero = float(np.nanmean(residual))
        residual, removed = residual - zero, {f"zero_{unit}": zero}
    if measurement.kind == "hysteresis":
        axis, where = "row of the loop", np.arange(float(residual.size))
    else:
        axis, where = "output angle [°]", measurement["output_angle_deg"]
    noise = _noise(residual, measurement.number(f"noise_{unit}"))
    return Gap(built, measurement, axis, where, residual, noise, removed)


def _scan_gap(built: Built, measurement: Measurement, disc: int) -> Gap:
    if not 0 <= disc < built.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {built.discs} discs", "count from 1")
    placed = place_scan(built.teeth[disc], measurement)
    residual = placed.removal / UM
    removed = {"turn_deg": placed.turn / DEGREE}
    if measurement.keys.get("datum", "bore") == "free":
        removed |= {"x_um": placed.shift.real / UM, "y_um": placed.shift.imag / UM}
    noise = _noise(residual, measurement.number("noise_um"))
    return Gap(built, measurement, "polar angle [°]", np.angle(placed.placed) / DEGREE, residual, noise, removed)


def _noise(residual: FloatArray, stated: float | None) -> float:
    """White noise: the stated one, or from third differences of neighbours, which a smooth effect hardly shows."""
    if stated is not None:
        return stated
    third = np.diff(residual, 3)
    third = third[np.isfinite(third)]
    # The median of |x| over σ is 0.6745, and third differences of white noise have variance 20.
    return float(np.median(np.abs(third)) / 0.6745 / math.sqrt(20.0)) if third.size else math.nan
