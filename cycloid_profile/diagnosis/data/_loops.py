"""Rows of a loop that can be compared with a prediction, the friction that they show, and their noise."""

from __future__ import annotations

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.diagnosis import _tuned as tuned
from cycloid_profile.diagnosis.data._branches import contrasts_of_branches
from cycloid_profile.diagnosis.data.noise import Noise, estimate_noise, local_noise, scatter_about_cubics
from cycloid_profile.effects import AsBuiltReducer, transmitted_torque
from cycloid_profile.measurement import Measurement
from cycloid_profile.rig import preceding_sign
from cycloid_profile.rig.hysteresis import UNLOADED_SHARE
from cycloid_profile.spec.model import quality_of

# Rows of a loop with less than this share of its largest torque on the stage are omitted: it may touch either flank.
NEAR_ZERO = 0.05
FRICTION_MARGIN = 0.25  # of friction, which a loop shows to this share: the limit above is raised by it
_MIDDLE, _ANGLES = 0.3, 41  # share of the range of angles, and angles in it, at which the branches are compared
_RANGE = 0.02, 0.98  # of the rows: few reading errors are beyond
# Share of the largest torque after a reversal that is omitted: the friction law at reversals is uncertain.
_NEAR_TURN = 0.05
_CHANCE = 0.05  # that contrasts of branches scatter so much less than rows of the same noise
_SMOOTHED = 0.85  # correlation of neighbours that no reading of a loop has


def usable_rows(measurement: Measurement) -> BoolArray:
    """Rows of a loop whose stage is loaded and away from reversals, where friction changes sign."""
    torque, friction = measurement["torque_nm"], shown_friction(measurement)
    peak = float(np.max(np.abs(torque)))
    transmitted = transmitted_torque(torque, friction, 0.0, preceding_sign(measurement))
    near = torque_since_reversal(torque, load_direction(torque)) < _NEAR_TURN * peak
    return (np.abs(transmitted) >= NEAR_ZERO * peak + FRICTION_MARGIN * friction) & ~near


def load_direction(torque: FloatArray) -> FloatArray:
    """Sign of the change of torque that leads to each row, 0 at the first; in the shape of ``torque``."""
    return np.asarray(np.sign(np.diff(torque, prepend=torque[0])))


def torque_since_reversal(torque: FloatArray, direction: FloatArray) -> FloatArray:
    """Torque passed since the ``direction`` of the load last changed its sign, infinite before; in their shape."""
    reversal = np.full(torque.size, np.inf)
    for i in range(1, torque.size):
        back = direction[i] * direction[i - 1] < 0.0
        reversal[i] = torque[i - 1] if back else reversal[i - 1]
    passed: FloatArray = np.abs(torque - reversal)
    return passed


def shown_friction(measurement: Measurement) -> float:
    """Friction torque: half the torque between the branches in the middle of the angles; 0 for one branch."""
    torque, angle = measurement["torque_nm"], measurement["angle_arcmin"]
    # Without torque either flank may touch: such a row is on the one of the branch before.
    direction = np.where(np.abs(torque) > UNLOADED_SHARE * np.max(np.abs(torque)), load_direction(torque), 0.0)
    low, high = np.quantile(angle, _RANGE)
    at = 0.5 * (low + high) + 0.5 * (high - low) * np.linspace(-_MIDDLE, _MIDDLE, _ANGLES)
    up, down = (_torque_at(at, torque[direction == sign], angle[direction == sign]) for sign in (1.0, -1.0))
    between = up - down
    known = np.isfinite(between)
    return max(0.5 * float(np.median(between[known])), 0.0) if np.any(known) else 0.0


def _torque_at(at: FloatArray, torque: FloatArray, angle: FloatArray) -> FloatArray:
    """Torque of a branch at some angles, linear between rows: across play, too; NaN beyond the branch."""
    if torque.size < 2:
        return np.full(at.size, np.nan)
    order = np.argsort(angle, kind="stable")
    return np.asarray(np.interp(at, angle[order], torque[order], left=np.nan, right=np.nan))


def path_error_share(reducer: AsBuiltReducer) -> float:
    """Share of the whole twist of a loop by which the model may err along its path; 0 for metal."""
    return tuned.LOOP_PATH[quality_of(reducer.quality, reducer.case.disc_material.youngs_modulus)]


def loop_noise(reducer: AsBuiltReducer, residual: FloatArray, rows: IntArray, measurement: Measurement) -> Noise:
    """Noise of the ``residual`` at ``rows`` of a loop, both shape (rows,), in the unit of the column."""
    if path_error_share(reducer):
        # What varies slowly along the branches is the error of their path, not of the reading.
        return local_noise(residual, rows, measurement.stated_noise)
    scatter = residual, rows
    contrasts = contrasts_of_branches(residual, rows, measurement["torque_nm"])
    # Effects that follow the torque alone vanish in contrasts; play and creep are larger there than in the rows.
    if contrasts is not None and _scatters_less(contrasts, scatter):
        scatter = contrasts
    noise = estimate_noise(*scatter, stated=measurement.stated_noise)
    if noise.rho > _SMOOTHED:
        # Averaged and smoothed: what varies slowly along the branches is the reducer, not the reading.
        return local_noise(residual, rows, measurement.stated_noise)
    return noise


def _scatters_less(one: tuple[FloatArray, IntArray], other: tuple[FloatArray, IntArray]) -> bool:
    """Whether rows, with their numbers, scatter less than others by more than chance (F test)."""
    from scipy.special import fdtrc

    (small, few), (large, many) = scatter_about_cubics(*one), scatter_about_cubics(*other)
    if min(few, many) == 0 or small == 0.0:
        return False
    return bool(fdtrc(many, few, large / small) < _CHANCE)
