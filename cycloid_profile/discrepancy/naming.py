"""Which effects explain the data best, of all singles, pairs and leading triples of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.chatter_candidates import (
    standing_out,
    with_waves_anew,
    with_waves_below,
    with_waves_elsewhere,
)
from cycloid_profile.discrepancy.climbing import Climb, about, contributes, leaves_something, nothing
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.exchange import exchanged
from cycloid_profile.discrepancy.few_rows import named_on_few_rows
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.recounting import counted_anew
from cycloid_profile.discrepancy.thinning import fewest

_RESCORINGS = 8  # sets that one climb on all rows rescores at most
_FINAL_ROUNDS = 2
_RECOUNTS = 2


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
    frequencies = max((r.rows.size for r in model.recordings if r.kind != "hysteresis"), default=2)
    library = Library((*candidates, *standing_out(model)), frequencies)
    model, climb, starts, gain = named_on_few_rows(model, library, tell, thorough)
    few = fewest(model, gain)
    if climb is None:
        climb = Climb(model, library, _RESCORINGS, tell, thorough=thorough, sieve=few)
    for number in range(_RECOUNTS + 1):
        tell("rescoring on the exact model with all rows")
        climb.up(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
        if best.members and not (model.only_scans or model.only_loops):
            tell("one name for another on the exact model")
            exchanged(climb, few, best)
            best = _first_that_contributes(climb)
        counted, begin = counted_anew(model, few, library, best)
        if counted is model or number == _RECOUNTS:
            break
        model, starts = counted, [(library.places(best.members), begin.u)]
        few = fewest(model, gain)
        climb = Climb(model, library, _RESCORINGS, tell, thorough=thorough, sieve=few)
    for other in (with_waves_below, with_waves_anew):
        library, starts = other(model, library, best)
        if starts:
            climb = Climb(model, library, _RESCORINGS, tell, climb.found, thorough, few)
            best = climb.up(starts, 0)
            if model.only_scans or leaves_something(model, best):
                climb.up(starts, _FINAL_ROUNDS)
            best = _first_that_contributes(climb)
    library = with_waves_elsewhere(model, library, best)
    return Named(best, model, library, about(model, library, best), tuple(climb.ranked))


def _first_that_contributes(climb: Climb) -> Optimum:
    found = (o for o in climb.ranked if o.log_evidence > 0.0 and contributes(climb.model, o))
    return next(found, nothing(climb.model))
