"""Measured minus predicted, after registration (docs/rig.md, "Comparing").

Registration removes the quantities that a measurement leaves undetermined: the angular zero of a scan, its origin when
the datum is free, and the zero of an angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError, SolveError
from cycloid_profile.measurement import Measurement
from cycloid_profile.rig.prediction import predict_curve
from cycloid_profile.rig.registration import register_scan
from cycloid_profile.units import DEGREE, SIGNS, UM


@dataclass(frozen=True, eq=False, repr=False)
class MeasurementResidual(Described):
    """Measured minus predicted, registered, in the unit of the measured column (µm, ′ or ″).

    ``position`` of the rows along ``axis``, in its unit; ``noise``, standard deviation of the white noise, estimated
    from neighbouring rows or stated in the file; ``registration``, what was removed, by name. ``predicted``, the column
    of a curve with its zero moved to the measured one, NaN without equilibrium, shape (rows,); None of a scan.
    """

    reducer: AsBuiltReducer
    measurement: Measurement
    axis: str
    position: FloatArray
    residual: FloatArray
    noise: float
    registration: dict[str, float]
    predicted: FloatArray | None = None

    @property
    def unit(self) -> str:
        """Unit of residual and noise."""
        return self.measurement.kind.unit

    @property
    def rms(self) -> float:
        """Root mean square of the residual; rows that cannot be compared are NaN and left out."""
        return float(np.sqrt(np.nanmean(self.residual**2)))

    def to_frame(self) -> Any:
        """``position`` and ``residual`` as a ``pandas.DataFrame``."""
        return frame({"position": self.position, f"residual_{self.unit}": self.residual})

    def _key_figures(self) -> dict[str, str]:
        sign = SIGNS[self.unit]
        return {
            "file": self.measurement.name,
            "kind": self.measurement.kind.title,
            "rows": str(self.residual.size),
            "rms": f"{self.rms:.4g} {sign}",
            "noise": f"{self.noise:.4g} {sign}",
            **{name: f"{value:.6g}" for name, value in self.registration.items()},
        }


def measurement_residual(reducer: AsBuiltReducer, measurement: Measurement, disc: int = 0) -> MeasurementResidual:
    """Difference of a measured file to the prediction; ``disc`` of a scan counted from 0.

    Raises ``MeasurementError`` if the file does not belong to this reducer, and ``SolveError`` if no row has an
    equilibrium to compare with.
    """
    if measurement.kind.is_curve:
        return _curve_residual(reducer, measurement)
    return _scan_residual(reducer, measurement, disc)


def _curve_residual(reducer: AsBuiltReducer, measurement: Measurement) -> MeasurementResidual:
    kind = measurement.kind
    prediction = predict_curve(reducer, measurement)
    residual, predicted = measurement.value - prediction.value, prediction.on_last_flank
    if np.all(np.isnan(residual)):
        raise SolveError(measurement.name, "without", "an equilibrium to compare with", reducer.smaller_effects, " ")
    registration: dict[str, float] = {}
    if kind.zero_unknown:
        zero = float(np.nanmean(residual))
        residual, predicted, registration = residual - zero, predicted + zero, {f"zero_{kind.unit}": zero}
    if kind.over_output_turn:
        axis, position = "output angle [°]", measurement["output_angle_deg"]
    else:
        axis, position = "row of the file [number]", np.arange(float(residual.size))
    noise = _noise(residual, measurement.stated_noise)
    return MeasurementResidual(reducer, measurement, axis, position, residual, noise, registration, predicted)


def _scan_residual(reducer: AsBuiltReducer, measurement: Measurement, disc: int) -> MeasurementResidual:
    if not 0 <= disc < reducer.discs:
        raise MeasurementError("disc", disc + 1, f"is not one of the {reducer.discs} discs", "count from 1")
    scan = register_scan(reducer.teeth[disc], measurement)
    residual = scan.removal / UM
    registration = {"turn_deg": scan.turn / DEGREE}
    if measurement.datum_free:
        registration |= {"x_um": scan.shift.real / UM, "y_um": scan.shift.imag / UM}
    noise = _noise(residual, measurement.stated_noise)
    polar = np.angle(scan.placed) / DEGREE
    return MeasurementResidual(reducer, measurement, "polar angle [°]", polar, residual, noise, registration)


def _noise(residual: FloatArray, stated: float | None) -> float:
    """Standard deviation of the white noise: stated, or from third differences, which suppress smooth effects."""
    if stated is not None:
        return stated
    third = np.diff(residual, 3)
    third = third[np.isfinite(third)]
    # The median of |x| over σ is 0.6745, and third differences of white noise have variance 20.
    return float(np.median(np.abs(third)) / 0.6745 / math.sqrt(20.0)) if third.size else math.nan
