"""Spreadsheets: .xlsx by openpyxl, an extra; older and other ones are refused with the way out."""

from __future__ import annotations

import io
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any

from cycloid_profile.errors import MeasurementError, ResourceError
from cycloid_profile.measurement.foreign.table import SourceTable, read_table
from cycloid_profile.resources import Need, unpacked_need

_MEMORY_PER_BYTE = 25.0  # of an unpacked sheet
_MOST_ROWS = 1_048_576
_STEP = 20_000_000  # characters of a sheet between two looks at what it needs
_ZIP, _OLE = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"


@dataclass(frozen=True)
class SpreadsheetReader:
    """The first sheet of a workbook that holds a table."""

    name: str = "xlsx"

    def recognises(self, data: bytes) -> bool:
        """See ``MeasurementReader.recognises``."""
        return data.startswith((_ZIP, _OLE))

    def read(self, data: bytes, name: str) -> SourceTable:
        """See ``MeasurementReader.read``."""
        unpacked_need(io.BytesIO(data), name, "is a workbook", _MEMORY_PER_BYTE).require()
        if b"xl/workbook" not in data:
            remedy = "save it as .xlsx or .csv"
            raise MeasurementError(name, "the file", "is no .xlsx workbook", remedy, ": ")
        try:
            from openpyxl import load_workbook
        except ImportError:
            remedy = "pip install 'cycloid-profile[excel]', or save the sheet as .csv"
            raise MeasurementError(name, "the file", "needs openpyxl to be read", remedy, ": ") from None
        try:
            book = load_workbook(io.BytesIO(data), read_only=True, data_only=True)
            # A row of any number has all rows before it; Excel has no more than these.
            rows = [(sheet.title, sheet.iter_rows(values_only=True, max_row=_MOST_ROWS)) for sheet in book.worksheets]
            sheets = [(title, _text(some, name)) for title, some in rows]
        except ResourceError:
            raise
        except Exception as error:  # a damaged archive raises whatever its parts raise
            reason = type(error).__name__
            raise MeasurementError(name, "the workbook", f"is damaged ({reason})", "save it again", ": ") from None
        fault: MeasurementError | None = None
        for title, text in sheets:
            try:
                table = read_table(text, name, {"delimiter": "\t"})
            except MeasurementError as error:
                fault = fault or error
                continue
            others = f", {len(sheets) - 1} other sheets not read" if len(sheets) > 1 else ""
            return replace(table, layout=f"sheet '{title}' of a workbook{others}", place="row")
        if any(_formulas(sheet) for sheet in load_workbook(io.BytesIO(data), read_only=True).worksheets):
            remedy = "open it in a spreadsheet program and save it again"
            raise MeasurementError(name, "the workbook", "holds formulas without their values", remedy, ": ")
        raise fault or MeasurementError(name, "the workbook", "has no sheets", "save one sheet", ": ")


def _text(rows: Iterable[tuple[Any, ...]], name: str) -> str:
    """The sheet as lines with tabs, an empty line for an empty row, so that lines count as rows do.

    Raises ``ResourceError`` where it grows too large: a cell far to the right has all cells before it.
    """
    lines, size, stated = [], 0, 0
    for row in rows:
        lines.append("\t".join(_cell(value) for value in row))
        size += len(lines[-1]) + 1
        if size > stated + _STEP:
            stated = size
            cells = f"has cells of {size / 1e6:,.0f} MB as text"
            Need(name, cells, "save the table alone", memory=_MEMORY_PER_BYTE * size, joint=" ").require()
    return "\n".join(lines)


def _formulas(sheet: Any) -> bool:
    """Whether the cells of a sheet, read without values, are formulas."""
    return any(str(value).startswith("=") for row in sheet.iter_rows(values_only=True) for value in row)


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return repr(value)
    return " ".join(str(value).split())
