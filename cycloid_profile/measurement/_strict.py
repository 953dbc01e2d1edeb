"""Strict reading of measured files: plain decimal numbers, no value lost as a comment, all faults in one error."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from cycloid_profile.errors import MeasurementError

# Python's float also takes 5_9.694, full-width digits and "infinity": a slip of the hand must not become a number.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
# Error values of spreadsheets in any language: #N/A, #NV, #DIV/0!, #WERT!, and ##### of a column that is too narrow.
_ERROR_VALUE = re.compile(r"#(?:N/?[ADV]|[A-ZÀ-ÖØ-Þ0-9/.]+[!?])\s*(?:$|[,;|\t])|#{2,}\s*[,;|\t]")
_LISTED = 8  # faults quoted in full; the others are counted


def finite_number(text: str) -> float | None:
    """The finite number that ``text`` writes in ASCII digits with a decimal point; None if it writes none."""
    bare = text.strip()
    if not _NUMBER.fullmatch(bare):
        return None
    value = float(bare)
    return value if math.isfinite(value) else None


def is_error_value(line: str) -> bool:
    """Whether the first cell of a line is the error value of a spreadsheet."""
    return _ERROR_VALUE.match(line.lstrip()) is not None


def is_comment(line: str) -> bool:
    """Whether a line is a comment, and not a row whose first cell is the error value of a spreadsheet."""
    return line.lstrip().startswith("#") and not is_error_value(line)


def joined(faults: Sequence[MeasurementError]) -> MeasurementError:
    """One error for all ``faults`` of a file: the first in full, the others as clauses of its remedy."""
    first, *others = faults
    if not others:
        return first
    said = {(first.limit, first.remedy)}
    clauses = []
    for fault in others[: _LISTED - 1]:
        place = fault.what.rpartition(": ")[2]
        known = (fault.limit, fault.remedy) in said
        clauses.append(f"{place} = {fault.value}" + ("" if known else f" {fault.limit}, {fault.remedy}"))
        said.add((fault.limit, fault.remedy))
    more = len(others) - len(clauses)
    also = ", ".join(clauses) + (f" and {more} more" if more else "")
    return MeasurementError(first.what, first.value, first.limit, f"{first.remedy}; also {also}", first.joint)
