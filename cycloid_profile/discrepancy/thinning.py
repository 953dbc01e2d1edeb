"""Fewer rows of a recording, for the coarse part of the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cycloid_profile.discrepancy.noise import Noise
from cycloid_profile.discrepancy.recording import Recording


def thinned(recording: Recording, rows: int, share: float = 0.0) -> Recording:
    """About ``rows`` of the rows to fit, or a ``share`` of them where that is more, evenly taken.

    A scan costs little and is left whole.
    """
    fit = recording.rows[~recording.held_out]
    step = int(fit.size / max(rows, share * fit.size))
    if recording.kind == "profile_scan" or step < 2:
        return recording
    # An odd step never falls on the same side of a pair.
    chosen = fit[:: step | 1]
    return replace(
        recording,
        rows=chosen,
        held_out=np.zeros(chosen.size, dtype=bool),
        noise=Noise(recording.noise.sigma, recording.noise.rho ** (step | 1)),
    )
