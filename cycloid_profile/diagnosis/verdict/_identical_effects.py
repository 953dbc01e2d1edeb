"""Aliases: effects with the same flank shape, which no ordinary measurement separates."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.evidence import ALIAS
from cycloid_profile.diagnosis.model.whitened import NormalEquations
from cycloid_profile.effects import AsBuiltReducer, EffectLocation, removal_between

_POINTS_PER_LOBE = 60  # as many as the finest cells of a scan
_STEP = 1e-3  # of the width of a coordinate: the shape is that of an infinitesimal size


def always_identical(reducer: AsBuiltReducer, one: Candidate, other: Candidate) -> bool:
    """Whether two flank effects remove the same shape, so that not even a scan separates them.

    The evidence of the data decides about effects that a scan can separate.
    """
    if EffectLocation.FLANK not in {one.kind.location} & {other.kind.location}:
        return False
    if one.coordinates != 1 or other.coordinates != 1 or one.choice.get("disc") != other.choice.get("disc"):
        return False
    a, b = _shape(reducer, one), _shape(reducer, other)
    return bool(abs(a @ b) > ALIAS * math.sqrt(float(a @ a) * float(b @ b)))


def cosine(equations: NormalEquations, i: int, j: int) -> float:
    """Cosine between the patterns of two candidates with one coordinate; 0 for two coordinates or without a pattern."""
    if equations.candidates[i].coordinates != 1 or equations.candidates[j].coordinates != 1:
        return 0.0
    own, other = equations.R[2 * i, 2 * i], equations.R[2 * j, 2 * j]
    if own < 1e-9 or other < 1e-9:
        return 0.0
    return float(abs(equations.R[2 * i, 2 * j]) / np.sqrt(own * other))


def _shape(reducer: AsBuiltReducer, candidate: Candidate) -> np.ndarray:
    disc = (candidate.choice.get("disc") or 1) - 1
    tooth = reducer.teeth[disc]
    effect = candidate.effect([_STEP * candidate.width, 0.0])
    assert effect is not None
    after = effect.apply(reducer).teeth[disc]
    lobe, psi = np.divmod(np.arange(tooth.trochoid.lobes * _POINTS_PER_LOBE), _POINTS_PER_LOBE)
    phase = (psi + 0.5) / _POINTS_PER_LOBE * 2.0 * np.pi - np.pi
    return removal_between(tooth, after, phase, lobe.astype(np.float64))
