"""Texts of the drawing: title, mass, table of tooth data and notes."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import NamedTuple

from cycloid_profile.design import DesignRecord, place_among_parts
from cycloid_profile.errors import SpecError
from cycloid_profile.export.drawing._tolerances import ShownTolerance, Tolerances
from cycloid_profile.export.inspection import AXIS, DIRECTION, datum_system
from cycloid_profile.geometry import OverRollers, least_radii, modification_sizes, over_rollers
from cycloid_profile.spec.model.materials import is_like_steel, named_material
from cycloid_profile.units import UM

_ROLLER_STEP = 0.5  # mm, step of standard roller diameters
_LARGER, _LARGEST = 1.1, 2.0  # times the concave radius of the root, so that it rests on both flanks; times the pin
_ON_ROOT, _ON_TIPS = 1e-4, 0.8 * math.pi  # rad


class TitleCell(NamedTuple):
    """One field of the title block: lower left corner and width [mm of paper], label and value."""

    up: float
    along: float
    width: float
    label: str
    value: str


class TableRow(NamedTuple):
    """One line of the table."""

    name: str
    symbol: str
    value: str


def title(record: DesignRecord) -> str:
    """Name of the disc, with its number where the discs of the stage differ."""
    name = f"Cycloid disc {record.spec.name}"
    return name if place_among_parts(record)[1] == 1 else f"{name}, disc {record.disc}"


def material(record: DesignRecord) -> str:
    """Name of the disc's material in the spec, else derived from its modulus."""
    disc = record.spec.materials.disc
    return disc.name or ("steel" if is_like_steel(disc.youngs_modulus_gpa) else f"E = {disc.youngs_modulus_gpa:g} GPa")


def mass_text(record: DesignRecord) -> str:
    """Mass of the disc, area times width times density; empty where the density is not known."""
    disc = record.spec.materials.disc
    density = disc.density_kg_per_m3
    if density is None:
        # A name that the table lacks says nothing about the density.
        with suppress(SpecError):
            density = named_material(material(record)).density_kg_per_m3
    if density is None:
        return ""
    # kg of mm³ × kg/m³.
    kilograms = record.outline.area * record.drive.disc_width * density * 1e-9
    shown = f"{kilograms:.4g} kg" if kilograms >= 0.1 else f"{1e3 * kilograms:.3g} g"
    return f"{shown} at {density:g} kg/m³"


def title_cells(record: DesignRecord, scale: str) -> tuple[TitleCell, ...]:
    """Fields of the title block."""
    fields = record.spec.export.drawing
    return (
        TitleCell(26, 0, 88, "title", title(record)),
        TitleCell(26, 88, 46, "drawing number", fields.number),
        TitleCell(26, 134, 18, "revision", fields.revision),
        TitleCell(26, 152, 14, "sheet", "{}/{}".format(*place_among_parts(record))),
        TitleCell(26, 166, 14, "format", "A3"),
        TitleCell(13, 0, 50, "material", material(record)),
        TitleCell(13, 50, 58, "heat treatment", fields.heat_treatment),
        TitleCell(13, 108, 34, "mass", mass_text(record)),
        TitleCell(13, 142, 20, "scale", scale),
        TitleCell(13, 162, 18, "units", "mm"),
        TitleCell(0, 0, 32, "drawn", fields.drawn_by),
        TitleCell(0, 32, 26, "date", fields.date),
        TitleCell(0, 58, 28, "checked", ""),
        TitleCell(0, 86, 28, "approved", ""),
        TitleCell(0, 114, 36, "general tolerances", fields.general_tolerance),
        TitleCell(0, 150, 30, "projection, first angle", ""),
    )


def tooth_data(record: DesignRecord, limits: Tolerances) -> tuple[TableRow, ...]:
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
        TableRow("profile, whole zone", "", _tolerance(limits.profile)),
        TableRow("single pitch deviation", "f_p", _tolerance(limits.single_pitch, "±")),
        TableRow("cumulative pitch deviation", "F_p", _tolerance(limits.cumulative_pitch)),
        TableRow("runout of the teeth", "F_r", _tolerance(limits.runout)),
        *(TableRow("datum", letter, name) for letter, name in _datums(record).items()),
        TableRow("mating pins", "", f"{t.pins} × Ø{2.0 * drive.pin_radius:g}"),
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


def notes(record: DesignRecord, limits: Tolerances, digest: str) -> tuple[str, ...]:
    """The notes: fixed ones, then those of the spec; ``digest`` is the sha256 of the spec."""
    fields = record.spec.export.drawing
    same = "identical" if record.profile.identical_lobes else "different"
    given = [
        f"Tooth curve: profile.dxf or profile.csv of spec {digest[:12]} (sha256).",
        f"{_root_1(record)}; {record.drive.trochoid.lobes} {same} lobes.",
        f"General tolerance {fields.general_tolerance}. Edges broken, teeth at most 0.2 × 45°.",
        "Framed sizes are theoretically exact (ISO 1101). Sizes at 20 °C.",
        f"Heat treatment: {fields.heat_treatment or '________________'}.",
        "Positive modification removes material.",
        *limits.notes,
    ]
    return (*given, *fields.notes)


def _datums(record: DesignRecord) -> dict[str, str]:
    """Names of the datums; the spec may name the axis."""
    names, given = datum_system(record).names, record.spec.export.drawing.datum
    return names | ({AXIS: given} if given else {})


def _root_1(record: DesignRecord) -> str:
    """Where root 1 is, seen from datum C."""
    datums = datum_system(record)
    turn = math.degrees(datums.direction_angle)
    if datums.direction is None:
        return "Root 1 at the top"
    name = datums.direction.name
    if not turn:
        return f"Root 1 on the axis through {name}, datum {DIRECTION}"
    return f"{name.capitalize()}, datum {DIRECTION}, {turn:.4f}° anticlockwise of root 1"


def _over(check: OverRollers) -> TableRow:
    seat = "root" if check.seat < _ON_ROOT else f"ψ ±{math.degrees(check.seat):.1f}°"
    return TableRow(f"over two rollers Ø{2.0 * check.roller_radius:g}, on {seat}", "M", _mm(check.size, 4))


def _mm(value: float, decimals: int = 3) -> str:
    return f"{value:.{decimals}f} mm"


def _um(value: float) -> str:
    return f"{value / UM + 0.0:+.2f} µm"


def _radius(value: float) -> str:
    return _mm(value) if math.isfinite(value) else "none"


def _tolerance(tolerance: ShownTolerance, sign: str = "") -> str:
    return sign + tolerance.in_unit(" mm")
