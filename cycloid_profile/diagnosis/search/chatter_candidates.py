"""Chatter candidates from the spectra of scans and of curves over a revolution, after subtraction of the effects
identified so far.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate, chatter
from cycloid_profile.diagnosis.model.chatter_spectrum import PEAK, chatter_peaks, peak_near
from cycloid_profile.diagnosis.model.evidence import estimate
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.library import Library
from cycloid_profile.diagnosis.model.normal_equations import Whitened, normal_equations
from cycloid_profile.diagnosis.model.optimum import Attempt, Optimum
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.unscanned_waves import AS_GOOD, Peak, UnscannedWaves, unscanned
from cycloid_profile.diagnosis.search.local_search import Start
from cycloid_profile.effects import GrindingChatter
from cycloid_profile.measurement import PROFILE_SCAN

# Share of the residual. In curves over a revolution every effect appears as waves, so the strongest wave need not be
# chatter.
_LEAST_SHARE = 0.5
# Share of the initial gap, squared: below it lies the simulation error of large effects.
_LEAST_OF_GAP = 0.02**2
_FITTED_TOGETHER = 4  # other effects fitted together with a wave


def significant_chatter(model: ExactModel, best: Optimum | None = None) -> list[Candidate]:
    """Significant chatter in the spectra, given the ``best`` set.

    The waves found in a scan become candidates on its disc and on all discs. For discs without a scan, the candidate is
    the wave that explains most of the residual of the bench measurements.
    """
    state, members = (model.baseline, ()) if best is None else (model.at(best), best.members)
    known = [c.choice["waves_per_turn"] for c in members if c.kind is GrindingChatter]
    priors = priors_of(model.reducer)
    # Other files decide whether the remaining discs have the waves of a scan.
    turns, found = not (model.only_scans or model.only_loops), list[Candidate]()
    for block in state.blocks:
        if block.residuals.recording.kind is PROFILE_SCAN:
            waves = chatter_peaks(block, _residual_after_fit(block, members))
            discs = (block.residuals.recording.disc + 1, None) if turns else (block.residuals.recording.disc + 1,)
            fresh = [n for n in waves if all(abs(n - other) > 1.0 for other in known)]
            found += [chatter(n, disc, priors) for n in fresh for disc in discs]
    return found if known else [*found, *_under_pins(model, state, members)]


def with_masked_waves(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, list[Start]]:
    """Library and starting sets with waves that larger effects masked in the first spectrum.

    Each start is the best set with one wave, with and without one of the other members.
    """
    more = significant_chatter(model, best) if best.members else []
    library, starts = library.with_more(more), list[Start]()
    mine = list(range(len(best.members)))
    for wave in more:
        members = (*best.members, wave)
        equations = normal_equations(model.at(best).blocks, members).about(mine, best.u)
        for left_out in (None, *(mine if len(mine) > 1 else ())):
            some = [i for i in range(len(members)) if i != left_out]
            starts.append((library.places([members[i] for i in some]), estimate(equations, some)[0]))
    return library, starts


def with_waves_given_others(
    model: ExactModel, library: Library, best: Optimum, ranked_singles: Sequence[Optimum]
) -> tuple[Library, list[Start]]:
    """Library and starting sets that combine other ``ranked_singles`` with a wave on a disc without a scan.

    Used where the best set has such a wave: the single effects were ranked without it.
    """
    others, starts = {c.name for c in best.members if c.name != "grinding_chatter"}, list[Start]()
    if not any(_unscanned_wave(model, member) for member in best.members):
        return library, starts
    unlike: dict[str, Optimum] = {}
    for one in ranked_singles:
        if len(one.members) == 1 and {one.members[0].name} != others:
            unlike.setdefault(one.members[0].name, one)
    for one in list(unlike.values())[:_FITTED_TOGETHER]:
        fitted = model.optimum(Attempt(one.members, one.u), library.prior(one.members))
        if fitted is not None and not fitted.implausible:
            library, more = with_masked_waves(model, library, fitted)
            starts += more
    return library, starts


def _unscanned_wave(model: ExactModel, member: Candidate) -> bool:
    """Whether a member is chatter on a disc that no scan shows."""
    disc, hidden = member.choice.get("disc"), unscanned(model.baseline.blocks)
    shown = len(hidden) < model.reducer.discs if disc is None else disc not in hidden
    return member.kind is GrindingChatter and not shown


def with_refitted_waves(model: ExactModel, library: Library, best: Optimum) -> tuple[Library, list[Start]]:
    """Library and starting sets with the number of waves read again after subtraction of the other members."""
    members = list(best.members)
    for i, member in enumerate(members):
        if member.name != "grinding_chatter":
            continue
        others, state = _state_without(model, best, i)
        waves, disc = float(member.choice["waves_per_turn"]), member.choice.get("disc")
        refitted = waves if state is None else _refitted_waves(state, others, waves, disc)
        if refitted != waves:
            members[i] = chatter(refitted, disc, priors_of(model.reducer))
    fresh = [new for new, old in zip(members, best.members, strict=True) if new is not old]
    library = library.with_more(fresh)
    return library, [(library.places(members), best.u)] if fresh else []


def with_alternative_waves(model: ExactModel, library: Library, best: Optimum) -> Library:
    """Library with other numbers of waves that turns cannot separate from those of the best set.

    Pins are nearly one lobe apart, so waves that differ by one per lobe look nearly identical.
    """
    for i, member in enumerate(best.members):
        disc = member.choice.get("disc")
        if not _unscanned_wave(model, member):
            continue
        others, state = _state_without(model, best, i)
        if state is not None:
            peaks = UnscannedWaves(state.blocks, others, disc).strongest()
            known = float(member.choice["waves_per_turn"])
            library = library.with_more(
                [chatter(p.waves, disc, priors_of(model.reducer)) for p in peaks if abs(p.waves - known) > 1.0]
            )
    return library


def _state_without(model: ExactModel, best: Optimum, i: int) -> tuple[list[Candidate], State | None]:
    """The other members of the best set, and the state with these members only."""
    others = [member for j, member in enumerate(best.members) if j != i]
    return others, model.state(others, np.delete(best.u, [2 * i, 2 * i + 1]))


def _refitted_waves(state: State, others: Sequence[Candidate], waves: float, disc: int | None) -> float:
    """Number of waves near ``waves`` that fits best given ``others``: from a scan that shows it, else from turns."""
    for block in state.blocks:
        recording = block.residuals.recording
        if recording.kind is PROFILE_SCAN and disc in (None, recording.disc + 1):
            return peak_near(block, waves, _residual_after_fit(block, others))
    return UnscannedWaves(state.blocks, others, disc).near(waves) if unscanned(state.blocks) else waves


def _under_pins(model: ExactModel, state: State, members: Sequence[Candidate]) -> list[Candidate]:
    """Strongest wave of the discs without a scan.

    On one disc, or on all discs if none was scanned; on each disc where the discs cannot be separated.
    """
    discs: list[int | None] = [*unscanned(state.blocks)]
    if len(discs) == state.reducer.discs > 1:
        discs.append(None)
    if not discs:
        return []
    first, peaks = UnscannedWaves(model.baseline.blocks, (), None).excess, list[Peak]()
    for disc in discs:
        waves = UnscannedWaves(state.blocks, members, disc)
        least = max(_LEAST_SHARE * waves.excess, _LEAST_OF_GAP * first)
        peaks += [peak for peak in waves.strongest()[:1] if peak.p_value < PEAK and peak.power > least]
    highest = max((peak.power for peak in peaks), default=0.0)
    return [
        chatter(peak.waves, peak.disc, priors_of(model.reducer)) for peak in peaks if peak.power > highest - AS_GOOD
    ]


def _residual_after_fit(block: Whitened, members: Sequence[Candidate]) -> FloatArray:
    """Whitened residual of a file after a free fit of ``members`` and nuisances."""
    z = block.projected(block.z)
    if not members:
        return z
    G = block.projected(block.columns(members))
    left: FloatArray = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
    return left
