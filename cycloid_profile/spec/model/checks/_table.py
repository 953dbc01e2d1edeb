"""A table of the spec file: frozen values whose keys carry description, remedy and limits."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

import msgspec
from msgspec import Meta

from cycloid_profile.errors import SpecError, did_you_mean
from cycloid_profile.spec.model.checks._suggestions import fields_of, tables_in
from cycloid_profile.spec.model.checks._validation import Alternative, validated

SIZE: dict[str, Any] = {"ge": 1e-3, "le": 1e4}  # limits of a length [mm]


class Table(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A table of the spec file."""

    alternatives: ClassVar[tuple[Alternative, ...]] = ()

    @classmethod
    def further_faults(cls, raw: Mapping[str, Any]) -> Iterable[SpecError]:  # noqa: ARG003 - most tables have none
        """Faults of the plain values of this table that its types cannot find."""
        return ()

    def __post_init__(self) -> None:
        """Convert dictionaries given for tables; raises ``SpecError`` as reading a file does."""
        for name, annotation in fields_of(type(self)).items():
            value = getattr(self, name)
            entries = value if isinstance(value, list | tuple) else (value,)
            tables = tuple(tables_in(annotation))
            if tables and not all(entry is None or isinstance(entry, tables) for entry in entries):
                msgspec.structs.force_setattr(self, name, validated(value, annotation, name))

    if not TYPE_CHECKING:  # hidden from type checkers, which must reject unknown keys

        def __getattr__(self, name: str) -> Any:
            known = [*self.__struct_fields__, *(each for each in dir(type(self)) if not each.startswith("_"))]
            remedy = did_you_mean(name, known, f"known are {', '.join(self.__struct_fields__)}")
            raise AttributeError(f"{type(self).__name__}.{name} does not exist: {remedy}", name=name, obj=self)


# What every reader of every export takes: no control characters, and none that XML refuses.
PRINTABLE = r"^[^\x00-\x1f\x7f\ufffe\uffff]*$"


def key(description: str, remedy: str, **limits: Any) -> Meta:
    """Note on a key: its meaning, the remedy where its value is refused, and its limits."""
    return Meta(description=description, extra={"remedy": remedy}, **limits)


def length(description: str) -> Meta:
    """Note on a key that holds a length above zero [mm]."""
    return key(description, "give a length above zero in mm", **SIZE)


def relief(description: str) -> Meta:
    """Note on a key that holds a relief along the axis [µm]."""
    return key(description, "give an amount in µm, 0 for none", ge=0, le=1000)


def relief_length(description: str) -> Meta:
    """Note on a key that holds the length of an edge relief [mm]."""
    return key(description, "give a length in mm, at most half the face width", ge=0, le=1e4)


def taper(description: str) -> Meta:
    """Note on a key that holds a taper over the face width [µm]."""
    return key(description, "give an amount in µm, 0 for none", ge=-1000, le=1000)
