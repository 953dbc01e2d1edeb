"""What effects leave that is neither noise, nor the error of the simulation, nor small for the gap."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cycloid_profile.discrepancy.candidates import Candidate
from cycloid_profile.discrepancy.detection import Detection, Finding, detect
from cycloid_profile.discrepancy.normal import Whitened

_REMAINDER = 0.02  # of the first gap


def detect_beside(blocks: Sequence[Whitened], members: Sequence[Candidate]) -> Detection:
    """Look everywhere at what effects leave, their own columns fitted freely."""
    return detect(blocks, None, [block.columns(members) for block in blocks] if members else None)


def worst_left(left: Detection, before: Sequence[Whitened]) -> Finding | None:
    """The most striking thing left over; ``before``, the same rows without any effect."""
    gap = {}
    for block in before:
        z = block.projected(block.z)
        gap[block.laid.recording.name] = block.laid.recording.noise.sigma * float(np.sqrt(np.mean(z**2)))
    large = [f for f in left.striking if abs(f.amplitude) > _REMAINDER * gap.get(f.file, math.inf)]
    return most_striking(replace(left, findings=tuple(large))) if large else None


def most_striking(detection: Detection) -> Finding:
    """The largest of the places that chance does not make; a whole file only if there is none."""
    places = [f for f in detection.striking if f.file and f.coordinate != "file"]
    return max(places or detection.striking, key=lambda f: abs(f.amplitude))
