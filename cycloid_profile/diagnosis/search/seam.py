"""Seam of chatter: a non-integer number of waves has a step where grinding began, which fixes the lobe index."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.diagnosis.data.noise import sidak
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.chatter_spectrum import GENERATING, PEAK, chi2_reduction
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Optimum
from cycloid_profile.diagnosis.model.whitened import Whitened
from cycloid_profile.diagnosis.search.lobe_index import has_free_index
from cycloid_profile.effects import GrindingChatter
from cycloid_profile.measurement import PROFILE_SCAN

SPLIT = 1.5  # waves: a step in the middle of the scan splits a peak into two, one wave apart
_STEP = 0.02  # waves


def seam(block: Whitened, z: FloatArray, waves: float, speed: str = GENERATING) -> int | None:
    """Lobe, counted from 0, at which about ``waves`` waves begin in the residual ``z`` of a scan; None if ambiguous.

    ``speed``: motion of constant speed, in which the waves are even.
    """
    lobes = block.residuals.reducer.case.drive.trochoid.lobes
    of = (block.residuals.position[block.chosen] // (2.0 * np.pi)).astype(np.intp) % lobes
    grid = waves + np.arange(-SPLIT, SPLIT + 0.5 * _STEP, _STEP)
    power = np.max([_power_from_each_lobe(block, z, float(n), speed, of, lobes) for n in grid], axis=0)
    first, second = np.argsort(power)[:-3:-1]
    chance = sidak(float(np.exp(-0.5 * (power[first] - power[second]))), lobes)
    return int(first) if chance < PEAK else None


def offsets_by_seams(model: ExactModel, optimum: Optimum) -> tuple[int, ...]:
    """Offset of each file's lobe index at which the chatter of an optimum begins; zero without a clear seam."""
    offsets = [0] * len(model.recordings)
    if any(member.kind is GrindingChatter for member in optimum.members):
        for i, block in enumerate(model.at(optimum).blocks):
            recording = block.residuals.recording
            if recording.kind is PROFILE_SCAN and has_free_index(model.reducer, recording):
                offsets[i] = _first_lobe(block, optimum) or 0
    return tuple(offsets)


def seam_notes(before: Sequence[Recording], after: Sequence[Recording], lobes: int) -> list[str]:
    """Notes on scans whose lobe index is not that of the file."""
    notes = []
    for old, new in zip(before, after, strict=True):
        if old.placed is not None and new.placed is not None:
            first = round((old.placed.turn - new.placed.turn) * lobes / (2.0 * np.pi)) % lobes + 1
            if first != 1:
                notes.append(f"{new.name}: lobe 1 is lobe {first} of the file")
    return notes


def _first_lobe(block: Whitened, best: Optimum) -> int | None:
    """Lobe at which the largest chatter of a scan begins, None if ambiguous."""
    shown = _shown(best, block)
    if not shown:
        return None
    choice = best.members[shown[0]].choice
    z = _with_members_added(block, best, shown)
    return seam(block, z, float(choice["waves_per_turn"]), str(choice["constant_speed"]))


def _shown(best: Optimum, block: Whitened) -> list[int]:
    """Indices of the chatter members that a scan shows, the largest first."""
    disc = block.residuals.recording.disc + 1
    mine = [i for i, m in enumerate(best.members) if m.kind is GrindingChatter and m.choice.get("disc") in (None, disc)]
    return sorted(mine, key=lambda i: -float(np.linalg.norm(best.coordinates(i))))


def _with_members_added(block: Whitened, best: Optimum, some: Sequence[int]) -> FloatArray:
    """Whitened residual of a scan with the members ``some`` added back."""
    u = np.concatenate([best.u[2 * i : 2 * i + 2] for i in some])
    z: FloatArray = block.projected(block.z + block.columns([best.members[i] for i in some]) @ u)
    return z


def _power_from_each_lobe(
    block: Whitened, z: FloatArray, waves: float, speed: str, of: IntArray, lobes: int
) -> FloatArray:
    """Reduction of chi² by waves that begin at each lobe, shape (lobes,)."""
    wave = block.white(block.residuals.waves(waves, speed))
    along = _from_each_lobe(z * wave, waves, of, lobes)
    across = _from_each_lobe(wave * wave, 2.0 * waves, of, lobes)
    return chi2_reduction(along, across, np.full(lobes, np.sum(np.abs(wave) ** 2)), z.size)


def _from_each_lobe(values: ComplexArray, waves: float, of: IntArray, lobes: int) -> ComplexArray:
    """Sums of ``values`` with the waves beginning at each lobe: earlier lobes are one turn later."""
    each = np.bincount(of, values.real, lobes) + 1j * np.bincount(of, values.imag, lobes)
    before = np.cumsum(each) - each
    found: ComplexArray = np.sum(each) + (np.exp(2j * np.pi * waves) - 1.0) * before
    return found
