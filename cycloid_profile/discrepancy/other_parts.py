"""The same effects of another disc and of other cranks.

Discs stand half a turn apart and cranks a third: what is wrong with one turns the output nearly like what is wrong with
another, and linear equations about the one have no idea of the other. The exact model tells them apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.climbing import Climb, Start
from cycloid_profile.discrepancy.optimum import Optimum

_SETS = 6
_MOST = 18  # of each set
_REACH = 60.0  # of the evidence

_Key = tuple[str, frozenset[tuple[str, Any]]]


def of_other_parts(climb: Climb) -> list[Start]:
    """Where to begin with the leading sets of the climb on the other discs, all members moved alike, and on every
    crank; only of those that few poses stand for.
    """
    starts, ranked = list[Start](), climb.ranked
    known = {_key(c.name, c.choice): i for i, c in enumerate(climb.library.candidates)}
    for one in ranked[:_SETS]:
        if one.log_evidence > ranked[0].log_evidence - _REACH and climb.model.solves_few_poses(one.members):
            starts += _moved(one, known, climb.model.built.discs, climb.model.built.cranks)
    return starts


def _moved(optimum: Optimum, known: Mapping[_Key, int], discs: int, cranks: int) -> list[Start]:
    found = []
    for further in range(discs):
        choices = [list(_choices(member.choice, further, discs, cranks)) for member in optimum.members]
        u = np.concatenate(
            [*(_turned(m, optimum.u[2 * i : 2 * i + 2], further / discs) for i, m in enumerate(optimum.members)), []]
        )
        for combination in product(*choices):
            keys = [_key(member.name, choice) for member, choice in zip(optimum.members, combination, strict=True)]
            if all(key in known for key in keys):
                found.append(([known[key] for key in keys], u))
    # The first is the set itself.
    return found[1 : _MOST + 1]


def _choices(choice: Mapping[str, Any], further: int, discs: int, cranks: int) -> Iterator[dict[str, Any]]:
    """The choice of parts so many discs further, on its own crank first and then on the others."""
    moved = dict(choice)
    if moved.get("disc") is not None:
        moved["disc"] = (moved["disc"] - 1 + further) % discs + 1
    if moved.get("crank") is None:
        yield moved
    else:
        for k in range(cranks):
            yield {**moved, "crank": (choice["crank"] - 1 + k) % cranks + 1}


def _turned(member: Candidate, u: FloatArray, turn: float) -> FloatArray:
    """Coordinates on a disc that is mounted a share of a turn further: directions turn with it."""
    if member.angle is None or member.choice.get("disc") is None:
        return u
    c = complex(u[0], u[1]) * np.exp(2j * math.pi * member.waves * turn)
    return np.array([c.real, c.imag])


def _key(name: str, choice: Mapping[str, Any]) -> _Key:
    return name, frozenset(choice.items())
