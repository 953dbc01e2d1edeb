"""Validation of plain values against the tables: each refusal has the key, the value, the limit and the remedy."""

from __future__ import annotations

import math
import re
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import msgspec

from cycloid_profile.errors import SpecError
from cycloid_profile.spec.model.checks._suggestions import Keys, fields_of, shown, tables_in

_SEE = "see docs/spec.md"
_LONGEST_SHOWN = 60  # characters of a refused value in a sentence
_FAULT = re.compile(r"^(?P<rule>.*?)(?: - at `\$\.?(?P<path>.*)`)?$", re.DOTALL)
_RULES = (
    (re.compile(r"^Expected `str` (?:matching regex|of length).*$"), "must be one line of at most 80 characters"),
    (re.compile(r"^Expected `(?:int|float)` (?P<op>[<>]=?) (?P<bound>.+)$"), r"must be \g<op> \g<bound>"),
    (re.compile(r"^Expected `(?P<want>.+)`, got `(?P<got>.+)`$"), r"must be of type \g<want>, not \g<got>"),
    (re.compile(r"^Invalid enum value .*$"), "is not one of the choices"),
)


@dataclass(frozen=True)
class Alternative:
    """A key that users may write in place of another, ``replaces``; ``values`` gives the keys that it stands for."""

    name: str
    annotation: Any
    replaces: str
    values: Callable[[Any], Mapping[str, Any]]


def validated(raw: Any, annotation: Any, path: str = "") -> Any:
    """Plain values (dictionaries, lists, numbers) as a value of the type ``annotation``.

    ``path`` is the dotted place of ``raw`` in the spec file, empty at its top. Raises ``SpecError`` with every fault.
    """
    tables = tables_in(annotation)
    plain = msgspec.to_builtins(raw, enc_hook=_plain_number)
    value, faults = _checked(plain, annotation, path, Keys(tables[0] if tables else None, path))
    if faults:
        raise SpecError.of(faults)
    try:
        return msgspec.convert(value, annotation)
    except msgspec.ValidationError as error:
        raise _as_spec_error(str(error), value, annotation, path) from None


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


def _checked(raw: Any, annotation: Any, path: str, keys: Keys) -> tuple[Any, list[SpecError]]:
    """A plain value with alternative keys replaced, and its faults."""
    tables = tables_in(annotation)
    if tables and isinstance(raw, dict):
        return _checked_table(raw, tables[0], path, keys)
    if tables and isinstance(raw, list):
        checked = [
            _checked_table(entry, tables[0], f"{path}[{i}]", keys) if isinstance(entry, dict) else (entry, [])
            for i, entry in enumerate(raw, start=1)
        ]
        return [value for value, _ in checked], [fault for _, faults in checked for fault in faults]
    infinite = list(_not_finite(raw, path))
    if infinite:
        return raw, infinite
    try:
        msgspec.convert(raw, annotation)
    except msgspec.ValidationError as error:
        return raw, [_as_spec_error(str(error), raw, annotation, path)]
    return raw, []


def _checked_table(
    raw: dict[str, Any], table: type[msgspec.Struct], path: str, keys: Keys
) -> tuple[dict[str, Any], list[SpecError]]:
    """The keys of one table, each checked by itself so that one fault hides no other."""
    known = fields_of(table)
    given, faults = _without_alternatives(raw, table, path)
    # A key that an unknown or refused one stands for is not missing as well.
    meant = {alternative.replaces for alternative in alternatives_of(table) if alternative.name in raw}
    checked: dict[str, Any] = {}
    for key, value in given.items():
        if key not in known:
            found = keys.suggestion(key, value, path)
            meant.add(found.key)
            faults.append(SpecError(_joined(path, key), shown(value), found.limit, found.remedy))
            continue
        checked[key], inner = _checked(value, known[key], _joined(path, key), keys)
        faults += inner
    for field in msgspec.structs.fields(table):
        if field.required and field.name not in checked and field.name not in meant:
            remedy = _remedy(field.name, table)
            faults.append(SpecError(_joined(path, field.name), "is missing", "though it has no default", remedy, " "))
    further: Callable[[Mapping[str, Any]], Iterable[SpecError]] = getattr(table, "further_faults", lambda _: ())
    return checked, [*faults, *further(checked)]


def alternatives_of(table: type[msgspec.Struct]) -> tuple[Alternative, ...]:
    """Keys of a table that stand for others."""
    found: tuple[Alternative, ...] = getattr(table, "alternatives", ())
    return found


def _without_alternatives(
    raw: dict[str, Any], table: type[msgspec.Struct], path: str
) -> tuple[dict[str, Any], list[SpecError]]:
    """The keys of a table with the alternative ones replaced, and the faults of those."""
    given, faults = dict(raw), list[SpecError]()
    for one in alternatives_of(table):
        if one.name not in raw:
            continue
        value, what = given.pop(one.name), _joined(path, one.name)
        if one.replaces in raw:
            limit = f"is given next to {_joined(path, one.replaces)} = {shown(raw[one.replaces])}"
            faults.append(SpecError(what, shown(value), limit, "give one of the two"))
            continue
        _, found = _checked(value, one.annotation, what, Keys(None, path))
        try:
            given |= {} if found else {key: new for key, new in one.values(value).items() if key not in raw}
        except SpecError as error:
            found = [SpecError(what, error.value, error.limit, error.remedy)]
        faults += found
    return given, faults


def _not_finite(raw: Any, path: str) -> Iterator[SpecError]:
    if isinstance(raw, float) and not math.isfinite(raw):
        yield SpecError(path, raw, "is not a finite number", "give a number")
    items = raw.items() if isinstance(raw, dict) else enumerate(raw) if isinstance(raw, list | tuple) else ()
    for key, value in items:
        yield from _not_finite(value, f"{path}.{key}" if path else str(key))


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
