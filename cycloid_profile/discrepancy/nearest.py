"""Of an unknown effect: which effects of the library come nearest, and why each of them is not the answer."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.exact import ExactModel
from cycloid_profile.discrepancy.normal import Normal, coordinates
from cycloid_profile.discrepancy.optimum import Attempt

_TOLD = 3
_EXPLAINED = 0.9  # of the gap: what an effect must explain to be the answer
_FARTHEST = 15.0  # widths
_STEPS = 5


@dataclass(frozen=True)
class Near:
    """An effect ``name`` with the ``parameters`` at which it explains most alone, its ``share`` of the gap, 0 to 1,
    and ``why`` it is not the answer, half a sentence.

    ``too_large`` if it explains the gap and only its size speaks against it.
    """

    name: str
    parameters: Mapping[str, Any]
    share: float
    why: str
    too_large: bool = False

    @property
    def sentence(self) -> str:
        """Of one that is ``too_large``."""
        return f"looks like {self.name}, but {self.why}"


def nearest(model: ExactModel, equations: Normal) -> tuple[Near, ...]:
    """The three names that explain most alone; the first on the exact model where its size is no workshop's."""
    gap = max(equations.chi2 - equations.rows, 1e-9)
    best: dict[str, tuple[float, Candidate, FloatArray]] = {}
    for i, candidate in enumerate(equations.candidates):
        where = coordinates([i])
        b, R = equations.b[where], equations.R[np.ix_(where, where)]
        u = np.asarray(np.linalg.lstsq(R, b, rcond=1e-9)[0], dtype=np.float64)
        share = float(np.clip(b @ u / gap, 0.0, 1.0))
        if share > best.get(candidate.name, (0.0,))[0]:
            best[candidate.name] = (share, candidate, u)
    ranked = sorted(best.values(), key=lambda found: -found[0])[:_TOLD]
    told = []
    for place, (share, candidate, u) in enumerate(ranked):
        if place == 0 and _too_large(candidate, u) and not _negative(candidate, u):
            optimum = model.optimum(Attempt((candidate,), u, steps=_STEPS, farthest=_FARTHEST), 0.0)
            if optimum is not None and model.nothing.chi2 - optimum.chi2 > share * gap:
                u, share = optimum.u, min((model.nothing.chi2 - optimum.chi2) / gap, 1.0)
        told.append(_told(candidate, u, share))
    return tuple(told)


def _told(candidate: Candidate, u: FloatArray, share: float) -> Near:
    if _negative(candidate, u):
        return Near(candidate.name, {}, share, f"{candidate.size} would be negative, which it cannot be")
    parameters = candidate.parameters(u * candidate.width)
    size = f"{candidate.size} = {parameters[candidate.size]:.3g}"
    leaves = f"leaves {100.0 * (1.0 - share):.0f} % of the gap"
    if not _too_large(candidate, u):
        return Near(candidate.name, parameters, share, f"alone, with {size}, it {leaves}")
    largest = abs(candidate.parameters([candidate.implausible, 0.0])[candidate.size])
    why = f"{size} is {'softer' if candidate.inverse else 'larger'} than any workshop makes ({largest:.3g})"
    enough = share > _EXPLAINED
    return Near(candidate.name, parameters, share, why if enough else f"{why}, and it {leaves}", enough)


def _too_large(candidate: Candidate, u: FloatArray) -> bool:
    return math.hypot(u[0], u[1]) * candidate.width > candidate.implausible


def _negative(candidate: Candidate, u: FloatArray) -> bool:
    return candidate.one_sided and not u[0] > 0.0
