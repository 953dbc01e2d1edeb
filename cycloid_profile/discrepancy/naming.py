"""Which effects explain the data best, of all singles, pairs and leading triples of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.chatter_candidates import (
    standing_out,
    with_waves_anew,
    with_waves_below,
    with_waves_beside_others,
    with_waves_elsewhere,
)
from cycloid_profile.discrepancy.climbing import Climb, Start, about, contributes, leaves_something, nothing
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.exchange import exchanged
from cycloid_profile.discrepancy.few_rows import named_on_few_rows
from cycloid_profile.discrepancy.finite_pairs import A_LITTLE, pairs_of_finite_size
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.missed_pairs import may_hide_a_pair, missed_pairs
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.recounting import counted_anew
from cycloid_profile.discrepancy.scans_first import counted_as_scans_show
from cycloid_profile.discrepancy.seam import counted_from_seams
from cycloid_profile.discrepancy.thinning import fewest

_RESCORINGS = 8  # sets that one climb on all rows rescores at most
_FINAL_ROUNDS = 2
_RECOUNTS = 2
_FEW_MEMBERS = 2  # of a set that two other effects may be hidden behind


@dataclass(frozen=True, eq=False)
class Named:
    """The best set with the equations linearised about it, told from zero, and all sets rescored, best first.

    ``model`` is the one it was found on: the lobes of its scans may be counted otherwise than at first.
    """

    best: Optimum
    model: ExactModel
    library: Library
    equations: Normal
    rescored: tuple[Optimum, ...]

    def start(self, members: Sequence[Candidate]) -> FloatArray:
        """Where to begin with another set, from the equations about the best."""
        return estimate(self.equations, self.library.places(members))[0]


def named(
    model: ExactModel, candidates: Sequence[Candidate], tell: Callable[[str], None], thorough: bool = False
) -> Named:
    """The best set of ``candidates`` and of chatter that stands out of the spectra.

    ``thorough``: every place of an effect is tried by itself, and the neighbours of each best set whether it seems to
    leave anything or not.
    """
    model = counted_as_scans_show(model, candidates)
    frequencies = max((r.rows.size for r in model.recordings if r.kind != "hysteresis"), default=2)
    library = Library((*candidates, *standing_out(model)), frequencies)
    begun = named_on_few_rows(model, library, tell, thorough)
    model, starts, few = begun.model, begun.starts, fewest(begun.model, begun.gain)
    climb = begun.climb or Climb(model, library, _RESCORINGS, tell, thorough=thorough, sieve=few)
    for number in range(_RECOUNTS + 1):
        tell("rescoring on the exact model with all rows")
        climb.up(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
        if best.members and _has_turns(model):
            tell("one name for another on the exact model")
            exchanged(climb, few, best)
            best = _first_that_contributes(climb)
        counted, begin = counted_anew(model, few, library, best)
        if counted is model or number == _RECOUNTS:
            break
        model, starts = counted, [(library.places(best.members), begin.u)]
        few = fewest(model, begun.gain)
        climb = Climb(model, library, _RESCORINGS, tell, thorough=thorough, sieve=few)
    climb, waved = _tried(climb, with_waves_below, best)
    if waved is best and _asked_for_pairs(model, best):
        _ask_for_pairs(climb, few, best, begun.lead, tell)
        climb, waved = _tried(climb, with_waves_below, _first_that_contributes(climb))
    best = waved
    for other in (partial(with_waves_beside_others, lead=begun.lead), with_waves_anew):
        climb, best = _tried(climb, other, best)
    counted = counted_from_seams(model, best)
    if counted is not model:
        return named(counted, candidates, tell, thorough)
    library = with_waves_elsewhere(model, climb.library, best)
    return Named(best, model, library, about(model, library, best), tuple(climb.ranked))


def _has_turns(model: ExactModel) -> bool:
    return not (model.only_scans or model.only_loops)


def _asked_for_pairs(model: ExactModel, best: Optimum) -> bool:
    return _has_turns(model) and 0 < len(best.members) <= _FEW_MEMBERS and may_hide_a_pair(model, best)


def _ask_for_pairs(
    climb: Climb, few: ExactModel, best: Optimum, lead: Sequence[Optimum], tell: Callable[[str], None]
) -> None:
    """Let the climb find what pairs do better than the ``best`` set."""
    missed = missed_pairs(climb.model, few, climb.library, lead, tell)
    finite = pairs_of_finite_size(climb.model, climb.library, lead)
    tell(f"pairs of effects on all rows, {len(missed) + len(finite)}")
    better = climb.judge(finite, climb.judge(missed, best), A_LITTLE)
    if better is not best:
        climb.up([(climb.library.places(better.members), better.u)], _FINAL_ROUNDS)
    exchanged(climb, few, _first_that_contributes(climb))


_More = Callable[[ExactModel, Library, Optimum], tuple[Library, list[Start]]]


def _tried(climb: Climb, more: _More, best: Optimum) -> tuple[Climb, Optimum]:
    """A climb from what ``more`` proposes beside the ``best`` set, with a larger library, and the best set then."""
    model = climb.model
    library, starts = more(model, climb.library, best)
    if starts:
        climb = climb.with_library(library, _RESCORINGS)
        best = climb.up(starts, 0)
        if model.only_scans or leaves_something(model, best):
            climb.up(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
    return climb, best


def _first_that_contributes(climb: Climb) -> Optimum:
    found = (o for o in climb.ranked if o.log_evidence > 0.0 and contributes(climb.model, o))
    return next(found, nothing(climb.model))
