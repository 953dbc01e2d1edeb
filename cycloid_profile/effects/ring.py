"""Errors of the pin ring: they stand still in the housing and show at multiples of z_c per turn of the output."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.effect import Effect, Place, angle, chosen, part, size
from cycloid_profile.units import DEGREE, UM


class _OnRing(Effect):
    place: ClassVar[Place] = Place.RING

    def apply(self, built: Built) -> Built:
        """The reducer with this effect."""
        pins = built.case.drive.trochoid.pins
        where = 2.0 * np.pi * np.arange(pins) / pins
        return replace(
            built,
            pin_shift=built.pin_shift + self._shift(where),
            pin_oversize=built.pin_oversize + self._oversize(where),
        )

    def _shift(self, where: FloatArray) -> ComplexArray:
        """Displacement of the pins at the angles ``where`` [mm]."""
        return np.zeros(where.shape, dtype=np.complex128)

    def _oversize(self, where: FloatArray) -> FloatArray:
        """Radius of the pins above the drawing [mm]."""
        return np.zeros(where.shape)


@dataclass(frozen=True)
class PinRadiusError(_OnRing):
    """All pins thicker than drawn by the amount in radius. Gap: −amount. Cure: another size class of pins."""

    name: ClassVar[str] = "pin_radius_error"
    amount_um: float = size("radius above the drawing [µm]", 1.0, -100.0, 100.0)

    def _oversize(self, where: FloatArray) -> FloatArray:
        return np.full(where.shape, self.amount_um * UM)


@dataclass(frozen=True)
class PinCircleRadiusError(_OnRing):
    """Pin circle larger than drawn by the amount. Gap: amount times the radial part of the normal.

    Cure: match the discs' radial-moving amount to the ring, or regrind the pin bores.
    """

    name: ClassVar[str] = "pin_circle_radius_error"
    amount_um: float = size("pin circle above the drawing, in radius [µm]", 3.0, -200.0, 200.0)

    def _shift(self, where: FloatArray) -> ComplexArray:
        outwards: ComplexArray = self.amount_um * UM * np.exp(1j * where)
        return outwards


@dataclass(frozen=True)
class PinRingRunout(_OnRing):
    """Pin ring off the axis of the main bearings by A towards φ. Cure: bore ring and bearing seats in one clamping."""

    name: ClassVar[str] = "pin_ring_runout"
    amplitude_um: float = size("offset [µm]", 5.0, 0.0, 200.0)
    phase_deg: float = angle("direction of the offset [°]")

    def _shift(self, where: FloatArray) -> ComplexArray:
        return np.full(where.shape, self.amplitude_um * UM * np.exp(1j * self.phase_deg * DEGREE))


@dataclass(frozen=True)
class PinRingOval(_OnRing):
    """Pin ring oval: radial displacement A cos(2(α − φ)). Cure: clamp the housing without bending it."""

    name: ClassVar[str] = "pin_ring_oval"
    amplitude_um: float = size("amplitude in radius [µm]", 3.0, 0.0, 200.0)
    phase_deg: float = angle("angle of a wide place [°]")

    def _shift(self, where: FloatArray) -> ComplexArray:
        radial = self.amplitude_um * UM * np.cos(2.0 * (where - self.phase_deg * DEGREE))
        outwards: ComplexArray = radial * np.exp(1j * where)
        return outwards


@dataclass(frozen=True)
class PinRingCumulativePitch(_OnRing):
    """Indexing error of the pin bores: tangential displacement A sin(α − φ). Cure: correct the index table."""

    name: ClassVar[str] = "pin_ring_cumulative_pitch"
    amplitude_um: float = size("amplitude along the circle [µm]", 4.0, 0.0, 200.0)
    phase_deg: float = angle("angle where it passes zero [°]")

    def _shift(self, where: FloatArray) -> ComplexArray:
        along = self.amplitude_um * UM * np.sin(where - self.phase_deg * DEGREE)
        around: ComplexArray = 1j * along * np.exp(1j * where)
        return around


@dataclass(frozen=True)
class SinglePinError(_OnRing):
    """One pin thicker or thinner than the others. Cure: change the pin."""

    name: ClassVar[str] = "single_pin_error"
    amount_um: float = size("radius above the others [µm]", 1.0, -200.0, 200.0)
    pin: int = part("number of the pin, 1 stands at angle 0, counted anticlockwise", 1)

    def _oversize(self, where: FloatArray) -> FloatArray:
        (pin,) = chosen(self, "pin", self.pin, where.size)
        return np.where(np.arange(where.size) == pin, self.amount_um * UM, 0.0)


@dataclass(frozen=True)
class PinPositionError(_OnRing):
    """One pin bore out of its place. Gap: the displacement along the normal. Cure: bore the ring in one set-up.

    To the disc it looks like a pin of another radius wherever it carries, so measurements are told of that.
    """

    name: ClassVar[str] = "pin_position_error"
    amplitude_um: float = size("distance from its place [µm]", 2.0, 0.0, 200.0)
    direction_deg: float = angle("direction in the housing [°]")
    pin: int = part("number of the pin, 1 stands at angle 0, counted anticlockwise", 1)

    def _shift(self, where: FloatArray) -> ComplexArray:
        (pin,) = chosen(self, "pin", self.pin, where.size)
        off = self.amplitude_um * UM * np.exp(1j * self.direction_deg * DEGREE)
        return np.where(np.arange(where.size) == pin, off, 0.0 + 0.0j)
