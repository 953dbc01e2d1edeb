"""Fewer rows of a recording, for the coarse part of the search."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.noise import Noise
from cycloid_profile.discrepancy.recording import Recording

_FEWEST_ROWS = 240  # of all curves together
_CHEAP_ROWS = 1000  # of all curves together: as few as that need no thinning
_GAIN_SEEN = 20.0  # of chi²


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


def fewest(model: ExactModel, gain: float) -> ExactModel:
    """The model of so few rows that most sets are fitted in a tenth of a second, and a ``gain`` in chi² still shows."""
    curves = [r.rows.size for r in model.recordings if r.kind != "profile_scan"]
    if sum(curves) <= _CHEAP_ROWS:
        return model
    rows = max(_FEWEST_ROWS, round(sum(curves) * min(_GAIN_SEEN / max(gain, 1.0), 1.0))) // max(len(curves), 1)
    return model.with_recordings([thinned(r, rows) for r in model.recordings])
