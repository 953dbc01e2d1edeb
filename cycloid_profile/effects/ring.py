"""Errors of the pin ring: fixed in the housing, they excite multiples of z_c per turn of the output."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.effects.base import (
    LARGEST_UM,
    Effect,
    EffectLocation,
    angle_field,
    part_field,
    part_indices,
    size_field,
)
from cycloid_profile.effects.reducer import AsBuiltReducer
from cycloid_profile.units import DEGREE, UM


class _OnRing(Effect):
    location = EffectLocation.RING

    def apply(self, reducer: AsBuiltReducer) -> AsBuiltReducer:
        pins = reducer.case.drive.trochoid.pins
        pin_angle = 2.0 * np.pi * np.arange(pins) / pins
        return replace(
            reducer,
            pin_shift=reducer.pin_shift + self._shift(pin_angle),
            pin_oversize=reducer.pin_oversize + self._oversize(pin_angle),
        )

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        """Displacement of the pins at the polar angles ``pin_angle`` [rad], shape (pins,) [mm]."""
        return np.zeros(pin_angle.shape, dtype=np.complex128)

    def _oversize(self, pin_angle: FloatArray) -> FloatArray:
        """Radius of the pins at ``pin_angle`` [rad] above the drawing, shape (pins,) [mm]."""
        return np.zeros(pin_angle.shape)


@dataclass(frozen=True)
class PinRadiusError(_OnRing):
    """All pins thicker than drawn by the amount in radius. Gap: −amount."""

    remedy = "another size class of pins"
    amount_um: float = size_field("radius above the drawing [µm]", 1.0, -LARGEST_UM, LARGEST_UM)

    def _oversize(self, pin_angle: FloatArray) -> FloatArray:
        return np.full(pin_angle.shape, self.amount_um * UM)


@dataclass(frozen=True)
class PinCircleRadiusError(_OnRing):
    """Pin circle larger than drawn by the amount. Gap: amount times the radial part of the normal."""

    remedy = "match the discs' radial-moving amount to the ring, or regrind the pin bores"
    amount_um: float = size_field("pin circle above the drawing, in radius [µm]", 3.0, -LARGEST_UM, LARGEST_UM)

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        return np.asarray(self.amount_um * UM * np.exp(1j * pin_angle))


@dataclass(frozen=True)
class PinRingRunout(_OnRing):
    """Pin ring off the axis of the main bearings by A towards φ."""

    remedy = "bore ring and bearing seats in one clamping"
    amplitude_um: float = size_field("offset [µm]", 5.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("direction of the offset [°]")

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        return np.full(pin_angle.shape, self.amplitude_um * UM * np.exp(1j * self.phase_deg * DEGREE))


class _GroundForm(_OnRing):
    """Pin bores out of round as ground: radial displacement A cos(k(α − φ)), k = ``harmonic``."""

    amplitude_um: float
    phase_deg: float

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        radial = self.amplitude_um * UM * np.cos(self.harmonic * (pin_angle - self.phase_deg * DEGREE))
        return np.asarray(radial * np.exp(1j * pin_angle))


@dataclass(frozen=True)
class PinRingOval(_GroundForm):
    """Pin ring oval: radial displacement A cos(2(α − φ))."""

    remedy = "clamp the housing without bending it"
    harmonic = 2
    amplitude_um: float = size_field("amplitude in radius [µm]", 3.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("angle of a wide place [°]")


@dataclass(frozen=True)
class PinRingThreeLobed(_GroundForm):
    """Pin ring with three lobes: radial displacement A cos(3(α − φ))."""

    remedy = "clamp the housing on its face instead of in three jaws"
    harmonic = 3
    amplitude_um: float = size_field("amplitude in radius [µm]", 3.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("angle of a wide place [°]")


@dataclass(frozen=True)
class RingMountingOvality(_OnRing):
    """Ring bent by its fit or its bolts: radial A cos(kα − φ), tangential −(A/k) sin(kα − φ), k waves.

    Bending leaves the length of the ring unchanged, u_r + du_θ/dα = 0, so that the pins also move along the circle;
    those of a ring ground oval do not. One wave moves the ring as a whole, as ``pin_ring_runout`` does.
    """

    remedy = "tighten the bolts crosswise and evenly, ease the fit"
    amplitude_um: float = size_field("amplitude in radius [µm]", 3.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("phase of the wave at pin 1, k times the angle of a wide place [°]")
    waves: int = part_field("waves round the ring: 2 of a fit, n of n bolts", 2, most=20)

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        wave = self.amplitude_um * UM * np.exp(1j * (self.waves * pin_angle - self.phase_deg * DEGREE))
        return np.asarray((wave.real - 1j * wave.imag / self.waves) * np.exp(1j * pin_angle))


@dataclass(frozen=True)
class PinRingCumulativePitch(_OnRing):
    """Indexing error of the pin bores: tangential displacement A sin(α − φ)."""

    remedy = "correct the index table"
    amplitude_um: float = size_field("amplitude along the circle [µm]", 4.0, 0.0, LARGEST_UM)
    phase_deg: float = angle_field("angle where it passes zero [°]")

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        along = self.amplitude_um * UM * np.sin(pin_angle - self.phase_deg * DEGREE)
        return np.asarray(1j * along * np.exp(1j * pin_angle))


@dataclass(frozen=True)
class SinglePinError(_OnRing):
    """One pin thicker or thinner than the others."""

    remedy = "change the pin"
    amount_um: float = size_field("radius above the others [µm]", 1.0, -LARGEST_UM, LARGEST_UM)
    pin: int = part_field("number of the pin, 1 at angle 0, counted anticlockwise", 1)

    def _oversize(self, pin_angle: FloatArray) -> FloatArray:
        (pin,) = part_indices(self, "pin", self.pin, pin_angle.size)
        return np.where(np.arange(pin_angle.size) == pin, self.amount_um * UM, 0.0)


@dataclass(frozen=True)
class PinPositionError(_OnRing):
    """One pin bore out of its place. Gap: the displacement along the normal.

    Where the pin carries, the disc cannot distinguish it from a pin of another radius, which diagnosis names instead.
    """

    remedy = "bore the ring in one set-up"
    amplitude_um: float = size_field("distance from its place [µm]", 2.0, 0.0, LARGEST_UM)
    direction_deg: float = angle_field("direction in the housing [°]")
    pin: int = part_field("number of the pin, 1 at angle 0, counted anticlockwise", 1)

    def _shift(self, pin_angle: FloatArray) -> ComplexArray:
        (pin,) = part_indices(self, "pin", self.pin, pin_angle.size)
        off = self.amplitude_um * UM * np.exp(1j * self.direction_deg * DEGREE)
        return np.where(np.arange(pin_angle.size) == pin, off, 0.0 + 0.0j)
