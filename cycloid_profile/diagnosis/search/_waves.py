"""Chatter: numbers of waves that the residual of an optimum shows, in scans and through the loaded pins."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate, chatter
from cycloid_profile.diagnosis.model.chatter_spectrum import AS_GOOD, PEAK, SPEEDS, chatter_peaks, peak_near
from cycloid_profile.diagnosis.model.exact_model import ExactModel, State
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.unscanned_waves import Peak, UnscannedWaves, unscanned
from cycloid_profile.diagnosis.model.whitened import Whitened
from cycloid_profile.effects import GrindingChatter
from cycloid_profile.measurement import PROFILE_SCAN

# Share of the residual. In curves over a revolution every effect appears as waves, so the strongest wave need not be
# chatter.
_LEAST_SHARE = 0.5


def waves_left(model: ExactModel, optimum: Optimum) -> list[Candidate]:
    """Chatter in the residual of an optimum: waves of each scan, on its disc and on all, and waves under the pins."""
    state, members = model.at(optimum), optimum.members
    known = [float(c.choice["waves_per_turn"]) for c in members if c.kind is GrindingChatter]
    # Other files decide whether the remaining discs have the waves of a scan.
    turns, found = not (model.only_scans or model.only_loops), list[Candidate]()
    priors = priors_of(model.reducer)
    for block in state.blocks:
        if block.residuals.recording.kind is PROFILE_SCAN:
            disc = block.residuals.recording.disc + 1
            left = _residual_after_fit(block, members)
            speed, waves = chatter_peaks(block, left)
            fresh = [n for n in waves if all(abs(n - other) > 1.0 for other in known)]
            found += [chatter(n, one, priors, speed) for n in fresh for one in ((disc, None) if turns else (disc,))]
    return found if known else [*found, *_under_pins(state, members)]


def refitted(model: ExactModel, optimum: Optimum, reach: float = 0.5) -> tuple[Candidate, ...]:
    """Members of an optimum, their numbers of waves read again within ``reach`` after subtraction of the others."""
    members = list(optimum.members)
    for i, member in enumerate(members):
        if member.kind is GrindingChatter:
            others, state = _state_without(model, optimum, i)
            if state is not None:
                waves, disc = float(member.choice["waves_per_turn"]), member.choice.get("disc")
                speed = str(member.choice["constant_speed"])
                waves = _refitted_waves(state, others, waves, disc, speed, reach)
                members[i] = chatter(waves, disc, priors_of(model.reducer), speed)
    return tuple(members)


def alternative_waves(model: ExactModel, optimum: Optimum) -> list[Candidate]:
    """Other numbers of waves that turns cannot separate from those of an optimum.

    Pins are nearly one lobe apart, so waves that differ by one per lobe look nearly identical.
    """
    found, priors = list[Candidate](), priors_of(model.reducer)
    for i, member in enumerate(optimum.members):
        disc, hidden = member.choice.get("disc"), unscanned(model.baseline.blocks)
        scanned = len(hidden) < model.reducer.discs if disc is None else disc not in hidden
        others, state = _state_without(model, optimum, i)
        if member.kind is GrindingChatter and not scanned and state is not None:
            known = float(member.choice["waves_per_turn"])
            speed = str(member.choice["constant_speed"])
            peaks = UnscannedWaves(state.blocks, others, disc).strongest(speed)
            found += [chatter(peak.waves, disc, priors, speed) for peak in peaks if abs(peak.waves - known) > 1.0]
    return found


def _state_without(model: ExactModel, optimum: Optimum, i: int) -> tuple[list[Candidate], State | None]:
    """The other members of an optimum, and the state with these members only."""
    others = [member for j, member in enumerate(optimum.members) if j != i]
    return others, model.state(others, np.delete(optimum.u, [2 * i, 2 * i + 1]))


def _refitted_waves(
    state: State, others: Sequence[Candidate], waves: float, disc: int | None, speed: str, reach: float
) -> float:
    """Number of waves near ``waves`` that fits best given ``others``: from a scan that shows it, else from turns."""
    for block in state.blocks:
        recording = block.residuals.recording
        if recording.kind is PROFILE_SCAN and disc in (None, recording.disc + 1):
            return peak_near(block, waves, _residual_after_fit(block, others), speed, reach)
    return UnscannedWaves(state.blocks, others, disc).near(waves, speed) if unscanned(state.blocks) else waves


def _under_pins(state: State, members: Sequence[Candidate]) -> list[Candidate]:
    """Strongest wave of the discs without a scan.

    On one disc, or on all discs if none was scanned; on each disc, and in each motion, that explains nearly as much.
    """
    discs: list[int | None] = [*unscanned(state.blocks)]
    if len(discs) == state.reducer.discs > 1:
        discs.append(None)
    peaks, priors = list[Peak](), priors_of(state.reducer)
    for disc in discs:
        waves = UnscannedWaves(state.blocks, members, disc)
        strongest = [peak for speed in SPEEDS for peak in waves.strongest(speed)[:1]]
        peaks += [peak for peak in strongest if peak.p_value < PEAK and peak.power > _LEAST_SHARE * waves.excess]
    highest = max((peak.power for peak in peaks), default=0.0)
    return [chatter(peak.waves, peak.disc, priors, peak.speed) for peak in peaks if peak.power > highest - AS_GOOD]


def _residual_after_fit(block: Whitened, members: Sequence[Candidate]) -> FloatArray:
    """Whitened residual of a file after a free fit of ``members`` and nuisances."""
    z = block.projected(block.z)
    if not members:
        return z
    G = block.projected(block.columns(members))
    left: FloatArray = z - G @ np.linalg.lstsq(G, z, rcond=None)[0]
    return left
