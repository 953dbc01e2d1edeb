"""Large effects are named on few rows, small ones beside them on all rows afterwards."""

from __future__ import annotations

from collections.abc import Callable

from cycloid_profile.discrepancy.climbing import Climb, Start, leaves_something
from cycloid_profile.discrepancy.evidence import estimate, search
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import recounted
from cycloid_profile.discrepancy.normal import normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.recounting import counted_by_curves
from cycloid_profile.discrepancy.starting import leading_pairs, leading_singles
from cycloid_profile.discrepancy.thinning import fewest, thinned

_RESCORINGS, _RESCORINGS_OF_WEAK = 40, 8  # sets that one climb rescores at most
_ROUNDS = 5
_FEW_ROWS = 360
_GAIN_KEPT = 500.0  # of chi², on the few rows that name an effect
_WEAK = 60.0  # below this gain everything is linear
_RECOUNTS = 3
_SINGLES, _PAIRS = 3, 6  # that a climb starts from
_HARDLY_MORE = 2.0  # standard deviations of chi²: the noise of few rows is known no better
# Sets that are rescored on all rows, and how much less likely they may be.
_KEPT, _LOOKED_AT, _AS_GOOD = 3, 10, 30.0


def named_on_few_rows(
    model: ExactModel, library: Library, tell: Callable[[str], None], thorough: bool
) -> tuple[ExactModel, Climb | None, list[Start], float]:
    """The model with its lobes counted by what leads, the climb if it was on all rows, sets to go on with, and what the
    best linear one gains in chi².
    """
    model, few, singles, linear, gain = _leading(model, library, tell, thorough)
    if gain <= _WEAK:
        return model, Climb(model, library, _RESCORINGS_OF_WEAK, tell, thorough=thorough), linear, gain
    thin = [thinned(r, _FEW_ROWS, _GAIN_KEPT / gain) for r in model.recordings]
    whole = all(a is b for a, b in zip(thin, model.recordings, strict=True))
    coarse = model if whole else model.with_recordings(thin)
    same_rows = all(a is b for a, b in zip(few.recordings, coarse.recordings, strict=True))
    known = {tuple(library.places(o.members)): o for o in singles if o.settled and same_rows}
    sieve = None if same_rows else few
    climb = Climb(coarse, library, _RESCORINGS, tell, known, thorough, sieve)
    # From single effects one after the other, and from the best linear set only if they leave something: one of two
    # effects need not be the one that does best alone.
    starts = [[(library.places(o.members), o.u)] for o in singles[:_SINGLES]] + [linear]
    if thorough:
        pairs = leading_pairs(few, library, singles, tell)[:_PAIRS]
        starts = [[(library.places(o.members), o.u) for o in (*pairs, *singles[:1])]]
    for some in starts:
        # What is in the best set so far, a climb has begun with or come by.
        new = [start for start in some if not climb.ranked or not set(start[0]) <= _places(climb, library)]
        if new:
            climb.up(new, _ROUNDS)
        if climb.found and not leaves_something(coarse, climb.ranked[0], _HARDLY_MORE):
            break
    starts_on_all = [(library.places(o.members), o.u) for o in _worth_all_rows(climb)]
    return model, climb if coarse is model else None, starts_on_all, gain


def _leading(
    model: ExactModel, library: Library, tell: Callable[[str], None], thorough: bool
) -> tuple[ExactModel, ExactModel, list[Optimum], list[Start], float]:
    """The model counted by its leading single effect, the same of fewest rows, single effects fitted on these, the best
    set of linear equations and what it gains in chi².
    """
    few, singles, known = model, list[Optimum](), list[Optimum]()
    gain, linear = 0.0, list[Start]()
    for number in range(_RECOUNTS + 1):
        equations = normal(model.nothing.blocks, library.candidates)
        first = search(equations, library.priors)
        linear = [(list(s.members), estimate(equations, s.members)[0]) for s in first[:1]]
        gain = 2.0 * first[0].log_evidence if first else 0.0
        if gain <= _WEAK:
            break
        few = fewest(model, gain)
        if known and not leaves_something(few, known[0]):
            singles = known
            break
        singles = leading_singles(few, library, equations, gain, tell, thorough)
        singles = sorted([*known, *singles], key=lambda one: -one.log_evidence)
        if number == _RECOUNTS or not singles or not leaves_something(few, singles[0]):
            break
        counted, leading = counted_by_curves(model, library, singles[0], gain, tell)
        known = [leading] if counted is not model else []
        # Few rows suspect another count, all rows decide on it.
        if counted is model and recounted(model, few, library, leading) is not model:
            counted = recounted(model, model, library, leading)
        if counted is model:
            break
        model = counted
    return model, few, singles, linear, gain


def _places(climb: Climb, library: Library) -> set[int]:
    return set(library.places(climb.ranked[0].members))


def _worth_all_rows(climb: Climb) -> list[Optimum]:
    """The best set of few rows, and if it leaves something those nearly as good that are not the same and more."""
    ranked = climb.ranked
    if not ranked or not leaves_something(climb.model, ranked[0], _HARDLY_MORE):
        return ranked[:1]
    best = {id(member) for member in ranked[0].members}
    others = [o for o in ranked[1:_LOOKED_AT] if o.log_evidence > ranked[0].log_evidence - _AS_GOOD]
    return [ranked[0], *(o for o in others if not best <= {id(member) for member in o.members})][:_KEPT]
