"""What every table of the spec file is made of: frozen values whose keys carry description, remedy and limits."""

from __future__ import annotations

from typing import Any

import msgspec
from msgspec import Meta

LENGTH = "give a length above zero in mm"
SIZE: dict[str, Any] = {"ge": 1e-3, "le": 1e4}  # limits of a length [mm]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A table of the spec file."""


def key(description: str, remedy: str, **limits: Any) -> Meta:
    """Note on a key: what it means, what to do where its value is refused, and its limits."""
    return Meta(description=description, extra={"remedy": remedy}, **limits)
