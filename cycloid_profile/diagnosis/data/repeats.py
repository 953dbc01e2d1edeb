"""What files of one instrument show together: noise from repeated measurements, and drift.

The difference of two files of one specimen is noise. Repeats without unclamping share their clamping error, which the
difference does not contain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._drift import covers_a_turn
from cycloid_profile.diagnosis.data.noise import Noise, estimate_noise
from cycloid_profile.diagnosis.data.recording import Recording
from cycloid_profile.measurement import HYSTERESIS
from cycloid_profile.units import DEGREE, UM

# Share of the row spacing: largest distance of two rows at the same position.
_SAME_PLACE = 0.1
_ENOUGH = 0.8  # share of the rows that must coincide


def with_noise_of_repeats(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings; repeats of one ``specimen`` and kind get the noise of their differences.

    Files with stated noise, without a specimen, or with rows at other positions keep their noise.
    """
    groups: dict[tuple[object, ...], list[int]] = {}
    for i, recording in enumerate(recordings):
        keys = recording.measurement.keys
        if "specimen" in keys and f"noise_{recording.unit}" not in keys:
            same = (
                keys["specimen"],
                recording.kind,
                recording.disc,
                keys.get("torque_nm"),
                keys.get("output_angle_deg"),
            )
            groups.setdefault(same, []).append(i)
    found = list(recordings)
    for group in groups.values():
        noises = [_noise_between(recordings[a], recordings[b]) for a, b in pairwise(group)]
        estimated = [noise for noise in noises if noise is not None]
        if estimated:
            sigma = math.sqrt(sum(noise.sigma**2 for noise in estimated) / len(estimated))
            noise = Noise(sigma, float(np.mean([noise.rho for noise in estimated])))
            note = f"noise from {len(estimated) + 1} repeats of {recordings[group[0]].measurement.keys['specimen']}"
            for i in {i for pair, one in zip(pairwise(group), noises, strict=True) if one is not None for i in pair}:
                found[i] = replace(found[i], noise=noise, notes=(*found[i].notes, note))
    return found


def with_drift_of_instrument(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings; where one curve over a turn drifts, those of its kind that show no drift may drift as far.

    Half a wave of drift closes a turn, so that a single file cannot show it: it passes for a wave of order one. A drift
    far above the noise is of the parts, not of the instrument, and holds for its own file alone.
    """
    found = list(recordings)
    for i, one in enumerate(recordings):
        if not one.drift and _is_a_turn(one):
            same = [other for other in recordings if other.kind is one.kind and _is_of_instrument(other)]
            widest = max(same, key=lambda other: other.drift, default=one)
            if widest.drift:
                note = f"{widest.name} drifts: a drift of the same width is fitted here, too"
                notes = (*one.notes, note)
                found[i] = replace(one, drift=widest.drift, drift_of_another_file=True, notes=notes)
    return found


def _is_a_turn(one: Recording) -> bool:
    return one.kind.over_output_turn and covers_a_turn(one.measurement["output_angle_deg"][one.rows] * DEGREE)


def _is_of_instrument(one: Recording) -> bool:
    return one.shown_drift <= tuned.DRIFT * one.noise.sigma


def _noise_between(one: Recording, other: Recording) -> Noise | None:
    """Noise of either of two files; None if too few rows coincide."""
    (x, values), (y, others) = _row(one), _row(other)
    if one.kind is HYSTERESIS:
        # The torque passes the same value several times: rows of a loop are matched by number.
        shared, here, there = np.intersect1d(one.rows, other.rows, return_indices=True)
        limit = _SAME_PLACE * float(np.median(np.abs(np.diff(x)))) if x.size > 1 else 0.0
        near = np.abs(x[here] - y[there]) <= limit
        here, there, number = here[near], there[near], shared[near]
    else:
        there = _nearest(y, x)
        near = np.abs(y[there] - x) <= _SAME_PLACE * float(np.median(np.diff(x)))
        here, there, number = np.flatnonzero(near), there[near], np.flatnonzero(near)
    if here.size < max(_ENOUGH * x.size, 8):
        return None
    difference = (values[here] - others[there]) / math.sqrt(2.0)
    return estimate_noise(difference, number, low_end=0.0)


def _row(recording: Recording) -> tuple[FloatArray, FloatArray]:
    """Position and value of every row; the value is in the unit of the noise."""
    rows, measurement = recording.rows, recording.measurement
    if recording.placed is not None:
        along = np.mod(recording.placed.along + np.pi, recording.placed.tooth.trochoid.phase_period)
        return along[rows], recording.placed.removal[rows] / UM
    place = recording.kind.columns[0]
    return measurement[place][rows], measurement.value[rows]


def _nearest(places: FloatArray, wanted: FloatArray) -> IntArray:
    """Index of the nearest of rising ``places`` for each wanted one."""
    right = np.clip(np.searchsorted(places, wanted), 1, places.size - 1)
    return right - (wanted - places[right - 1] < places[right] - wanted)
