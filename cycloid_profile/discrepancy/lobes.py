"""Which lobe of a scan is the first one: no scan knows, but files that show the same effects must agree on it.

Counting the lobes on by some turns every hypothesis into another of the library, so the normal equations of all
countings follow from those of one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.evidence import log_priors, with_one_more
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.library import Library
from cycloid_profile.discrepancy.normal import Normal, Whitened, normal
from cycloid_profile.discrepancy.optimum import Optimum
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.effects.built import Built


def counted_alike(built: Built, laid: Sequence[Laid], candidates: Sequence[Candidate], probes: Probes) -> list[Laid]:
    """The recordings with the lobes of all scans counted so that they agree best with the files before them."""
    equations = [normal([Whitened(one)], candidates) for one in laid] if _countable(built, laid) else []
    counts = _counts(built, laid, equations, log_priors(candidates), [])
    return [_counted(one, n, probes) for one, n in zip(laid, counts, strict=True)]


def recounted(model: ExactModel, near: ExactModel, library: Library, best: Optimum) -> ExactModel:
    """The model with its scans counted anew beside a set of effects, the model itself where the count stays.

    Half a turn of an oval, on an odd number of lobes, is told from none by half a lobe only: the linear error of
    other files may hide that. So these are linearised about ``best``, an optimum of ``near``, which may be of fewer
    rows than ``model``.
    """
    laid = model.nothing.laid
    if not _countable(model.built, laid):
        return model
    places = library.places(best.members)
    equations = []
    for whole, block in zip(model.nothing.blocks, near.at(best).blocks, strict=True):
        if whole.laid.recording.kind == "profile_scan":
            equations.append(normal([whole], library.candidates))
        else:
            equations.append(normal([block], library.candidates).about(places, best.u))
    counts = _counts(model.built, laid, equations, library.priors, places)
    if not any(counts):
        return model
    return _with_counts(model, counts)


def counted_by(model: ExactModel, lobes: int) -> ExactModel:
    """The model with the lobes of all its scans counted so many further, where one is like another."""
    if not lobes:
        return model
    return _with_counts(model, [lobes if is_countable(model.built, r) else 0 for r in model.recordings])


def is_countable(built: Built, recording: Recording) -> bool:
    """Whether any lobe of a file may be the first: of a scan of lobes alike that nothing has told."""
    return recording.kind == "profile_scan" and built.teeth[recording.disc].lobes_alike and not recording.lobes_counted


def begun_at(one: Laid, lobe: int, probes: Probes) -> Laid:
    """The scan with its lobes counted from ``lobe`` on, counted from 0 as it has them, for good."""
    counted = _counted(one, lobe, probes)
    return counted.under(replace(counted.recording, lobes_counted=True))


def _with_counts(model: ExactModel, counts: Sequence[int]) -> ExactModel:
    return model.with_laid([_counted(one, n, model.probes) for one, n in zip(model.nothing.laid, counts, strict=True)])


def _countable(built: Built, laid: Sequence[Laid]) -> bool:
    """Whether there is a scan of lobes alike, and another file that its count must agree with."""
    return len(laid) > 1 and any(is_countable(built, one.recording) for one in laid)


def _counted(one: Laid, lobes: int, probes: Probes) -> Laid:
    if not lobes:
        return one
    return Laid(counted_on(one.recording, -lobes, one.built.case.drive.trochoid.lobes), one.built, probes)


def _counts(
    built: Built, laid: Sequence[Laid], equations: Sequence[Normal], priors: FloatArray, members: Sequence[int]
) -> list[int]:
    """By how many lobes each recording counts further than those before it; scans come last."""
    counts = [0] * len(laid)
    so_far: Normal | None = None
    told = [not is_countable(built, one.recording) for one in laid]
    for i in sorted(range(len(equations)), key=lambda i: (laid[i].recording.kind == "profile_scan", not told[i])):
        own = equations[i]
        if so_far is not None and not told[i]:
            counts[i], own = _best_count(so_far, own, built.case.drive.trochoid.lobes, priors, members)
        so_far = own if so_far is None else so_far.plus(own)
    return counts


def counted_on(recording: Recording, lobes: int, of: int) -> Recording:
    """The scan with every lobe's number raised."""
    if recording.placed is None or lobes == 0:
        return recording
    turn = recording.placed.turn + 2.0 * math.pi * lobes / of
    return replace(recording, placed=replace(recording.placed, turn=turn))


def _best_count(
    others: Normal, scan: Normal, of: int, priors: FloatArray, members: Sequence[int]
) -> tuple[int, Normal]:
    """By how many lobes the scan counts further than the other files, and its equations in their count.

    Judged by the evidence of ``members`` with at most one effect more.
    """
    best = (-math.inf, 0, scan)
    # Small turns first: among countings that are as good the nearest is kept.
    for lobes in sorted(range(of), key=lambda n: min(n, of - n)):
        further = moved(scan, lobes, of)
        value = with_one_more(others.plus(further), priors, members).log_evidence
        if value > best[0] + 1.0:
            best = (value, lobes, further)
    return best[1], best[2]


def moved(scan: Normal, lobes: int, of: int) -> Normal:
    """The equations of a scan whose lobes count ``lobes`` further than the library's."""
    index = {(c.name, tuple(sorted(c.choice.items(), key=str))): i for i, c in enumerate(scan.candidates)}
    place, turn = np.empty(len(scan.candidates), dtype=np.intp), np.empty((len(scan.candidates), 2, 2))
    for i, candidate in enumerate(scan.candidates):
        choice, angle = candidate.turned(lobes, of)
        place[i] = index[(candidate.name, tuple(sorted(choice.items(), key=str)))]
        turn[i] = rotation(angle)
    n = place.size
    b = np.einsum("idc,id->ic", turn, scan.b.reshape(n, 2)[place])
    blocks = scan.R.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)[place[:, np.newaxis], place]
    blocks = np.swapaxes(turn, 1, 2)[:, np.newaxis] @ blocks @ turn
    return replace(scan, b=b.ravel(), R=blocks.transpose(0, 2, 1, 3).reshape(2 * n, 2 * n))


def rotation(angle: float) -> FloatArray:
    """Turns two coordinates by an angle."""
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
