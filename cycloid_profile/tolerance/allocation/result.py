"""Result of an allocation: each tolerance before and after, yield, cost, and how the search ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from typing import Any

import numpy as np

from cycloid_profile._display import Described, frame
from cycloid_profile.arrays import FloatArray
from cycloid_profile.tolerance.allocation._optimum import CostCurves, active_bounds
from cycloid_profile.tolerance.inputs import Limit, Scatter, Tolerances
from cycloid_profile.tolerance.study import Interval, percent

_BOUNDS = {-1: "finest", 0: "", 1: "coarsest"}


class AllocationStatus(Enum):
    """How an allocation ended."""

    CONFIRMED = "the yield is reached, and independent reducers confirm it"
    LOOSEST = (
        "every tolerance is as coarse as its bound allows and the yield is confirmed: allow coarser ones to save more"
    )
    UNCONFIRMED = "the yield is reached on the reducers of the search but not surely on others: draw more of both"
    UNSETTLED = "the yield is confirmed, but the search stopped before the cheapest set: draw more reducers"


@dataclass(frozen=True)
class AllocatedTolerance:
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


@dataclass(frozen=True, eq=False, repr=False)
class Allocation(Described):
    """Tolerances that reach the ``wanted`` yield at least cost.

    ``tolerances`` to be held; ``lines``, one per scatter; ``yield_before`` and ``yield_after`` of the same independent
    reducers, whose quantities ``names`` are ``before`` and ``after``, shape (reducers, quantities); ``aimed``, the
    yield searched for, which differs from ``wanted`` by the margin that confirms it; ``cost_per_percent`` of one more
    percent of yield; ``saving_left``, share of the cost a better search might still save at most, by Eq. 74;
    ``assumed_costs``, no scatter had a cost and all were given the same.
    """

    status: AllocationStatus
    limits: tuple[Limit, ...]
    wanted: float
    aimed: float
    tolerances: Tolerances
    lines: tuple[AllocatedTolerance, ...]
    yield_before: Interval
    yield_after: Interval
    cost_per_percent: float
    saving_left: float
    rounds: int
    samples: int
    assumed_costs: bool
    names: tuple[str, ...]
    before: FloatArray
    after: FloatArray

    @property
    def cost_before(self) -> float:
        """Cost of all tolerances as drawn."""
        return sum(one.cost_before or 0.0 for one in self.lines)

    @property
    def cost_after(self) -> float:
        """Cost of all tolerances as allocated."""
        return sum(one.cost_after or 0.0 for one in self.lines)

    def to_frame(self) -> Any:
        """A ``pandas.DataFrame``, one row per tolerance: width and cost before and after, and the bound it reached."""
        rows = [asdict(one) | {"ratio": one.ratio} for one in self.lines]
        return frame({name: [row[name] for row in rows] for name in rows[0]})

    def _key_figures(self) -> Mapping[str, str]:
        figures = {
            "status": self.status.value,
            "cost": f"{self.cost_before:.4g} → {self.cost_after:.4g}",
            "yield before": percent(self.yield_before),
            "yield after": percent(self.yield_after),
        }
        widths = (f"±{one.plus_minus_before:.3g} → ±{one.plus_minus_after:.3g} {one.unit}" for one in self.lines)
        return figures | dict(zip((one.label for one in self.lines), widths, strict=True))


def lines_of(curves: CostCurves, u: FloatArray, tolerances: Tolerances) -> tuple[AllocatedTolerance, ...]:
    """One line per scatter of the ``tolerances`` as drawn, allocated at ``u``."""
    number = {int(where): i for i, where in enumerate(curves.where)}
    met = active_bounds(curves, u)
    lines = []
    for j, (old, new) in enumerate(zip(tolerances.scatters, curves.applied(tolerances, u).scatters, strict=True)):
        i = number.get(j)
        ratio, bound = (1.0, "") if i is None else (float(np.exp(u[i])), _BOUNDS[int(met[i])])
        before, after = (None if old.cost is None else old.cost.value(r) for r in (1.0, ratio))
        lines.append(AllocatedTolerance(old.label, old.unit, _width(old), _width(new), before, after, bound))
    return tuple(lines)


def _width(scatter: Scatter) -> float:
    return 3.0 * scatter.size.standard_deviation if scatter.plus_minus is None else scatter.plus_minus
