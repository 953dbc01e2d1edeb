"""Read a spec file; every refusal names the key, the value, the limit and the remedy."""

from __future__ import annotations

import json
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import msgspec

from cycloid_profile.errors import SpecError
from cycloid_profile.spec.effect_names import EFFECT_NAMES
from cycloid_profile.spec.keys import nearest, remedy_for, tables_in, wrong_unit
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.table import Table

_FAULT = re.compile(r"^(?P<rule>.*?)(?: - at `\$\.?(?P<path>.*)`)?$", re.DOTALL)
_LONGEST_SHOWN = 60
_RULES = (
    (re.compile(r"^Expected `str` (?:matching regex|of length).*$"), "must be one line of at most 80 characters"),
    (re.compile(r"^Expected `(?:int|float)` (?P<op>[<>]=?) (?P<bound>.+)$"), r"must be \g<op> \g<bound>"),
    (re.compile(r"^Expected `(?P<want>.+)`, got `(?P<got>.+)`$"), r"must be of type \g<want>, not \g<got>"),
    (re.compile(r"^Invalid enum value .*$"), "is not one of the choices"),
)


def read_spec(path: str | Path) -> Spec:
    """Read a TOML spec file.

    Raises
    ------
    SpecError
        If the file is missing, unreadable or not TOML, or a key is unknown, missing or out of its limits.
    """
    file = Path(path)
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise SpecError(
            "spec file",
            f"'{file}'",
            "does not exist",
            "check the path, or see 'cycloid-profile catalog' for drives",
            " ",
        ) from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise SpecError("spec file", f"'{file}'", f"cannot be read ({reason})", "give a TOML text file", " ") from None
    return parse_spec(text, name=str(file))


def parse_spec(text: str, name: str = "spec") -> Spec:
    """Parse the text of a spec file; ``name`` is used in messages. Raises ``SpecError`` as ``read_spec``."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SpecError("spec file", f"'{name}'", f"is not valid TOML ({error})", "mend that line", " ") from None
    except RecursionError:
        raise SpecError("spec file", f"'{name}'", "nests tables too deeply", "see docs/spec.md", " ") from None
    _refuse_unknown_keys(raw, Spec, "")
    _refuse_not_finite(raw, "")
    try:
        spec = msgspec.convert(raw, Spec)
    except msgspec.ValidationError as error:
        raise _in_four_parts(str(error), raw) from None
    _refuse_unknown_effects(spec)
    return spec


def _refuse_unknown_keys(raw: dict[str, Any], table: type[Table], path: str) -> None:
    known = {field.name: field for field in msgspec.structs.fields(table)}
    for key, value in raw.items():
        here = f"{path}{key}"
        if key not in known:
            shown = "{…}" if isinstance(value, dict) else _shown(value)
            limit, remedy = wrong_unit(key, value, list(known)) or (
                "is not a key of the spec file",
                nearest(key, list(known), path),
            )
            raise SpecError(here, shown, limit, remedy)
        for inner in tables_in(known[key].type):
            entries = value if isinstance(value, list) else [value]
            for entry in entries:
                if isinstance(entry, dict):
                    _refuse_unknown_keys(entry, inner, f"{here}.")


def _refuse_not_finite(raw: Any, path: str) -> None:
    if isinstance(raw, float) and not math.isfinite(raw):
        raise SpecError(path, raw, "is not a finite number", "give a number")
    items = raw.items() if isinstance(raw, dict) else enumerate(raw) if isinstance(raw, list) else ()
    for key, value in items:
        _refuse_not_finite(value, f"{path}.{key}" if path else str(key))


def _in_four_parts(message: str, raw: dict[str, Any]) -> SpecError:
    """msgspec's message, with the value looked up and the remedy from the model."""
    match = _FAULT.match(message)
    assert match is not None
    rule, path = match["rule"], match["path"] or ""
    missing = re.match(r"Object missing required field `(.+)`", rule)
    if missing:
        key = f"{path}.{missing[1]}".lstrip(".")
        return SpecError(key, "is missing", "though it has no default", remedy_for(key), " ")
    for pattern, wording in _RULES:
        if pattern.match(rule):
            rule = pattern.sub(wording, rule)
            break
    return SpecError(path or "spec", _shown(_value_at(raw, path)), rule, remedy_for(path))


def _value_at(raw: Any, path: str) -> Any:
    for key in re.findall(r"[^.\[\]]+", path):
        raw = raw[int(key)] if isinstance(raw, list) else raw.get(key) if isinstance(raw, dict) else None
    return raw


def _shown(value: Any) -> str:
    if isinstance(value, dict):
        return "{…}"
    text = json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)
    return text if len(text) <= _LONGEST_SHOWN else f"{text[:_LONGEST_SHOWN]}…"


def _refuse_unknown_effects(spec: Spec) -> None:
    for number, effect in enumerate(spec.effects, start=1):
        name = effect.get("name")
        if not isinstance(name, str) or name not in EFFECT_NAMES:
            raise SpecError(
                f"effects[{number}].name",
                _shown(name),
                "is not the name of an effect",
                nearest(str(name), sorted(EFFECT_NAMES), ""),
            )
