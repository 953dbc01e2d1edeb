"""Normal removals that differ from lobe to lobe, each with its two derivatives by phase.

The angle along the disc is t = ψ/z_c, from the root of lobe 0, against the polar angle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.geometry import RemovalDerivatives, Trochoid

# A removal that must jump between lobes jumps over this phase to either side, at the tip unless said otherwise: there
# no pin presses.
BLEND = 0.5  # rad
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


class AngleDerivatives(NamedTuple):
    """An angle along the disc, 0 at the root of lobe 0 and 2π after a turn [rad], with two derivatives by phase."""

    value: FloatArray
    first: FloatArray
    second: FloatArray


class AngleAlongDisc(Protocol):
    """An angle by which waves are evenly spaced."""

    def derivatives(self, phase: FloatArray, trochoid: Trochoid) -> AngleDerivatives:
        """Angle and derivatives, in the shape of ``phase`` [rad]."""
        ...


@dataclass(frozen=True, slots=True)
class GeneratingAngle:
    """t = ψ/z_c, the rotation of generation."""

    def derivatives(self, phase: FloatArray, trochoid: Trochoid) -> AngleDerivatives:
        """Angle and derivatives, in the shape of ``phase`` [rad]."""
        rate = 1.0 / trochoid.lobes
        return AngleDerivatives(rate * phase, np.full_like(phase, rate), np.zeros_like(phase))


@dataclass(frozen=True, slots=True)
class PolarAngle:
    """t = −arg P, clockwise, of the ground point P = C − r n with the generating ``radius`` r [mm] (Eq. 125)."""

    radius: float

    def derivatives(self, phase: FloatArray, trochoid: Trochoid) -> AngleDerivatives:
        """Angle and derivatives, in the shape of ``phase`` [rad]."""
        path = trochoid.derivatives(phase)
        point = path.centre - self.radius * path.normal
        along, along_rate = _tooth_speed(phase, trochoid, self.radius)
        by_phase = -1j * along * path.normal / point
        second = (path.turn * along - 1j * along_rate) * path.normal / point - by_phase**2
        # Turned back by ψ/z_c the point stays near the real axis, where its argument does not jump.
        turned = phase / trochoid.lobes
        return AngleDerivatives(turned - np.angle(point * np.exp(1j * turned)), -by_phase.imag, -second.imag)


@dataclass(frozen=True, slots=True)
class ArcLength:
    """t = 2π s/L, s the length along the tooth curve of generating ``radius`` r [mm], L that of a turn (Eq. 126)."""

    radius: float

    def derivatives(self, phase: FloatArray, trochoid: Trochoid) -> AngleDerivatives:
        """Angle and derivatives, in the shape of ``phase`` [rad]."""
        # Imported here: few effects need it.
        from scipy.special import ellipe, ellipeinc

        K1, z_c = trochoid.short_width_ratio, trochoid.lobes
        lobe = np.round(phase / (2.0 * math.pi))
        psi = phase - 2.0 * math.pi * lobe
        modulus = 4.0 * K1 / (1.0 + K1) ** 2
        scale = 2.0 * (1.0 + K1) * trochoid.pin_circle_radius / z_c
        of_path = scale * (ellipe(modulus) - ellipeinc(0.5 * (math.pi - psi), modulus))
        # The parallel curve is shorter by r times the turn of the normal.
        turn = np.arctan2(K1 * np.sin(psi), 1.0 - K1 * np.cos(psi)) - psi / z_c
        of_lobe = 2.0 * scale * float(ellipe(modulus)) - 2.0 * math.pi * self.radius / z_c
        unit = 2.0 * math.pi / (z_c * of_lobe)
        along, along_rate = _tooth_speed(phase, trochoid, self.radius)
        length = of_path + self.radius * turn + of_lobe * lobe
        return AngleDerivatives(unit * length, unit * along, unit * along_rate)


def _tooth_speed(phase: FloatArray, trochoid: Trochoid, radius: float) -> tuple[FloatArray, FloatArray]:
    """g = |dP/dψ| of the parallel curve of ``radius`` [mm/rad] and dg/dψ (Eq. 4)."""
    path = trochoid.derivatives(phase)
    c = trochoid.pin_circle_radius / trochoid.lobes
    return c * path.speed + radius * path.turn, c * path.speed_rate + radius * path.turn_rate


GENERATING_ANGLE = GeneratingAngle()


@dataclass(frozen=True, slots=True)
class Wave(_WholeDisc):
    """h = A cos(n t − φ): ``amount`` A [mm], ``waves`` n round the disc, ``angle`` φ [rad], even in the angle t ``by``.

    ``point_spacing`` for waves so short that a pin can have feet on several of them.
    """

    amount: float
    waves: float
    angle: float
    point_spacing: float | None = None
    by: AngleAlongDisc = GENERATING_ANGLE

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        if self.waves % 1.0:
            return self._fractional_wave(phase, trochoid)
        return self._wave(self.by.derivatives(phase, trochoid))

    def _wave(self, t: AngleDerivatives) -> RemovalDerivatives:
        turned, rate = self.waves * t.value - self.angle, self.waves * t.first
        cos, sin = self.amount * np.cos(turned), self.amount * np.sin(turned)
        return RemovalDerivatives(cos, -rate * sin, -rate * rate * cos - self.waves * t.second * sin)

    def _fractional_wave(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        """A non-integer number of waves: the last wave passes into the first round the tip before lobe 0."""
        period = trochoid.phase_period
        x = np.mod(phase + math.pi + 0.5 * period, period) - 0.5 * period
        t = self.by.derivatives(x - math.pi, trochoid)
        first, last = self._wave(t), self._wave(t._replace(value=t.value + 2.0 * math.pi))
        s, ds, dds = _smooth_step(x / BLEND)
        ds, dds = ds / BLEND, dds / BLEND**2
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
    """h falls from 0 to −``amount`` [mm] along the disc from the phase ``start`` on, and jumps back there.

    The jump is blended over ``blend`` to either side [rad]; ``point_spacing`` where that is steep.
    """

    amount: float
    start: float
    blend: float = BLEND
    point_spacing: float | None = None

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        period = trochoid.phase_period
        # x from −period/2 to period/2, 0 at the start.
        x = np.mod(phase - self.start + 0.5 * period, period) - 0.5 * period
        step, step1, step2 = _smooth_step(x / self.blend)
        return RemovalDerivatives(
            -self.amount * (x / period + 1.0 - step),
            -self.amount * (1.0 / period - step1 / self.blend),
            self.amount * step2 / self.blend**2,
        )


@dataclass(frozen=True, slots=True)
class OneLobe(_WholeDisc):
    """Removes ``amount`` [mm] from both flanks of lobe ``lobe``, blended within ``blend`` of its tips [rad].

    ``point_spacing`` where the blend is steep.
    """

    amount: float
    lobe: int
    blend: float = BLEND
    point_spacing: float | None = None

    def _jet(self, phase: FloatArray, trochoid: Trochoid) -> RemovalDerivatives:
        period = trochoid.phase_period
        x = np.mod(phase - 2.0 * math.pi * self.lobe + 0.5 * period, period) - 0.5 * period
        # Counted from the tip, so that both ends are one formula.
        from_tip = math.pi - np.abs(x)
        rise, rise1, rise2 = _smooth_step(from_tip / self.blend)
        return RemovalDerivatives(
            self.amount * rise,
            -np.sign(x) * self.amount * rise1 / self.blend,
            self.amount * rise2 / self.blend**2,
        )


def _smooth_step(x: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """From 0 below −1 to 1 above 1 with two continuous derivatives; the value and both of them."""
    u = np.clip(0.5 * (x + 1.0), 0.0, 1.0)
    return (
        u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        0.5 * 30.0 * u * u * (1.0 - u) ** 2,
        0.25 * 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u),
    )
