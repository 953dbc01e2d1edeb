"""A Monte Carlo study: what scatters, what is counted, how many reducers; and the answers of one chunk of them.

A chunk is the unit of work: it depends on the study and its own number alone, so that any worker may do it, twice if
need be, and the result does not depend on how many workers there were.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.patterns import UnitChange, unit_changes
from cycloid_profile.tolerance.quantities import Measures
from cycloid_profile.tolerance.scatter import Tolerances

CHUNK = 4096  # reducers; a power of two, as a net of Sobol wants


@dataclass(frozen=True)
class Study:
    """``samples`` reducers as ``built`` with errors as ``draws`` has them, and the quantities ``wanted`` of each."""

    built: Built
    draws: Draws
    wanted: tuple[str, ...]
    samples: int
    chunk: int = CHUNK

    @property
    def tolerances(self) -> Tolerances:
        """What scatters."""
        return self.draws.tolerances

    @cached_property
    def changes(self) -> list[UnitChange]:
        """What a unit of each coordinate changes."""
        return unit_changes(self.built, self.tolerances)

    @cached_property
    def measures(self) -> Measures:
        """How the quantities are computed, made once."""
        return Measures(self.built, self.changes, self.wanted)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-self.samples // self.chunk)

    def span(self, number: int) -> tuple[int, int]:
        """First reducer of a chunk, and their count."""
        first = number * self.chunk
        return first, min(self.chunk, self.samples - first)

    def coordinates(self, number: int) -> FloatArray:
        """Coordinates of the reducers of a chunk, shape (count, coordinates)."""
        first, count = self.span(number)
        # The whole chunk is drawn even where its end is cut off: a longer study begins with the same reducers.
        return self.draws.coordinates(number, self.chunk, first)[:count]

    def values(self, number: int) -> FloatArray:
        """Quantities of the reducers of a chunk, shape (count, quantities), in the order of ``measures.names``."""
        return self.measures.of(self.coordinates(number))

    def with_tolerances(self, tolerances: Tolerances) -> Study:
        """The same reducers under other tolerances: the same normal numbers, other sizes."""
        return replace(self, draws=replace(self.draws, tolerances=tolerances))

    @cached_property
    def fingerprint(self) -> str:
        """Changes with anything that changes a chunk, but not with how many chunks there are."""
        case = self.built.case
        told = [repr(case), repr(self.draws), repr(self.wanted), repr(self.chunk), repr(self.built.teeth)]
        drawn = as_drawn(case)
        for name in ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift", "crank_lead"):
            told.append(f"{name}{(getattr(self.built, name) - getattr(drawn, name)).tobytes().hex()}")
        told += [repr(self.built.series_compliance), repr(self.built.encoder)]
        return hashlib.sha256("\n".join(told).encode("utf-8")).hexdigest()
