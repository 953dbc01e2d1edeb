"""Removals of all flank hypotheses, made once: the search asks for them again and again."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Place
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import NormalRemoval, flank_side

STEP = 1e-3  # of the width of a coordinate


class Probes:
    """Small effects of a size of ``STEP`` on one reducer; what they remove hardly depends on what else it has."""

    def __init__(self, built: Built) -> None:
        self.built = built
        self._made: dict[tuple[int, int], dict[int, tuple[NormalRemoval, ...]] | None] = {}
        self._kept: list[Candidate] = []

    def after(self, candidate: Candidate, coordinate: int, built: Built) -> tuple[Built, float]:
        """``built`` with a small amount of one coordinate, and the amount."""
        step = np.zeros(2)
        step[coordinate] = STEP * candidate.width
        effect = candidate.effect(step)
        assert effect is not None
        return effect.apply(built), float(step[coordinate])

    def removals(self, candidate: Candidate, coordinate: int) -> dict[int, tuple[NormalRemoval, ...]] | None:
        """Removals that a step of the coordinate adds to each disc; None where it does more than add removals."""
        key = (id(candidate), coordinate)
        if key not in self._made:
            self._kept.append(candidate)  # so that its id stays its own
            self._made[key] = self._added(candidate, coordinate)
        return self._made[key]

    def _added(self, candidate: Candidate, coordinate: int) -> dict[int, tuple[NormalRemoval, ...]] | None:
        if candidate.kind.place is not Place.FLANK:
            return None
        after, _ = self.after(candidate, coordinate, self.built)
        found = {}
        for j, (old, new) in enumerate(zip(self.built.teeth, after.teeth, strict=True)):
            if new is old:
                continue
            if new.trochoid != old.trochoid or new.pin_radius != old.pin_radius:
                return None
            found[j] = new.removals[len(old.removals) :]
        return found


def removed(
    removals: tuple[NormalRemoval, ...], tooth: ToothProfile, phase: FloatArray, lobe: FloatArray
) -> FloatArray:
    """Sum of removals at phases of lobes [mm]."""
    along, side = phase + 2.0 * np.pi * lobe, flank_side(phase)
    return sum((one.jet(along, side, tooth.trochoid).value for one in removals), np.zeros_like(along))
