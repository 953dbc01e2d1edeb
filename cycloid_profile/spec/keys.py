"""Help for a wrong key: the nearest known one, the right unit, the remedy written in the model."""

from __future__ import annotations

import difflib
import re
import typing
from typing import Any

import msgspec

from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.table import Table
from cycloid_profile.units import ARCMIN

_SEE = "see docs/spec.md"

# Size of each unit in the first of its family; a key's suffix names one of them.
_UNITS = {
    "nm": ("length", 1e-6), "um": ("length", 1e-3), "mm": ("length", 1.0), "cm": ("length", 10.0),
    "m": ("length", 1e3), "in": ("length", 25.4), "inch": ("length", 25.4),
    "mpa": ("stress", 1e-3), "gpa": ("stress", 1.0), "pa": ("stress", 1e-9),
    "nm_torque": ("torque", 1.0), "nmm": ("torque", 1e-3),
    "rad": ("angle", 1.0 / ARCMIN), "deg": ("angle", 60.0), "arcmin": ("angle", 1.0),
    "arcsec": ("angle", 1 / 60.0),
    "n_per_mm": ("stiffness", 1.0), "n_per_um": ("stiffness", 1e3), "n_per_m": ("stiffness", 1e-3),
}  # fmt: skip


def nearest(key: str, known: list[str], path: str) -> str:
    """Remedy for an unknown ``key``: the nearest known name at ``path``, or where else it belongs."""
    close = difflib.get_close_matches(key, known, n=1, cutoff=0.6)
    if close:
        return f"did you mean {path}{close[0]}?"
    for other_path, names in _all_keys():
        if key in names and other_path != path:
            return f"did you mean {other_path}{key}?"
    return f"known here are {', '.join(known)}" if len(known) <= 12 else "see docs for the list of names"


def wrong_unit(key: str, value: Any, known: list[str]) -> tuple[str, str] | None:
    """Limit and remedy if ``key`` is a known one under another unit, else None."""
    stem, unit = _split(key)
    for name in known:
        name_stem, name_unit = _split(name)
        if name_stem != stem or name_unit is None or name == key:
            continue
        if unit is None:
            return f"has no unit in its key, which is {name}", f"write {name} and give the value in that unit"
        limit = f"carries the wrong unit, the key is {name}"
        if isinstance(value, int | float) and not isinstance(value, bool):
            (family, size), (name_family, name_size) = _UNITS[unit], _UNITS[name_unit]
            if family == name_family:
                return limit, f"write {name} = {value * size / name_size:.10g}"
        return limit, f"write {name} and convert the value"
    return None


def tables_in(annotation: Any) -> list[type[Table]]:
    """The spec tables inside a field's type, seen through unions, tuples and annotations."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return [annotation]
    return [table for inner in typing.get_args(annotation) for table in tables_in(inner)]


def remedy_for(path: str) -> str:
    """The remedy the model gives for the key at ``path``."""
    table: type[Table] = Spec
    keys = re.findall(r"[^.\[\]]+", path)
    for position, key in enumerate(keys):
        fields = {field.name: field for field in msgspec.structs.fields(table)}
        if key.isdigit() or key not in fields:
            continue
        annotation = fields[key].type
        if position == len(keys) - 1 or not tables_in(annotation):
            choices, meta = choices_in(annotation), meta_in(annotation)
            if choices:
                return f"choose from {', '.join(choices)}"
            return str(meta.extra["remedy"]) if meta is not None and meta.extra else _SEE
        table = tables_in(annotation)[0]
    return _SEE


def meta_in(annotation: Any) -> msgspec.Meta | None:
    """The model's note on a key: description, limits, remedy; None where it has none."""
    for meta in getattr(annotation, "__metadata__", ()):
        if isinstance(meta, msgspec.Meta):
            return meta
    found = (meta_in(inner) for inner in typing.get_args(annotation))
    return next((meta for meta in found if meta is not None), None)


def choices_in(annotation: Any) -> list[str]:
    """The words a key may take, empty where it is free."""
    if typing.get_origin(annotation) is typing.Literal:
        return [str(choice) for choice in typing.get_args(annotation)]
    return [choice for inner in typing.get_args(annotation) for choice in choices_in(inner)]


def _split(key: str) -> tuple[str, str | None]:
    """Stem and unit suffix of a key; torque's _nm is told from nanometres by its stem."""
    for unit in sorted(_UNITS, key=len, reverse=True):
        if key.endswith(f"_{unit}"):
            stem = key[: -len(unit) - 1]
            return stem, "nm_torque" if unit == "nm" and "torque" in stem else unit
    return key, None


def _all_keys(table: type[Table] = Spec, path: str = "") -> list[tuple[str, list[str]]]:
    fields = msgspec.structs.fields(table)
    found = [(path, [field.name for field in fields])]
    for field in fields:
        for inner in tables_in(field.type):
            found += _all_keys(inner, f"{path}{field.name}.")
    return found
