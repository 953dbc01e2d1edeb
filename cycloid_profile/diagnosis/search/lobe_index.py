"""Lobe index of scans: which lobe is number 1. A single scan does not determine it; files that show the same effects
must agree.

Raising the index maps every hypothesis to another one of the library, so the normal equations of all indices follow
from those of one. Effects common to all discs cancel to first order on the bench; there the exact model decides.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import Library, best_extension_or_self, log_priors
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.model.whitened import NormalEquations, Whitened, normal_equations
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.measurement import PROFILE_SCAN


def index_lobes(
    reducer: AsBuiltReducer, residuals: Sequence[Residuals], candidates: Sequence[Candidate], flank_grid: FlankGrid
) -> list[Residuals]:
    """Residuals with the lobe index of each scan that agrees best with the files before it."""
    equations = (
        [normal_equations([Whitened(one)], candidates) for one in residuals]
        if _has_free_scan(reducer, residuals)
        else []
    )
    offsets = _offsets(reducer, residuals, equations, log_priors(candidates), [])
    return [_reindexed(one, n, flank_grid) for one, n in zip(residuals, offsets, strict=True)]


def offsets_about(model: ExactModel, library: Library, optimum: Optimum) -> tuple[int, ...]:
    """Offset of each file's lobe index that suits a set of effects best, given the files before it.

    On an odd number of lobes, an oval rotated by 180° differs from the original by half a lobe only. The linear error
    of other files can hide that, so they are linearised about the optimum.
    """
    residuals = model.baseline.residuals
    if not _has_free_scan(model.reducer, residuals):
        return (0,) * len(residuals)
    state = model.at(optimum)
    library = _at_every_lobe(library, optimum.members, model.reducer.case.drive.trochoid.lobes)
    places = library.places(optimum.members)
    equations = []
    for whole, block in zip(model.baseline.blocks, state.blocks, strict=True):
        if whole.residuals.recording.kind is PROFILE_SCAN:
            equations.append(normal_equations([whole], library.candidates))
        else:
            equations.append(normal_equations([block], library.candidates).about(places, optimum.u))
    return tuple(_offsets(model.reducer, residuals, equations, library.priors, places))


def _at_every_lobe(library: Library, members: Sequence[Candidate], lobes: int) -> Library:
    """The library without shapes between those of its effects, but with ``members`` at every number of the lobe."""
    twins = [replace(one, choice=one.reindexed(n, lobes)[0]) for one in members for n in range(lobes)]
    listed = [one for one in library.candidates if one.listed]
    return Library(tuple(dict.fromkeys([*listed, *twins])), library.frequencies)


def with_offsets(model: ExactModel, offsets: Sequence[int]) -> ExactModel:
    """The model with the lobe index of each scan raised."""
    if not any(offsets):
        return model
    return model.with_residuals(
        [_reindexed(one, n, model.flank_grid) for one, n in zip(model.baseline.residuals, offsets, strict=True)]
    )


def has_free_index(reducer: AsBuiltReducer, recording: Recording) -> bool:
    """Whether the lobe index of a file is free: a scan of identical lobes."""
    return recording.kind is PROFILE_SCAN and reducer.teeth[recording.disc].identical_lobes


def _has_free_scan(reducer: AsBuiltReducer, residuals: Sequence[Residuals]) -> bool:
    """Whether there is a scan with a free lobe index, and another file to compare it with."""
    return len(residuals) > 1 and any(has_free_index(reducer, one.recording) for one in residuals)


def _reindexed(one: Residuals, lobes: int, flank_grid: FlankGrid) -> Residuals:
    if not lobes:
        return one
    return Residuals(
        with_raised_index(one.recording, -lobes, one.reducer.case.drive.trochoid.lobes), one.reducer, flank_grid
    )


def _offsets(
    reducer: AsBuiltReducer,
    residuals: Sequence[Residuals],
    equations: Sequence[NormalEquations],
    priors: FloatArray,
    members: Sequence[int],
) -> list[int]:
    """Index offset of each recording against the files before it; scans come last."""
    offsets = [0] * len(residuals)
    so_far: NormalEquations | None = None
    fixed = [not has_free_index(reducer, one.recording) for one in residuals]
    for i in sorted(range(len(equations)), key=lambda i: (residuals[i].recording.kind is PROFILE_SCAN, not fixed[i])):
        own = equations[i]
        if so_far is not None and not fixed[i]:
            offsets[i], own = _best_offset(so_far, own, reducer.case.drive.trochoid.lobes, priors, members)
        so_far = own if so_far is None else so_far.plus(own)
    return offsets


def with_raised_index(recording: Recording, lobes: int, of: int) -> Recording:
    """The scan with the number of every lobe raised by ``lobes``."""
    if recording.placed is None or lobes == 0:
        return recording
    turn = recording.placed.turn + 2.0 * math.pi * lobes / of
    return replace(recording, placed=replace(recording.placed, turn=turn))


def _best_offset(
    others: NormalEquations, scan: NormalEquations, of: int, priors: FloatArray, members: Sequence[int]
) -> tuple[int, NormalEquations]:
    """Index offset of the scan that fits the other files best, and its equations with that index.

    The criterion is the evidence of ``members`` with at most one more effect.
    """
    best = (-math.inf, 0, scan)
    # Small offsets first: the nearest is kept unless another is clearly better.
    for lobes in sorted(range(of), key=lambda n: min(n, of - n)):
        further = reindexed_equations(scan, lobes, of)
        value = best_extension_or_self(others.plus(further), priors, members).log_evidence
        if value > best[0] + 1.0:
            best = (value, lobes, further)
    return best[1], best[2]


def reindexed_equations(scan: NormalEquations, lobes: int, of: int) -> NormalEquations:
    """The equations of a scan with its lobe index raised by ``lobes`` against the library."""
    index = {(c.name, tuple(sorted(c.choice.items(), key=str))): i for i, c in enumerate(scan.candidates)}
    place, turn = np.empty(len(scan.candidates), dtype=np.intp), np.empty((len(scan.candidates), 2, 2))
    for i, candidate in enumerate(scan.candidates):
        choice, angle = candidate.reindexed(lobes, of)
        place[i] = index[(candidate.name, tuple(sorted(choice.items(), key=str)))]
        turn[i] = rotation(angle)
    n = place.size
    b = np.einsum("idc,id->ic", turn, scan.b.reshape(n, 2)[place])
    blocks = scan.R.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)[place[:, np.newaxis], place]
    blocks = np.swapaxes(turn, 1, 2)[:, np.newaxis] @ blocks @ turn
    return replace(scan, b=b.ravel(), R=blocks.transpose(0, 2, 1, 3).reshape(2 * n, 2 * n))


def rotation(angle: float) -> FloatArray:
    """Rotation matrix of two coordinates."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
