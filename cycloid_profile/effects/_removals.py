"""Normal removals that differ from lobe to lobe, each with its two derivatives by phase.

The angle along the disc is t = ψ/z_c, from the root of lobe 0, against the polar angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry import RemovalDerivatives, Trochoid

# A removal that must jump between lobes jumps near the tip, where no pin presses.
_TRANSITION_HALF_WIDTH = 0.5  # rad to either side
# A removal of one flank ends within twice this from root and tip. The first loaded pin of an RV-40E with 5 µm of
# clearance is 0.31 rad from the root; wider ends would reduce its removal.
_FLANK_END_HALF_WIDTH = 0.15  # rad


class _WholeDisc:
    """A smooth removal given by a formula over the whole disc, equal on both sides of a lobe."""

    whole_disc: ClassVar[bool] = True
    corners: ClassVar[tuple[float, ...]] = ()
    point_spacing: float | None = None

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        del side
        return self._jet(phase, trochoid)

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        raise NotImplementedError


@dataclass(frozen=True, slots=True)
class Wave(_WholeDisc):
    """h = A cos(n t − φ): ``amount`` A [mm], ``waves`` n round the disc, ``angle`` φ [rad].

    ``point_spacing`` for waves so short that a pin can have feet on several of them.
    """

    amount: float
    waves: float
    angle: float
    point_spacing: float | None = None

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        return self._fractional_wave(phase, trochoid) if self.waves % 1.0 else self._wave(phase, trochoid)

    def _wave(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        rate = self.waves / trochoid.lobes
        turned = rate * phase - self.angle
        cos, sin = self.amount * np.cos(turned), self.amount * np.sin(turned)
        return RemovalDerivatives(cos, -rate * sin, -rate * rate * cos)

    def _fractional_wave(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """A non-integer number of waves: the last wave passes into the first round the tip before lobe 0."""
        period = trochoid.phase_period
        x = np.mod(phase + math.pi + 0.5 * period, period) - 0.5 * period
        first, last = self._wave(x - math.pi, trochoid), self._wave(x - math.pi + period, trochoid)
        s, ds, dds = _smooth_step(x / _TRANSITION_HALF_WIDTH)
        ds, dds = ds / _TRANSITION_HALF_WIDTH, dds / _TRANSITION_HALF_WIDTH**2
        step, step1, step2 = first.value - last.value, first.first - last.first, first.second - last.second
        return RemovalDerivatives(
            last.value + s * step,
            last.first + s * step1 + ds * step,
            last.second + s * step2 + 2.0 * ds * step1 + dds * step,
        )


@dataclass(frozen=True, slots=True)
class ToothForm:
    """h = A cos(n ψ − φ) on every lobe; on one ``flank`` (±1) alone, or on both with 0.

    ``amount`` A [mm], ``waves`` n from root to root, ``angle`` φ [rad]; ``point_spacing`` as in ``Wave``.
    """

    amount: float
    waves: int
    angle: float
    flank: int = 0
    point_spacing: float | None = None
    whole_disc: ClassVar[bool] = False
    corners: ClassVar[tuple[float, ...]] = ()

    def derivatives(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """Removal and derivatives, in the shape of ``phase``; independent of ``side`` and ``trochoid``."""
        del side, trochoid
        turned = self.waves * phase - self.angle
        cos, sin = self.amount * np.cos(turned), self.amount * np.sin(turned)
        wave = RemovalDerivatives(cos, -self.waves * sin, -self.waves * self.waves * cos)
        return wave if self.flank == 0 else _product(wave, self._share(phase))

    def _share(self, phase: FloatArray) -> RemovalDerivatives:
        """1 on the flank and 0 on the other, smooth at its root and tip."""
        x = self.flank * (np.mod(phase + math.pi, 2.0 * math.pi) - math.pi)
        w = _FLANK_END_HALF_WIDTH
        at_root = np.abs(x) < 0.5 * math.pi
        from_end = np.where(at_root, x, math.pi - x)
        s, ds, dds = _smooth_step(from_end / w - 1.0)
        rising = np.where(at_root, self.flank, -self.flank)
        return RemovalDerivatives(*(np.where(x > 0.0, one, 0.0) for one in (s, rising * ds / w, dds / w**2)))


def _product(a: RemovalDerivatives, b: RemovalDerivatives) -> RemovalDerivatives:
    return RemovalDerivatives(
        a.value * b.value,
        a.first * b.value + a.value * b.first,
        a.second * b.value + 2.0 * a.first * b.first + a.value * b.second,
    )


@dataclass(frozen=True, slots=True)
class Shift(_WholeDisc):
    """h = −A cos(θ_n − φ): the whole tooth moved by A towards φ; θ_n is the direction of the normal."""

    amount: float
    angle: float

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        path = trochoid.derivatives(phase)
        # d(n̄)/dψ = −i θ' n̄.
        n = -self.amount * np.conj(path.normal) * np.exp(1j * self.angle)
        first = -1j * path.turn * n
        second = -1j * path.turn_rate * n - path.turn**2 * n
        return RemovalDerivatives(n.real, first.real, second.real)


@dataclass(frozen=True, slots=True)
class PitchDeviationWave(_WholeDisc):
    """h = A sinψ S cos(n t − φ): each lobe rotated about the disc's centre, sinusoidally round the disc."""

    amount: float
    waves: float
    angle: float

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        wave = Wave(self.amount, self.waves, self.angle)._jet(phase, trochoid)
        l0, l1, l2 = trochoid.lever_jet(phase)
        return RemovalDerivatives(
            l0 * wave.value,
            l1 * wave.value + l0 * wave.first,
            l2 * wave.value + 2.0 * l1 * wave.first + l0 * wave.second,
        )


@dataclass(frozen=True, slots=True)
class Ramp(_WholeDisc):
    """h falls from 0 to −``amount`` [mm] along the disc from lobe ``first`` on, and jumps back at its tip."""

    amount: float
    first: int

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        period = trochoid.phase_period
        # x from −period/2 to period/2, 0 at the tip before the first lobe.
        x = np.mod(phase - (2.0 * self.first - 1.0) * math.pi + 0.5 * period, period) - 0.5 * period
        step, step1, step2 = _smooth_step(x / _TRANSITION_HALF_WIDTH)
        return RemovalDerivatives(
            -self.amount * (x / period + 1.0 - step),
            -self.amount * (1.0 / period - step1 / _TRANSITION_HALF_WIDTH),
            self.amount * step2 / _TRANSITION_HALF_WIDTH**2,
        )


@dataclass(frozen=True, slots=True)
class OneLobe(_WholeDisc):
    """Removes ``amount`` [mm] from both flanks of lobe ``lobe``."""

    amount: float
    lobe: int

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        period = trochoid.phase_period
        x = np.mod(phase - 2.0 * math.pi * self.lobe + 0.5 * period, period) - 0.5 * period
        # Counted from the tip, so that both ends are one formula.
        from_tip = math.pi - np.abs(x)
        rise, rise1, rise2 = _smooth_step(from_tip / _TRANSITION_HALF_WIDTH)
        return RemovalDerivatives(
            self.amount * rise,
            -np.sign(x) * self.amount * rise1 / _TRANSITION_HALF_WIDTH,
            self.amount * rise2 / _TRANSITION_HALF_WIDTH**2,
        )


def _smooth_step(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """From 0 below −1 to 1 above 1 with two continuous derivatives; the value and both of them."""
    u = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return (
        u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        0.5 * 30.0 * u * u * (1.0 - u) ** 2,
        0.25 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )
