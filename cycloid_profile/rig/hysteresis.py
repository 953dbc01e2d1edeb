"""Torque and twist at one place of the output, up and down: the hysteresis loop (docs/rig.md, "Hysteresis loop").

Static. Friction keeps part of the torque from the stage: a band about the torque applied, within which the
stage's own torque stays where it was.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built

POINTS = 400
# Share of the rated torque below which the stage floats in its backlash: it rests where it touched last.
_AFLOAT = 1e-4


@dataclass(frozen=True, slots=True)
class Loop:
    """A hysteresis loop: 0 → +T → −T → +T.

    ``torque`` applied to the output [N·mm], ``angle`` read [rad] and ``stage_torque`` left after friction [N·mm],
    shape (points,); ``output_angle``, where the output stands [rad].
    """

    built: Built
    output_angle: float
    torque: FloatArray
    stage_torque: FloatArray
    angle: FloatArray


def torque_path(peak: float, points: int = POINTS) -> FloatArray:
    """0 → +peak → −peak → +peak, closer about zero where the flanks change, shape (about points,) [N·mm]."""
    quarter = max(points // 5, 2)
    u = (
        np.concatenate([np.arange(quarter), np.arange(quarter, -quarter, -1), np.arange(-quarter, quarter + 1)])
        / quarter
    )
    path: FloatArray = peak * u * (0.1 + 0.9 * np.abs(u))
    return path


def hysteresis_loop(
    built: Built, peak: float | None = None, points: int = POINTS, output_angle: float = 0.0, before: float = -1.0
) -> Loop:
    """The loop up to ``peak`` torque, rated unless given [N·mm], with the output at ``output_angle`` [rad].

    ``before`` is the sign of the torque that went before: it says where in its backlash the stage starts.
    """
    T = torque_path(abs(built.case.torque) if peak is None else peak, points)
    left = stage_torque(T, built.coulomb_torque, built.proportional_friction, before)
    crank = -output_angle * built.case.drive.trochoid.lobes
    least = _AFLOAT * abs(built.case.torque)
    # Afloat, the side of the last touch holds.
    afloat = np.abs(left) < least
    side = np.sign(left)
    for i in np.flatnonzero(afloat):
        side[i] = side[i - 1] if i else math.copysign(1.0, before)
    pressed = np.where(afloat, side * least, left)
    stage = StageEquilibrium(as_built=built.parts)
    solved = stage.at(built.case, crank, pressed)
    angle = np.where(solved.settled, solved.rotation, np.nan)
    read = (built.encoder * np.exp(-1j * output_angle)).real
    return Loop(built, output_angle, T, left, angle + built.series_compliance * left + read)


def stage_torque(torque: FloatArray, coulomb: float, proportional: float, before: float = -1.0) -> FloatArray:
    """Torque that friction leaves the stage, for torques applied one after the other [N·mm].

    A play operator: the stage follows when the difference exceeds coulomb + proportional·|torque| [N·mm].
    """
    left = np.empty_like(torque)
    now = math.copysign(coulomb, before)
    for i, T in enumerate(torque):
        band = coulomb + proportional * abs(T)
        now = min(max(now, T - band), T + band)
        left[i] = now
    return left
