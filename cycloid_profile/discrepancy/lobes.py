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
from cycloid_profile.discrepancy.evidence import log_priors, search
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.normal import Normal, Whitened, normal
from cycloid_profile.discrepancy.probes import Probes
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.effects.built import Built


def counted_alike(built: Built, laid: Sequence[Laid], library: Sequence[Candidate], probes: Probes) -> list[Laid]:
    """The recordings with the lobes of all scans counted so that they agree best with the files before them."""
    ordered = sorted(laid, key=lambda one: one.recording.kind == "profile_scan")
    if len(ordered) < 2 or ordered[-1].recording.kind != "profile_scan":
        return list(laid)
    placed: dict[int, Laid] = {}
    so_far: Normal | None = None
    for one in ordered:
        recording, now = one.recording, one
        own = normal([Whitened(one)], library)
        if so_far is not None and recording.kind == "profile_scan" and built.teeth[recording.disc].lobes_alike:
            lobes, own = _best_count(so_far, own, built.case.drive.trochoid.lobes)
            if lobes:
                counted = counted_on(recording, -lobes, built.case.drive.trochoid.lobes)
                now = Laid(counted, built, probes)
        placed[id(one)] = now
        so_far = own if so_far is None else _sum(so_far, own)
    return [placed[id(one)] for one in laid]


def counted_on(recording: Recording, lobes: int, of: int) -> Recording:
    """The scan with every lobe's number raised."""
    if recording.placed is None or lobes == 0:
        return recording
    turn = recording.placed.turn + 2.0 * math.pi * lobes / of
    return replace(recording, placed=replace(recording.placed, turn=turn))


def _best_count(others: Normal, scan: Normal, of: int) -> tuple[int, Normal]:
    """By how many lobes the scan counts further than the other files, and its equations in their count."""
    best = (-math.inf, 0, scan)
    priors = log_priors(scan.candidates)
    # Small turns first: among countings that are as good the nearest is kept.
    for lobes in sorted(range(of), key=lambda n: min(n, of - n)):
        moved = _moved(scan, lobes, of)
        top = search(_sum(others, moved), priors, 1)
        value = top[0].log_evidence if top else 0.0
        if value > best[0] + 1.0:
            best = (value, lobes, moved)
    return best[1], best[2]


def _moved(scan: Normal, lobes: int, of: int) -> Normal:
    """The equations of a scan whose lobes count ``lobes`` further than the library's."""
    index = {(c.name, tuple(sorted(c.choice.items(), key=str))): i for i, c in enumerate(scan.candidates)}
    P = np.zeros_like(scan.R)
    for i, candidate in enumerate(scan.candidates):
        choice, angle = candidate.turned(lobes, of)
        j = index[(candidate.name, tuple(sorted(choice.items(), key=str)))]
        P[2 * j : 2 * j + 2, 2 * i : 2 * i + 2] = _rotation(angle)
    return replace(scan, b=P.T @ scan.b, R=P.T @ scan.R @ P)


def _rotation(angle: float) -> FloatArray:
    return np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])


def _sum(a: Normal, b: Normal) -> Normal:
    return Normal(a.candidates, a.b + b.b, a.R + b.R, a.chi2 + b.chi2, a.rows + b.rows, (*a.parts, *b.parts))
