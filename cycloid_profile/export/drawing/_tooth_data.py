"""Texts of the drawing: the table of tooth data and the notes."""

from __future__ import annotations

import math
from dataclasses import dataclass

from cycloid_profile.design import DesignRecord
from cycloid_profile.geometry import OverRollers, least_radii, modification_sizes, over_rollers
from cycloid_profile.spec.model import DrawingSpec
from cycloid_profile.units import UM

_ROLLER_STEP = 0.5  # mm, step of standard roller diameters
_LARGER, _LARGEST = 1.1, 2.0  # times the concave radius of the root, so that it rests on both flanks; times the pin
_ON_ROOT, _ON_TIPS = 1e-4, 0.8 * math.pi  # rad


@dataclass(frozen=True, slots=True)
class TableRow:
    """One line of the table."""

    name: str
    symbol: str
    value: str


def tooth_data(record: DesignRecord, fields: DrawingSpec) -> tuple[TableRow, ...]:
    """Rows of the table; tolerances without a value are blank lines to fill in."""
    drive, outline, profile = record.drive, record.outline, record.profile
    t = drive.trochoid
    equidistant, radial = modification_sizes(drive, profile)
    delta = 0.0 if record.compensation is None else record.compensation.delta_max
    least = least_radii(profile)
    rows = [
        TableRow("number of lobes", "z_c", f"{t.lobes}"),
        TableRow("number of pins", "z_p", f"{t.pins}"),
        TableRow("pin circle radius", "r_p", _mm(t.pin_circle_radius)),
        TableRow("pin radius", "r_rp", _mm(drive.pin_radius)),
        TableRow("eccentricity", "a", _mm(t.eccentricity)),
        TableRow("short-width ratio", "K_1", f"{t.short_width_ratio:.6g}"),
        TableRow("equidistant modification", "Δr_rp", _um(equidistant)),
        TableRow("radial-moving modification", "Δr_p", _um(radial)),
        TableRow("rotation of each flank", "β", f"{record.spec.modification.rotation_arcmin:g}′"),
        TableRow("deformation compensation", "δ_max", f"{delta / UM:.3f} µm"),
        TableRow("radial clearance", "Δ_j", _um(equidistant + radial)),
        TableRow("pitch circle diameter", "2a·z_c", _mm(2.0 * t.longest_lever)),
        TableRow("root diameter", "d_f", _mm(2.0 * outline.root_radius)),
        TableRow("tip diameter", "d_a", _mm(2.0 * outline.tip_radius)),
        TableRow("least radius, convex", "ρ_a", _radius(least.convex)),
        TableRow("least radius, concave", "ρ_f", _radius(least.concave)),
        *(_over(check) for check in check_sizes(record)),
        TableRow("profile tolerance", "", _tolerance(fields.profile_tolerance_um)),
        TableRow("single pitch deviation", "f_p", _tolerance(fields.single_pitch_tolerance_um, "±")),
        TableRow("cumulative pitch deviation", "F_p", _tolerance(fields.cumulative_pitch_tolerance_um)),
        TableRow("runout of the teeth", "F_r", _tolerance(fields.runout_tolerance_um)),
        TableRow("datum for measuring", "A", fields.datum),
        TableRow("mating pins", "", f"{t.pins} × φ{2.0 * drive.pin_radius:g}"),
    ]
    return tuple(rows)


def check_sizes(record: DesignRecord) -> tuple[OverRollers, ...]:
    """Sizes over rollers of the pins' diameter, and over larger rollers if they touch the flanks."""
    nominal = over_rollers(record.profile, record.drive.pin_radius)
    concave = least_radii(record.profile).concave
    if not math.isfinite(concave):
        return (nominal,)
    step = _ROLLER_STEP if record.drive.pin_radius > 1.0 else 0.1 * _ROLLER_STEP
    diameter = step * math.ceil(2.0 * _LARGER * max(concave, record.drive.pin_radius) / step)
    larger = over_rollers(record.profile, 0.5 * diameter)
    sensible = diameter <= _LARGEST * 2.0 * record.drive.pin_radius and _ON_ROOT < larger.seat < _ON_TIPS
    return (nominal, larger) if sensible else (nominal,)


def notes(record: DesignRecord, fields: DrawingSpec, digest: str) -> tuple[str, ...]:
    """The notes: fixed ones, then those of the spec; ``digest`` is the sha256 of the spec."""
    tooth, other = fields.tooth_roughness_ra_um, fields.roughness_ra_um
    given = [
        f"Tooth curve: profile.dxf or profile.csv of the same spec (sha256 {digest[:12]}).",
        f"{_root_1(record)}; {record.drive.trochoid.lobes} "
        f"{'identical' if record.profile.identical_lobes else 'different'} lobes.",
        f"Roughness: tooth flanks {_ra(tooth)}, elsewhere {_ra(other)}.",
        f"Heat treatment: {fields.heat_treatment or '________________'}.",
        f"Tolerances not stated: {fields.general_tolerance}. Edges broken, tooth edges at most 0.2 × 45°.",
        "Positive modification removes material; sizes at 20 °C.",
    ]
    return (*given, *fields.notes)


def _root_1(record: DesignRecord) -> str:
    if not record.openings_turn:
        return "Root 1 on the axis through crank or output hole 1"
    turn = math.degrees(record.openings_turn)
    return f"Disc {record.disc}: crank or output hole 1 {turn:.4f}° anticlockwise of the axis through root 1"


def _over(check: OverRollers) -> TableRow:
    seat = "root" if check.seat < _ON_ROOT else f"ψ ±{math.degrees(check.seat):.1f}°"
    return TableRow(f"over two rollers φ{2.0 * check.roller_radius:g}, on {seat}", "M", _mm(check.size, 4))


def _mm(value: float, decimals: int = 3) -> str:
    return f"{value:.{decimals}f} mm"


def _um(value: float) -> str:
    return f"{value / UM + 0.0:+.2f} µm"


def _radius(value: float) -> str:
    return _mm(value) if math.isfinite(value) else "none"


def _tolerance(value_um: float | None, sign: str = "") -> str:
    return "________" if value_um is None else f"{sign}{value_um * UM:g} mm"


def _ra(value_um: float | None) -> str:
    return "Ra ____" if value_um is None else f"Ra {value_um:g}"
