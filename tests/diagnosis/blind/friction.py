"""Torque that friction leaves the stage, for torques applied one after the other."""

from __future__ import annotations

import numpy as np

Array = np.ndarray
FORMS = ("coulomb", "smooth", "elastoslide", "stribeck")
_WIDE = 0.03  # of the peak: how much torque a reversal of the softer forms takes more
_PARTS = 9
# Sliding speed over the path from a reversal, breakaway over sliding friction, speeds of breakaway and of the film.
_RAMP, _BREAKAWAY, _SLOW, _FILM = 0.15, 0.15, 0.2, 0.05


def left_over(torque: Array, coulomb: float, proportional: float, form: str) -> Array:
    """Torque of the stage under friction of coulomb + proportional·|torque|, all in one unit.

    "coulomb": a play; "smooth": plays of several widths side by side, of the same mean; "elastoslide": friction that
    grows over some of the torque before it slides, after Prandtl; "stribeck": a tanh of the sliding speed with a peak
    at low speed, the speed rising from each reversal and falling to the next. The torque before the first was of the
    other sign.
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
    if form == "stribeck":
        speed = _speed(torque)
        peak = 1.0 + _BREAKAWAY * np.exp(-((speed / _SLOW) ** 2))
        friction: Array = limit * peak * np.tanh(speed / _FILM)
        return torque - friction
    raise ValueError(f"friction of form '{form}' is not known; choose {', '.join(FORMS)}")


def _speed(torque: Array) -> Array:
    """Sliding speed with its sign, from 0 at each reversal of the torque to 1 far from all."""
    step = np.diff(torque, prepend=2.0 * torque[0] - torque[min(1, torque.size - 1)])
    turns = torque[np.flatnonzero(np.diff(np.sign(step)) != 0.0)]
    wide = _RAMP * float(np.max(np.abs(torque)))
    away = np.min(np.abs(torque[:, None] - turns), axis=1, initial=np.inf)
    return np.sign(step) * -np.expm1(-away / wide)


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
