"""Subsamples of curves: most sets are compared on few rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.measurement import PROFILE_SCAN

_GOLDEN = 0.5 * (5.0**0.5 - 1.0)  # its multiples fill an interval most evenly
_FEWEST_ROWS = 240  # of all curves together
_CHEAP_ROWS = 1000  # of all curves together: up to this number no subsample is needed
_GAIN_SEEN = 60.0  # of chi²
_SCREENED = 4  # of so many rows one decides which sets are fitted to all of them


def subsample(recording: Recording, rows: int) -> Recording:
    """Recording with about ``rows`` of its rows to fit, unevenly spaced.

    Scans are cheap and remain complete.
    """
    fit = recording.rows[~recording.held_out]
    step = fit.size // rows
    if recording.kind is PROFILE_SCAN or step < 2:
        return recording
    # Uneven steps: even ones would take the mesh for a slow wave.
    count = fit.size // step
    chosen = fit[((np.arange(count) + np.arange(count) * _GOLDEN % 1.0) * step).astype(np.intp)]
    return replace(
        recording,
        rows=chosen,
        held_out=np.zeros(chosen.size, dtype=bool),
        noise=recording.noise.thinned(step),
    )


def smallest_subsample(model: ExactModel, gain: float) -> ExactModel:
    """The model with the smallest subsample on which a ``gain`` in chi² stays visible."""
    curves = [r.rows.size for r in model.recordings if r.kind.is_curve]
    if sum(curves) <= _CHEAP_ROWS:
        return model
    rows = max(_FEWEST_ROWS, round(sum(curves) * min(_GAIN_SEEN / max(gain, 1.0), 1.0))) // max(len(curves), 1)
    return model.with_recordings([subsample(r, rows) for r in model.recordings])


def screening_subsample(model: ExactModel, few: ExactModel) -> ExactModel | None:
    """The model with the subsample on which sets are fitted before all rows: of no file less than the ``few`` rows.

    None where it would save little, and for loops alone: few pins bear there, and each row may decide which.
    """
    files = zip(model.recordings, few.recordings, strict=True)
    rows = [max(int(np.count_nonzero(~r.held_out)) // _SCREENED, some.rows.size) for r, some in files]
    fewer = [subsample(r, count) for r, count in zip(model.recordings, rows, strict=True)]
    saved = sum(r.rows.size for r in fewer) < 0.5 * sum(r.rows.size for r in model.recordings)
    return model.with_recordings(fewer) if saved and not model.only_loops else None
