"""A section of the tolerance report: texts, tables, pictures and a note."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cycloid_profile.tolerance.plain_tables import PlainTable
from cycloid_profile.tolerance.quantities import QUANTITIES
from cycloid_profile.units import sign_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

UNITS = {name: sign_of(name) for name in QUANTITIES}


@dataclass(frozen=True)
class Section:
    """A part of the report; ``drawn`` holds the name, the caption and the maker of each picture."""

    title: str
    texts: tuple[str, ...] = ()
    tables: tuple[PlainTable, ...] = ()
    drawn: tuple[tuple[str, str, Callable[[], Figure]], ...] = ()
    note: str = ""


def words(name: str) -> str:
    """Name of a quantity without its unit."""
    return name.rsplit("_", 1)[0].replace("_", " ")
