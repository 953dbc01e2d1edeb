"""The cheapest tolerances that reach a yield, confirmed on reducers they were not found with (docs/allocation.md)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import AllocationError, SpecError
from cycloid_profile.tolerance.allocated import Allocation, Status, lines_of, percent
from cycloid_profile.tolerance.cheapest import ROUGH, Cheapest, Sample, bounds_met, cheapest, finest_quantile
from cycloid_profile.tolerance.draws import Draws
from cycloid_profile.tolerance.limits import Ends, Limit, limits_of, within
from cycloid_profile.tolerance.quantities import Answers
from cycloid_profile.tolerance.scatter import Cost
from cycloid_profile.tolerance.sequence import Random, Sobol
from cycloid_profile.tolerance.summary import Interval, share_interval

_TWO_SIDED = 1.959964  # standard errors to either end of a 95 % interval
_LEAST_FAILING = 40.0  # reducers beyond the limits in a sample, on average; fewer are no tail to find a gradient in
_COARSE = 8  # times fewer reducers to choose a start with
_ROUNDS = 5
_SETTLED = 2e-3  # share of the cost that may be left to save
_CHUNK = 4096
# Where a scatter names no cost, and none does: all cost the same, half the tolerance twice as much.
EQUAL_COST = Cost(1.0)


@dataclass(frozen=True, slots=True)
class Effort:
    """How many reducers: ``samples`` to search with, ``verification`` to confirm with; None for as many as it takes.

    As many as it takes: 40 beyond the limits to search with, at least 4096; to confirm with, four times as many.
    """

    samples: int | None = None
    verification: int | None = None

    def counted(self, failing: float) -> tuple[int, int]:
        """Both numbers for a share ``failing``; powers of two, as a net of Sobol wants."""
        least = max(4096, math.ceil(_LEAST_FAILING / failing))
        samples = self.samples or 1 << (least - 1).bit_length()
        return samples, self.verification or 4 * samples


def allocate(
    draws: Draws,
    answers: Answers,
    limits: Sequence[Limit] | Mapping[str, Ends],
    wanted: float = 0.95,
    effort: Effort = Effort(),
    tell: Callable[[str], None] = lambda _: None,
) -> Allocation:
    """Tolerances of least cost at which a share ``wanted`` of reducers keeps ``limits`` (docs/allocation.md, Eq. 71).

    ``answers``, such as ``Measures``, gives the quantities of reducers with coordinates as ``draws`` has them.
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
    kept = limits_of(limits, answers.names) if isinstance(limits, Mapping) else _computed(limits, answers.names)
    draws, assumed = _with_costs(_lone(draws))
    samples, verification = effort.counted(1.0 - wanted)
    sample = Sample.drawn(replace(draws, sequence=Sobol()), answers, kept, samples)
    if sample.curves.where.size == 0:
        raise SpecError("tolerances", "no cost", "changes with the tolerance", "give one a cost above 0", ": ")
    search = _Search(sample, kept, wanted, verification, tell)
    best, rounds = search.confirmed(search.start())
    return _told(search, best, rounds, assumed)


def _computed(limits: Sequence[Limit], names: tuple[str, ...]) -> tuple[Limit, ...]:
    if not limits:
        raise SpecError("limits", "none", "leave nothing to reach", f"limit one of {', '.join(names)}", ": ")
    for limit in limits:
        if limit.quantity not in names:
            raise SpecError("limit of", limit.quantity, "is of what is not computed here",
                            f"limit {', '.join(names)} or compute it too", " ")  # fmt: skip
    return tuple(limits)


@dataclass(frozen=True)
class _Round:
    """One search, and what independent reducers said of it."""

    number: int
    aimed: float
    found: Cheapest
    confirmed: Interval

    def reaches(self, wanted: float) -> bool:
        return self.confirmed.low >= wanted


