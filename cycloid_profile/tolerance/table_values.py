"""Values of one table of a spec file, each refused by its key."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from cycloid_profile.errors import SpecError


def number(table: Mapping[str, Any], key: str, default: float, where: str, low: float, high: float) -> float:
    """The number under ``key`` of the table at ``where``. Raises ``SpecError`` if it is none or outside its limits."""
    value = table.get(key, default)
    # Whole numbers of a spec file can be larger than any float.
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise SpecError(f"{where}.{key}", repr(value)[:40], "is not a number", "give a number")
    if not low <= value <= high:
        raise SpecError(f"{where}.{key}", f"{value:g}", f"is outside {low:g} to {high:g}", "give a number within")
    return float(value)


def refuse_unknown(table: Mapping[str, Any], known: Sequence[str], where: str, of: str) -> None:
    """Raise ``SpecError`` for the first key that is no key of ``of``, offering the nearest."""
    for key in table:
        if key not in known:
            raise SpecError(f"{where}.{key}", table[key], f"is not a key of {of}", nearest(key, known))


def nearest(word: str, known: Iterable[str]) -> str:
    """Remedy for an unknown word: the nearest known one, or all of them."""
    known = list(known)
    close = difflib.get_close_matches(word, known, n=1, cutoff=0.4)
    return f"did you mean {close[0]}?" if close else f"choose from {', '.join(sorted(known))}"
