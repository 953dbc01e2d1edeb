"""Where waves that do not come out even begin: a scan shows the jump, and the lobe behind it is the first one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.discrepancy.chance import several
from cycloid_profile.discrepancy.chatter_waves import PEAK, fall_of_chi2
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.lobes import begun_at, is_countable
from cycloid_profile.discrepancy.normal import Whitened
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.recording import Recording

_REACH, _STEP = 1.5, 0.02  # waves: a jump in the middle of the scan parts a peak in two, one wave apart
_CHATTER = "grinding_chatter"


def seam(block: Whitened, z: FloatArray, waves: float) -> int | None:
    """From which lobe on, counted from 0, about ``waves`` are in ``z``, what is left of a scan; None where another lobe
    may do as well.
    """
    lobes = block.laid.built.case.drive.trochoid.lobes
    of = (block.laid.position[block.chosen] // (2.0 * np.pi)).astype(np.intp) % lobes
    grid = waves + np.arange(-_REACH, _REACH + 0.5 * _STEP, _STEP)
    power = np.max([_power_from_each_lobe(block, z, float(n), of, lobes) for n in grid], axis=0)
    first, second = np.argsort(power)[:-3:-1]
    chance = several(float(np.exp(-0.5 * (power[first] - power[second]))), lobes)
    return int(first) if chance < PEAK else None


def counted_from_seams(model: ExactModel, best: Optimum) -> ExactModel:
    """The model with the lobes of its scans counted from where the chatter of the ``best`` set begins; the same model
    where no scan tells.
    """
    open_ = [is_countable(model.built, recording) for recording in model.recordings]
    if not any(open_) or not any(member.name == _CHATTER for member in best.members):
        return model
    # Only scans are laid beside the set: nothing else shows a seam.
    blocks = iter(model.scans_alone().at(best).blocks)
    laid, told = list(model.nothing.laid), False
    for i, recording in enumerate(model.recordings):
        block = next(blocks) if recording.kind == "profile_scan" else None
        lobe = _first_lobe(block, best) if block is not None and open_[i] else None
        if lobe is not None:
            laid[i], told = begun_at(laid[i], lobe, model.probes), True
    return model.with_laid(laid) if told else model


def seams_told(before: Sequence[Recording], after: Sequence[Recording], lobes: int) -> list[str]:
    """Sentences about scans whose lobes are counted from where waves begin."""
    told = []
    for old, new in zip(before, after, strict=True):
        if new.lobes_counted and old.placed is not None and new.placed is not None:
            first = round((old.placed.turn - new.placed.turn) * lobes / (2.0 * np.pi)) % lobes + 1
            if first != 1:
                told.append(
                    f"{new.name}: lobes are counted from where the waves begin, lobe {first} as the file counts"
                )
    return told


def _first_lobe(block: Whitened, best: Optimum) -> int | None:
    """Where the largest chatter that a scan shows begins."""
    shown = _shown(best, block)
    if not shown:
        return None
    return seam(block, _with(block, best, shown), float(best.members[shown[0]].choice["waves_per_turn"]))


def _shown(best: Optimum, block: Whitened) -> list[int]:
    """Places of the chatter that a scan shows, the largest first."""
    disc = block.laid.recording.disc + 1
    mine = [i for i, m in enumerate(best.members) if m.name == _CHATTER and m.choice.get("disc") in (None, disc)]
    return sorted(mine, key=lambda i: -float(np.linalg.norm(best.coordinates(i))))


def _with(block: Whitened, best: Optimum, some: Sequence[int]) -> FloatArray:
    """What is left of a scan beside the other members of a set."""
    u = np.concatenate([best.u[2 * i : 2 * i + 2] for i in some])
    z: FloatArray = block.projected(block.z + block.columns([best.members[i] for i in some]) @ u)
    return z


def _power_from_each_lobe(block: Whitened, z: FloatArray, waves: float, of: IntArray, lobes: int) -> FloatArray:
    """Fall of chi² by waves that begin at each lobe, shape (lobes,)."""
    wave = block.white(block.laid.waves(waves))
    along = _from_each_lobe(z * wave, waves, of, lobes)
    across = _from_each_lobe(wave * wave, 2.0 * waves, of, lobes)
    return fall_of_chi2(along, across, np.full(lobes, np.sum(np.abs(wave) ** 2)), z.size)


def _from_each_lobe(values: ComplexArray, waves: float, of: IntArray, lobes: int) -> ComplexArray:
    """Sums of ``values`` of waves that begin at each lobe: the lobes before it come a whole turn later."""
    each = np.bincount(of, values.real, lobes) + 1j * np.bincount(of, values.imag, lobes)
    before = np.cumsum(each) - each
    found: ComplexArray = np.sum(each) + (np.exp(2j * np.pi * waves) - 1.0) * before
    return found
