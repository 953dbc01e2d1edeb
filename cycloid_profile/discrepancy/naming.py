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
from cycloid_profile.discrepancy.exact import ExactModel, Optimum, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.lobes import recounted
from cycloid_profile.discrepancy.normal import Normal, normal
from cycloid_profile.discrepancy.starting import leading_singles
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
_SINGLES = 2  # single effects that a climb starts from


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
        climb = Climb(model, library, _RESCORINGS_FULL, tell, thorough=thorough)
    best = nothing(model)
    for _ in range(_RECOUNTS):
        tell("rescoring on the exact model with all rows")
        climb.up(starts, _FINAL_ROUNDS)
        best = _first_that_contributes(climb)
        counted = recounted(model, model, library, best) if best.members else model
        if counted is model:
            break
        model, starts = counted, [(library.places(best.members), best.u)]
        climb = Climb(model, library, _RESCORINGS_FULL, tell, thorough=thorough)
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
    coarse = model if whole else ExactModel(model.built, thin, model.probes)
    same_rows = all(a is b for a, b in zip(few.recordings, coarse.recordings, strict=True))
    known = {tuple(library.places(o.members)): o for o in singles if o.settled and same_rows}
    climb = Climb(coarse, library, _RESCORINGS, tell, known, thorough)
    # From single effects one after the other, and from the best linear set only if they leave something.
    for start in [*((library.places(o.members), o.u) for o in singles[:_SINGLES]), *linear]:
        climb.up([start], _ROUNDS)
        if climb.found and not leaves_something(climb.ranked[0]):
            break
    return model, climb, [(library.places(o.members), o.u) for o in climb.ranked[:1]]


def _few(model: ExactModel) -> ExactModel:
    curves = sum(r.kind != "profile_scan" for r in model.recordings)
    rows = _COARSE_ROWS // max(curves, 1)
    return ExactModel(model.built, [thinned(r, rows) for r in model.recordings], model.probes)


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
