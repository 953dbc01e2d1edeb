"""Chatter as a hypothesis: waves that stand out of the spectra of scans and turns, with the effects known so far taken
off.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate, chatter
from cycloid_profile.discrepancy.chatter_waves import PEAK, chatter_peaks, peak_near
from cycloid_profile.discrepancy.climbing import Start
from cycloid_profile.discrepancy.evidence import estimate
from cycloid_profile.discrepancy.exact import ExactModel, State
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Whitened, normal
from cycloid_profile.discrepancy.optimum import Attempt, Optimum
from cycloid_profile.discrepancy.waves_under_pins import AS_GOOD, Peak, WavesUnderPins, unscanned

# Of what is left. Turns show every effect as waves, and one of them always comes nearest to what has no name yet.
_LEAST_SHARE = 0.5
# Of the first gap in squares: less is what the simulation of large effects errs by.
_LEAST_OF_GAP = 0.02**2
_BESIDE = 4  # other effects that a wave is tried beside


def standing_out(model: ExactModel, best: Optimum | None = None) -> list[Candidate]:
    """Chatter that stands out of the spectrum of any scan beside the ``best`` set, on its disc and on all; on discs
    that were not scanned what explains most of what the turns of a bench leave.
    """
    state, members = (model.nothing, ()) if best is None else (model.at(best), best.members)
    known = [c.choice["waves_per_turn"] for c in members if c.name == "grinding_chatter"]
    # Whether the other discs have what a scan shows, other files tell.
    turns, found = not (model.only_scans or model.only_loops), list[Candidate]()
    for block in state.blocks:
        if block.laid.recording.kind == "profile_scan":
            waves = chatter_peaks(block, _left(block, members))
            discs = (block.laid.recording.disc + 1, None) if turns else (block.laid.recording.disc + 1,)
            fresh = [n for n in waves if all(abs(n - other) > 1.0 for other in known)]
            found += [chatter(n, disc) for n in fresh for disc in discs]
    return found if known else [*found, *_under_pins(model, state, members)]


def with_waves_below(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, list[Start]]:
    """The library with waves that stood below what larger effects made of the spectrum, and where to begin with them:
    the best set with each, and without one of its members, which may have stood for it.
    """
    more = standing_out(model, best) if best.members else []
    library, starts = library.with_more(more), list[Start]()
    mine = list(range(len(best.members)))
    for wave in more:
        members = (*best.members, wave)
        equations = normal(model.at(best).blocks, members).about(mine, best.u)
        for left_out in (None, *(mine if len(mine) > 1 else ())):
            some = [i for i in range(len(members)) if i != left_out]
            starts.append((library.places([members[i] for i in some]), estimate(equations, some)[0]))
    return library, starts


def with_waves_beside_others(
    model: ExactModel, library: Library, best: Optimum, lead: Sequence[Optimum]
) -> tuple[Library, list[Start]]:
    """Where to begin with other effects that ``lead`` beside a wave on a disc that was not scanned, if the best set has
    one: nobody knew of it when the others were told apart.
    """
    others, starts = {c.name for c in best.members if c.name != "grinding_chatter"}, list[Start]()
    if not any(_unscanned_wave(model, member) for member in best.members):
        return library, starts
    unlike: dict[str, Optimum] = {}
    for one in lead:
        if len(one.members) == 1 and {one.members[0].name} != others:
            unlike.setdefault(one.members[0].name, one)
    for one in list(unlike.values())[:_BESIDE]:
        fitted = model.optimum(Attempt(one.members, one.u), library.prior(one.members))
        if fitted is not None and not fitted.implausible:
            library, more = with_waves_below(model, library, fitted)
            starts += more
    return library, starts


def _unscanned_wave(model: ExactModel, member: Candidate) -> bool:
    """Whether a member is chatter that no scan shows."""
    disc, hidden = member.choice.get("disc"), unscanned(model.nothing.blocks)
    shown = len(hidden) < model.built.discs if disc is None else disc not in hidden
    return member.name == "grinding_chatter" and not shown


def with_waves_anew(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, list[Start]]:
    """The library with chatter of as many waves as it has beside the other members, which moved its peak before, and
    where to begin with it.
    """
    members = list(best.members)
    for i, member in enumerate(members):
        if member.name != "grinding_chatter":
            continue
        others, state = _without(model, best, i)
        waves, disc = float(member.choice["waves_per_turn"]), member.choice.get("disc")
        beside = waves if state is None else _beside(state, others, waves, disc)
        if beside != waves:
            members[i] = chatter(beside, disc)
    fresh = [new for new, old in zip(members, best.members, strict=True) if new is not old]
    library = library.with_more(fresh)
    return library, [(library.places(members), best.u)] if fresh else []


def with_waves_elsewhere(model: ExactModel, library: Library, best: Optimum) -> Library:
    """The library with the other numbers of waves that turns do not tell from that of the best set: pins stand a lobe
    apart, nearly, and meet waves that differ by one to a lobe nearly alike.
    """
    for i, member in enumerate(best.members):
        disc = member.choice.get("disc")
        if not _unscanned_wave(model, member):
            continue
        others, state = _without(model, best, i)
        if state is not None:
            peaks = WavesUnderPins(state.blocks, others, disc).strongest()
            known = float(member.choice["waves_per_turn"])
            library = library.with_more([chatter(p.waves, disc) for p in peaks if abs(p.waves - known) > 1.0])
    return library


def _without(model: ExactModel, best: Optimum, i: int) -> tuple[list[Candidate], State | None]:
    """The other members of the best set, and the state with them alone."""
    others = [member for j, member in enumerate(best.members) if j != i]
    return others, model.state(others, np.delete(best.u, [2 * i, 2 * i + 1]))


def _beside(state: State, others: Sequence[Candidate], waves: float, disc: int | None) -> float:
    """Number of waves near ``waves`` that fits best beside others: on a scan that shows it, or under the pins."""
    for block in state.blocks:
        recording = block.laid.recording
        if recording.kind == "profile_scan" and disc in (None, recording.disc + 1):
            return peak_near(block, waves, _left(block, others))
    return WavesUnderPins(state.blocks, others, disc).near(waves) if unscanned(state.blocks) else waves


def _under_pins(model: ExactModel, state: State, members: Sequence[Candidate]) -> list[Candidate]:
    """The strongest wave of the discs that were not scanned, one or all of them if none was; where discs do not tell,
    that of each.
    """
    discs: list[int | None] = [*unscanned(state.blocks)]
    if len(discs) == state.built.discs > 1:
        discs.append(None)
    if not discs:
        return []
    first, peaks = WavesUnderPins(model.nothing.blocks, (), None).excess, list[Peak]()
    for disc in discs:
        waves = WavesUnderPins(state.blocks, members, disc)
        least = max(_LEAST_SHARE * waves.excess, _LEAST_OF_GAP * first)
        peaks += [peak for peak in waves.strongest()[:1] if peak.p_value < PEAK and peak.power > least]
    highest = max((peak.power for peak in peaks), default=0.0)
    return [chatter(peak.waves, peak.disc) for peak in peaks if peak.power > highest - AS_GOOD]


def _left(block: Whitened, members: Sequence[Candidate]) -> FloatArray:
    """What is left of a file once ``members`` are fitted, and what no measurement can know."""
    z = block.projected(block.z)
    if not members:
        return z
    G = block.projected(block.columns(members))
    left: FloatArray = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
    return left
