"""Torque that friction leaves the stage, for torques applied one after the other."""

from __future__ import annotations

import numpy as np

Array = np.ndarray
_WIDE = 0.03  # of the peak: how much torque a reversal of the softer forms takes more
_PARTS = 9


def left_over(torque: Array, coulomb: float, proportional: float, form: str) -> Array:
    """Torque of the stage under friction of coulomb + proportional·|torque|, all in one unit.

    "coulomb": a play; "smooth": plays of several widths side by side, of the same mean; "elastoslide": friction that
    grows over some of the torque before it slides. The torque before the first was of the other sign.
    """
    limit = coulomb + proportional * np.abs(torque)
    before = -coulomb if torque[min(1, torque.size - 1)] >= 0.0 else coulomb
    wide = _WIDE * float(np.max(np.abs(torque)))
    if coulomb == 0.0 and proportional == 0.0:
        return torque.copy()
    if form == "coulomb":
        return _play(torque, limit, before)
    if form == "smooth":
        shares = (np.arange(_PARTS) + 0.5) / _PARTS * 2.0 - 1.0
        widths = [np.maximum(limit + np.minimum(limit, 0.5 * wide) * share, 0.0) for share in shares]
        return np.mean([_play(torque, width, before) for width in widths], axis=0)
    if form == "elastoslide":
        return _sliding(torque, limit, before, 2.0 * limit / (2.0 * limit + wide))
    raise ValueError(f"friction of form '{form}' is not known; choose coulomb, smooth or elastoslide")


def _play(torque: Array, limit: Array, before: float) -> Array:
    left, now = np.empty_like(torque), before
    for i, (applied, band) in enumerate(zip(torque, limit, strict=True)):
        now = min(max(now, applied - band), applied + band)
        left[i] = now
    return left


def _sliding(torque: Array, limit: Array, before: float, grip: Array) -> Array:
    """Friction takes the share ``grip`` of each step of torque until it slides."""
    left, friction = np.empty_like(torque), -before
    friction = float(np.clip(friction, -limit[0], limit[0]))
    for i, applied in enumerate(torque):
        step = applied - torque[i - 1] if i else 0.0
        friction = min(max(friction + grip[i] * step, -limit[i]), limit[i])
        left[i] = applied - friction
    return left
