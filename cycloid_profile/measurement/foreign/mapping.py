"""Which column holds which quantity: the text of ``--columns``, and mappings remembered for the next file."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cycloid_profile.errors import MeasurementError, did_you_mean
from cycloid_profile.filesystem import new_file
from cycloid_profile.measurement._strict import finite_number
from cycloid_profile.measurement.foreign._vocabulary import DIMENSIONS, UNITS, interpret, unit_size
from cycloid_profile.measurement.kinds import kind_named
from cycloid_profile.spec import plain_text, toml_values

MAPPING_FILE = ".mapping.toml"
_OPTION = "--columns"
_NUMBERS = (
    "torque_nm", "output_angle_deg", "temperature_c", "probe_radius_mm", "noise_um", "noise_arcmin", "noise_arcsec",
)  # fmt: skip
_WORDS: dict[str, tuple[str, ...]] = {
    "datum": ("bore", "free"),
    "decimal": ("point", "comma"),
    "delimiter": ("semicolon", "comma", "tab", "blank", "bar"),
    "encoding": ("utf-8", "utf-16", "cp1252", "gb18030"),
    "points": ("measured", "nominal"),
}
# Facts of one file, which the next one need not share.
_OF_ONE_FILE = frozenset({"datum", "torque_nm", "output_angle_deg", "temperature_c", "specimen"})
_SETTINGS = ("unit", "kind", "specimen", *_NUMBERS, *_WORDS)
SIGNS = {"point": ".", "comma": ",", "semicolon": ";", "tab": "\t", "blank": " ", "bar": "|"}
_SOURCE = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\])?")
_HEAD = (
    "# Columns of measured files by their header, as --columns writes them; reused for the next file of that header."
)


@dataclass(frozen=True)
class ColumnSource:
    """A column by its name or its number from 1; ``unit`` as stated, "" where not; ``sign`` −1 of an inverted one."""

    column: str
    unit: str = ""
    sign: int = 1

    def __str__(self) -> str:
        unit = f"[{self.unit}]" if self.unit else ""
        return f"{'-' if self.sign < 0 else ''}{self.column}{unit}"


@dataclass(frozen=True)
class ColumnMapping:
    """Quantities with the columns that hold them, and settings: unit, kind, datum, torque_nm, probe_radius_mm …"""

    columns: Mapping[str, ColumnSource] = field(default_factory=dict)
    settings: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        words = [*(f"{role}={source}" for role, source in self.columns.items())]
        words += [f"{key}={value}" for key, value in self.settings.items()]
        return ",".join(f'"{word}"' if "," in word else word for word in words)


def parse_columns(text: str, what: str = _OPTION) -> ColumnMapping:
    """The mapping that ``x=X,y=Y,unit=mm`` writes; ``what`` names it in the message.

    Raises ``MeasurementError`` for a quantity, setting or unit that does not exist.
    """
    columns: dict[str, ColumnSource] = {}
    settings: dict[str, str] = {}
    for entry in next(csv.reader([text], skipinitialspace=True), []):
        key, equals, value = (part.strip() for part in entry.partition("="))
        key = key.lower()
        if not equals or not value:
            raise MeasurementError(what, f"'{entry}'", "has no value", "write x=X,y=Y,unit=mm", " ")
        if key in columns or key in settings:
            raise MeasurementError(what, f"'{key}'", "is given twice", "keep one", " ")
        if key in _SETTINGS:
            settings[key] = _checked_setting(key, value, what)
        elif key in DIMENSIONS:
            columns[key] = _source(key, value, what)
        else:
            remedy = did_you_mean(key, [*DIMENSIONS, *_SETTINGS], f"choose from {', '.join(DIMENSIONS)}")
            raise MeasurementError(what, f"'{key}'", "is not known", remedy, " ")
    return ColumnMapping(columns, settings)


def _source(role: str, value: str, what: str) -> ColumnSource:
    match = _SOURCE.fullmatch(value)
    name, unit = (match[1], match[2] or "") if match else (value, "")
    if unit and unit_size(unit, DIMENSIONS[role]) is None:
        known = ", ".join(list(UNITS.get(DIMENSIONS[role], {"none": 1.0}))[:12])
        raise MeasurementError(f"{what} {role}", f"'{unit}'", "is not a unit of it", f"choose from {known}")
    return ColumnSource(name.removeprefix("-"), unit, -1 if name.startswith("-") else 1)


def _checked_setting(key: str, value: str, what: str) -> str:
    if key in _WORDS and value.lower() not in _WORDS[key]:
        raise MeasurementError(f"{what} {key}", f"'{value}'", "is not known", f"choose from {', '.join(_WORDS[key])}")
    if key in _NUMBERS and finite_number(value) is None:
        raise MeasurementError(f"{what} {key}", f"'{value}'", "is not a number", "write a number without its unit")
    if key == "probe_radius_mm" and not 0.0 < float(value) < 50.0:
        raise MeasurementError(f"{what} {key}", value, "is not between 0 and 50 mm", "give the radius of the ball")
    if key == "kind":
        kind_named(value, f"{what} kind")
    if key == "unit" and all(unit_size(value, dimension) is None for dimension in UNITS):
        raise MeasurementError(f"{what} unit", f"'{value}'", "is not known", "write mm, inch, deg, arcmin or N·m")
    return value.lower() if key in _WORDS else value


def mapping_for(header: Sequence[str], mappings: Sequence[ColumnMapping]) -> ColumnMapping | None:
    """The first mapping whose columns all are in the ``header``; settings alone fit every file."""
    return next((one for one in mappings if all(_place(source.column, header) is not None
                                                for source in one.columns.values())), None)  # fmt: skip


def place_of(column: str, header: Sequence[str], what: str) -> int:
    """Position of a column given by name or number; raises ``MeasurementError`` if it is not there."""
    place = _place(column, header)
    if place is None:
        remedy = did_you_mean(column, header, "choose another")
        raise MeasurementError(what, f"'{column}'", f"is not a column among {', '.join(header)}", remedy)
    return place


def _place(column: str, header: Sequence[str]) -> int | None:
    names = [name.strip() for name in header]
    bare = [interpret(name).name for name in names]
    for known in (names, bare, [name.lower() for name in names], [name.lower() for name in bare]):
        for word in (column, column.lower()):
            if known.count(word) == 1:
                return known.index(word)
    if column.isascii() and column.isdigit() and 1 <= int(column) <= len(names):
        return int(column) - 1
    return None


def remembered(folder: Path, header: Sequence[str]) -> ColumnMapping | None:
    """The mapping that ``.mapping.toml`` of a folder holds for files of this header; None if it holds none."""
    file = folder / MAPPING_FILE
    for entry in _entries(file) or []:
        if entry.get("header") == list(header):
            return parse_columns(str(entry.get("columns", "")), str(file))
    return None


def remember(folder: Path, header: Sequence[str], mapping: ColumnMapping) -> Path | None:
    """Write the mapping of a header into ``.mapping.toml``, without facts of one file such as its torque.

    None if nothing is left to keep, the file there is not ours, or it cannot be written.
    """
    import tomli_w

    file = folder / MAPPING_FILE
    entries = _entries(file)
    lasting = {key: value for key, value in mapping.settings.items() if key not in _OF_ONE_FILE}
    kept_mapping = ColumnMapping(mapping.columns, lasting)
    if entries is None or not str(kept_mapping):
        return None
    kept = [entry for entry in entries if entry.get("header") != list(header)]
    text = tomli_w.dumps({"mapping": [*kept, {"header": list(header), "columns": str(kept_mapping)}]})
    try:
        with new_file(file) as scratch:
            scratch.write_text(f"{_HEAD}\n{text}", encoding="utf-8", newline="\n")
    except OSError:
        return None
    return file


def _entries(file: Path) -> list[dict[str, object]] | None:
    """Mappings of a file; none where there is no file, None where it is not ours."""
    try:
        text = plain_text(file)
        entries = toml_values(text).get("mapping")
    except FileNotFoundError:
        return []
    except (OSError, ValueError):
        return None
    tables = isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries)
    return entries if text.startswith(_HEAD) and tables else None
