"""Normal removals that are not the same on every lobe, each with its two derivatives by phase.

The angle along the disc is t = ψ/z_c, from the root of lobe 0, against the polar angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry.removal import RemovalJet
from cycloid_profile.geometry.trochoid import Trochoid

# Where a removal must jump between lobes it does so round the tip, which no pin presses on.
_JUMP = 0.5  # rad to either side


class _WholeDisc:
    """Removals that run once round the disc, smooth, given by a formula."""

    whole_disc: ClassVar[bool] = True
    corners: ClassVar[tuple[float, ...]] = ()


@dataclass(frozen=True, slots=True)
class Wave(_WholeDisc):
    """h = A cos(n t − φ): ``amount`` A [mm], ``waves`` n round the disc, ``angle`` φ [rad].

    ``spacing`` for waves so short that a pin can have feet on several of them.
    """

    amount: float
    waves: float
    angle: float
    spacing: float | None = None

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        del side
        if self.waves % 1.0:
            return self._uneven(phase, trochoid)
        return self._wave(phase, trochoid)

    def _wave(self, phase: FloatArray, trochoid: Trochoid) -> RemovalJet:
        rate = self.waves / trochoid.lobes
        turned = rate * phase - self.angle
        cos, sin = self.amount * np.cos(turned), self.amount * np.sin(turned)
        return RemovalJet(cos, -rate * sin, -rate * rate * cos)

    def _uneven(self, phase: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """A number that does not come out even: the last wave gives way to the first round the tip before lobe 0."""
        period = trochoid.phase_period
        x = np.mod(phase + math.pi + 0.5 * period, period) - 0.5 * period
        first, last = self._wave(x - math.pi, trochoid), self._wave(x - math.pi + period, trochoid)
        s, ds, dds = _smooth_step(x / _JUMP)
        ds, dds = ds / _JUMP, dds / _JUMP**2
        gap, gap1, gap2 = first.value - last.value, first.first - last.first, first.second - last.second
        return RemovalJet(
            last.value + s * gap,
            last.first + s * gap1 + ds * gap,
            last.second + s * gap2 + 2.0 * ds * gap1 + dds * gap,
        )


@dataclass(frozen=True, slots=True)
class Shift(_WholeDisc):
    """h = −A cos(θ_n − φ): the whole tooth moved by A towards φ; θ_n is the direction of the normal."""

    amount: float
    angle: float
    spacing: ClassVar[None] = None

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        del side
        path = trochoid.jet(phase)
        # d(n̄)/dψ = −i θ' n̄.
        n = -self.amount * np.conj(path.normal) * np.exp(1j * self.angle)
        first = -1j * path.turn * n
        second = -1j * path.turn_rate * n - path.turn**2 * n
        return RemovalJet(n.real, first.real, second.real)


@dataclass(frozen=True, slots=True)
class Index(_WholeDisc):
    """h = A sinψ S cos(n t − φ): lobes turned about the disc's centre, more here and less there."""

    amount: float
    waves: float
    angle: float
    spacing: ClassVar[None] = None

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        wave = Wave(self.amount, self.waves, self.angle).jet(phase, side, trochoid)
        l0, l1, l2 = trochoid.lever_jet(phase)
        return RemovalJet(
            l0 * wave.value,
            l1 * wave.value + l0 * wave.first,
            l2 * wave.value + 2.0 * l1 * wave.first + l0 * wave.second,
        )


@dataclass(frozen=True, slots=True)
class Ramp(_WholeDisc):
    """h falls from 0 to −``amount`` [mm] along the disc from lobe ``first`` on, and jumps back at its tip."""

    amount: float
    first: int
    spacing: ClassVar[None] = None

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        del side
        period = trochoid.phase_period
        # x from −period/2 to period/2, 0 at the tip before the first lobe.
        x = np.mod(phase - (2.0 * self.first - 1.0) * math.pi + 0.5 * period, period) - 0.5 * period
        step, step1, step2 = _smooth_step(x / _JUMP)
        return RemovalJet(
            -self.amount * (x / period + 1.0 - step),
            -self.amount * (1.0 / period - step1 / _JUMP),
            self.amount * step2 / _JUMP**2,
        )


@dataclass(frozen=True, slots=True)
class OneLobe(_WholeDisc):
    """h = ``amount`` [mm] on the flanks of lobe ``lobe``, nothing on the others."""

    amount: float
    lobe: int
    spacing: ClassVar[None] = None

    def jet(self, phase: FloatArray, side: FloatArray, trochoid: Trochoid) -> RemovalJet:
        """See ``NormalRemoval.jet``."""
        del side
        period = trochoid.phase_period
        x = np.mod(phase - 2.0 * math.pi * self.lobe + 0.5 * period, period) - 0.5 * period
        # Counted from the tip, so that both ends are one formula.
        from_tip = math.pi - np.abs(x)
        rise, rise1, rise2 = _smooth_step(from_tip / _JUMP)
        return RemovalJet(self.amount * rise, -np.sign(x) * self.amount * rise1 / _JUMP, self.amount * rise2 / _JUMP**2)


def _smooth_step(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """From 0 below −1 to 1 above 1 with two continuous derivatives; the value and both of them."""
    u = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return (
        u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        0.5 * 30.0 * u * u * (1.0 - u) ** 2,
        0.25 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )
