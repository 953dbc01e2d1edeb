"""The cheapest tolerances that reach a yield, confirmed on independent reducers (docs/allocation.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import AllocationError, SpecError
from cycloid_profile.tolerance.allocation._optimum import (
    ROUGH,
    Cheapest,
    Sample,
    active_bounds,
    cheapest,
    highest_yield_tolerances,
)
from cycloid_profile.tolerance.allocation.result import Allocation, AllocationStatus, lines_of
from cycloid_profile.tolerance.inputs import Cost, Ends, Limit, limits_of, within
from cycloid_profile.tolerance.model import Quantities
from cycloid_profile.tolerance.study import Draws, Interval, Random, Sobol, percent, share_interval

_TWO_SIDED = 1.959964  # standard errors to either end of a 95 % interval
_LEAST_FAILING = 40.0  # reducers beyond the limits in a sample, on average; fewer are no tail to find a gradient in
_COARSE = 8  # times fewer reducers to choose a start with
_ROUNDS = 5
_SETTLED = 2e-3  # share of the cost that may be left to save
_CHUNK = 4096
# Where a scatter names no cost, and none does: all cost the same, half the tolerance twice as much.
EQUAL_COST = Cost(1.0)


@dataclass(frozen=True, slots=True)
class SampleSizes:
    """How many reducers: ``samples`` to search with, ``verification`` to confirm with; None for the default.

    The default search uses 40 reducers beyond the limits and at least 4096 in total; the verification uses four times
    as many.
    """

    samples: int | None = None
    verification: int | None = None

    def counted(self, failing: float) -> tuple[int, int]:
        """Both numbers for a share ``failing``; powers of two, as a Sobol net requires."""
        least = max(4096, math.ceil(_LEAST_FAILING / failing))
        samples = self.samples or 1 << (least - 1).bit_length()
        return samples, self.verification or 4 * samples


def allocate(
    draws: Draws,
    answers: Quantities,
    limits: Sequence[Limit] | Mapping[str, Ends],
    wanted: float = 0.95,
    effort: SampleSizes = SampleSizes(),
    progress: Callable[[str], None] = lambda _: None,
) -> Allocation:
    """Tolerances of least cost at which a share ``wanted`` of reducers keeps ``limits`` (docs/allocation.md, Eq. 71).

    ``answers``, such as ``QuantityModel``, gives the quantities of reducers at coordinates from ``draws``.
    ``limits`` as a mapping are read by ``limits_of``. Scatters without a cost stay as drawn, unless none has one. The
    same arguments give the same answer.

    Raises
    ------
    SpecError
        If a limit or the yield is impossible, or nothing may change.
    AllocationError
        If no tolerances within their bounds reach the yield.
    """
    if not 0.0 < wanted < 1.0:
        raise SpecError("yield", f"{wanted:g}", "is outside (0, 1)", "give a share, such as 0.95")
    kept = limits_of(limits, answers.names)
    draws, assumed = _prepared(draws)
    samples, verification = effort.counted(1.0 - wanted)
    progress(f"allocation: search with {samples:,} reducers, confirmed with {verification:,}, at most {_ROUNDS} rounds")
    sample = Sample.drawn(replace(draws, sequence=Sobol()), answers, kept, samples)
    if sample.curves.where.size == 0:
        raise SpecError("tolerances", "no cost", "changes with the tolerance", "give one a cost above 0", ": ")
    search = _Search(sample, kept, wanted, verification, progress)
    best, rounds = search.confirmed(search.start())
    return _allocation(search, best, rounds, assumed)


@dataclass(frozen=True)
class _Round:
    """One search, and its yield confirmed on independent reducers."""

    number: int
    aimed: float
    found: Cheapest
    confirmed: Interval


@dataclass(frozen=True)
class _Search:
    sample: Sample
    limits: tuple[Limit, ...]
    wanted: float
    verification: int
    progress: Callable[[str], None]

    @property
    def margin(self) -> float:
        """Margin by which a yield has to exceed the wanted one to be distinguished from it."""
        return _TWO_SIDED * math.sqrt(self.wanted * (1.0 - self.wanted) / self.verification)

    def start(self) -> FloatArray:
        """Start of the search: the cheapest that a smaller sample finds from drawing, finest and coarsest."""
        curves = self.sample.curves
        small = self.sample.beginning(max(len(self.sample.z) // _COARSE, min(len(self.sample.z), 512)))
        found = []
        for name, u in (("drawing", np.zeros(len(curves.where))), ("finest", curves.low), ("coarsest", curves.high)):
            one = cheapest(small, self._first_target, u, ROUGH)
            outcome = f"costs {one.cost:.4g}" if one.kept else "does not reach the yield"
            self.progress(f"searched with {len(small.z)} reducers from the {name} tolerances: {outcome}")
            found.append(one)
        reaching = [one for one in found if one.kept]
        if reaching:
            return min(reaching, key=lambda one: one.cost).u
        u, share = highest_yield_tolerances(self.sample, self._first_target, curves.low)
        if share < self._first_target:
            raise AllocationError(
                "yield", f"{100.0 * share:.2f} %", f"is the highest that tolerances within their bounds reach, below "
                f"{100.0 * self.wanted:g} % with {100.0 * self.margin:.2f} % to confirm it",
                "allow finer tolerances or wider limits, change the modification, or ask for less",
            )  # fmt: skip
        return u

    @property
    def _first_target(self) -> float:
        return self._limited_target(self.wanted + self.margin)

    def _limited_target(self, target: float) -> float:
        """The target yield with a failing share between a fifth and twice of the wanted one: limits the correction of
        the target.
        """
        failing = 1.0 - self.wanted
        return 1.0 - min(max(1.0 - target, 0.2 * failing), min(2.0 * failing, 0.5 + 0.5 * failing))

    def confirmed(self, start: FloatArray) -> tuple[_Round, int]:
        """The cheapest round whose yield independent reducers confirm, else the last round; and the number of rounds.

        If a round misses the yield or exceeds it by more than the margin, the next target is corrected by the
        difference.
        """
        rounds: list[_Round] = []
        target, u = self._first_target, start
        for number in range(1, _ROUNDS + 1):
            found = cheapest(self.sample, target, u)
            if not found.kept and rounds:
                break
            values = self.values(found.u, number)
            seen = _yield(values, self.sample.answers.names, self.limits)
            self.progress(
                f"round {number}: aimed at {100.0 * target:.2f} %, cost {found.cost:.4g}, confirmed {percent(seen)}"
            )
            rounds.append(_Round(number, target, found, seen))
            excess = seen.low - self.wanted
            if 0.0 <= excess <= self.margin or _all_coarsest(self.sample, found):
                break
            # A third of the margin above the least that is needed: else every second round would just miss it.
            target = self._limited_target(target + (self.margin / 3.0 - excess))
            u = found.u
        passed = [one for one in rounds if one.confirmed.low >= self.wanted]
        return (min(passed, key=lambda one: one.found.cost) if passed else rounds[-1]), len(rounds)

    def values(self, u: FloatArray, number: int) -> FloatArray:
        """Quantities of independent reducers at u, another seed each round, shape (verification, quantities)."""
        drawn = self.sample.draws
        tolerances = self.sample.curves.applied(drawn.tolerances, u)
        fresh = Draws(tolerances, drawn.seed + number, Random())
        found, left = [], self.verification
        for chunk in range(-(-self.verification // _CHUNK)):
            found.append(self.sample.answers.of(fresh.coordinates(chunk, min(_CHUNK, left), 0)))
            left -= _CHUNK
        return np.concatenate(found)


def _allocation(search: _Search, best: _Round, rounds: int, assumed: bool) -> Allocation:
    sample, found = search.sample, best.found
    tolerances = sample.draws.tolerances
    values = search.values(np.zeros(len(found.u)), best.number)
    return Allocation(
        status=_status(search, best),
        limits=search.limits,
        wanted=search.wanted,
        aimed=best.aimed,
        tolerances=sample.curves.applied(tolerances, found.u),
        lines=lines_of(sample.curves, found.u, tolerances),
        yield_before=_yield(values, sample.answers.names, search.limits),
        yield_after=best.confirmed,
        cost_per_percent=0.01 * found.cost_per_yield,
        saving_left=found.saving_left,
        rounds=rounds,
        samples=len(sample.z),
        assumed_costs=assumed,
        names=sample.answers.names,
        before=values,
        after=search.values(found.u, best.number),
    )


def _status(search: _Search, best: _Round) -> AllocationStatus:
    if best.confirmed.low < search.wanted:
        return AllocationStatus.UNCONFIRMED
    if _all_coarsest(search.sample, best.found):
        return AllocationStatus.LOOSEST
    return AllocationStatus.CONFIRMED if best.found.saving_left <= _SETTLED else AllocationStatus.UNSETTLED


def _all_coarsest(sample: Sample, found: Cheapest) -> bool:
    return bool(np.all(active_bounds(sample.curves, found.u) == 1))


def _yield(values: FloatArray, names: tuple[str, ...], limits: tuple[Limit, ...]) -> Interval:
    return share_interval(int(np.sum(within(values, names, limits))), len(values))


def _prepared(draws: Draws) -> tuple[Draws, bool]:
    """Draws of independent reducers, as a confidence interval requires; with equal costs where no scatter has one.

    Also whether these costs were assumed.
    """
    tolerances = draws.tolerances
    assumed = all(one.cost is None for one in tolerances.scatters)
    scatters = tuple(
        replace(one, batch_share=0.0, cost=EQUAL_COST if assumed else one.cost) for one in tolerances.scatters
    )
    return replace(draws, tolerances=replace(tolerances, scatters=scatters)), assumed
