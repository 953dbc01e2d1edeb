"""Effects that no ordinary measurement tells apart, because the flanks they make are the same."""

from __future__ import annotations

import math

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.evidence import ALIAS
from cycloid_profile.discrepancy.normal import Normal
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Place
from cycloid_profile.effects.pattern import removal_between

_POINTS_PER_LOBE = 60
_STEP = 1e-3


def always_alike(built: Built, one: Candidate, other: Candidate) -> bool:
    """Whether two flank errors remove the same shape, so that not even a scan tells them apart.

    Other measurements see the flanks less sharply than a scan; two effects that a scan separates are told apart, or
    not, by the evidence of the data at hand.
    """
    if Place.FLANK not in {one.kind.place} & {other.kind.place}:
        return False
    if one.coordinates != 1 or other.coordinates != 1 or one.choice.get("disc") != other.choice.get("disc"):
        return False
    a, b = _shape(built, one), _shape(built, other)
    return bool(abs(a @ b) > ALIAS * math.sqrt(float(a @ a) * float(b @ b)))


def cosine(equations: Normal, i: int, j: int) -> float:
    """Cosine between what two candidates of one coordinate show; 0 where one has two or shows nothing."""
    if equations.candidates[i].coordinates != 1 or equations.candidates[j].coordinates != 1:
        return 0.0
    own, other = equations.R[2 * i, 2 * i], equations.R[2 * j, 2 * j]
    if own < 1e-9 or other < 1e-9:
        return 0.0
    return float(abs(equations.R[2 * i, 2 * j]) / np.sqrt(own * other))


def _shape(built: Built, candidate: Candidate) -> np.ndarray:
    disc = (candidate.choice.get("disc") or 1) - 1
    tooth = built.teeth[disc]
    effect = candidate.effect([_STEP * candidate.width, 0.0])
    assert effect is not None
    after = effect.apply(built).teeth[disc]
    lobe, psi = np.divmod(np.arange(tooth.trochoid.lobes * _POINTS_PER_LOBE), _POINTS_PER_LOBE)
    phase = (psi + 0.5) / _POINTS_PER_LOBE * 2.0 * np.pi - np.pi
    return removal_between(tooth, after, phase, lobe.astype(np.float64))
