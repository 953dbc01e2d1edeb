"""Large effects are named on few rows, small ones beside them on all rows afterwards."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from cycloid_profile.discrepancy.climbing import Climb, Start, leaves_something
from cycloid_profile.discrepancy.evidence import estimate, search
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.scans_first import led_by_scans
from cycloid_profile.discrepancy.starting import leading_singles
from cycloid_profile.discrepancy.starting_pairs import leading_pairs
from cycloid_profile.discrepancy.thinning import fewest, thinned

_RESCORINGS, _RESCORINGS_OF_WEAK = 40, 8  # sets that one climb rescores at most
_ROUNDS = 5
_FEW_ROWS = 360
_GAIN_KEPT = 500.0  # of chi², on the few rows that name an effect
_WEAK = 60.0  # below this gain everything is linear
_SETS, _PAIRS, _PAIRS_OF_THOROUGH = 3, 5, 6  # that a climb starts from
_HARDLY_MORE = 2.0  # standard deviations of chi²: the noise of few rows is known no better
# Sets that are rescored on all rows, and how much less likely they may be.
_KEPT, _LOOKED_AT = 3, 10
_AS_GOOD, _AS_GOOD_AS_WHAT_LEAVES = 10.0, 30.0


@dataclass(frozen=True, eq=False)
class _Linear:
    """The ``equations`` of all rows about no effect, where the ``best`` set of them is, what it gains in chi²."""

    equations: Normal
    best: list[Start]
    gain: float


@dataclass(frozen=True, eq=False)
class _Leading:
    """The ``model`` with its lobes counted by the effects that lead, the same of a ``few`` rows, the sets that lead on
    these, best first, and the linear equations of the model.
    """

    model: ExactModel
    few: ExactModel
    sets: list[Optimum]
    linear: _Linear


@dataclass(frozen=True, eq=False)
class OfFewRows:
    """The ``model`` with its lobes counted by what leads, the ``climb`` if it was on all rows, the sets it ``starts``
    from on all rows, what the best linear one gains in chi², and single effects that ``lead``, best first.
    """

    model: ExactModel
    climb: Climb | None
    starts: list[Start]
    gain: float
    lead: list[Optimum]


def named_on_few_rows(model: ExactModel, library: Library, tell: Callable[[str], None], thorough: bool) -> OfFewRows:
    """What few rows say of large effects, for all rows to go on with."""
    leading = _leading(model, library, tell, thorough)
    model, gain = leading.model, leading.linear.gain
    if gain <= _WEAK:
        climb = Climb(model, library, _RESCORINGS_OF_WEAK, tell, thorough=thorough)
        return OfFewRows(model, climb, leading.linear.best, gain, leading.sets)
    thin = [thinned(r, _FEW_ROWS, _GAIN_KEPT / gain) for r in model.recordings]
    whole = all(a is b for a, b in zip(thin, model.recordings, strict=True))
    coarse = model if whole else model.with_recordings(thin)
    same_rows = all(a is b for a, b in zip(leading.few.recordings, coarse.recordings, strict=True))
    known = {tuple(library.places(o.members)): o for o in leading.sets if o.settled and same_rows}
    climb = Climb(coarse, library, _RESCORINGS, tell, known, thorough, None if same_rows else leading.few)
    for some in _starts(leading, library, tell, thorough):
        # What is in the best set so far, a climb has begun with or come by.
        new = [start for start in some if not climb.ranked or not set(start[0]) <= _places(climb, library)]
        if new:
            climb.up(new, _ROUNDS)
        if climb.found and not leaves_something(coarse, climb.ranked[0], _HARDLY_MORE):
            break
    starts_on_all = [(library.places(o.members), o.u) for o in _worth_all_rows(climb)]
    return OfFewRows(model, climb if coarse is model else None, starts_on_all, gain, leading.sets)


def _leading(model: ExactModel, library: Library, tell: Callable[[str], None], thorough: bool) -> _Leading:
    """What leads on few rows: a set that begins with what scans show, with single effects if it leaves something."""
    linear, sets = _linear(model, library), list[Optimum]()
    if linear.gain <= _WEAK:
        return _Leading(model, model, sets, linear)
    counted, led = led_by_scans(model, library, linear.gain, tell)
    if counted is not model:
        model, linear = counted, _linear(counted, library)
    few = fewest(model, linear.gain)
    if led is not None:
        sets.append(led)
    if led is None or leaves_something(few, led):
        sets += leading_singles(few, library, linear.equations, linear.gain, tell, thorough)
        sets.sort(key=lambda one: -one.log_evidence)
    return _Leading(model, few, sets, linear)


def _starts(leading: _Leading, library: Library, tell: Callable[[str], None], thorough: bool) -> Iterator[list[Start]]:
    """Where to begin, one after the other while something is left: one of two effects need not be the one that does
    best alone.
    """
    few, sets = leading.few, leading.sets
    begun = [(library.places(one.members), one.u) for one in sets[:_SETS]]
    if not few.only_scans and (thorough or not sets or leaves_something(few, sets[0])):
        pairs = leading_pairs(few, library, sets, tell, thorough)
        most = _PAIRS_OF_THOROUGH if thorough else _PAIRS
        yield [*((library.places(one.members), one.u) for one in pairs[:most]), *begun[:1]]
        begun = [] if thorough else begun[1:]
    yield from ([one] for one in begun)
    if not thorough:
        yield leading.linear.best


def _linear(model: ExactModel, library: Library) -> _Linear:
    equations = normal(model.nothing.blocks, library.candidates)
    found = search(equations, library.priors)
    best = [(list(s.members), estimate(equations, s.members)[0]) for s in found[:1]]
    return _Linear(equations, best, 2.0 * found[0].log_evidence if found else 0.0)


def _places(climb: Climb, library: Library) -> set[int]:
    return set(library.places(climb.ranked[0].members))


def _worth_all_rows(climb: Climb) -> list[Optimum]:
    """The best set of few rows and those nearly as good that are not the same and more; more of them if it leaves
    something.
    """
    ranked = climb.ranked
    if not ranked:
        return []
    reach = _AS_GOOD_AS_WHAT_LEAVES if leaves_something(climb.model, ranked[0], _HARDLY_MORE) else _AS_GOOD
    best = {id(member) for member in ranked[0].members}
    others = [o for o in ranked[1:_LOOKED_AT] if o.log_evidence > ranked[0].log_evidence - reach]
    return [ranked[0], *(o for o in others if not best <= {id(member) for member in o.members})][:_KEPT]
