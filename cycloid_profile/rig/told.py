"""The key figures of a measured or simulated file, each named with its unit."""

from __future__ import annotations

import numpy as np

from cycloid_profile.measurement.files import Measurement
from cycloid_profile.rig.evaluation import evaluate_loop
from cycloid_profile.rig.transmission import spectrum
from cycloid_profile.units import ARCMIN, NEWTON_METRE


def figures_of(measurement: Measurement) -> dict[str, float]:
    """Key figures by name; the unit is the end of the name."""
    if measurement.kind == "hysteresis":
        found = evaluate_loop(measurement["torque_nm"] * NEWTON_METRE, measurement["angle_arcmin"] * ARCMIN)
        return {
            "lost_motion_arcmin": found.lost_motion / ARCMIN,
            "hysteresis_loss_arcmin": found.hysteresis_loss / ARCMIN,
            "torsional_rigidity_nm_per_arcmin": found.torsional_rigidity * ARCMIN / NEWTON_METRE,
            "loss_energy_nm_arcmin": found.loss_energy / ARCMIN / NEWTON_METRE,
        }
    if measurement.kind == "transmission_error":
        error = measurement["error_arcsec"]
        amplitude = spectrum(error)
        largest = np.argsort(amplitude[1:])[::-1][:3] + 1
        orders = {f"order_{order}_amplitude_arcsec": float(amplitude[order]) for order in largest}
        return {"peak_to_peak_arcsec": float(np.ptp(error))} | orders
    if measurement.kind == "lost_motion_map":
        value = measurement["lost_motion_arcmin"]
        return {
            "mean_arcmin": float(np.mean(value)),
            "largest_arcmin": float(np.max(value)),
            "peak_to_peak_arcmin": float(np.ptp(value)),
        }
    radius = np.hypot(measurement["x_mm"], measurement["y_mm"])
    return {"points": float(radius.size), "root_radius_mm": float(radius.min()), "tip_radius_mm": float(radius.max())}
