"""Twist in series with the stage that is not proportional to its torque, and friction that gives way smoothly.

Both are small frozen laws of the torque over a whole path of load (docs/theory.md, "Loops of real reducers").
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray

# Thresholds of slip that stand for an even spread. A step between two of them is 1/16 of the spread.
_SLIDERS = 32


class SeriesTwist(Protocol):
    """Twist of parts that carry the torque of the stage; both methods keep the shape of ``torque`` [N·mm → rad]."""

    def settled(self, torque: FloatArray) -> FloatArray:
        """Twist after a long time under each torque."""
        ...

    def along(self, torque: FloatArray, applied: FloatArray) -> FloatArray:
        """Twist under torques one after the other, from rest, while the torque ``applied`` to the output changes."""
        ...


@dataclass(frozen=True, slots=True)
class PowerTwist:
    """Twist that grows with a power of the torque, ``twist`` [rad] at ``rated`` torque [N·mm]."""

    twist: float
    exponent: float
    rated: float

    def settled(self, torque: FloatArray) -> FloatArray:
        return np.asarray(self.twist * np.sign(torque) * np.abs(torque / self.rated) ** self.exponent)

    def along(self, torque: FloatArray, applied: FloatArray) -> FloatArray:
        del applied  # it keeps no memory
        return self.settled(torque)


@dataclass(frozen=True, slots=True)
class CreepTwist:
    """Twist of a Kelvin–Voigt element: ``twist`` [rad] at ``rated`` torque [N·mm] once it has come to rest.

    A ramp of steady speed takes a time in proportion to the change of the torque applied. So the change is the clock:
    after ``relaxation`` [N·mm] of it the difference has fallen to 1/e.
    """

    twist: float
    relaxation: float
    rated: float

    def settled(self, torque: FloatArray) -> FloatArray:
        return np.asarray(self.twist * torque / self.rated)

    def along(self, torque: FloatArray, applied: FloatArray) -> FloatArray:
        rest = self.settled(torque)
        passed = np.abs(np.diff(applied, prepend=0.0)) / self.relaxation
        # Exact for a torque that is linear between two points.
        kept = np.exp(-passed)
        share = np.where(passed > 1e-8, -np.expm1(-passed) / np.where(passed > 0.0, passed, 1.0), 1.0 - 0.5 * passed)
        before = np.concatenate([[0.0], rest[:-1]])
        found, now = np.empty_like(rest), 0.0
        for i, keep in enumerate(kept):
            now = keep * now + rest[i] - keep * before[i] - share[i] * (rest[i] - before[i])
            found[i] = now
        return found


def transmitted_torque(
    torque: FloatArray,
    coulomb: float,
    proportional: float,
    before: float = -1.0,
    spread: float = 0.0,
    breakaway: tuple[float, float] = (0.0, 0.0),
) -> FloatArray:
    """Torque that friction transmits to the stage, for torques applied one after the other [N·mm].

    A play operator: the stage follows when the difference exceeds coulomb + proportional·|torque| [N·mm]. With a
    ``spread`` [N·mm] it is the mean of many, their Coulomb friction spread evenly over coulomb ± spread (Iwan).
    ``breakaway``, friction added after each reversal, negative where friction builds up, and the change of the torque
    on the stage in which that falls to 1/e [N·mm]. ``before``, the sign of the preceding torque.
    """
    at = (np.arange(_SLIDERS) + 0.5) * (2.0 / _SLIDERS) - 1.0
    slips = np.maximum(coulomb + spread * at, 0.0) if spread else np.array([coulomb])
    added, travel = breakaway

    def follow(slip: float) -> FloatArray:
        if added == 0.0:
            return _play(torque, slip, proportional, before)
        return _play_with_breakaway(torque, slip, proportional, before, max(added, -slip), travel)

    return np.asarray(np.mean([follow(float(slip)) for slip in slips], axis=0))


def _play(torque: FloatArray, slip: float, proportional: float, before: float) -> FloatArray:
    transmitted = np.empty_like(torque)
    now = math.copysign(slip, before)
    for i, T in enumerate(torque):
        band = slip + proportional * abs(T)
        now = min(max(now, T - band), T + band)
        transmitted[i] = now
    return transmitted


def _play_with_breakaway(
    torque: FloatArray, slip: float, proportional: float, before: float, added: float, travel: float
) -> FloatArray:
    """Play whose band is wider by added·e^{−s/travel}, s the torque since the last reversal of slip (Eq. 129)."""
    # Imported here: few reducers have such friction.
    from scipy.special import lambertw

    transmitted = np.empty_like(torque)
    # After a steady motion that ends at zero torque.
    now, direction, excess = math.copysign(slip, before), -math.copysign(1.0, before), 0.0
    for i, T in enumerate(torque):
        towards = math.copysign(1.0, T - now)
        left = added if towards != direction else excess
        beyond = abs(T - now) - slip - proportional * abs(T)
        if beyond > left:
            # The step u of the stage solves u + left·e^{−u/travel} = beyond; the other root is negative.
            u = beyond + travel * float(lambertw(-left / travel * math.exp(-beyond / travel)).real)
            now, direction, excess = now + towards * u, towards, left * math.exp(-u / travel)
        transmitted[i] = now
    return transmitted
