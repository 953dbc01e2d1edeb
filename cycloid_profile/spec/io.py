"""The spec file in and out: TOML text to validated values and back, its JSON schema, and its keys as Markdown."""

from __future__ import annotations

import json
import tomllib
import typing
from pathlib import Path
from typing import Any

import msgspec

from cycloid_profile.errors import SpecError
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.model.checks._suggestions import tables_in
from cycloid_profile.spec.model.checks._validation import alternatives_of, choices_in, meta_in, validated

SCHEMA_FILE = "cycloid-profile.schema.json"
_LARGEST = 20_000_000  # bytes of a spec file; one with a measured curve of 100 000 points has 5 million
_DEEPEST = 100  # tables in tables; the deepest key of a spec lies five deep
_BOUNDS = (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))


def read_spec(path: str | Path) -> Spec:
    """Read a TOML spec file.

    Raises
    ------
    SpecError
        If the file is missing, unreadable or not TOML, or a key is unknown, missing or out of its limits.
    """
    file = Path(path)
    try:
        text = plain_text(file)
    except FileNotFoundError:
        remedy = "check the path, or see 'cycloid-profile catalog' for drives"
        raise SpecError("spec file", f"'{file}'", "does not exist", remedy, " ") from None
    except (OSError, ValueError) as error:
        limit = unreadable(error)
        raise SpecError("spec file", f"'{file}'", limit, "give a TOML text file, see docs/spec.md", " ") from None
    spec = parse_spec(text, name=str(file))
    named_files = {"load.disc_body_file": spec.load.disc_body_file, "export.machine": spec.export.machine}
    relative = {key: name for key, name in named_files.items() if name is not None and not Path(name).is_absolute()}
    return spec.replace({key: str(file.parent / name) for key, name in relative.items()}) if relative else spec


def parse_spec(text: str, name: str = "spec") -> Spec:
    """Parse the text of a spec file; ``name`` is used in messages. Raises ``SpecError`` as ``read_spec``."""
    try:
        values = toml_values(text)
    except ValueError as error:
        raise SpecError("spec file", f"'{name}'", str(error), "correct that line, see docs/spec.md", " ") from None
    spec: Spec = validated(values, Spec)
    return spec


def plain_text(file: Path) -> str:
    """Text of a plain UTF-8 file of limited size; raises ``OSError`` and ``ValueError`` with the reason."""
    # A device may never end, and a pipe that nobody writes to never begins.
    if file.exists() and not (file.is_file() or file.is_dir()):
        raise ValueError("is no plain file")
    if file.stat().st_size > _LARGEST:
        raise ValueError(f"is larger than {_LARGEST / 1e6:g} MB")
    return file.read_text(encoding="utf-8-sig")


def toml_values(text: str) -> dict[str, Any]:
    """Values of a TOML text; raises ``ValueError`` with the reason, a clause."""
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"is not valid TOML ({error})") from None
    except RecursionError:
        raise ValueError("nests tables too deeply") from None
    except ValueError:
        raise ValueError("holds a whole number of more than 4300 digits") from None
    inner: list[Any] = [values]
    for _ in range(_DEEPEST):
        inner = [one for each in inner for one in (each.values() if isinstance(each, dict) else each)]
        inner = [one for one in inner if isinstance(one, dict | list)]
    if inner:
        raise ValueError("nests tables too deeply")
    return values


def unreadable(error: OSError | ValueError) -> str:
    """Why ``plain_text`` or ``toml_values`` could not read a file, as a clause."""
    if isinstance(error, UnicodeDecodeError):
        return "cannot be read (it is not UTF-8 text)"
    return f"cannot be read ({error.strerror})" if isinstance(error, OSError) else str(error)


def format_spec(spec: Spec, schema: str = SCHEMA_FILE) -> str:
    """TOML text that reads back to an equal ``Spec``, without defaults; its first line points editors to ``schema``."""
    import tomli_w

    return f"#:schema {schema}\n{tomli_w.dumps(msgspec.to_builtins(spec))}"


def spec_schema() -> str:
    """The JSON Schema of the spec file as text, the same bytes for the same model."""
    schema = msgspec.json.schema(Spec)
    for table in _tables_below(Spec):
        _add_alternatives(schema["$defs"][table.__name__], table)
    _put_null_last(schema)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "cycloid_profile spec file"
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def _put_null_last(schema: Any) -> None:
    """Order the alternatives of keys that may be absent: versions of msgspec differ in it."""
    for one in schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ():
        _put_null_last(one)
    if isinstance(schema, dict) and "anyOf" in schema:
        schema["anyOf"].sort(key=lambda one: one == {"type": "null"})


def _tables_below(table: type[msgspec.Struct]) -> set[type[msgspec.Struct]]:
    inner = {each for field in msgspec.structs.fields(table) for each in tables_in(field.type)}
    return {table}.union(*map(_tables_below, inner))


def _add_alternatives(schema: dict[str, Any], table: type[msgspec.Struct]) -> None:
    """Keys that stand for others, in the JSON Schema of a table: exactly one of a required pair, at most one else."""
    for one in alternatives_of(table):
        schema["properties"][one.name] = msgspec.json.schema(one.annotation)
        either: list[dict[str, Any]] = [{"required": [one.replaces]}, {"required": [one.name]}]
        if one.replaces in schema["required"]:
            schema["required"].remove(one.replaces)
            rule: dict[str, Any] = {"oneOf": either}
        else:
            rule = {"not": {"required": [one.replaces, one.name]}}
        schema.setdefault("allOf", []).append(rule)


def key_reference(table: type[msgspec.Struct] = Spec) -> str:
    """One Markdown table for every table of the spec file, or of a machine file, in the order of the model."""
    return "\n".join(_sections(table, "", repeated=False))


def _sections(table: type[msgspec.Struct], path: str, repeated: bool) -> list[str]:
    title = "Top level" if not path else f"`[[{path}]]`" if repeated else f"`[{path}]`"
    rows: list[str] = []
    inner: list[str] = []
    for field in msgspec.structs.fields(table):
        tables = tables_in(field.type)
        if tables:
            inner += _sections(tables[0], f"{path}.{field.name}".lstrip("."), typing.get_origin(field.type) is tuple)
        else:
            rows.append(_row(field.name, field.type, _default(field, table)))
    rows += [_row(one.name, one.annotation, f"in place of `{one.replaces}`") for one in alternatives_of(table)]
    head = [f"### {title}", "", str(table.__doc__), ""]
    if rows:
        head += ["| key | default | limits | meaning |", "|---|---|---|---|", *rows, ""]
    return head + inner


def _row(name: str, annotation: Any, default: str) -> str:
    meta = meta_in(annotation)
    limits = ", ".join(
        f"{sign} {getattr(meta, name):g}" for name, sign in _BOUNDS if getattr(meta, name, None) is not None
    )
    choices = choices_in(annotation)
    meaning = [meta.description] if meta is not None and meta.description else []
    if choices:
        meaning.append("One of " + ", ".join(f"`{choice}`" for choice in choices) + ".")
    return f"| `{name}` | {default} | {limits} | {' '.join(meaning)} |"


def _default(field: msgspec.structs.FieldInfo, table: type[msgspec.Struct]) -> str:
    default: Any = field.default
    if default is msgspec.NODEFAULT:
        others = [f"`{one.name}`" for one in alternatives_of(table) if one.replaces == field.name]
        return " or ".join(["**required**", *others])
    return "–" if default is None or default in ("", ()) else f"`{json.dumps(default)}`"
