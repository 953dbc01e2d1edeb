"""Scans of a disc beside its drawing: what the named effects leave of them, and what a correction will."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.discrepancy.laid import Laid
from cycloid_profile.discrepancy.outcome import Diagnosis
from cycloid_profile.discrepancy.recording import Recording
from cycloid_profile.discrepancy.remainder import Residual
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.units import UM

_ROUNDS = 12
_PULL = 2.0  # standard deviations


@dataclass(frozen=True, eq=False)
class Outlook:
    """A scan before the correction and as it is expected after it, both beside the drawing; arrays over its rows.

    ``along`` the disc, phase + 2π·lobe [rad]; ``before`` and ``after``, removal with the registration taken off [µm];
    ``noise`` [µm]; ``turn``, angle of lobe 1 in the coordinates of the file [rad].
    """

    name: str
    along: FloatArray
    before: FloatArray
    after: FloatArray
    noise: float
    turn: float

    @property
    def rms_before(self) -> float:
        """Root mean square [µm]."""
        return float(np.sqrt(np.mean(self.before**2)))

    @property
    def rms_after(self) -> float:
        """Root mean square [µm]."""
        return float(np.sqrt(np.mean(self.after**2)))


def residuals(diagnosis: Diagnosis, grown: Built, disc: int) -> list[Residual]:
    """What each scan leaves once the effects to be cancelled are taken into account."""
    found = []
    for recording in _scanned(diagnosis, disc):
        laid = Laid(recording, grown)
        along = laid.phase + 2.0 * math.pi * laid.lobe
        left = _settled(laid.residual, _registration(laid), recording.noise.sigma)
        found.append(Residual(along, left * UM, recording.noise.sigma * UM, recording.noise.rho))
    return found


def outlooks(diagnosis: Diagnosis, drawing: ToothProfile, program: ToothProfile, disc: int) -> list[Outlook]:
    """The scans before and after ``program`` is ground in place of ``drawing``."""
    found = []
    bare = diagnosis.built.with_tooth(disc, drawing)
    for recording in _scanned(diagnosis, disc):
        laid = Laid(recording, bare)
        change = removal_between(drawing, program, laid.phase, laid.lobe) / UM
        sigma = recording.noise.sigma
        free = _registration(laid)
        before, after = (_settled(r, free, sigma) for r in (laid.residual, laid.residual + change))
        along = laid.phase + 2.0 * math.pi * laid.lobe
        found.append(Outlook(recording.name, along, before, after, sigma, laid.placed.turn))
    return found


def _scanned(diagnosis: Diagnosis, disc: int) -> list[Recording]:
    recordings = [gap.recording for gap in diagnosis.gaps]
    return [r for r in recordings if r.kind == "profile_scan" and r.disc == disc]


def _registration(laid: Laid) -> FloatArray:
    """What the datum leaves open: the angle, and the origin where it is free. The bore is what the disc turns about."""
    free = laid.recording.measurement.keys.get("datum", "bore") == "free"
    return laid.nuisance if free else laid.nuisance[:, :1]


def _settled(residual: FloatArray, nuisance: FloatArray, sigma: float) -> FloatArray:
    """The residual with what no measurement can know fitted against its prior [µm].

    Rows far off pull no harder than those at a few standard deviations (Huber): one bad lobe does not move the disc.
    """
    left = residual
    for _ in range(_ROUNDS):
        weighted = nuisance.T / (sigma**2 * np.maximum(1.0, np.abs(left) / (_PULL * sigma)))
        gram = np.eye(nuisance.shape[1]) + weighted @ nuisance
        left = residual - nuisance @ np.linalg.solve(gram, weighted @ residual)
    return left
