"""Poses that are one pose seen from pins further on: one of them is solved for all.

Turn carrier, cranks and discs together by pin pitches, and they meet the same pins again, as long as all pins are
alike; and that is where the input takes them, once the output has turned by as many pin pitches. Whatever lobes,
cranks, bores and bearings differ by turns with them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact.sharing import StagePlace
from cycloid_profile.effects.built import Built

Values = TypeVar("Values", FloatArray, ComplexArray)

# A difference of angle that turns the output by less than 0.0001″ at the steepest ripple.
_SAME_ANGLE = 1e-8  # rad
_SAME_PIN = 1e-12  # mm
_WORTH_IT = 0.5  # of the poses
_REMEMBERED = 32  # rows of poses


@dataclass(frozen=True, eq=False)
class AlikePoses:
    """For every pose ``of``, which solved pose it is like, and ``pitches``, by how many pins it is ahead of that; both
    of shape (poses,).
    """

    of: IntArray
    pitches: IntArray

    def at(self, rows: IntArray) -> tuple[AlikePoses, IntArray]:
        """The same at some of the poses, and which of the solved ones these are like."""
        used, of = np.unique(self.of[rows], return_inverse=True)
        return AlikePoses(of.reshape(-1), self.pitches[rows]), used

    def over_pins(self, values: Values) -> Values:
        """What belongs to the pins at all poses, shape (poses, …, pins), from the same at the solved ones."""
        pins = values.shape[-1]
        found = values[self.of]
        pin = np.mod(np.arange(pins) - self.pitches[:, np.newaxis], pins)
        return np.take_along_axis(found, pin.reshape(len(pin), *(1,) * (values.ndim - 2), pins), axis=-1)

    def turn(self, pins: int) -> ComplexArray:
        """Unit complex numbers that turn what each pose is like into the pose, shape (poses,)."""
        turn: ComplexArray = np.exp(2j * math.pi / pins * self.pitches)
        return turn

    def place(self, place: StagePlace, pins: int) -> StagePlace:
        """Where the parts rest at all poses, from where they rest at the solved ones."""
        motion = place.motion[self.of]
        shift = (motion[..., 0] + 1j * motion[..., 1]) * self.turn(pins)[:, np.newaxis]
        return StagePlace(
            place.rotation[self.of],
            np.stack([shift.real, shift.imag, motion[..., 2]], axis=-1),
            None if place.foot is None else self.over_pins(place.foot),
        )


def alike_poses(built: Built, output_angle: FloatArray, torque: FloatArray) -> tuple[IntArray, AlikePoses]:
    """Which poses of the output [rad] under ``torque`` are to be solved, and which of these the others are like; all
    of them where the pins differ.
    """
    if _pins_alike(built):
        solved, alike = _seen_from_pins(built.case.drive.trochoid.pins, output_angle.tobytes(), torque.tobytes())
        if solved.size <= _WORTH_IT * output_angle.size:
            return solved, alike
    every = np.arange(output_angle.size)
    return every, AlikePoses(every, np.zeros_like(every))


@lru_cache(maxsize=_REMEMBERED)
def _seen_from_pins(pins: int, output_angle: bytes, torque: bytes) -> tuple[IntArray, AlikePoses]:
    """The same for any number of poses; one reducer after another is looked at in the same ones."""
    angle, pitch = np.frombuffer(output_angle), 2.0 * math.pi / pins
    # The same pose stands for the others in whatever order they come.
    order = np.argsort(angle, kind="stable")
    ahead = np.floor((angle[order] + _SAME_ANGLE) / pitch)
    within = np.round((angle[order] - ahead * pitch) / _SAME_ANGLE)
    keys = np.stack([np.frombuffer(torque)[order], within], axis=1)
    _, first, of = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    of = of.reshape(-1)
    found = AlikePoses(np.empty_like(of), np.empty_like(of))
    found.of[order], found.pitches[order] = of, (ahead - ahead[first][of]).astype(np.intp)
    return order[first], found


def _pins_alike(built: Built) -> bool:
    """Whether a turn of the ring by a pin changes nothing."""
    pins = built.case.drive.trochoid.pins
    outwards: ComplexArray = built.pin_shift * np.exp(-2j * math.pi / pins * np.arange(pins))
    differ = max(float(np.max(np.abs(a - a[0]))) for a in (outwards, built.pin_oversize))
    return differ < _SAME_PIN
