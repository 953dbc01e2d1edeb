"""What is asked of the exact model, a set of effects to be fitted, and what it answers: the best sizes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate

FARTHEST = 4.0  # widths: no workshop makes that, and the equilibrium may not exist
_STEPS = 8


@dataclass(frozen=True, eq=False)
class Optimum:
    """The best sizes of a set of ``members``: coordinates ``u`` in units of widths, two a member, with covariance.

    ``R`` is the curvature of chi² there, ``chi2`` over so many ``rows``; ``log_evidence`` against no effect.
    ``settled`` if the steps ended small. The state behind it is ``ExactModel.at``.
    """

    members: tuple[Candidate, ...]
    u: FloatArray
    covariance: FloatArray
    R: FloatArray
    chi2: float
    rows: int
    log_evidence: float
    settled: bool

    def coordinates(self, i: int) -> FloatArray:
        """Coordinates of member ``i`` in its own unit."""
        return self.u[self._own(i)] * self.members[i].width

    def covariance_of(self, i: int) -> FloatArray:
        """Their covariance."""
        return self.covariance[self._own(i), self._own(i)] * self.members[i].width ** 2

    def _own(self, i: int) -> slice:
        i %= len(self.members)
        return slice(2 * i, 2 * i + 2)

    def beside(self, others: Sequence[Candidate]) -> Candidate | None:
        """The one member beside effects of the names of the ``others``, wherever they are; None if it is not one."""
        rest = list(self.members)
        for other in others:
            same = [member for member in rest if member.name == other.name]
            if not same:
                return None
            rest.remove(same[0])
        return rest[0] if len(rest) == 1 else None

    @property
    def misfit(self) -> float:
        """chi² with that of the priors."""
        return self.chi2 + float(self.u @ self.u)

    def turned_round(self) -> Iterator[tuple[tuple[Candidate, ...], Optimum]]:
        """Members that all discs see, each and then several together, with the set that has them half a turn on: discs
        half a turn apart see nearly the same.
        """
        alike = [
            i
            for i, member in enumerate(self.members)
            if member.on_all_discs and member.angle is not None and member.waves == 1
        ]
        for count in range(1, len(alike) + 1):
            for some in combinations(alike, count):
                u = self.u.copy()
                for i in some:
                    u[self._own(i)] *= -1.0
                yield tuple(self.members[i] for i in some), replace(self, u=u)

    @property
    def implausible(self) -> bool:
        """Whether a size is one that no workshop makes."""
        sizes = np.hypot(self.u[0::2], self.u[1::2])
        return any(size * c.width > c.implausible for size, c in zip(sizes, self.members, strict=True))


@dataclass(frozen=True, eq=False)
class Attempt:
    """A set of ``members`` to be fitted from ``start``, shape (2·members,), in at most so many ``steps``.

    Up to ``farthest`` widths; given up where not even what the linear model promises comes near
    ``beat``, the chi² with priors of a better set, and where a member falls below ``least`` widths.
    """

    members: tuple[Candidate, ...]
    start: FloatArray
    steps: int = _STEPS
    beat: float = math.inf
    farthest: float = FARTHEST
    least: float = 0.0
