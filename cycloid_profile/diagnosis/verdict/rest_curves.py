"""What no effect explains, as smooth curves of the model: empirical, not physical."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cycloid_profile.diagnosis.model.residuals import Residuals, fitted_rms, nuisance_fitted
from cycloid_profile.diagnosis.verdict.remainder import ScanResidual, smooth_remainder
from cycloid_profile.effects import Empirical, fit_torque_twist, form_deviation_of, loop_branches
from cycloid_profile.errors import CycloidError
from cycloid_profile.measurement import HYSTERESIS, PROFILE_SCAN
from cycloid_profile.units import UM

_MANY = 3.0  # standard deviations of the noise


@dataclass(frozen=True, eq=False)
class EmpiricalFit:
    """An empirical ``effect`` fitted to a ``file``; root mean square of the held-out rows without and with it."""

    effect: Empirical
    file: str
    unit: str
    held_out_before: float
    held_out_after: float

    @property
    def sentence(self) -> str:
        """What was fitted, and by how much it closes the gap."""
        rms = f"{self.held_out_before:.3g} to {self.held_out_after:.3g} {self.unit} rms on held-out rows"
        return f"{self.file}: the rest becomes {self.effect.name}, {self.effect.label}: {rms}"


def exceeds_noise(one: Residuals) -> bool:
    """Whether a loop leaves several times its noise: the error of the model may."""
    recording = one.recording
    return recording.kind is HYSTERESIS and fitted_rms(one, ~recording.held_out) > _MANY * recording.noise.sigma


def empirical_fits(residuals: Sequence[Residuals]) -> tuple[EmpiricalFit, ...]:
    """A smooth curve for each scan and loop whose held-out rows it brings closer to the prediction."""
    found = []
    for one in residuals:
        effect = _curve_of(one)
        if effect is None:
            continue
        try:
            after = Residuals(one.recording, effect.apply(one.reducer))
        except CycloidError:
            continue
        before_rms, after_rms = (fitted_rms(each, one.recording.held_out) for each in (one, after))
        if after_rms < before_rms:
            found.append(EmpiricalFit(effect, one.recording.name, one.recording.unit, before_rms, after_rms))
    return tuple(found)


def _curve_of(one: Residuals) -> Empirical | None:
    """Curve through the rows to fit; None if it is not significant, or for a curve over a turn."""
    recording = one.recording
    left = nuisance_fitted(one)
    fit = ~recording.held_out & np.isfinite(left)
    noise = recording.noise
    if recording.kind is PROFILE_SCAN:
        along = one.phase + 2.0 * np.pi * one.lobe
        scan = ScanResidual(along[fit], left[fit] * UM, noise.sigma * UM, noise.rho)
        remainder = smooth_remainder([scan], one.reducer.case.drive.trochoid.lobes)
        if remainder is None:
            return None
        return form_deviation_of(remainder.curve, remainder.uncertainty, disc=recording.disc + 1)
    if recording.kind is HYSTERESIS:
        torque = recording.measurement["torque_nm"]
        branch = loop_branches(torque)[recording.rows]
        rows = recording.rows[fit]
        return fit_torque_twist(torque[rows], branch[fit], left[fit], noise.sigma, correlation=noise.rho)
    return None