@dataclass(frozen=True)
class _Search:
    sample: Sample
    limits: tuple[Limit, ...]
    wanted: float
    verification: int
    tell: Callable[[str], None]

    @property
    def margin(self) -> float:
        """By how much a yield has to be above the wanted one to be told from it."""
        return _TWO_SIDED * math.sqrt(self.wanted * (1.0 - self.wanted) / self.verification)

    def start(self) -> FloatArray:
        """Where to begin: the cheapest of what a smaller sample finds from the drawing, the finest and the coarsest."""
        curves = self.sample.curves
        small = self.sample.beginning(max(len(self.sample.z) // _COARSE, min(len(self.sample.z), 512)))
        found = []
        for name, u in (("drawing", np.zeros(len(curves.where))), ("finest", curves.low), ("coarsest", curves.high)):
            one = cheapest(small, self._first_aim, u, ROUGH)
            told = f"costs {one.cost:.4g}" if one.kept else "does not reach the yield"
            self.tell(f"searched with {len(small.z)} reducers from the {name} tolerances: {told}")
            found.append(one)
        reaching = [one for one in found if one.kept]
        if reaching:
            return min(reaching, key=lambda one: one.cost).u
        u, share = finest_quantile(self.sample, self._first_aim, curves.low)
        if share < self._first_aim:
            raise AllocationError(
                "yield", f"{100.0 * share:.2f} %", f"is the highest that tolerances within their bounds reach, below "
                f"{100.0 * self.wanted:g} % with {100.0 * self.margin:.2f} % to confirm it",
                "allow finer tolerances or wider limits, change the modification, or ask for less",
            )  # fmt: skip
        return u

    @property
    def _first_aim(self) -> float:
        return self._sane(self.wanted + self.margin)

    def _sane(self, aim: float) -> float:
        """Between half and twice the failing share that was wanted to begin with; a correction may not run away."""
        failing = 1.0 - self.wanted
        return 1.0 - min(max(1.0 - aim, 0.2 * failing), min(2.0 * failing, 0.5 + 0.5 * failing))

    def confirmed(self, start: FloatArray) -> tuple[_Round, int]:
        """The cheapest round that independent reducers confirm, else the last; and how many rounds there were.

        A round that misses the yield, or passes it by more than the margin, moves the aim of the next by as much.
        """
        rounds: list[_Round] = []
        aim, u = self._first_aim, start
        for number in range(1, _ROUNDS + 1):
            found = cheapest(self.sample, aim, u)
            if not found.kept and rounds:
                break
            values = self.values(found.u, number)
            seen = _yield(values, self.sample.answers.names, self.limits)
            self.tell(f"round {number}: aimed at {100.0 * aim:.2f} %, cost {found.cost:.4g}, confirmed {percent(seen)}")
            rounds.append(_Round(number, aim, found, seen))
            excess = seen.low - self.wanted
            if 0.0 <= excess <= self.margin or _all_coarsest(self.sample, found):
                break
            # A third of the margin above the least that is needed: else every second round would just miss it.
            aim = self._sane(aim + (self.margin / 3.0 - excess))
            u = found.u
        passed = [one for one in rounds if one.reaches(self.wanted)]
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


def _told(search: _Search, best: _Round, rounds: int, assumed: bool) -> Allocation:
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


def _status(search: _Search, best: _Round) -> Status:
    if not best.reaches(search.wanted):
        return Status.UNCONFIRMED
    if _all_coarsest(search.sample, best.found):
        return Status.LOOSEST
    return Status.CONFIRMED if best.found.saving_left <= _SETTLED else Status.UNSETTLED


def _all_coarsest(sample: Sample, found: Cheapest) -> bool:
    return bool(np.all(bounds_met(sample.curves, found.u) == 1))


def _yield(values: FloatArray, names: tuple[str, ...], limits: tuple[Limit, ...]) -> Interval:
    return share_interval(int(np.sum(within(values, names, limits))), len(values))


def _lone(draws: Draws) -> Draws:
    """The same reducers, each a batch by itself: as one reducer scatters nothing changes, and their yields are
    independent, which a confidence interval asks for."""
    tolerances = draws.tolerances
    scatters = tuple(replace(one, batch_share=0.0) for one in tolerances.scatters)
    return replace(draws, tolerances=replace(tolerances, scatters=scatters))


def _with_costs(draws: Draws) -> tuple[Draws, bool]:
    """With equal costs where no scatter has one, and whether that was so."""
    tolerances = draws.tolerances
    if any(one.cost is not None for one in tolerances.scatters):
        return draws, False
    scatters = tuple(replace(one, cost=EQUAL_COST) for one in tolerances.scatters)
    return replace(draws, tolerances=replace(tolerances, scatters=scatters)), True
