"""Input and output of an exact fit: the attempt and its optimum."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.model.candidate import Candidate

FARTHEST = 4.0  # widths: beyond this a size is implausible and the equilibrium may not exist
_CONVERGED_GAIN = 0.02  # of chi²: a tenth of a standard deviation of one size
_STEPS = 8  # most fits end earlier, by the gain of their last step
_ABANDONED_ABOVE = 50.0  # of chi² above the best set: five times the 9 between two distinguished sets


@dataclass(frozen=True, eq=False)
class Optimum:
    """Optimal sizes of ``members``: coordinates ``u`` in units of prior widths, two each, with covariance.

    ``R``: half the curvature of chi². ``chi2``: over ``rows`` rows; ``misfit``: the same with the terms of prior and
    covariance. ``log_evidence``: against no effect. ``converged``: the last step was small; ``stalled``: no step left
    less. ``ExactModel.at`` gives the state.
    """

    members: tuple[Candidate, ...]
    u: FloatArray
    covariance: FloatArray
    R: FloatArray
    chi2: float
    misfit: float
    rows: int
    log_evidence: float
    converged: bool
    stalled: bool = False

    @property
    def ended(self) -> bool:
        """Whether further steps would leave as much."""
        return self.converged or self.stalled

    @property
    def residual_variance(self) -> float:
        """Variance that the set leaves, in units of that of the noise, at least 1."""
        return max(self.chi2 / max(self.rows, 1), 1.0)

    def coordinates(self, i: int) -> FloatArray:
        """Coordinates of member ``i`` in their own unit."""
        return self.u[self._own(i)] * self.members[i].width

    def covariance_of(self, i: int) -> FloatArray:
        """Their covariance."""
        return self.covariance[self._own(i), self._own(i)] * self.members[i].width ** 2

    def _own(self, i: int) -> slice:
        i %= len(self.members)
        return slice(2 * i, 2 * i + 2)

    def remaining_member(self, others: Sequence[Candidate]) -> Candidate | None:
        """The single member that matches none of ``others`` by name; None otherwise."""
        rest = list(self.members)
        for other in others:
            same = [member for member in rest if member.name == other.name]
            if not same:
                return None
            rest.remove(same[0])
        return rest[0] if len(rest) == 1 else None

    def rotated_by_180(self) -> Iterator[tuple[tuple[Candidate, ...], Optimum]]:
        """Combinations of members that are nearly the same at 180°, each with the set that has them rotated by it."""
        identical = [i for i, member in enumerate(self.members) if member.same_at_180]
        for count in range(1, len(identical) + 1):
            for some in combinations(identical, count):
                yield tuple(self.members[i] for i in some), self._negated(some)

    def of_opposite_sign(self) -> Iterator[tuple[Candidate, Optimum]]:
        """Each member of either sign without an angle, with the set that has its size with the opposite sign."""
        for i, member in enumerate(self.members):
            if member.angle is None and not member.one_sided:
                yield member, self._negated([i])

    def _negated(self, some: Iterable[int]) -> Optimum:
        u = self.u.copy()
        for i in some:
            u[self._own(i)] *= -1.0
        return replace(self, u=u)

    @property
    def linearly_determined(self) -> list[int]:
        """Numbers of the members whose size is clearly not zero in linear equations: another only lends the error of
        its form.
        """
        found = []
        for i in range(len(self.members)):
            u, covariance = self.u[self._own(i)], self.covariance[self._own(i), self._own(i)]
            variance = float(u @ covariance @ u) + self.members[i].size_error ** 2 * float(u @ u)
            if float(u @ u) ** 2 >= tuned.DETERMINED**2 * variance:
                found.append(i)
        return found

    def part(self, numbers: Sequence[int]) -> tuple[tuple[Candidate, ...], FloatArray]:
        """Some of the members, and their coordinates, shape (2·numbers,)."""
        u = np.concatenate([np.zeros(0), *(self.u[self._own(i)] for i in numbers)])
        return tuple(self.members[i] for i in numbers), u

    @property
    def implausible(self) -> bool:
        """Whether a size is implausible."""
        sizes = np.hypot(self.u[0::2], self.u[1::2])
        return any(size * c.width > c.implausible for size, c in zip(sizes, self.members, strict=True))


@dataclass(frozen=True, eq=False)
class Attempt:
    """Fit of ``members`` from ``start``, shape (2·members,), in at most ``steps`` steps.

    The last step is the first that promises less than ``least_gain`` of chi². Sizes are limited to ``farthest`` widths.
    The attempt is abandoned if even the linear model cannot reach ``beat``, chi² with priors of a better set.
    """

    members: tuple[Candidate, ...]
    start: FloatArray
    steps: int = _STEPS
    beat: float = math.inf
    farthest: float = FARTHEST
    least_gain: float = _CONVERGED_GAIN

    def cannot_beat(self, misfit: float) -> bool:
        """Whether a set that reaches no less than this ``misfit``, chi² with priors, is clearly worse."""
        return misfit > self.beat + _ABANDONED_ABOVE
