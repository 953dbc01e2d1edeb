"""The same effects on another disc, on the opposite pins and on other cranks.

Discs are mounted 180° apart, cranks 120°. Errors of equivalent parts act on the output in nearly the same way; only the
exact model separates them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.effects import AsBuiltReducer

_MOST = 18  # of each set


def on_other_parts(library: Library, optimum: Optimum, reducer: AsBuiltReducer) -> list[tuple[list[int], FloatArray]]:
    """Library indices and coordinates of the same effects moved to the other discs, to the pins that these meet as the
    first disc meets the present ones, and to every crank together.
    """
    found, discs = [], reducer.discs
    for further in range(discs):
        choices = [list(_choices(member.choice, further, reducer)) for member in optimum.members]
        u = np.concatenate(
            [*(_rotated(m, optimum.u[2 * i : 2 * i + 2], further / discs) for i, m in enumerate(optimum.members)), []]
        )
        for combination in product(*choices):
            pairs = zip(optimum.members, combination, strict=True)
            moved = [library.where(member.name, choice) for member, choice in pairs]
            known = [one for one in moved if one is not None]
            if len(known) == len(moved):
                found.append((library.places(known), u))
    # The first is the set itself.
    return found[1 : _MOST + 1]


def _choices(choice: Mapping[str, Any], further: int, reducer: AsBuiltReducer) -> Iterator[dict[str, Any]]:
    """Choices of parts ``further`` discs on, first with the same crank, then with the others."""
    moved, discs, cranks = dict(choice), reducer.discs, reducer.cranks
    if moved.get("disc") is not None:
        moved["disc"] = (moved["disc"] - 1 + further) % discs + 1
    if "pin" in moved:
        pins = reducer.case.drive.trochoid.pins
        moved["pin"] = (moved["pin"] - 1 + round(pins * further / discs)) % pins + 1
    if moved.get("crank") is None:
        yield moved
    else:
        for k in range(cranks):
            yield {**moved, "crank": (choice["crank"] - 1 + k) % cranks + 1}


def _rotated(member: Candidate, u: FloatArray, turn: float) -> FloatArray:
    """Coordinates on a disc mounted ``turn`` turns further: directions rotate with it."""
    if member.angle is None or member.choice.get("disc") is None:
        return u
    c = complex(u[0], u[1]) * np.exp(2j * math.pi * member.waves * turn)
    return np.array([c.real, c.imag])
