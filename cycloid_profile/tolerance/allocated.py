"""What an allocation of tolerances says: each tolerance before and after, yield, cost, and how it ended."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.cheapest import Curves, bounds_met
from cycloid_profile.tolerance.limits import Limit
from cycloid_profile.tolerance.scatter import Scatter, Tolerances
from cycloid_profile.tolerance.summary import Interval

_BOUNDS = {-1: "finest", 0: "", 1: "coarsest"}


class Status(Enum):
    """How an allocation ended."""

    CONFIRMED = "the yield is reached, and independent reducers confirm it"
    LOOSEST = (
        "every tolerance is as coarse as its bound allows and the yield is confirmed: allow coarser ones to save more"
    )
    UNCONFIRMED = "the yield is reached on the reducers of the search but not surely on others: draw more of both"
    UNSETTLED = "the yield is confirmed, but the search stopped before the cheapest set: draw more reducers"


@dataclass(frozen=True)
class Line:
    """One tolerance before and after: ``plus_minus`` in its ``unit``, three standard deviations where only these were
    given; ``bound`` "finest", "coarsest" or "" where it is at neither; costs None where it has none and stayed as
    drawn.
    """

    label: str
    unit: str
    plus_minus_before: float
    plus_minus_after: float
    cost_before: float | None
    cost_after: float | None
    bound: str

    @property
    def ratio(self) -> float:
        """Tolerance after by before."""
        return self.plus_minus_after / self.plus_minus_before if self.plus_minus_before else 1.0


@dataclass(frozen=True)
class Allocation:
    """Tolerances that reach the ``wanted`` yield at least cost.

    ``tolerances`` to be held; ``lines``, one a scatter; ``yield_before`` and ``yield_after`` of the same independent
    reducers, whose quantities ``names`` are ``before`` and ``after``, shape (reducers, quantities); ``aimed``, the
    yield searched for, which differs from ``wanted`` by the margin that confirms it; ``cost_per_percent`` of one more
    percent of yield; ``saving_left``, share of the cost a better search might still save at most, by Eq. 74;
    ``assumed_costs``, no scatter had a cost and all were given the same.
    """

    status: Status
    limits: tuple[Limit, ...]
    wanted: float
    aimed: float
    tolerances: Tolerances
    lines: tuple[Line, ...]
    yield_before: Interval
    yield_after: Interval
    cost_per_percent: float
    saving_left: float
    rounds: int
    samples: int
    assumed_costs: bool
    names: tuple[str, ...]
    before: FloatArray = field(repr=False)
    after: FloatArray = field(repr=False)

    @property
    def cost_before(self) -> float:
        """Cost of all tolerances as drawn."""
        return sum(one.cost_before or 0.0 for one in self.lines)

    @property
    def cost_after(self) -> float:
        """Cost of all tolerances as allocated."""
        return sum(one.cost_after or 0.0 for one in self.lines)


def lines_of(curves: Curves, u: FloatArray, tolerances: Tolerances) -> tuple[Line, ...]:
    """One line a scatter of the ``tolerances`` as drawn, allocated at ``u``."""
    number = {int(where): i for i, where in enumerate(curves.where)}
    met = bounds_met(curves, u)
    lines = []
    for j, (old, new) in enumerate(zip(tolerances.scatters, curves.applied(tolerances, u).scatters, strict=True)):
        i = number.get(j)
        ratio, bound = (1.0, "") if i is None else (float(np.exp(u[i])), _BOUNDS[int(met[i])])
        before, after = (None if old.cost is None else old.cost.at(r) for r in (1.0, ratio))
        lines.append(Line(old.label, old.unit, _width(old), _width(new), before, after, bound))
    return tuple(lines)


def _width(scatter: Scatter) -> float:
    return 3.0 * scatter.size.standard_deviation if scatter.plus_minus is None else scatter.plus_minus


def percent(share: Interval) -> str:
    """A yield with its 95 % interval, in words."""
    return f"{100.0 * share.value:.2f} % ({100.0 * share.low:.2f} to {100.0 * share.high:.2f} %)"
