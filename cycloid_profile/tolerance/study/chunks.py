"""A Monte Carlo study: tolerances, quantities and number of reducers; and the results of one chunk of them.

A chunk is the unit of work. It depends on the study and its own number alone, so that any worker may compute it, and
the result does not depend on the number of workers.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import AsBuiltReducer, ReducerChange, as_drawn, plugin_code
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.tolerance.inputs import Tolerances
from cycloid_profile.tolerance.model import QuantityModel, unit_changes
from cycloid_profile.tolerance.study.draws import Draws

CHUNK = 4096  # reducers; a power of two, as a net of Sobol wants


@dataclass(frozen=True)
class Study:
    """``samples`` random reducers, ``reducer`` with errors from ``draws``, and the quantities ``wanted`` of each."""

    reducer: AsBuiltReducer
    draws: Draws
    wanted: tuple[str, ...]
    samples: int
    chunk: int = CHUNK

    @property
    def tolerances(self) -> Tolerances:
        """Tolerances of the study."""
        return self.draws.tolerances

    @cached_property
    def changes(self) -> list[ReducerChange]:
        """Change of the reducer by a unit of each coordinate."""
        return unit_changes(self.reducer, self.tolerances)

    @cached_property
    def quantity_model(self) -> QuantityModel:
        """Methods that compute the quantities, made once."""
        return QuantityModel(self.reducer, self.changes, self.wanted)

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
        """Quantities of the reducers of a chunk, shape (count, quantities), ordered as ``quantity_model.names``."""
        return self.quantity_model.of(self.coordinates(number))

    def with_tolerances(self, tolerances: Tolerances) -> Study:
        """The same reducers under other tolerances: the same normal numbers, other sizes."""
        return replace(self, draws=replace(self.draws, tolerances=tolerances))

    @cached_property
    def fingerprint(self) -> str:
        """Hash of all that a chunk depends on; the number of chunks is no part of it."""
        case = self.reducer.case
        parts = [repr(case), repr(self.draws), repr(self.wanted), repr(self.chunk), repr(self.reducer.teeth)]
        drawn = as_drawn(case)
        for name in ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift", "crank_lead"):
            parts.append(f"{name}{(getattr(self.reducer, name) - getattr(drawn, name)).tobytes().hex()}")
        parts += [repr(getattr(self.reducer, name)) for name in ("series_compliance", "further_twists", "encoder")]
        parts += [f"{name}{value}" for name in ("sun_shift", "input_error") if (value := getattr(self.reducer, name))]
        removals = [removal for tooth in self.reducer.teeth for removal in tooth.removals]
        # The ``repr`` of a curve names its range only.
        curves = (one for one in removals if isinstance(one, NormalDeviation))
        parts += [f"{one.phase.tobytes().hex()}{one.removal.tobytes().hex()}" for one in curves]
        users: list[type] = [one.kind for one in self.tolerances.scatters]
        users += [type(one) for one in (*removals, *self.reducer.further_twists)]
        parts += [code] if (code := plugin_code(users)) else []
        return hashlib.sha256("\n".join(parts).encode("utf-8")).hexdigest()
