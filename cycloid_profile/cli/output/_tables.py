"""Tables for a terminal of any width: names stay whole, no column is lost.

A table that is too wide folds its heads and long texts at blanks. If that is not enough, it continues below with the
names repeated, and last it prints a block for each row.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING

from rich.cells import cell_len

from cycloid_profile._display import is_number

if TYPE_CHECKING:
    from cycloid_profile.articles import PlainTable

GAP, NARROW_GAP = 3, 2  # blanks between columns, and where the table does not fit with them
SHORTEST_TEXT = 24  # cells; only longer ones fold
SHORTEST_SIGNS = 8  # cells, four signs: less is hard to read
_BOUND = "\u00a0"  # joins a number to its unit, and a head to its bracket
# A blank before a unit, a bracket or ±, and those around an equals sign.
_UNIT = re.compile(r"(?<=[\d–]) (?=(?:[′″°%]|of \d|[^\W\d_]{1,3}(?:[·/][^\s]*)?(?:[\s,;:)]|$)))| (?=[\[±=])|(?<=[±=]) ")
# Next to a sign of a script without blanks, but not before a closing mark or after an opening one.
_SIGN = r"[\u3040-\u30ff\u3400-\u9fff，。；：、（）“”]"
_BETWEEN_SIGNS = re.compile(
    rf"(?:(?<={_SIGN})|(?={_SIGN}))(?<=[^（“(\[])(?![，。；：、）”)\],.;:%%′″°])".replace("%%", "%")
)


@dataclass(frozen=True)
class Column:
    """Folded cells of one column, the head first; ``text`` columns are flush left."""

    cells: tuple[tuple[str, ...], ...]
    text: bool

    @property
    def width(self) -> int:
        """Widest line [cells]."""
        return max((cell_len(line) for cell in self.cells for line in cell), default=0)

    def lines(self, row: int, height: int) -> list[str]:
        """The ``height`` lines of one row, padded to the column's width; heads stand at the bottom."""
        folded = list(self.cells[row])
        missing = [""] * (height - len(folded))
        folded = missing + folded if row == 0 else folded + missing
        pads = [" " * (self.width - cell_len(line)) for line in folded]
        return [line + pad if self.text else pad + line for line, pad in zip(folded, pads, strict=True)]


def table_lines(table: PlainTable, width: int | None) -> list[str]:
    """Lines of head and rows in ``width`` cells; None: as wide as the table is.

    Only a single word, or a row's name, that is itself longer makes a longer line.
    """
    columns = [list(cells) for cells in zip_longest(table.head, *table.rows, fillvalue="")]
    limits = [_limit(cells, named=i == 0) for i, cells in enumerate(columns)]
    if width is None:
        limits = [max(map(cell_len, cells)) for cells in columns]
        return _grid(columns, limits, GAP)
    gap = GAP if sum(limits) + GAP * (len(limits) - 1) <= width else NARROW_GAP
    if limits[0] + gap + max(limits[1:], default=0) > width:
        return _blocks(table, width)
    lines: list[str] = []
    for part in _parts(limits, width, gap):
        if lines:
            lines.append("")
        chosen = [columns[i] for i in part]
        lines += _grid(chosen, _widened(chosen, [limits[i] for i in part], width, gap), gap)
    return lines


def fold(text: str, width: int) -> tuple[str, ...]:
    """The text in lines of at most ``width`` cells, broken at blanks and between Chinese signs; a number keeps its
    unit, a word stays whole.
    """
    lines = [""]
    for blank, word in _words(_UNIT.sub(_BOUND, text)):
        longer = f"{lines[-1]}{blank}{word}" if lines[-1] else word
        if cell_len(longer) <= width or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return tuple(line.replace(_BOUND, " ") for line in lines)


def _words(text: str) -> Iterator[tuple[str, str]]:
    """What a line may begin with, and the blank that stands before it in a line."""
    for number, word in enumerate(text.split(" ")):
        first, *following = _BETWEEN_SIGNS.split(word)
        yield " " if number else "", first
        yield from (("", sign) for sign in following)


def _narrowest(text: str) -> int:
    """Least width of a text: its longest word, and a few of the signs that could stand alone [cells]."""
    longest = max(map(cell_len, fold(text, 1)))
    return max(longest, min(cell_len(text), SHORTEST_SIGNS)) if re.search(_SIGN, text) else longest


def _limit(cells: Sequence[str], named: bool) -> int:
    """Least width of a column: names, numbers and short texts whole, heads and long texts folded."""
    head, *rows = cells
    whole = max((cell_len(cell) if named else min(cell_len(cell), SHORTEST_TEXT) for cell in rows), default=0)
    return max([_narrowest(head), whole, *(_narrowest(cell) for cell in rows)])


def _parts(limits: Sequence[int], width: int, gap: int) -> list[list[int]]:
    """Columns of each part of the table; the names, column 0, begin every one."""
    parts = [[0]]
    for column in range(1, len(limits)):
        if sum(limits[i] + gap for i in parts[-1]) + limits[column] > width:
            parts.append([0])
        parts[-1].append(column)
    return parts


def _widened(columns: Sequence[Sequence[str]], limits: Sequence[int], width: int, gap: int) -> list[int]:
    """The spare cells of a line go to the column that they save most lines."""
    widths = list(limits)
    for _ in range(width - sum(widths) - gap * (len(widths) - 1)):
        missing = [sum(max(0, cell_len(cell) - w) for cell in cells) for cells, w in zip(columns, widths, strict=True)]
        if not any(missing):
            break
        widths[missing.index(max(missing))] += 1
    return widths


def _grid(columns: Sequence[Sequence[str]], widths: Sequence[int], gap: int) -> list[str]:
    folded = [
        Column(tuple(fold(cell, w) for cell in cells), i == 0 or not all(map(is_number, cells[1:])))
        for i, (cells, w) in enumerate(zip(columns, widths, strict=True))
    ]
    lines = []
    for row in range(len(columns[0])):
        if row == 0 and not any(cells[0] for cells in columns):
            continue  # no column has a head
        height = max(len(column.cells[row]) for column in folded)
        cells = zip(*(column.lines(row, height) for column in folded), strict=True)
        lines += [(" " * gap).join(line).rstrip() for line in cells]
    return lines


def _blocks(table: PlainTable, width: int) -> list[str]:
    """A block for each row: its name, then head and cell of each column on lines of their own."""
    heads = ["", *table.head[1:]]
    label = max(min(max(map(cell_len, heads)), width // 3), *map(_narrowest, heads))
    lines: list[str] = []
    for name, *cells in table.rows:
        lines += fold(name, width)
        lines += [f"  {line}" for line in _grid([heads, ["", *cells]], [label, max(width - 2 - GAP - label, 1)], GAP)]
    return lines
