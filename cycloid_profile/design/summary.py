"""The numbers of a design as one JSON-ready object, each key with its unit; the contract of ``--json``."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cycloid_profile.contact.backlash import input_locked_factor
from cycloid_profile.contact.running import sliding_speed
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.design.accuracy import Accuracy
from cycloid_profile.design.from_spec import output_speed
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.geometry.curvature import least_radii
from cycloid_profile.geometry.drive import set_up_amounts
from cycloid_profile.geometry.profile import undercut_limit
from cycloid_profile.units import ARCMIN, ARCSEC, NEWTON_METRE, UM


def summary(record: DesignRecord) -> dict[str, Any]:
    """All key figures of ``record``; a number that does not exist is None."""
    trochoid, profile, spec = record.drive.trochoid, record.profile, record.spec
    radii, ground = least_radii(record.drive.theoretical_profile), least_radii(profile)
    compensation = record.compensation
    return {
        "schema": 1,
        "name": spec.name,
        "pins": trochoid.pins,
        "lobes": trochoid.lobes,
        "reduction_ratio": record.drive.reduction_ratio,
        "short_width_ratio": trochoid.short_width_ratio,
        "root_radius_mm": record.outline.root_radius,
        "tip_radius_mm": record.outline.tip_radius,
        "undercut_limit_mm": _finite(undercut_limit(trochoid)),
        "least_convex_radius_mm": _finite(radii.convex),
        "least_concave_radius_mm": _finite(radii.concave),
        "largest_wheel_radius_mm": _finite(ground.concave),
        "corner_mrad": 1e3 * ground.largest_corner,
        "radial_clearance_um": round(sum(set_up_amounts(record.drive, profile)) / UM, 9),
        "generating_pin_radius_mm": profile.pin_radius,
        "generating_pin_circle_radius_mm": profile.trochoid.pin_circle_radius,
        "rated_torque_nm": record.case.torque / NEWTON_METRE,
        "rated_torque_assumed": spec.load.rated_torque_nm is None,
        "classical": _sharing(record.classical),
        "equilibrium": _sharing(record.equilibrium),
        "under_load": _under_load(record),
        "compensation": {
            "applied": compensation is not None,
            "load_share": spec.modification.compensation_load_share,
            "delta_max_um": 0.0 if compensation is None else compensation.delta_max / UM,
            "solver": _solver(record),
            "rounds": 0 if compensation is None else len(compensation.history),
            "backlash_change_arcmin": 0.0 if compensation is None else compensation.backlash_change / ARCMIN,
            "refused": record.refusal,
        },
        "conventional": _accuracy(record.conventional_accuracy),
        "compensated": _accuracy(record.compensated_accuracy),
        "checks": [
            {
                "name": c.name,
                "passed": c.passed,
                "value": c.value,
                "limit": c.limit,
                "severe": c.severe,
                "sentence": c.sentence,
            }
            for c in record.checks
        ],
        "effects": [effect["name"] for effect in spec.effects],
        "as_built": _as_built(record),
        "failures": list(record.failures),
    }


def shown(value: float | None, digits: int = 4) -> str:
    """A figure with ``digits`` significant digits, a dash where there is none."""
    # Rounding errors of a perfect fit are shown as the zero they are.
    return "–" if value is None else f"{0.0 if abs(value) < 1e-9 else value:.{digits}g}"


def _sharing(sharing: LoadSharing) -> dict[str, Any]:
    return {
        "max_force_n": sharing.max_force,
        "delta_max_um": sharing.delta_max / UM,
        "loaded_pins": sharing.loaded_pins,
        "max_pressure_mpa": sharing.max_pressure,
        "iterations": sharing.iterations,
        "residual": _finite(sharing.max_residual),
        "status": sharing.status.value,
    }


def _under_load(record: DesignRecord) -> dict[str, Any]:
    """The whole stage at rated torque with the tooth to be ground, over one turn of the crank."""
    loaded, drive = record.under_load, record.drive
    assert loaded.stage is not None
    contact = record.case.line_contact(loaded.curvature)
    slide = sliding_speed(drive, loaded.phase, output_speed(record.spec))
    stiffness = loaded.torsional_stiffness * ARCMIN / NEWTON_METRE
    return {
        "max_force_n": loaded.max_force,
        "max_pressure_mpa": loaded.max_pressure,
        "max_subsurface_shear_mpa": float(np.max(contact.subsurface_shear(loaded.force))),
        "shear_depth_um": float(np.max(contact.shear_depth(loaded.force))) / UM,
        "loaded_pins": loaded.loaded_pins,
        "fewest_loaded_pins": loaded.fewest_loaded_pins,
        "twist_arcmin": float(np.mean(np.abs(loaded.twist))) / ARCMIN,
        "torsional_stiffness_nm_per_arcmin": float(np.mean(stiffness)),
        "max_bearing_force_n": float(np.max(np.abs(loaded.stage.bearing_force))),
        "output_speed_rpm": record.spec.load.output_speed_rpm,
        "max_sliding_speed_mm_per_s": float(np.max(np.where(loaded.loaded, slide, 0.0))),
        "mesh_loss_w": record.losses.mesh,
        "bearing_loss_w": record.losses.bearings,
        "efficiency": record.losses.efficiency if record.losses.output > 0.0 else None,
        "residual": _finite(loaded.max_residual),
        "status": loaded.status.value,
    }


def _as_built(record: DesignRecord) -> dict[str, Any] | None:
    """What the rig reads of the reducer with its effects over a turn of the output; None without effects."""
    found = record.as_built
    if found is None:
        return None
    return {
        "lost_motion_arcmin": _finite(float(np.max(found.lost_motion.value)) / ARCMIN),
        "lost_motion_mean_arcmin": _finite(float(np.mean(found.lost_motion.value)) / ARCMIN),
        "hysteresis_loss_arcmin": _finite(found.loop.hysteresis_loss / ARCMIN),
        "torsional_rigidity_nm_per_arcmin": _finite(found.loop.torsional_rigidity * ARCMIN / NEWTON_METRE),
        "transmission_error_arcsec": _finite(found.transmission.peak_to_peak / ARCSEC),
    }


def _solver(record: DesignRecord) -> str | None:
    if record.compensation is None:
        return None
    sharing = record.compensation.sharing
    return "given" if sharing is None else sharing.solver


def _accuracy(accuracy: Accuracy) -> dict[str, Any]:
    return {
        "backlash_arcmin": accuracy.backlash.worst / ARCMIN,
        "backlash_least_arcmin": accuracy.backlash.least / ARCMIN,
        "backlash_input_locked_arcmin": accuracy.backlash.worst * input_locked_factor(accuracy.case.drive) / ARCMIN,
        "lost_motion_arcmin": _finite(accuracy.lost_motion / ARCMIN),
        "torsional_rigidity_nm_per_arcmin": _finite(accuracy.torsional_rigidity * ARCMIN / NEWTON_METRE),
        "transmission_error_arcsec": _finite(accuracy.transmission_error / ARCSEC),
        "converged": accuracy.converged,
    }


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
