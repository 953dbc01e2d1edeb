"""Key figures of a design as one JSON-ready object; each key ends with its unit."""

from __future__ import annotations

from typing import Any

import numpy as np

from cycloid_profile._display import finite
from cycloid_profile.contact import LoadSharing, LossRange, first_order_backlash, sliding_speed
from cycloid_profile.design.checks import strength_checks
from cycloid_profile.design.discs_as_parts import disc_parts_sentence
from cycloid_profile.design.from_spec import output_speed
from cycloid_profile.design.record import DesignRecord
from cycloid_profile.design.strength import bearing_stiffness
from cycloid_profile.geometry import least_radii, modification_sizes, undercut_limit
from cycloid_profile.modification import pair_ratios, rotation_to_backlash
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM


def summary(record: DesignRecord) -> dict[str, Any]:
    """All key figures of ``record``; a figure that does not exist is None."""
    trochoid, profile, spec = record.drive.trochoid, record.profile, record.spec
    nominal, final = least_radii(record.drive.theoretical_profile), least_radii(profile)
    compensation = record.compensation
    sharing = None if compensation is None else compensation.sharing
    given = None if compensation is None else "given"
    return {
        "schema": 1,
        "name": spec.name,
        "pins": trochoid.pins,
        "lobes": trochoid.lobes,
        "reduction_ratio": record.drive.reduction_ratio,
        "short_width_ratio": trochoid.short_width_ratio,
        "root_radius_mm": record.outline.root_radius,
        "tip_radius_mm": record.outline.tip_radius,
        "undercut_limit_mm": finite(undercut_limit(trochoid)),
        "least_convex_radius_mm": finite(nominal.convex),
        "least_concave_radius_mm": finite(nominal.concave),
        "largest_wheel_radius_mm": finite(final.concave),
        "corner_mrad": 1e3 * final.largest_corner,
        "radial_clearance_um": round(sum(modification_sizes(record.drive, profile)) / UM, 9),
        "generating_pin_radius_mm": profile.pin_radius,
        "generating_pin_circle_radius_mm": profile.trochoid.pin_circle_radius,
        "rated_torque_nm": record.case.torque / NEWTON_METRE,
        "rated_torque_assumed": spec.load.rated_torque_nm is None,
        "classical": _sharing(record.classical),
        "equilibrium": _sharing(record.equilibrium),
        "under_load": _under_load(record),
        "modification": _modification(record),
        "compensation": {
            "applied": compensation is not None,
            "load_share": spec.modification.compensation_load_share,
            "delta_max_um": 0.0 if compensation is None else compensation.delta_max / UM,
            "delta_max_least_um": 0.0 if compensation is None else compensation.delta_max_least / UM,
            "delta_max_largest_um": 0.0 if compensation is None else compensation.delta_max_largest / UM,
            "solver": given if sharing is None else sharing.solver,
            "rounds": 0 if compensation is None else len(compensation.history),
            "backlash_change_arcmin": 0.0 if compensation is None else compensation.backlash_change / ARCMIN,
            "refused": record.refusal,
        },
        "conventional": record.conventional_accuracy.figures(),
        "compensated": record.compensated_accuracy.figures(),
        "checks": [
            {key: getattr(check, key) for key in ("name", "passed", "value", "limit", "severe", "sentence")}
            | {"status": check.status.value, "remedy": check.remedy, "assumed": check.assumed or None}
            for check in record.checks
        ],
        "losses": _losses(record.loss_range),
        "strength": record.strength.figures() | {"checks": [each.name for each in strength_checks(record.strength)]},
        "effects": [effect["name"] for effect in spec.effects],
        **({"empirical": [one.name for one in spec.empirical]} if spec.empirical else {}),
        "as_built": None if record.as_built is None else record.as_built.figures(),
        "failures": list(record.failures),
        "disc_parts": disc_parts_sentence(record),
        **({"supports": _supports(record.under_load)} if record.case.supports else {}),
    }


def _modification(record: DesignRecord) -> dict[str, Any]:
    """Amounts of the set-up, and the backlash that they make to first order, before deformation compensation.

    The ratio of the amounts shows the pair: near ``conjugate_ratio`` many pins share the load at the price of backlash,
    near ``zero_backlash_ratio`` it is the other way round.
    """
    m, (conjugate, zero) = record.spec.modification, pair_ratios(record.drive.trochoid)
    turned = rotation_to_backlash(m.rotation_arcmin * ARCMIN)
    play = first_order_backlash(record.drive, m.equidistant_um * UM, m.radial_moving_um * UM) + turned
    return {
        "equidistant_um": m.equidistant_um,
        "radial_moving_um": m.radial_moving_um,
        "rotation_arcmin": m.rotation_arcmin,
        "radial_clearance_um": m.equidistant_um + m.radial_moving_um,
        "backlash_arcmin": play / ARCMIN,
        "ratio": m.radial_moving_um / m.equidistant_um if m.equidistant_um else None,
        "conjugate_ratio": conjugate,
        "zero_backlash_ratio": zero,
    }


