"""Keys of `[source]`: where the numbers come from, and what was published of the drive."""

from __future__ import annotations

from typing import Annotated

from cycloid_profile.spec.table import Table, key


class PublishedValue(Table, frozen=True):
    """A number that was published of this drive, to lay beside the computed one."""

    quantity: Annotated[str, key("What was published.", "give a text")]
    value: Annotated[float, key("Its value.", "give a number")]
    unit: Annotated[str, key("Its unit.", "give a text")] = ""
    note: Annotated[str, key("How it was found.", "give a text")] = ""


class SourceSpec(Table, frozen=True):
    """Where the numbers come from, and which of them are assumed."""

    reference: Annotated[str, key("Publication or maker.", "give a text")] = ""
    assumed: Annotated[tuple[str, ...], key("Keys whose values are assumed.", "give a list of texts")] = ()
    published: tuple[PublishedValue, ...] = ()
