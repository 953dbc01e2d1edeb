"""Poses equivalent under rotation by whole pin pitches: one of them is solved for all.

If all pins are identical, a rotation of carrier, cranks and discs together by whole pin pitches leaves the contacts
unchanged. The input reaches that pose when the output turns by as many pitches. Errors of lobes, cranks, bores and
bearings rotate with the parts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import TypeVar

import numpy as np

from cycloid_profile.arrays import ComplexArray, FloatArray, IntArray
from cycloid_profile.contact import StagePositions
from cycloid_profile.effects import AsBuiltReducer

Values = TypeVar("Values", FloatArray, ComplexArray)

# A difference of angle that turns the output by less than 0.0001″ at the steepest ripple.
_ANGLE_TOLERANCE = 1e-8  # rad
_PIN_TOLERANCE = 1e-12  # mm
_LARGEST_SOLVED_SHARE = 0.5  # of the poses; beyond it all are solved
_CACHED_PATHS = 32  # rows of poses


@dataclass(frozen=True, eq=False)
class EquivalentPoses:
    """Map from every pose to the solved pose that represents it.

    ``representative``, index among the solved poses; ``pitches``, number of pin pitches by which the pose is ahead of
    its representative; both of shape (poses,).
    """

    representative: IntArray
    pitches: IntArray

    def at(self, rows: IntArray) -> tuple[EquivalentPoses, IntArray]:
        """The map of the poses ``rows``, and the indices of the solved poses that represent them."""
        used, representative = np.unique(self.representative[rows], return_inverse=True)
        return EquivalentPoses(representative.reshape(-1), self.pitches[rows]), used

    def over_pins(self, values: Values) -> Values:
        """Values of the pins at all poses, shape (poses, …, pins), from their values at the solved poses."""
        pins = values.shape[-1]
        found = values[self.representative]
        pin = np.mod(np.arange(pins) - self.pitches[:, np.newaxis], pins)
        return np.take_along_axis(found, pin.reshape(len(pin), *(1,) * (values.ndim - 2), pins), axis=-1)

    def turn(self, pins: int) -> ComplexArray:
        """Unit complex numbers that rotate the representative into each pose, shape (poses,)."""
        return np.asarray(np.exp(2j * math.pi / pins * self.pitches))

    def place(self, place: StagePositions, pins: int) -> StagePositions:
        """Positions of the parts at all poses, from their positions at the solved poses."""
        motion, tilt = place.motion[self.representative], place.tilt
        shift = (motion[..., 0] + 1j * motion[..., 1]) * self.turn(pins)[:, np.newaxis]
        if tilt is not None:
            tilt = _turned(tilt[self.representative], self.turn(pins))
        return StagePositions(
            place.rotation[self.representative],
            np.stack([shift.real, shift.imag, motion[..., 2]], axis=-1),
            None if place.foot is None else self.over_pins(place.foot),
            None if place.load is None else self._load(place.load, motion.shape[1] * pins, pins),
            tilt,
        )

    def _load(self, load: FloatArray, contacts: int, pins: int) -> FloatArray:
        """Forces that deform the discs at all poses: those of ``contacts`` pins, then of the bearings."""
        if not load.size:
            return load[self.representative]
        pressed = self.over_pins(load[:, :contacts].reshape(len(load), -1, pins))
        bearings = load[self.representative, contacts:].reshape(len(pressed), -1, 2)
        both = _turned(bearings, self.turn(pins))
        return np.concatenate([pressed.reshape(len(pressed), -1), both.reshape(len(pressed), -1)], axis=1)


def _turned(vectors: FloatArray, turn: ComplexArray) -> FloatArray:
    """Vectors (x, y), shape (poses, n, 2), turned by the unit complex number of each pose."""
    turned = (vectors[..., 0] + 1j * vectors[..., 1]) * turn[:, np.newaxis]
    return np.stack([turned.real, turned.imag], axis=-1)


def equivalent_poses(
    reducer: AsBuiltReducer, output_angle: FloatArray, torque: FloatArray
) -> tuple[IntArray, EquivalentPoses]:
    """Poses of the output [rad] under ``torque`` to solve, and the map of all poses to these.

    Every pose is solved if the pins differ, or if a sun off its axis makes no whole turns in a pin pitch.
    """
    if _pins_identical(reducer) and _sun_returns(reducer):
        solved, equivalent = _by_pitch(reducer.case.drive.trochoid.pins, output_angle.tobytes(), torque.tobytes())
        if solved.size <= _LARGEST_SOLVED_SHARE * output_angle.size:
            return solved, equivalent
    every = np.arange(output_angle.size)
    return every, EquivalentPoses(every, np.zeros_like(every))


@lru_cache(maxsize=_CACHED_PATHS)
def _by_pitch(pins: int, output_angle: bytes, torque: bytes) -> tuple[IntArray, EquivalentPoses]:
    """``equivalent_poses`` of identical pins, cached: reducer after reducer is solved in the same poses."""
    angle, pitch = np.frombuffer(output_angle), 2.0 * math.pi / pins
    # The representative must not depend on the order of the poses.
    order = np.argsort(angle, kind="stable")
    ahead = np.floor((angle[order] + _ANGLE_TOLERANCE) / pitch)
    within = np.round((angle[order] - ahead * pitch) / _ANGLE_TOLERANCE)
    keys = np.stack([np.frombuffer(torque)[order], within], axis=1)
    _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    group = group.reshape(-1)
    found = EquivalentPoses(np.empty_like(group), np.empty_like(group))
    found.representative[order], found.pitches[order] = group, (ahead - ahead[first][group]).astype(np.intp)
    return order[first], found


def _pins_identical(reducer: AsBuiltReducer) -> bool:
    """Whether rotation of the ring by a pin pitch changes nothing."""
    pins = reducer.case.drive.trochoid.pins
    outwards: ComplexArray = reducer.pin_shift * np.exp(-2j * math.pi / pins * np.arange(pins))
    spread = max(float(np.max(np.abs(a - a[0]))) for a in (outwards, reducer.pin_oversize))
    return spread < _PIN_TOLERANCE


def _sun_returns(reducer: AsBuiltReducer) -> bool:
    """Whether the sun makes whole turns on the carrier while the output turns by a pin pitch, or is on its axis."""
    stage = reducer.case.drive.first_stage
    return not reducer.sun_shift or stage is None or stage.planet_teeth % stage.sun_teeth == 0
