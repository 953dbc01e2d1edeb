"""Removals of all flank hypotheses, tabulated on one grid of the phase along the disc.

A removal depends on the phase only, and hardly on the other effects of the reducer. One table serves all states: the
change of a file is a sparse product of its weights on the grid with the table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.effects import AsBuiltReducer, EffectLocation, removal_between

if TYPE_CHECKING:
    from scipy.sparse import csr_array

STEP = 1e-3  # of the width of a coordinate
# Cubic interpolation through four samples of each interval. No interval crosses a root or tip, where removals may have
# a corner.
_INTERVALS_PER_FLANK = 32
_SAMPLES_PER_INTERVAL = 3  # new ones; the fourth of a cubic is the first of the next interval
# Interpolation error below 1 % of the amplitude.
_SAMPLES_PER_WAVE = 10.0
_SHORTER = 10.0  # times
_MANY = 20  # candidates: tables of this size are cached


class FlankGrid:
    """Removals of small effects, ``STEP`` prior widths in size, tabulated on one reducer."""

    def __init__(self, reducer: AsBuiltReducer) -> None:
        self.reducer = reducer
        self.period = reducer.case.drive.trochoid.phase_period
        self._intervals = reducer.case.drive.trochoid.lobes * 2 * _INTERVALS_PER_FLANK
        count = self._intervals * _SAMPLES_PER_INTERVAL
        self._along = np.arange(count) * self.period / count
        self._tables: dict[Candidate, dict[int, FloatArray]] = {}
        self._first_lobe_tables: dict[tuple[str, tuple[tuple[str, Any], ...]], dict[int, FloatArray]] = {}
        self._cached: dict[int, tuple[tuple[Candidate, ...], FloatArray]] = {}

    def after(self, candidate: Candidate, coordinate: int, reducer: AsBuiltReducer) -> tuple[AsBuiltReducer, float]:
        """``reducer`` with a small value of one coordinate of the candidate, and the value."""
        step = np.zeros(2)
        step[coordinate] = STEP * candidate.width
        effect = candidate.effect(step)
        assert effect is not None
        return effect.apply(reducer), float(step[coordinate])

    def sampled(self, candidate: Candidate) -> bool:
        """Whether the grid resolves the candidate: every flank effect except very short waves."""
        waves = float(candidate.choice.get("waves_per_turn", 0.0))
        # Waves that are even in another motion than the generating one are shorter near the tips.
        waves *= 1.0 if candidate.choice.get("constant_speed", "generating") == "generating" else _SHORTER
        return candidate.kind.location is EffectLocation.FLANK and waves * _SAMPLES_PER_WAVE < self._along.size

    def weights(self, row: IntArray, along: FloatArray, weight: FloatArray, rows: int) -> csr_array:
        """Matrix of sums of ``weight`` times removal at ``along`` [rad], shape (rows, grid)."""
        from scipy.sparse import csr_array

        x = np.mod(along, self.period) * (self._intervals / self.period)
        interval = np.minimum(x.astype(np.intp), self._intervals - 1)
        s = x - interval
        # Lagrange polynomials through 0, 1/3, 2/3, 1.
        a, b, c = s - 1.0 / 3.0, s - 2.0 / 3.0, s - 1.0
        parts = (-4.5 * a * b * c, 13.5 * s * b * c, -13.5 * s * a * c, 4.5 * s * a * b)
        data = np.concatenate([weight * part for part in parts])
        first = _SAMPLES_PER_INTERVAL * interval
        where = np.concatenate([np.mod(first + k, self._along.size) for k in range(4)])
        return csr_array((data, (np.tile(row, 4), where)), shape=(rows, self._along.size))

    def removals(self, candidates: Sequence[Candidate], disc: int) -> FloatArray:
        """Removal of the candidates from a disc on the grid, per prior width, shape (grid, 2n) [mm]."""
        key = tuple(candidates)
        if disc in self._cached and self._cached[disc][0] == key:
            return self._cached[disc][1]
        rows = np.zeros((2 * len(candidates), self._along.size))
        for i, candidate in enumerate(candidates):
            own = self._removal(candidate).get(disc)
            if own is not None:
                rows[2 * i : 2 * i + own.shape[0]] = own
        found = np.ascontiguousarray(rows.T)
        if len(candidates) >= _MANY:
            self._cached[disc] = (key, found)
        return found

    def touches(self, candidate: Candidate, disc: int) -> bool:
        """Whether the candidate changes a disc, counted from 0."""
        return disc in self._removal(candidate)

    def _removal(self, candidate: Candidate) -> dict[int, FloatArray]:
        """For each disc that the candidate changes, shape (coordinates, grid)."""
        if candidate not in self._tables:
            self._tables[candidate] = self._shifted_or_new(candidate)
        return self._tables[candidate]

    def _shifted_or_new(self, candidate: Candidate) -> dict[int, FloatArray]:
        key = next((k for k in ("lobe", "first_lobe") if k in candidate.choice), None)
        if key is None:
            return self._tabulated(candidate)
        # The table of another lobe is shifted by whole lobes.
        first = tuple((k, v) for k, v in candidate.choice.items() if k != key)
        known = (candidate.name, first)
        if known not in self._first_lobe_tables:
            self._first_lobe_tables[known] = self._tabulated(replace(candidate, choice={**candidate.choice, key: 1}))
        lobes = self.reducer.case.drive.trochoid.lobes
        further = (candidate.choice[key] - 1) * self._along.size // lobes
        return {j: np.roll(own, further, axis=1) for j, own in self._first_lobe_tables[known].items()}

    def _tabulated(self, candidate: Candidate) -> dict[int, FloatArray]:
        lobe = np.round(self._along / (2.0 * math.pi))
        phase = self._along - 2.0 * math.pi * lobe
        found: dict[int, list[FloatArray]] = {}
        for c in range(candidate.coordinates):
            after, _ = self.after(candidate, c, self.reducer)
            for j, (old, new) in enumerate(zip(self.reducer.teeth, after.teeth, strict=True)):
                if new is not old:
                    found.setdefault(j, []).append(removal_between(old, new, phase, lobe) / STEP)
        return {j: np.stack(parts) for j, parts in found.items()}
