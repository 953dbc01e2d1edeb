"""The table of a delimited text file: delimiter, decimal sign, header, units and lines before it."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement._strict import is_comment, is_error_value
from cycloid_profile.measurement.foreign._vocabulary import is_unit

_BLANKS = " "  # any run of blanks
_DELIMITERS = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", _BLANKS: "blanks"}
_DECIMALS = {".": "decimal points", ",": "decimal commas"}
_NUMBER = {
    sign: re.compile(rf"[+-]?(?:\d+(?:{re.escape(sign)}\d*)?|{re.escape(sign)}\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
    for sign in _DECIMALS
}
_NUMBER[","] = re.compile(r"[+-]?(?:\d+(?:,\d+)?|,\d+)(?:[eEdD][+-]?\d+)?", re.ASCII)
# A number with thousands apart: 1'000, or the other sign between them as in 34.333,33; 59,694 alone is a decimal comma.
_GROUPED = {
    sign: re.compile(
        rf"[+-]?\d{{1,3}}(?:(?:['’\s]\d{{3}})+(?:{re.escape(sign)}\d*)?"
        rf"|(?:{re.escape(other)}\d{{3}})+{re.escape(sign)}\d*|(?:{re.escape(other)}\d{{3}}){{2,}})",
        re.ASCII,
    )
    for sign, other in ((".", ","), (",", "."))
}
_WITH_UNIT = re.compile(r"([+-]?[\d.,]+)\s*(\D{1,20})", re.ASCII)
_SAMPLED = 400  # lines that decide about delimiter and decimal sign
_LONGEST_LINE = 2000  # characters of a header or of a line before it; longer ones are no words
_COMMENTS = ("#", "%", "//", "!")
# A name with its unit in brackets, where blanks separate the columns.
_NAME_AND_UNIT = re.compile(r"[^\s\[(]+(?:\s*[\[(][^\])]*[\])])?|[\[(][^\])]*[\])]")
# A word and its value with a sign between them, or a word and a number.
_KEY = re.compile(r"\s*([^:：=;\t|]{1,60}?)\s*[:：=;\t|]\s*(.*?)[\s;,\t|]*")
_KEY_AND_NUMBER = re.compile(r"\s*([^:：=;\t|\d±+-]{1,60})\s([±+-]*\d[^:：=;\t|]*?)[\s;,\t|]*")


@dataclass(frozen=True, eq=False)
class SourceTable:
    """Cells of a file as text, before anything is known of their meaning.

    ``columns``: names, or numbers from 1 where there is no header; ``units`` of a row of units, "" where there is none;
    ``rows``: line number and cells; ``keys``: words of the lines before the header with their values, in order;
    ``decimal``: sign of the numbers; ``layout``: what was found, in words; ``settings``: what a format states, as those
    of ``--columns``; ``place``: word for the position of a row.
    """

    name: str
    columns: tuple[str, ...]
    units: tuple[str, ...]
    rows: Sequence[tuple[int, Sequence[str]]]
    keys: Sequence[tuple[str, str]] = ()
    decimal: str = "."
    layout: str = ""
    has_header: bool = True
    settings: Mapping[str, str] = field(default_factory=dict)
    place: str = "line"


def number(cell: str, decimal: str = ".") -> float | None:
    """The number in a cell, None if it is none."""
    bare = cell.strip().replace("\u2212", "-")
    if not _NUMBER[decimal].fullmatch(bare):
        return None
    return float(bare.replace(",", ".").replace("D", "e").replace("d", "e"))


def grouped_number(cell: str, decimal: str = ".") -> bool:
    """Whether a cell is a number whose thousands are set apart."""
    return _GROUPED[decimal].fullmatch(cell.strip().replace("\u202f", " ").replace("\xa0", " ")) is not None


def number_with_unit(cell: str, decimal: str = ".") -> bool:
    """Whether a cell is a number with a unit behind it."""
    match = _WITH_UNIT.fullmatch(cell.strip())
    return match is not None and number(match[1], decimal) is not None and is_unit(match[2])


def read_table(text: str, name: str, settings: Mapping[str, str] | None = None) -> SourceTable:
    """The table in ``text``; ``settings`` may state ``delimiter`` and ``decimal``.

    Raises ``MeasurementError`` if there is no row with two numbers.
    """
    given = settings or {}
    lines = [(n, line.strip("\r\n")) for n, line in enumerate(text.splitlines(), 1) if line.strip()]
    if lines and lines[0][1].lower().startswith("sep="):  # a line that Excel obeys and does not show
        lines = lines[1:]
    delimiter, decimal = _layout([line for _, line in lines], given.get("delimiter"), given.get("decimal"))
    cells = [(n, line, split(line, delimiter)) for n, line in lines]
    first, width = _first_row(cells, decimal)
    if width == 0:
        limit = "is of no known kind and holds no rows of two numbers"
        remedy = "export a table of numbers with one header row"
        raise MeasurementError(name, "the file", limit, remedy, ": ")
    while first and _is_faulty_row(*cells[first - 1][1:], width):
        first -= 1
    before = [(n, _uncommented(line)) for n, line, _ in cells[:first]]
    if not any(len(split(line, delimiter)) == width for _, line in before[-3:]):
        width -= _empty_at_end([row for _, _, row in cells[first:] if len(row) == width])
    columns, units, used = _header(before, delimiter, width)
    if not columns:
        _refuse_double_commas(before, delimiter, width, name)
    rows = [(n, row) for n, line, row in cells[first:] if not _is_remark(line, delimiter)]
    return SourceTable(
        name,
        columns or tuple(str(i + 1) for i in range(width)),
        units,
        rows,
        _keys([line for n, line in before if n not in used]),
        decimal,
        f"{_DELIMITERS[delimiter]}, {_DECIMALS[decimal]}",
        bool(columns),
    )


def split(line: str, delimiter: str) -> list[str]:
    """Cells of a line; quotes as of spreadsheets."""
    if delimiter == _BLANKS:
        return line.split()
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:  # a cell beyond the limit of the library
        return [line]


def _is_remark(line: str, delimiter: str) -> bool:
    bare = line.lstrip()
    if bare.startswith(_COMMENTS[1:]):
        return True
    return is_comment(f"{split(bare, delimiter)[0]}," if delimiter == _BLANKS else bare)


def _uncommented(line: str) -> str:
    bare = line.strip()
    return next((bare.lstrip(sign[0]).strip() for sign in _COMMENTS if bare.startswith(sign)), line)


def _layout(lines: Sequence[str], delimiter: str | None, decimal: str | None) -> tuple[str, str]:
    """Delimiter and decimal sign that turn most cells into numbers."""
    sample = [line for line in lines[-_SAMPLED:] if not line.lstrip().startswith(_COMMENTS)]
    pairs = [
        (d, p)
        for d in _DELIMITERS
        for p in _DECIMALS
        if delimiter in (None, d) and decimal in (None, p)
    ]  # fmt: skip
    return max(pairs, key=lambda pair: _score(sample, *pair), default=(",", "."))


def _score(lines: Iterable[str], delimiter: str, decimal: str) -> tuple[float, float]:
    """Share of cells meant as numbers in lines with at least two, summed; then the share of those that are numbers."""
    meant = exact = 0.0
    for line in lines:
        row = [cell for cell in split(line, delimiter) if cell]
        wanted = _numbers(row, decimal)
        if wanted > 1:
            meant += wanted / len(row)
            exact += sum(number(cell, decimal) is not None for cell in row) / len(row)
    return meant, exact


def _first_row(cells: Sequence[tuple[int, str, list[str]]], decimal: str) -> tuple[int, int]:
    """Position of the first row of numbers, and the usual number of cells; 0 if there are no such rows."""
    widths = [len(row) if _numbers(row, decimal) > 1 else 0 for _, _, row in cells]
    usual = Counter(width for width in widths if width).most_common(1)
    if not usual:
        return len(cells), 0
    width = usual[0][0]
    return next(i for i, each in enumerate(widths) if each == width), width


def _is_faulty_row(line: str, row: Sequence[str], width: int) -> bool:
    """Whether a line before the first sound row is a row with a fault: it must be refused, not skipped."""
    if is_error_value(line):
        return True
    some = any(number(cell, sign) is not None for cell in row for sign in _DECIMALS)
    return len(row) == width and some and not line.lstrip().startswith(_COMMENTS)


def _numbers(row: Iterable[str], decimal: str) -> int:
    """Cells that are meant as numbers: a row of them is refused for its cells, and not taken for a line of words."""
    return sum(
        number(cell, decimal) is not None or grouped_number(cell, decimal) or number_with_unit(cell, decimal)
        for cell in row
    )


def _empty_at_end(rows: Sequence[Sequence[str]]) -> int:
    """Number of last columns that are empty in every row, after a delimiter at the end of each."""
    return next((i for i in range(len(rows[0])) if any(row[-1 - i] for row in rows)), 0)


def _header(
    before: Sequence[tuple[int, str]], delimiter: str, width: int
) -> tuple[tuple[str, ...], tuple[str, ...], set[int]]:
    """Names and units of the columns from the lines before the first row, and the numbers of these lines."""
    units: tuple[str, ...] = ("",) * width
    used: set[int] = set()
    for n, line in reversed(before[-3:]):
        cells = _header_cells(line, delimiter, width)
        if cells is not None and not any(units) and all(not cell or is_unit(cell) for cell in cells):
            units = cells
        elif any(character.isalnum() for character in line):
            return (cells, units, used | {n}) if cells is not None else ((), ("",) * width, set())
        used.add(n)
    return (), ("",) * width, set()


def _header_cells(line: str, delimiter: str, width: int) -> tuple[str, ...] | None:
    """The ``width`` names in a line, None if it has another number of names under every delimiter."""
    if len(line) > _LONGEST_LINE:
        return None
    for one in dict.fromkeys((delimiter, *_DELIMITERS)):
        cells = [cell.strip('"') for cell in split(line, one)]
        # LabVIEW names a column of remarks that the rows leave out.
        if one == delimiter != _BLANKS or not any(cells[width:]):
            cells = cells[:width]
        if len(cells) == width and _are_names(cells):
            return tuple(cells)
    by_bracket = _NAME_AND_UNIT.findall(line)
    if len(by_bracket) == width and _are_names(by_bracket):
        return tuple(by_bracket)
    short = split(line, delimiter)
    # R names the rows and gives them no header.
    return ("", *(cell.strip('"') for cell in short)) if line.startswith('"') and len(short) == width - 1 else None


def _are_names(cells: Sequence[str]) -> bool:
    return any(cells) and all(number(cell, sign) is None for cell in cells for sign in _DECIMALS)


def _keys(lines: Iterable[str]) -> list[tuple[str, str]]:
    """Words before the header, in small letters, with their values."""
    short = (line for line in lines if len(line) <= _LONGEST_LINE)
    matches = [_KEY.fullmatch(line) or _KEY_AND_NUMBER.fullmatch(line) for line in short]
    return [(m[1].strip().strip('"').lower(), m[2].strip().strip('"')) for m in matches if m and m[2]]


def _refuse_double_commas(before: Sequence[tuple[int, str]], delimiter: str, width: int, name: str) -> None:
    """Raise ``MeasurementError`` where commas stand between the cells and in the numbers."""
    if before and delimiter == "," and 2 * len(split(before[-1][1], delimiter)) == width:
        limit = f"holds {width // 2} names over rows of {width} cells, so commas separate both cells and decimals"
        remedy = "export with semicolons between the cells"
        raise MeasurementError(f"{name}: line {before[-1][0]}", f"'{before[-1][1][:40]}'", limit, remedy, " ")