def _sharing(sharing: LoadSharing) -> dict[str, Any]:
    return {
        "max_force_n": sharing.max_force,
        "delta_max_um": sharing.delta_max / UM,
        "loaded_pins": sharing.loaded_pins,
        "max_pressure_mpa": sharing.max_pressure,
        "iterations": sharing.iterations,
        "residual": finite(sharing.max_residual),
        "status": sharing.status.value,
    }


def _supports(loaded: LoadSharing) -> dict[str, Any]:
    """Elastic supports under rated torque, apart from contact and discs: stiffness, recession, shares of the turn."""
    supports = loaded.case.supports
    seats, ring, pillars = supports.seats, supports.ring, supports.pillars
    stiffness = None if pillars is None else 1.0 / pillars.compliance if pillars.compliance else None
    return {
        "elastic": list(supports.names),
        "seat_half_width_mm": None if seats is None or not seats.contact else seats.half_width,
        "pin_um_per_kn": None if seats is None else float(np.max(seats.compliance())) * 1e3 / UM,
        "ring_outer_radius_mm": None if ring is None else ring.outer_radius,
        "ring_um_per_kn_by_waves": None
        if ring is None
        else [float(ring.wave_compliance(k)[0, 0]) * 1e3 / UM for k in range(ring.waves + 1)],
        "pillars_nm_per_arcmin": None if stiffness is None else stiffness * ARCMIN / NEWTON_METRE,
        "largest_recession_um": {name: float(np.max(each)) / UM for name, each in loaded.receded_supports.items()},
        "rotation_arcmin": {name: float(np.mean(each)) / ARCMIN for name, each in loaded.rotation_by_part.items()},
    }


def _losses(found: LossRange) -> dict[str, Any]:
    """Losses of the stage in watts, for the least, the likely and the largest friction, with their assumption."""
    cases = {"low": found.low, "likely": found.likely, "high": found.high}
    return {
        **{
            name: {
                "friction_coefficient": one.friction,
                "bearing_friction_coefficient": one.needle_friction,
                "mesh_loss_w": one.mesh,
                "bearing_loss_w": one.bearings,
                "heat_w": one.heat,
                "efficiency": one.efficiency if one.output > 0.0 else None,
            }
            for name, one in cases.items()
        },
        "assumption": found.assumption,
    }


def _over_width(loaded: LoadSharing) -> dict[str, Any]:
    """Figures of the slices over the face width; none without slices."""
    if loaded.case.width is None or loaded.stage is None or loaded.stage.tilt is None:
        return {}
    tilt = loaded.stage.tilt
    return {
        "width_slices": loaded.case.width.slices,
        "max_edge_pressure_mpa": loaded.max_edge_pressure,
        "max_tilt_mrad": 1e3 * float(np.max(np.hypot(tilt[..., 0], tilt[..., 1]))),
    }


def _under_load(record: DesignRecord) -> dict[str, Any]:
    """The whole stage with the final tooth at rated torque, over one turn of the crank."""
    loaded, drive = record.under_load, record.drive
    assert loaded.stage is not None
    contact = record.case.line_contact(loaded.curvature)
    slide = sliding_speed(drive, loaded.phase, output_speed(record.spec))
    stiffness = loaded.torsional_stiffness * ARCMIN / NEWTON_METRE
    most = float(np.max(np.abs(loaded.stage.bearing_force)))
    return {
        "max_force_n": loaded.max_force,
        "max_pressure_mpa": loaded.max_pressure,
        **_over_width(loaded),
        "max_subsurface_shear_mpa": float(np.max(contact.subsurface_shear(loaded.force))),
        "shear_depth_um": float(np.max(contact.shear_depth(loaded.force))) / UM,
        "loaded_pins": loaded.loaded_pins,
        "fewest_loaded_pins": loaded.fewest_loaded_pins,
        "twist_arcmin": float(np.mean(np.abs(loaded.twist))) / ARCMIN,
        "torsional_stiffness_nm_per_arcmin": float(np.mean(stiffness)),
        "max_bearing_force_n": most,
        **bearing_stiffness(loaded.case.drive.support, most).figures(),
        "output_speed_rpm": record.spec.load.output_speed_rpm,
        "max_sliding_speed_mm_per_s": float(np.max(np.where(loaded.loaded, slide, 0.0))),
        "mesh_loss_w": record.losses.mesh,
        "bearing_loss_w": record.losses.bearings,
        "efficiency": record.losses.efficiency if record.losses.output > 0.0 else None,
        "residual": finite(loaded.max_residual),
        "status": loaded.status.value,
    }
