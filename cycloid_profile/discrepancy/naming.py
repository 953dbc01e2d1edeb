"""Which effects explain the data best, of all singles, pairs and leading triples of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, chatter
from cycloid_profile.discrepancy.chatter_waves import chatter_peaks
from cycloid_profile.discrepancy.climbing import Climb, Start, about, contributes, leaves_something, nothing
from cycloid_profile.discrepancy.evidence import estimate, search
from cycloid_profile.discrepancy.exact import Attempt, ExactModel, Optimum, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import recounted
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.starting import leading_pairs, leading_singles
from cycloid_profile.discrepancy.thinning import thinned

# Sets that are rescored at most by one climb, on few rows and on all.
_RESCORINGS = 40
_RESCORINGS_FULL = 8
_ROUNDS = 5
_FINAL_ROUNDS = 2
_COARSE_ROWS = 240  # of all curves together
_FEW_ROWS = 360
_GAIN_KEPT = 500.0  # of chi², on the few rows that name an effect
_WEAK = 60.0  # below this gain everything is linear
_RECOUNTS = 2
_SINGLES, _PAIRS = 3, 6  # that a climb starts from
_HARDLY_MORE = 1.0  # standard deviations of chi²
_KEPT, _LOOKED_AT, _AS_GOOD = 3, 10, 30.0  # sets of few rows that are rescored on all, how much less likely they may be


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
    waves = max((r.rows.size for r in model.recordings if r.kind == "profile_scan"), default=2)
    library = Library((*candidates, *_chatter(model.nothing, ())), waves)
    model, climb, starts = _coarse(model, library, tell, thorough)
    if climb.model is not model:
        climb = Climb(model, library, _RESCORINGS_FULL, tell, thorough=thorough, sieve=_few(model))
    for number in range(_RECOUNTS + 1):
        tell("rescoring on the exact model with all rows")
        climb.up(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
        counted, u = _counted_anew(model, library, best)
        if counted is model or number == _RECOUNTS:
            break
        model, starts = counted, [(library.places(best.members), u)]
        climb = Climb(model, library, _RESCORINGS_FULL, tell, thorough=thorough, sieve=_few(model))
    more = _chatter(model.at(best), best.members)
    if more and best.members:
        # Waves that stood below what larger effects made of the spectrum.
        library = library.with_more(more)
        climb = Climb(model, library, _RESCORINGS_FULL, tell, climb.found, thorough)
        climb.up([(library.places(best.members), best.u)], _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
    return Named(best, model, library, about(model, library, best), tuple(climb.ranked))


def _coarse(
    model: ExactModel, library: Library, tell: Callable[[str], None], thorough: bool
) -> tuple[ExactModel, Climb, list[Start]]:
    """Large effects are named on few rows, small ones beside them on all rows afterwards.

    The model with the lobes of its scans counted by what leads, the climb, and where to go on.
    """
    few = _few(model)
    singles: list[Optimum] = []
    gain, linear = 0.0, list[Start]()
    for _ in range(_RECOUNTS):
        equations = normal(model.nothing.blocks, library.candidates)
        first = search(equations, library.priors)
        linear = [(list(s.members), estimate(equations, s.members)[0]) for s in first[:1]]
        gain = 2.0 * first[0].log_evidence if first else 0.0
        if gain <= _WEAK:
            return model, Climb(model, library, _RESCORINGS_FULL, tell, thorough=thorough), linear
        singles = leading_singles(few, library, equations, gain, tell, thorough)
        # Few rows suspect another count, all rows decide on it.
        if not singles or recounted(model, few, library, singles[0]) is model:
            break
        counted = recounted(model, model, library, singles[0])
        if counted is model:
            break
        model = counted
        few = _few(model)
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
    return model, climb, [(library.places(o.members), o.u) for o in _worth_all_rows(climb)]


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


def _counted_anew(model: ExactModel, library: Library, best: Optimum) -> tuple[ExactModel, FloatArray]:
    """The model with its lobes counted as the best set has them, or as it has them half a turn on if that fits better,
    and where to begin on it; the same model where the count stays.
    """
    if not best.members:
        return model, best.u
    counted = recounted(model, model, library, best)
    if counted is not model:
        return counted, best.u
    for _, other in best.turned_round():
        if model.state(other.members, other.u) is None:
            continue
        counted = recounted(model, model, library, other)
        if counted is not model:
            beat = best.chi2 + float(best.u @ best.u)
            found = counted.optimum(Attempt(other.members, other.u, beat=beat), library.prior(other.members))
            if found is not None and found.log_evidence > best.log_evidence:
                return counted, found.u
    return model, best.u


def _few(model: ExactModel) -> ExactModel:
    curves = sum(r.kind != "profile_scan" for r in model.recordings)
    rows = _COARSE_ROWS // max(curves, 1)
    return model.with_recordings([thinned(r, rows) for r in model.recordings])


def _chatter(state: State, members: Sequence[Candidate]) -> list[Candidate]:
    """Chatter that stands out of the spectrum of any scan once ``members`` are fitted."""
    found = []
    known = [c.choice["waves_per_turn"] for c in members if c.name == "grinding_chatter"]
    for block in state.blocks:
        if block.laid.recording.kind == "profile_scan":
            z = block.projected(block.z)
            if members:
                G = block.projected(block.columns(members))
                z = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
            waves = chatter_peaks(block, z)
            disc = block.laid.recording.disc + 1
            found += [chatter(n, disc) for n in waves if all(abs(n - other) > 1.0 for other in known)]
    return found


def _first_that_contributes(climb: Climb) -> Optimum:
    found = (o for o in climb.ranked if o.log_evidence > 0.0 and contributes(climb.model, o))
    return next(found, nothing(climb.model))
