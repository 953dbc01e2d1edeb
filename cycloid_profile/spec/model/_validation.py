"""Validation of plain values against the tables: each refusal has the key, the value, the limit and the remedy."""

from __future__ import annotations

import json
import math
import re
import typing
from functools import cache
from typing import Any

import msgspec

from cycloid_profile.errors import SpecError, nearest_name
from cycloid_profile.units import ARCMIN

_SEE = "see docs/spec.md"
_LONGEST_SHOWN = 60  # characters of a refused value in a sentence
_FAULT = re.compile(r"^(?P<rule>.*?)(?: - at `\$\.?(?P<path>.*)`)?$", re.DOTALL)
_RULES = (
    (re.compile(r"^Expected `str` (?:matching regex|of length).*$"), "must be one line of at most 80 characters"),
    (re.compile(r"^Expected `(?:int|float)` (?P<op>[<>]=?) (?P<bound>.+)$"), r"must be \g<op> \g<bound>"),
    (re.compile(r"^Expected `(?P<want>.+)`, got `(?P<got>.+)`$"), r"must be of type \g<want>, not \g<got>"),
    (re.compile(r"^Invalid enum value .*$"), "is not one of the choices"),
)
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


def validated(raw: Any, annotation: Any, path: str = "") -> Any:
    """Plain values (dictionaries, lists, numbers) as a value of the type ``annotation``.

    ``path`` is the dotted place of ``raw`` in the spec file, empty at its top. Raises ``SpecError``.
    """
    prefix = f"{path}." if path else ""
    for table in tables_in(annotation):
        for entry in raw if isinstance(raw, list | tuple) else (raw,):
            if isinstance(entry, dict):
                _refuse_unknown_keys(entry, table, "", table, prefix)
    _refuse_not_finite(raw, path)
    try:
        return msgspec.convert(msgspec.to_builtins(raw, enc_hook=_plain_number), annotation)
    except msgspec.ValidationError as error:
        raise _as_spec_error(str(error), raw, annotation, path) from None


def shown(value: Any) -> str:
    """A value as messages show it: strings in quotes, tables as {…}, long text cut."""
    if isinstance(value, dict):
        return "{…}"
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


@cache
def fields_of(table: type[msgspec.Struct]) -> dict[str, Any]:
    """Name and annotated type of each key of a table."""
    return {field.name: field.type for field in msgspec.structs.fields(table)}


def tables_in(annotation: Any) -> list[type[msgspec.Struct]]:
    """The spec tables inside a key's type, seen through unions, tuples and annotations."""
    if isinstance(annotation, type) and issubclass(annotation, msgspec.Struct):
        return [annotation]
    return [table for inner in typing.get_args(annotation) for table in tables_in(inner)]


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


def _plain_number(value: Any) -> Any:
    """A numpy number as the number of Python that it holds."""
    if hasattr(value, "item"):
        return value.item()
    raise SpecError("spec", shown(value), f"is of type {type(value).__name__}", "give text, numbers, lists or tables")


def _refuse_unknown_keys(
    raw: dict[str, Any], table: type[msgspec.Struct], path: str, root: type[msgspec.Struct], prefix: str
) -> None:
    """Raise on the first unknown key of ``raw`` at ``path`` below ``root``, whose path in the file is ``prefix``."""
    known = fields_of(table)
    for key, value in raw.items():
        if key not in known:
            limit, remedy = _wrong_unit(key, value, list(known)) or (
                "is not a key of the spec file",
                _nearest(key, list(known), path, root, prefix),
            )
            raise SpecError(f"{prefix}{path}{key}", shown(value), limit, remedy)
        for inner in tables_in(known[key]):
            for entry in value if isinstance(value, list | tuple) else (value,):
                if isinstance(entry, dict):
                    _refuse_unknown_keys(entry, inner, f"{path}{key}.", root, prefix)


def _refuse_not_finite(raw: Any, path: str) -> None:
    if isinstance(raw, float) and not math.isfinite(raw):
        raise SpecError(path, raw, "is not a finite number", "give a number")
    items = raw.items() if isinstance(raw, dict) else enumerate(raw) if isinstance(raw, list | tuple) else ()
    for key, value in items:
        _refuse_not_finite(value, f"{path}.{key}" if path else str(key))


def _as_spec_error(message: str, raw: Any, annotation: Any, prefix: str) -> SpecError:
    """msgspec's message, with the value looked up and the remedy from the model."""
    match = _FAULT.match(message)
    assert match is not None
    rule, path = match["rule"], match["path"] or ""
    missing = re.match(r"Object missing required field `(.+)`", rule)
    if missing:
        path = f"{path}.{missing[1]}".lstrip(".")
        return SpecError(
            _joined(prefix, path), "is missing", "though it has no default", _remedy(path, annotation), " "
        )
    for pattern, wording in _RULES:
        if pattern.match(rule):
            rule = pattern.sub(wording, rule)
            break
    return SpecError(_joined(prefix, path) or "spec", shown(_value_at(raw, path)), rule, _remedy(path, annotation))


def _joined(prefix: str, path: str) -> str:
    return f"{prefix}{'.' if prefix and path and path[0] != '[' else ''}{path}"


def _value_at(raw: Any, path: str) -> Any:
    for key in re.findall(r"[^.\[\]]+", path):
        raw = raw[int(key)] if isinstance(raw, list | tuple) else raw.get(key) if isinstance(raw, dict) else None
    return raw


def _remedy(path: str, annotation: Any) -> str:
    """The remedy the model gives for the key at ``path`` below a value of type ``annotation``."""
    for key in re.findall(r"[^.\[\]]+", path):
        known = fields_of(tables_in(annotation)[0]) if tables_in(annotation) else {}
        annotation = known.get(key, annotation)
    choices, meta = choices_in(annotation), meta_in(annotation)
    if tables_in(annotation):
        return _SEE
    if choices:
        return f"choose from {', '.join(choices)}"
    return str(meta.extra["remedy"]) if meta is not None and meta.extra else _SEE


def _nearest(key: str, known: list[str], path: str, root: type[msgspec.Struct], prefix: str) -> str:
    """Remedy for an unknown ``key``: the same key of another table, else the nearest name at ``path``."""
    for other, names in _all_keys(root, ""):
        if key in names:
            return f"did you mean {prefix}{other}{key}?"
    close = nearest_name(key, known)
    if close:
        return f"did you mean {prefix}{path}{close}?"
    return f"known here are {', '.join(known)}" if len(known) <= 16 else _SEE


def _all_keys(table: type[msgspec.Struct], path: str) -> list[tuple[str, list[str]]]:
    found = [(path, list(fields_of(table)))]
    for name, annotation in fields_of(table).items():
        for inner in tables_in(annotation):
            found += _all_keys(inner, f"{path}{name}.")
    return found


def _wrong_unit(key: str, value: Any, known: list[str]) -> tuple[str, str] | None:
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


def _split(key: str) -> tuple[str, str | None]:
    """Stem and unit suffix of a key; the suffix _nm of a torque is N·m, of a length nanometres."""
    for unit in sorted(_UNITS, key=len, reverse=True):
        if key.endswith(f"_{unit}"):
            stem = key[: -len(unit) - 1]
            return stem, "nm_torque" if unit == "nm" and "torque" in stem else unit
    return key, None
