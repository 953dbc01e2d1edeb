"""From the cells of a file to a measurement in the units of its kind, with a sentence on what was understood."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement._strict import finite_number, joined
from cycloid_profile.measurement.files import Measurement, PendingSteps, key_faults
from cycloid_profile.measurement.foreign._detection import complete, headers, with_units
from cycloid_profile.measurement.foreign._vocabulary import ANGLE, DIMENSIONS, LENGTH, TORQUE, unit_size
from cycloid_profile.measurement.foreign.mapping import ColumnMapping, ColumnSource, place_of
from cycloid_profile.measurement.foreign.table import SourceTable, grouped_number, number, number_with_unit
from cycloid_profile.measurement.kinds import HYSTERESIS, PROFILE_SCAN, MeasurementKind, kind_named
from cycloid_profile.units import ARCMIN, ARCSEC, DEGREE, NEWTON_METRE

_STEADY = 0.05  # largest relative deviation of a torque that was held
_TURN = 360.0  # degrees
_RADIANS = 6.4  # a turn in rad, with its last step
# Units that are taken where the file states none: those of the four kinds. Angles that are measured have none.
_DEFAULT_UNITS = {LENGTH: "mm", TORQUE: "N·m"}
_NOUNS = {LENGTH: "a length", ANGLE: "an angle", TORQUE: "a torque"}
_MEASURED_ANGLES = ("angle", "error", "lost_motion")


def measurement_of(table: SourceTable, given: ColumnMapping | None = None) -> Measurement:
    """The measurement that a table holds; ``given``, its mapping where the header does not say enough.

    Raises ``MeasurementError`` with all faults of the file: cells that are no numbers, units and keys that are missing.
    """
    mapping = with_units(table, complete(table, given))
    kind = kind_named(mapping.settings["kind"], f"{table.name}: kind")
    values, faults = _values(table, mapping)
    if not faults and len(table.rows) < 2:
        faults.append(MeasurementError(f"{table.name}: rows", len(table.rows), "are too few", "give at least two"))
    if faults:
        raise joined(faults)
    sizes, assumed = _unit_sizes(table, mapping, kind, values)
    base = {role: values[role] * sizes[role] for role in values}
    keys = _keys(table, mapping, kind, base)
    missing = key_faults(keys, kind, table.name)
    if missing:
        raise joined([_by_option(fault) for fault in missing])
    columns, pending = _FINISH[kind.name](base, mapping)
    note = _note(table, mapping, kind, keys, assumed)
    return Measurement(kind, columns, keys, table.name, (note,), pending)


def _values(table: SourceTable, mapping: ColumnMapping) -> tuple[dict[str, FloatArray], list[MeasurementError]]:
    """Numbers of each mapped column with its sign, and a fault for each line with a cell that is none."""
    faults = []
    places = {
        role: place_of(source.column, table.columns, f"{table.name}: --columns {role}")
        for role, source in mapping.columns.items()
    }
    found: list[list[float]] = []
    for line, row in table.rows:
        cells = [row[place] if place < len(row) else "" for place in places.values()]
        numbers = [number(cell, table.decimal) for cell in cells]
        bad = [cell for cell, value in zip(cells, numbers, strict=True) if value is None or not math.isfinite(value)]
        if bad:
            limit, remedy = "is not a finite number", _remedy(bad[0], table.decimal)
            faults.append(MeasurementError(f"{table.name}: {table.place} {line}", f"'{bad[0][:40]}'", limit, remedy))
        else:
            found.append([value for value in numbers if value is not None])
    signs = [source.sign for source in mapping.columns.values()]
    values = np.array(found, dtype=np.float64).reshape(-1, len(places)) * signs
    return dict(zip(places, values.T.copy(), strict=True)), faults


def _remedy(cell: str, decimal: str) -> str:
    """What to do about a cell that is no number."""
    if not cell:
        return "fill the cell or delete the row"
    if grouped_number(cell, decimal) or ("." in cell and "," in cell):
        return "export numbers without thousands separators"
    if number_with_unit(cell, decimal):
        return "write the unit into the header, not into the cells"
    if any(number(cell, sign) is not None for sign in ".," if sign != decimal):
        return f"write all numbers with a decimal {'comma' if decimal == ',' else 'point'}"
    return "give a number or delete the row"


def _unit_sizes(
    table: SourceTable, mapping: ColumnMapping, kind: MeasurementKind, values: dict[str, FloatArray]
) -> tuple[dict[str, float], list[str]]:
    """Size of the unit of each column in base units, and the units that nobody stated, in words."""
    sizes: dict[str, float] = {}
    assumed, faults = [], []
    for role, source in mapping.columns.items():
        dimension = DIMENSIONS[role]
        unit = source.unit or _general_unit(mapping, role, kind)
        if not unit and dimension:
            unit = _DEFAULT_UNITS.get(dimension) or _unit_of_turn(role, kind, values[role])
            assumed += [f"{role} in {unit}"] if unit else []
        size = unit_size(unit, dimension) if dimension else 1.0
        if size is None:
            value, limit = (f"'{unit}'", f"is no unit of {_NOUNS[dimension]}") if unit else ("not given", "is needed")
            what = f"{table.name}: unit of column '{source.column}'"
            faults.append(MeasurementError(what, value, limit, f"give --columns {_example(mapping, role)}"))
        else:
            sizes[role] = size
    if faults:
        raise joined(faults)
    return sizes, assumed


def _general_unit(mapping: ColumnMapping, role: str, kind: MeasurementKind) -> str:
    """The unit that ``unit=`` states, for lengths of a scan or for the measured column of a curve."""
    unit = mapping.settings.get("unit", "")
    dimension = DIMENSIONS[role]
    measured = dimension == LENGTH if kind is PROFILE_SCAN else role in _MEASURED_ANGLES
    return unit if unit and measured and unit_size(unit, dimension) is not None else ""


def _unit_of_turn(role: str, kind: MeasurementKind, values: FloatArray) -> str:
    """Unit of an angle round the output or the disc, from its range; "" for a measured angle."""
    if role in {"error", "lost_motion"} or kind is HYSTERESIS:
        return ""
    span = float(np.ptp(values))
    return "rad" if np.max(np.abs(values)) < _RADIANS and span > 0.5 * _RADIANS else "deg"


def _example(mapping: ColumnMapping, role: str) -> str:
    example = {LENGTH: "mm", ANGLE: "arcmin", TORQUE: "N·m"}[DIMENSIONS[role]]
    words = [
        f"{each}={ColumnSource(source.column, example if each == role else source.unit, source.sign)}"
        for each, source in mapping.columns.items()
    ]
    return f"'{','.join(words)}'"


def _keys(
    table: SourceTable, mapping: ColumnMapping, kind: MeasurementKind, base: dict[str, FloatArray]
) -> dict[str, str]:
    """Keys of the measured file; a torque that was held comes from its column."""
    internal = {"unit", "kind", "probe_radius_mm", "decimal", "delimiter", "encoding", "points"}
    keys = {key: value for key, value in mapping.settings.items() if key not in internal}
    if kind is PROFILE_SCAN:
        keys.setdefault("datum", "bore")
    if kind.over_output_turn and "torque" in base:
        torque = base["torque"] / NEWTON_METRE
        middle = float(np.mean(torque))
        held = finite_number(keys.setdefault("torque_nm", f"{middle:.6g}"))
        if held is not None and np.max(np.abs(torque - held)) > _STEADY * abs(middle):
            span, limit = f"{torque.min():.4g} to {torque.max():.4g} N·m", f"was not held at {held:g} N·m"
            remedy = "split the file by torque, or correct the torque that is stated"
            raise MeasurementError(f"{table.name}: torque", span, limit, remedy, " ")
    return keys


def _by_option(fault: MeasurementError) -> MeasurementError:
    key = fault.what.rpartition(": ")[2]
    remedy = f"add --columns {key}=…" if fault.value == "not given" else fault.remedy
    return MeasurementError(fault.what, fault.value, fault.limit, remedy, fault.joint)


Finished = tuple[dict[str, FloatArray], PendingSteps | None]


def _scan(base: dict[str, FloatArray], mapping: ColumnMapping) -> Finished:
    probe_radius = float(mapping.settings.get("probe_radius_mm", "0"))
    deviation = base.get("deviation")
    stated = mapping.settings.get("points")
    if "radius" in base:
        angle = base["polar_angle"] if "polar_angle" in base else base["angle"]
        z = base["radius"] * np.exp(1j * angle)
    elif "nominal_x" in base:
        z, stated = base["nominal_x"] + 1j * base["nominal_y"], "nominal"
    else:
        z = base["x"] + 1j * base["y"]
    if stated == "nominal" and deviation is not None and "normal_x" in base:
        normal = base["normal_x"] + 1j * base["normal_y"]
        z, deviation = z + deviation * normal / np.abs(normal), None
    pending = None
    if probe_radius or (deviation is not None and stated != "measured"):
        pending = PendingSteps(probe_radius, None if stated == "measured" else deviation, stated == "nominal")
    return {"x_mm": z.real.copy(), "y_mm": z.imag.copy()}, pending


def _loop(base: dict[str, FloatArray], _: ColumnMapping) -> Finished:
    angle = base["angle"] if "angle" in base else base["output_angle"]
    return {"torque_nm": base["torque"] / NEWTON_METRE, "angle_arcmin": angle / ARCMIN}, None


def _over_turn(value: str, column: str, unit: float) -> Callable[[dict[str, FloatArray], ColumnMapping], Finished]:
    def finish(base: dict[str, FloatArray], _: ColumnMapping) -> Finished:
        angle = base["output_angle"] if "output_angle" in base else base["angle"]
        return {"output_angle_deg": angle / DEGREE, column: base[value] / unit}, None

    return finish


_FINISH: dict[str, Callable[[dict[str, FloatArray], ColumnMapping], Finished]] = {
    "profile_scan": _scan,
    "hysteresis": _loop,
    "transmission_error": _over_turn("error", "error_arcsec", ARCSEC),
    "lost_motion_map": _over_turn("lost_motion", "lost_motion_arcmin", ARCMIN),
}


def _note(
    table: SourceTable, mapping: ColumnMapping, kind: MeasurementKind, keys: dict[str, str], assumed: Sequence[str]
) -> str:
    """What was understood, in one sentence."""
    used = {
        place_of(source.column, table.columns, f"{table.name}: --columns {role}")
        for role, source in mapping.columns.items()
    }
    parts = [f"read as {kind.title}, {len(table.rows)} rows", f"columns {ColumnMapping(mapping.columns)}", table.layout]
    if assumed:
        parts.append(f"no unit stated, taken as {' and '.join(assumed)}")
    names = enumerate(headers(table) if table.has_header else [])
    unused = [word.name for place, word in names if word.name and place not in used]
    if unused:
        parts.append(f"not used: {', '.join(unused)}")
    if kind is PROFILE_SCAN:
        said = "datum" in mapping.settings
        parts.append(
            "the origin is unknown (datum free)"
            if keys["datum"] == "free"
            else f"the origin is the bore axis (datum bore{'' if said else ', as nothing else is said'})"
        )
    if "torque_nm" in keys:
        parts.append(f"torque {keys['torque_nm']} N·m")
    return "; ".join(part for part in parts if part)
