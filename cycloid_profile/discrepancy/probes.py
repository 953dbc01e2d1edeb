"""What all flank hypotheses remove, made once: the search asks for it again and again.

A removal is a function of one place, the phase along the disc. It is sampled on a grid of that, once for all states of
the reducer; what a file gains by all flank effects then is one sparse product, weights on the grid times samples.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Place
from cycloid_profile.effects.pattern import removal_between

STEP = 1e-3  # of the width of a coordinate
# A cubic through four samples on each interval; none reaches over root or tip, where a removal may have a corner.
_INTERVALS_PER_FLANK = 32
_SAMPLES_PER_INTERVAL = 3
# The error of a cubic is below 1 % of a wave with so many samples.
_SAMPLES_PER_WAVE = 10.0
_MANY = 20  # candidates: the whole library is asked for in state after state


class Probes:
    """Small effects of a size of ``STEP`` on one reducer; what they remove hardly depends on what else it has."""

    def __init__(self, built: Built) -> None:
        self.built = built
        self.period = built.case.drive.trochoid.phase_period
        self._intervals = built.case.drive.trochoid.lobes * 2 * _INTERVALS_PER_FLANK
        count = self._intervals * _SAMPLES_PER_INTERVAL
        self._along = np.arange(count) * self.period / count
        self._made: dict[int, dict[int, FloatArray]] = {}
        self._of_first_lobe: dict[tuple[str, tuple[tuple[str, Any], ...]], dict[int, FloatArray]] = {}
        self._kept: list[Candidate] = []
        self._of_many: dict[int, tuple[tuple[int, ...], FloatArray]] = {}

    def after(self, candidate: Candidate, coordinate: int, built: Built) -> tuple[Built, float]:
        """``built`` with a small amount of one coordinate, and the amount."""
        step = np.zeros(2)
        step[coordinate] = STEP * candidate.width
        effect = candidate.effect(step)
        assert effect is not None
        return effect.apply(built), float(step[coordinate])

    def sampled(self, candidate: Candidate) -> bool:
        """Whether the grid follows it: every flank effect but a wave too short for it."""
        waves = float(candidate.choice.get("waves_per_turn", 0.0))
        return candidate.kind.place is Place.FLANK and waves * _SAMPLES_PER_WAVE < self._along.size

    def weights(self, row: IntArray, along: FloatArray, weight: FloatArray, rows: int) -> csr_array:
        """Sums over places of ``weight`` times removal at ``along`` [rad] as a matrix, shape (rows, grid)."""
        x = np.mod(along, self.period) * (self._intervals / self.period)
        interval = np.minimum(x.astype(np.intp), self._intervals - 1)
        s = x - interval
        # Lagrange through 0, 1/3, 2/3, 1.
        a, b, c = s - 1.0 / 3.0, s - 2.0 / 3.0, s - 1.0
        parts = (-4.5 * a * b * c, 13.5 * s * b * c, -13.5 * s * a * c, 4.5 * s * a * b)
        data = np.concatenate([weight * part for part in parts])
        first = _SAMPLES_PER_INTERVAL * interval
        where = np.concatenate([np.mod(first + k, self._along.size) for k in range(4)])
        return csr_array((data, (np.tile(row, 4), where)), shape=(rows, self._along.size))

    def removals(self, candidates: Sequence[Candidate], disc: int) -> FloatArray:
        """What the candidates remove of a disc on the grid, per width of each coordinate, shape (grid, 2n) [mm]."""
        key = tuple(map(id, candidates))
        if disc in self._of_many and self._of_many[disc][0] == key:
            return self._of_many[disc][1]
        rows = np.zeros((2 * len(candidates), self._along.size))
        for i, candidate in enumerate(candidates):
            own = self._removal(candidate).get(disc)
            if own is not None:
                rows[2 * i : 2 * i + own.shape[0]] = own
        found = np.ascontiguousarray(rows.T)
        if len(candidates) >= _MANY:
            self._of_many[disc] = (key, found)
        return found

    def touches(self, candidate: Candidate, disc: int) -> bool:
        """Whether it removes anything of a disc, counted from 0."""
        return disc in self._removal(candidate)

    def _removal(self, candidate: Candidate) -> dict[int, FloatArray]:
        """For each disc that is touched, shape (coordinates, grid)."""
        if id(candidate) not in self._made:
            self._kept.append(candidate)  # so that its id stays its own
            self._made[id(candidate)] = self._turned_or_fresh(candidate)
        return self._made[id(candidate)]

    def _turned_or_fresh(self, candidate: Candidate) -> dict[int, FloatArray]:
        key = next((k for k in ("lobe", "first_lobe") if k in candidate.choice), None)
        if key is None:
            return self._fresh(candidate)
        # The same on another lobe is the same further round.
        first = tuple((k, v) for k, v in candidate.choice.items() if k != key)
        known = (candidate.name, first)
        if known not in self._of_first_lobe:
            self._of_first_lobe[known] = self._fresh(replace(candidate, choice={**candidate.choice, key: 1}))
        lobes = self.built.case.drive.trochoid.lobes
        further = (candidate.choice[key] - 1) * self._along.size // lobes
        return {j: np.roll(own, further, axis=1) for j, own in self._of_first_lobe[known].items()}

    def _fresh(self, candidate: Candidate) -> dict[int, FloatArray]:
        lobe = np.round(self._along / (2.0 * math.pi))
        phase = self._along - 2.0 * math.pi * lobe
        found: dict[int, list[FloatArray]] = {}
        for c in range(candidate.coordinates):
            after, _ = self.after(candidate, c, self.built)
            for j, (old, new) in enumerate(zip(self.built.teeth, after.teeth, strict=True)):
                if new is not old:
                    found.setdefault(j, []).append(removal_between(old, new, phase, lobe) / STEP)
        return {j: np.stack(parts) for j, parts in found.items()}
