"""Scans of a disc against its drawing: residual after the named effects, and expectation after a correction."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.diagnosis import Diagnosis, Recording, Residuals, ScanResidual
from cycloid_profile.effects import AsBuiltReducer, removal_between
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.measurement import PROFILE_SCAN
from cycloid_profile.units import UM

_ROUNDS = 12  # reweightings of Huber's fit, which converges linearly
_PULL = 2.0  # standard deviations


@dataclass(frozen=True, eq=False)
class ExpectedScan:
    """A scan before the correction and as expected after it, against the drawing; arrays over its rows.

    ``along``: phase + 2π·lobe [rad]. ``before`` and ``after``: removal after registration [µm]. ``noise`` [µm].
    ``lobe_1_angle``: angle of lobe 1 in the coordinates of the file [rad].
    """

    name: str
    along: FloatArray
    before: FloatArray
    after: FloatArray
    noise: float
    lobe_1_angle: float

    @property
    def rms_before(self) -> float:
        """Root mean square [µm]."""
        return float(np.sqrt(np.mean(self.before**2)))

    @property
    def rms_after(self) -> float:
        """Root mean square [µm]."""
        return float(np.sqrt(np.mean(self.after**2)))


def scan_residuals(diagnosis: Diagnosis, with_effects: AsBuiltReducer, disc: int) -> list[ScanResidual]:
    """Residual of each scan after subtraction of the effects to be cancelled."""
    found = []
    for recording in _scanned(diagnosis, disc):
        registered = Residuals(recording, with_effects)
        along = registered.phase + 2.0 * math.pi * registered.lobe
        left = _robust_fit(registered.residual, _registration(registered), recording.noise.sigma)
        found.append(ScanResidual(along, left * UM, recording.noise.sigma * UM, recording.noise.rho))
    return found


def expected_scans(diagnosis: Diagnosis, drawing: ToothProfile, program: ToothProfile, disc: int) -> list[ExpectedScan]:
    """The scans before and after ``program`` replaces ``drawing``."""
    found = []
    bare = diagnosis.reducer.with_tooth(disc, drawing)
    for recording in _scanned(diagnosis, disc):
        registered = Residuals(recording, bare)
        change = removal_between(drawing, program, registered.phase, registered.lobe) / UM
        sigma = recording.noise.sigma
        free = _registration(registered)
        before, after = (_robust_fit(r, free, sigma) for r in (registered.residual, registered.residual + change))
        along = registered.phase + 2.0 * math.pi * registered.lobe
        found.append(ExpectedScan(recording.name, along, before, after, sigma, registered.placed.turn))
    return found


def _scanned(diagnosis: Diagnosis, disc: int) -> list[Recording]:
    recordings = [gap.recording for gap in diagnosis.gaps]
    return [r for r in recordings if r.kind is PROFILE_SCAN and r.disc == disc]


def _registration(registered: Residuals) -> FloatArray:
    """Free nuisances: the angle, and the origin if the datum is free. The disc rotates about its bore."""
    free = registered.recording.measurement.keys.get("datum", "bore") == "free"
    return registered.nuisance if free else registered.nuisance[:, :1]


def _robust_fit(residual: FloatArray, nuisance: FloatArray, sigma: float) -> FloatArray:
    """Residual after a robust fit of the nuisances against their priors (Huber) [µm].

    Rows beyond ``_PULL`` standard deviations have bounded influence, so that outliers on one lobe do not bias the
    registration.
    """
    left = residual
    for _ in range(_ROUNDS):
        weighted = nuisance.T / (sigma**2 * np.maximum(1.0, np.abs(left) / (_PULL * sigma)))
        gram = np.eye(nuisance.shape[1]) + weighted @ nuisance
        left = residual - nuisance @ np.linalg.solve(gram, weighted @ residual)
    return left
