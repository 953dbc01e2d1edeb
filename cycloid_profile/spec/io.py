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
from cycloid_profile.spec.model._validation import choices_in, meta_in, tables_in, validated

SCHEMA_FILE = "cycloid-profile.schema.json"
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
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        remedy = "check the path, or see 'cycloid-profile catalog' for drives"
        raise SpecError("spec file", f"'{file}'", "does not exist", remedy, " ") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise SpecError("spec file", f"'{file}'", f"cannot be read ({reason})", "give a TOML text file", " ") from None
    spec = parse_spec(text, name=str(file))
    body = spec.load.disc_body_file
    if body is not None and not Path(body).is_absolute():
        spec = spec.replace("load.disc_body_file", str(file.parent / body))
    return spec


def parse_spec(text: str, name: str = "spec") -> Spec:
    """Parse the text of a spec file; ``name`` is used in messages. Raises ``SpecError`` as ``read_spec``."""
    try:
        raw = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SpecError("spec file", f"'{name}'", f"is not valid TOML ({error})", "correct that line", " ") from None
    except RecursionError:
        raise SpecError("spec file", f"'{name}'", "nests tables too deeply", "see docs/spec.md", " ") from None
    spec: Spec = validated(raw, Spec)
    return spec


def format_spec(spec: Spec, schema: str = SCHEMA_FILE) -> str:
    """TOML text that reads back to an equal ``Spec``, without defaults; its first line points editors to ``schema``."""
    import tomli_w

    return f"#:schema {schema}\n{tomli_w.dumps(msgspec.to_builtins(spec))}"


def spec_schema() -> str:
    """The JSON Schema of the spec file as text, the same bytes for the same model."""
    schema = msgspec.json.schema(Spec)
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "cycloid_profile spec file"
    return json.dumps(schema, indent=1, ensure_ascii=False) + "\n"


def key_reference() -> str:
    """One Markdown table for every table of the spec file, in the order of the model."""
    return "\n".join(_sections(Spec, "", repeated=False))


def _sections(table: type[msgspec.Struct], path: str, repeated: bool) -> list[str]:
    title = "Top level" if not path else f"`[[{path}]]`" if repeated else f"`[{path}]`"
    rows: list[str] = []
    inner: list[str] = []
    for field in msgspec.structs.fields(table):
        tables = tables_in(field.type)
        if tables:
            inner += _sections(tables[0], f"{path}.{field.name}".lstrip("."), typing.get_origin(field.type) is tuple)
        else:
            rows.append(_row(field))
    head = [f"### {title}", "", str(table.__doc__), ""]
    if rows:
        head += ["| key | default | limits | meaning |", "|---|---|---|---|", *rows, ""]
    return head + inner


def _row(field: msgspec.structs.FieldInfo) -> str:
    meta = meta_in(field.type)
    limits = ", ".join(
        f"{sign} {getattr(meta, name):g}" for name, sign in _BOUNDS if getattr(meta, name, None) is not None
    )
    choices = choices_in(field.type)
    meaning = [meta.description] if meta is not None and meta.description else []
    if choices:
        meaning.append("One of " + ", ".join(f"`{choice}`" for choice in choices) + ".")
    return f"| `{field.name}` | {_default(field)} | {limits} | {' '.join(meaning)} |"


def _default(field: msgspec.structs.FieldInfo) -> str:
    default: Any = field.default
    if default is msgspec.NODEFAULT:
        return "**required**"
    return "–" if default is None or default in ("", ()) else f"`{json.dumps(default)}`"
