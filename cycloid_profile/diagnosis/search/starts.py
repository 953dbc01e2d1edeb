"""Starts that linear equations cannot propose: the other sign, half a turn, other parts, effects of second order."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.search.proposals import Proposal

_SIZE = 0.5  # prior widths


def both_signs(proposals: list[Proposal]) -> Iterator[Proposal]:
    """Single effects without direction, from either side of zero where both exist."""
    for one in proposals:
        if len(one.members) == 1 and one.members[0].angle is None and not one.members[0].one_sided:
            sign = -1.0 if one.start[0] > 0.0 else 1.0
            yield replace(one, start=np.array([sign * _SIZE, 0.0]))


def unpromising(library: Library, offsets: tuple[int, ...], known: set[str]) -> Iterator[Proposal]:
    """One start of every effect without direction that linear equations exclude, such as one of negative size."""
    for name in library.names - known:
        candidate = library.candidates[library.of_name(name)[0]]
        if candidate.angle is None:
            yield Proposal((candidate,), np.array([_SIZE, 0.0]), offsets)
