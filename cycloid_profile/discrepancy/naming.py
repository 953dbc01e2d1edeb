"""Which effects explain the data best, of all singles, pairs and leading triples of the library."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, chatter
from cycloid_profile.discrepancy.chatter_waves import chatter_peaks, peak_near
from cycloid_profile.discrepancy.climbing import Climb, Start, about, contributes, nothing
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel, State
from cycloid_profile.discrepancy.exchange import exchanged
from cycloid_profile.discrepancy.few_rows import named_on_few_rows
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, Whitened
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
    waves = max((r.rows.size for r in model.recordings if r.kind == "profile_scan"), default=2)
    library = Library((*candidates, *_chatter(model.nothing, ())), waves)
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
    for other in (_with_waves_below, _with_waves_anew):
        library, start = other(model, library, best)
        if start is not None:
            climb = Climb(model, library, _RESCORINGS, tell, climb.found, thorough, few)
            climb.up([start], _FINAL_ROUNDS)
            best = _first_that_contributes(climb)
    return Named(best, model, library, about(model, library, best), tuple(climb.ranked))


def _with_waves_below(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, Start | None]:
    """The library with waves that stood below what larger effects made of the spectrum, and where to begin with it."""
    more = _chatter(model.at(best), best.members) if best.members else []
    return library.with_more(more), (library.places(best.members), best.u) if more else None


def _with_waves_anew(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, Start | None]:
    """The library with chatter of as many waves as it has beside the other members, which moved its peak before, and
    where to begin with it.
    """
    members = list(best.members)
    for i, member in enumerate(members):
        if member.name != "grinding_chatter":
            continue
        others = [m for m in members if m is not member]
        state = model.state(others, np.delete(best.u, [2 * i, 2 * i + 1]))
        waves = float(member.choice["waves_per_turn"])
        for block in () if state is None else state.blocks:
            if block.laid.recording.kind == "profile_scan" and block.laid.recording.disc + 1 == member.choice["disc"]:
                beside = peak_near(block, waves, _left(block, others))
                if beside != waves:
                    members[i] = chatter(beside, block.laid.recording.disc + 1)
    fresh = [new for new, old in zip(members, best.members, strict=True) if new is not old]
    library = library.with_more(fresh)
    return library, (library.places(members), best.u) if fresh else None


def _chatter(state: State, members: Sequence[Candidate]) -> list[Candidate]:
    """Chatter that stands out of the spectrum of any scan once ``members`` are fitted."""
    found = []
    known = [c.choice["waves_per_turn"] for c in members if c.name == "grinding_chatter"]
    for block in state.blocks:
        if block.laid.recording.kind == "profile_scan":
            waves = chatter_peaks(block, _left(block, members))
            disc = block.laid.recording.disc + 1
            found += [chatter(n, disc) for n in waves if all(abs(n - other) > 1.0 for other in known)]
    return found


def _left(block: Whitened, members: Sequence[Candidate]) -> FloatArray:
    """What is left of a file once ``members`` are fitted, and what no measurement can know."""
    z = block.projected(block.z)
    if not members:
        return z
    G = block.projected(block.columns(members))
    left: FloatArray = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
    return left


def _first_that_contributes(climb: Climb) -> Optimum:
    found = (o for o in climb.ranked if o.log_evidence > 0.0 and contributes(climb.model, o))
    return next(found, nothing(climb.model))
