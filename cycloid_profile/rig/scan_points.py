"""Points of the tooth from what a file holds: centres of the probe's ball, or nominal points with deviations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import Measurement, PendingSteps
from cycloid_profile.modification import Equidistant
from cycloid_profile.rig.registration import RegisteredScan, register_scan

# Coordinates are nominal where they lie this much closer to the nominal tooth than the deviations printed next to
# them are large. Measured coordinates lie as far from it as those deviations; half or twice the share decides the same.
_NOMINAL_SHARE = 0.25


def tooth_points(reducer: AsBuiltReducer, measurement: Measurement) -> Measurement:
    """The measurement after its ``pending`` steps, with a note on each; itself where it has none.

    Raises ``MeasurementError`` if the points are not those of this disc.
    """
    steps = measurement.pending
    if steps is None:
        return measurement
    bare = replace(measurement, pending=None)
    if steps.deviation is not None:
        bare = _with_deviations(reducer, bare, steps, steps.deviation)
    return _without_ball(reducer, bare, steps.probe_radius) if steps.probe_radius else bare


def _with_deviations(
    reducer: AsBuiltReducer, measurement: Measurement, steps: PendingSteps, deviation: FloatArray
) -> Measurement:
    placed = register_scan(reducer.case.profile, measurement)
    size = float(np.sqrt(np.mean(deviation**2)))
    nominal = steps.nominal or float(np.sqrt(np.mean(placed.removal**2))) < _NOMINAL_SHARE * size
    if not nominal:
        note = "the coordinates lie off the nominal tooth, so they are measured points and the deviations are not used"
        return _noted(measurement, note)
    moved = _moved(measurement, placed, deviation)
    return _noted(moved, "the coordinates are nominal, so the deviations were added along the normals")


def _without_ball(reducer: AsBuiltReducer, measurement: Measurement, radius: float) -> Measurement:
    """The points where the ball touched: its centres lie on the parallel curve of the tooth, ``radius`` outside."""
    placed = register_scan(Equidistant(-radius).apply(reducer.case.profile), measurement)
    moved = _moved(measurement, placed, np.full(measurement.rows, -radius))
    return _noted(moved, f"the probe radius of {radius:g} mm was removed along the normals of the tooth")


def _moved(measurement: Measurement, placed: RegisteredScan, outwards: FloatArray) -> Measurement:
    """The scan with each point moved along the outward normal of the tooth [mm]."""
    z = measurement["x_mm"] + 1j * measurement["y_mm"] + outwards * placed.normal * np.exp(1j * placed.turn)
    return replace(measurement, columns={"x_mm": z.real, "y_mm": z.imag})


def _noted(measurement: Measurement, note: str) -> Measurement:
    return replace(measurement, notes=(*measurement.notes, note))
