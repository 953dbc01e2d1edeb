"""The keys of the spec file as Markdown tables, made from the model itself: docs/spec.md holds them."""

from __future__ import annotations

import json
import typing
from typing import Any

import msgspec

from cycloid_profile.spec.keys import choices_in, meta_in, tables_in
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.table import Table

_BOUNDS = (("gt", ">"), ("ge", "≥"), ("lt", "<"), ("le", "≤"))


def key_reference() -> str:
    """One Markdown table for every table of the spec file, in the order of the model."""
    return "\n".join(_sections(Spec, "", repeated=False))


def _sections(table: type[Table], path: str, repeated: bool) -> list[str]:
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
