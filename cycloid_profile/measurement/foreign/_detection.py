"""The meaning of the columns of a file, from the words and units of its header and the lines before it."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement._strict import finite_number
from cycloid_profile.measurement.foreign._vocabulary import (
    ANGLE,
    LENGTH,
    TORQUE,
    HeaderWord,
    interpret,
    unit_size,
    words_of,
)
from cycloid_profile.measurement.foreign.mapping import ColumnMapping, ColumnSource
from cycloid_profile.measurement.foreign.table import SourceTable, number
from cycloid_profile.measurement.kinds import HYSTERESIS, LOST_MOTION_MAP, PROFILE_SCAN, TRANSMISSION_ERROR, kind_named
from cycloid_profile.units import NEWTON_METRE

# Sets of quantities that make a kind, the first that a file has; optional ones in the second tuple.
_SCAN_EXTRAS = ("deviation", "normal_x", "normal_y")
_TORQUE = ("torque",)
RECIPES: tuple[tuple[str, tuple[str, ...], tuple[str, ...]], ...] = (
    (LOST_MOTION_MAP.name, ("output_angle", "lost_motion"), _TORQUE),
    (LOST_MOTION_MAP.name, ("angle", "lost_motion"), _TORQUE),
    (TRANSMISSION_ERROR.name, ("output_angle", "error"), _TORQUE),
    (TRANSMISSION_ERROR.name, ("angle", "error"), _TORQUE),
    (HYSTERESIS.name, ("torque", "angle"), ()),
    (HYSTERESIS.name, ("torque", "output_angle"), ()),
    (PROFILE_SCAN.name, ("x", "y"), _SCAN_EXTRAS),
    (PROFILE_SCAN.name, ("radius", "polar_angle"), ("deviation",)),
    (PROFILE_SCAN.name, ("radius", "angle"), ("deviation",)),
    (PROFILE_SCAN.name, ("nominal_x", "nominal_y", "deviation"), ("normal_x", "normal_y")),
)
_RING = 2.0  # largest over smallest radius of a scan of one disc
_COVERED = math.pi  # angle that points without a header must cover to be a scan [rad]
_KEY_WORDS = {
    "specimen": (
        "specimen",
        "serial",
        "serial number",
        "part",
        "teil",
        "werkstück",
        "probe nr",
        "编号",
        "工件",
        "试件",
    ),
    "temperature_c": ("temperature", "temperatur", "temp", "温度"),
    "unit": ("unit", "units", "einheit", "einheiten", "单位"),
    "datum": ("datum", "bezug"),
    "kind": ("kind",),
}
_CONTRACT_KEYS = ("output_angle_deg", "noise_um", "noise_arcmin", "noise_arcsec", "torque_nm", "temperature_c")
_VALUE = re.compile(r"(?:±|\+/?-)?\s*([+-]?[\d.,]+(?:[eE][+-]?\d+)?)\s*(.*)", re.ASCII | re.DOTALL)


def complete(table: SourceTable, given: ColumnMapping | None) -> ColumnMapping:
    """The whole mapping of a file: what was ``given``, else what its header says.

    Raises ``MeasurementError`` if the columns do not make one of the four kinds.
    """
    stated, wanted = {**_settings(table), **table.settings}, dict(given.settings) if given else {}
    for key in ("torque_nm", "output_angle_deg"):
        if key in stated and key in wanted and finite_number(stated[key]) != finite_number(wanted[key]):
            limit, remedy = f"is not the {stated[key]} that the file states", "correct one of them"
            raise MeasurementError(f"{table.name}: --columns {key}", wanted[key], limit, remedy)
    settings = {**stated, **wanted}
    if "kind" in settings:
        kind_named(settings["kind"], f"{table.name}: kind")
    chosen = dict(given.columns) if given else {}
    found = _from_header(table, chosen) if table.has_header else {} if chosen else _from_points(table)
    kind, roles = _recipe(table, {**found, **chosen}, chosen, settings.get("kind"))
    kept = {role: chosen.get(role) or found[role] for role in roles}
    return ColumnMapping(kept, {**settings, "kind": kind})


def headers(table: SourceTable) -> list[HeaderWord]:
    """Name, unit and quantity of each column."""
    return [interpret(name, unit) for name, unit in zip(table.columns, table.units, strict=True)]


def _from_header(table: SourceTable, chosen: Mapping[str, ColumnSource]) -> dict[str, ColumnSource]:
    """Columns by the words of their names; raises ``MeasurementError`` for two of one quantity that is not chosen."""
    found: dict[str, ColumnSource] = {}
    twice = []
    words = headers(table)
    names = [word.name for word in words]
    for place, word in enumerate(words):
        if not word.role:
            continue
        if word.role in found and word.role not in chosen:
            twice.append(word.name)
        clear = names.count(word.name) == 1 and not set(',="[]') & set(word.name) and not word.name.startswith("-")
        found.setdefault(word.role, ColumnSource(word.name if clear else str(place + 1), word.unit))
    if twice:
        limit, remedy = "mean the same quantity as another column", "choose with --columns, such as x=X,y=Y,unit=mm"
        raise MeasurementError(f"{table.name}: columns", _quoted(twice), limit, remedy, " ")
    return found


def _from_points(table: SourceTable) -> dict[str, ColumnSource]:
    """Columns x and y of points without a header, if they lie in a ring as those of a disc do."""
    rows = [[number(cell, table.decimal) for cell in row] for _, row in table.rows]
    full = [row for row in rows if len(row) == len(table.columns) and None not in row]
    values = np.array(full, dtype=np.float64)
    for first in range(min(len(table.columns) - 1, 2) if len(full) > 2 else 0):
        z = values[:, first] + 1j * values[:, first + 1]
        radius = np.abs(z)
        angles = np.sort(np.angle(z))
        gap = float(np.max(np.diff(angles, append=angles[0] + 2.0 * math.pi)))
        if radius.min() > 0.0 and radius.max() < _RING * radius.min() and 2.0 * math.pi - gap > _COVERED:
            return {"x": ColumnSource(str(first + 1)), "y": ColumnSource(str(first + 2))}
    limit = "has no names of its columns"
    remedy = "name them with --columns, such as x=1,y=2,unit=mm or torque=1,angle=2[deg]"
    raise MeasurementError(table.name, "the file", limit, remedy, ": ")


def _recipe(
    table: SourceTable, columns: Mapping[str, ColumnSource], chosen: Mapping[str, ColumnSource], kind: str | None
) -> tuple[str, Sequence[str]]:
    """The kind and its quantities: those of the columns that use all ``chosen`` ones."""
    for name, needed, optional in RECIPES:
        if kind in (None, name) and all(role in columns for role in needed) and set(chosen) <= {*needed, *optional}:
            return name, (*needed, *(role for role in optional if role in columns))
    known = f"understood are {', '.join(columns)}" if columns else "none is understood"
    what = f"are no {kind}" if kind else "do not say which kind of measurement this is"
    raise MeasurementError(
        f"{table.name}: columns",
        _quoted(table.columns),
        f"{what}; {known}",
        "name them with --columns, such as x=X,y=Y,unit=mm or torque=M[N·m],angle=phi[deg]",
        " ",
    )


def _quoted(names: Sequence[str]) -> str:
    shown = [f"'{name}'" for name in names[:12]]
    return ", ".join(shown) + (f" and {len(names) - 12} more" if len(names) > 12 else "")


def _settings(table: SourceTable) -> dict[str, str]:
    """Settings among the words before the header; raises ``MeasurementError`` for two values of one setting."""
    found: dict[str, str] = {}
    for key, value in table.keys:
        setting, meant = _setting(key, value, table.decimal)
        if setting and found.setdefault(setting, meant) != meant:
            limit, remedy = "are two values of one key", f"keep one, or add --columns {setting}=…"
            raise MeasurementError(f"{table.name}: {setting}", f"'{found[setting]}' and '{meant}'", limit, remedy, " ")
    return found


def _setting(key: str, value: str, decimal: str) -> tuple[str, str]:
    """Name and value of the setting that a line before the header makes; empty names where it makes none."""
    if key in _CONTRACT_KEYS:
        return key, value
    setting = next((name for name, spellings in _KEY_WORDS.items() if key in spellings), "")
    quantity = _quantity(value, decimal)
    if setting == "datum":
        return (setting, value.lower()) if value.lower() in {"bore", "free"} else ("", "")
    if setting == "unit":
        return (setting, value) if any(unit_size(value, each) is not None for each in (LENGTH, ANGLE)) else ("", "")
    if setting == "temperature_c":
        return (setting, f"{quantity[0]:.12g}") if quantity else ("", "")
    if setting:
        return setting, value
    word = interpret(key)
    # "Load: 412 Nm" is the torque of the measurement, "rated torque: 412 Nm" is not.
    if quantity and words_of(word.name) <= {"torque", "output"}:
        size = unit_size(quantity[1] or word.unit or ("nm" if word.role else ""), TORQUE)
        return ("torque_nm", f"{quantity[0] * size / NEWTON_METRE:.12g}") if size is not None else ("", "")
    return "", ""


def _quantity(text: str, decimal: str) -> tuple[float, str] | None:
    """Number and unit of a value such as ``412 Nm``."""
    match = _VALUE.fullmatch(text.strip())
    values = [number(match[1], sign) for sign in (decimal, ".", ",")] if match else []
    value = next((each for each in values if each is not None), None)
    return (value, match[2].strip()) if match and value is not None else None


def with_units(table: SourceTable, mapping: ColumnMapping) -> ColumnMapping:
    """The mapping with the units of the header where it states none itself."""
    from cycloid_profile.measurement.foreign.mapping import place_of

    words = headers(table)
    columns = {}
    for role, source in mapping.columns.items():
        place = place_of(source.column, table.columns, f"{table.name}: --columns {role}")
        columns[role] = source if source.unit else replace(source, unit=words[place].unit)
    return ColumnMapping(columns, mapping.settings)
