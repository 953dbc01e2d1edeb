"""Readers of files of other programs, those of plug-ins included: bytes to a table of cells."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import entry_points
from typing import Protocol, runtime_checkable

from cycloid_profile.errors import MeasurementError, PluginError
from cycloid_profile.measurement.foreign._public_formats import DmisReader, QifReader, VdaReader
from cycloid_profile.measurement.foreign._spreadsheet import SpreadsheetReader
from cycloid_profile.measurement.foreign.encoding import decode
from cycloid_profile.measurement.foreign.mapping import SIGNS
from cycloid_profile.measurement.foreign.table import SourceTable, read_table

# Installed packages list their readers under this group: a name, and an object or class with the methods below.
READER_GROUP = "cycloid_profile.readers"


@runtime_checkable
class MeasurementReader(Protocol):
    """Reads one format: ``recognises`` looks at the bytes, ``read`` gives the cells of its table as text."""

    @property
    def name(self) -> str:
        """Name of the format."""
        ...

    def recognises(self, data: bytes) -> bool:
        """Whether ``data`` is a file of this format."""
        ...

    def read(self, data: bytes, name: str) -> SourceTable:
        """The table of the file ``name``; raises ``MeasurementError`` if it cannot be read."""
        ...


_BUILT_IN: tuple[MeasurementReader, ...] = (SpreadsheetReader(), VdaReader(), DmisReader(), QifReader())
_registered: list[MeasurementReader] = []


def register_reader(reader: MeasurementReader) -> None:
    """Add a reader, asked before the built-in ones; raises ``PluginError`` if it is incomplete."""
    if not isinstance(reader, MeasurementReader):
        remedy = "give it a name, recognises(data) and read(data, name), see docs/foreign-files.md"
        raise PluginError("reader", f"'{reader}'", "is no reader", remedy, " ")
    _registered.append(reader)


@cache
def _installed() -> tuple[MeasurementReader, ...]:
    found = []
    for entry in entry_points(group=READER_GROUP):
        try:
            loaded = entry.load()
            reader = loaded() if isinstance(loaded, type) else loaded
            if not isinstance(reader, MeasurementReader):
                raise PluginError("entry point", entry.name, "is no reader", "see docs/foreign-files.md")
            found.append(reader)
        except Exception as error:  # the code of others may raise anything; the other readers still work
            warnings.warn(f"the reader '{entry.name}' of '{entry.value}' is left out: {error}", stacklevel=2)
    return tuple(found)


def read_source(data: bytes, name: str, settings: Mapping[str, str] | None = None) -> SourceTable:
    """The table of a file by the first reader that recognises it, else as delimited text: CSV of every dialect, plain
    points of measuring machines, columns of a test bench.

    ``settings`` may state encoding, delimiter and decimal sign of a text. Raises ``MeasurementError`` or
    ``UnicodeError`` if it cannot be read.
    """
    for reader in (*_registered, *_installed(), *_BUILT_IN):
        if reader.recognises(data):
            table = reader.read(data, name)
            if not table.rows:
                limit, remedy = "holds no measured points", "export the measured points, not only the nominal ones"
                raise MeasurementError(name, f"the {reader.name} file", limit, remedy, ": ")
            return replace(table, layout=table.layout or reader.name)
    given = settings or {}
    text, encoding = decode(data, given.get("encoding"))
    table = read_table(text, name, {key: SIGNS[given[key]] for key in ("delimiter", "decimal") if key in given})
    return replace(table, layout=f"{table.layout}, {encoding}")
