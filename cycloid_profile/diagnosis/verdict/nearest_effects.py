"""Nearest effects of an unknown effect, each with the reason for its rejection."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis.model.candidate import Candidate
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.optimum import Attempt
from cycloid_profile.diagnosis.model.priors import priors_of
from cycloid_profile.diagnosis.model.whitened import NormalEquations, coordinates

_REPORTED = 3  # a note stays one sentence
_EXPLAINED = 0.9  # share of the initial residual that an accepted effect must explain
_FARTHEST = 15.0  # widths: a size far beyond the plausible one still appears in the note
_STEPS = 5  # from the linear size, which is far off beyond the plausible one


@dataclass(frozen=True)
class NearestEffect:
    """An effect fitted alone and rejected: its ``name`` and best ``parameters``, and the reason ``why``.

    ``share``: explained share of the initial residual, 0 to 1. ``too_large``: the effect explains the residual, but its
    size is implausible.
    """

    name: str
    parameters: Mapping[str, Any]
    share: float
    why: str
    too_large: bool = False

    @property
    def sentence(self) -> str:
        """Note on an effect that is ``too_large``."""
        return f"resembles {self.name}, but {self.why}"


def nearest(model: ExactModel, equations: NormalEquations) -> tuple[NearestEffect, ...]:
    """The three effects that explain most alone; the first with the exact model if its size is implausible.

    None where a drift that is fitted leaves no more than the noise.
    """
    gap = equations.chi2 - equations.rows
    if gap <= 0.0:
        return ()
    best: dict[str, tuple[float, Candidate, FloatArray]] = {}
    for i, candidate in enumerate(equations.candidates):
        where = coordinates([i])
        b, R = equations.b[where], equations.R[np.ix_(where, where)]
        u = np.asarray(np.linalg.lstsq(R, b, rcond=1e-9)[0], dtype=np.float64)
        share = float(np.clip(b @ u / gap, 0.0, 1.0))
        if share > best.get(candidate.name, (0.0,))[0]:
            best[candidate.name] = (share, candidate, u)
    ranked = sorted(best.values(), key=lambda found: -found[0])[:_REPORTED]
    described, quality = [], priors_of(model.reducer).quality
    for place, (share, candidate, u) in enumerate(ranked):
        if place == 0 and _too_large(candidate, u) and not _negative(candidate, u):
            optimum = model.optimum(Attempt((candidate,), u, steps=_STEPS, farthest=_FARTHEST), 0.0)
            if optimum is not None and model.baseline.chi2 - optimum.chi2 > share * gap:
                u, share = optimum.u, min((model.baseline.chi2 - optimum.chi2) / gap, 1.0)
        described.append(_nearest_effect(candidate, u, share, quality))
    return tuple(described)


def _nearest_effect(candidate: Candidate, u: FloatArray, share: float, quality: str) -> NearestEffect:
    if _negative(candidate, u):
        return NearestEffect(candidate.name, {}, share, f"{candidate.size} would have to be negative")
    parameters = candidate.parameters(u * candidate.width)
    size = f"{candidate.size} = {parameters[candidate.size]:.3g}"
    leaves = f"leaves {100.0 * (1.0 - share):.0f} % of the gap"
    if not _too_large(candidate, u):
        return NearestEffect(candidate.name, parameters, share, f"alone, with {size}, it {leaves}")
    largest = abs(candidate.parameters([candidate.implausible, 0.0])[candidate.size])
    than = f"than a {quality} drive of this size plausibly has ({largest:.3g})"
    why = f"{size} is {'softer' if candidate.inverse else 'larger'} {than}"
    enough = share > _EXPLAINED
    return NearestEffect(candidate.name, parameters, share, why if enough else f"{why}, and it {leaves}", enough)


def _too_large(candidate: Candidate, u: FloatArray) -> bool:
    return math.hypot(u[0], u[1]) * candidate.width > candidate.implausible


def _negative(candidate: Candidate, u: FloatArray) -> bool:
    return candidate.one_sided and not u[0] > 0.0
