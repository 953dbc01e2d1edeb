"""Backlash with the crank locked: of many reducers with gaps linear in all errors, and its derivatives about one.

Each nominal disc is rotated to its exact first touch. Errors change every gap linearly; the least closing rotation
over all pins of all discs is the touch (docs/tolerance.md, Eq. 58). The gap that touches first is zero, so that its
change over its arm is exactly the change of the rotation (Eq. 61).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray, IntArray
from cycloid_profile.contact.bodies import support_misfit, support_model
from cycloid_profile.contact.mesh import LEAST_REACH, Gaps, Meshing, closing_turn, first_touch, mesh, output_turn
from cycloid_profile.contact.stage import ContactPoints
from cycloid_profile.effects import AsBuiltReducer, ReducerChange, as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.tolerance.model._directional import DirectionalDerivative, Gradient, least, weighted_sum

# Rounding of a touch is some 1e-15 rad; contacts of two discs that mirror each other meet within it.
_TIE = 1e-12  # rad


@dataclass(frozen=True, eq=False)
class CrankLockedBacklash:
    """Closing rotations of all contacts, linear in the coordinates.

    ``base`` shape (contacts, flanks) [rad] with the errors of the working point, infinite where a flank has fewer
    contacts than the others; flanks are those that stop a forward rotation at each pose, then those that stop a
    backward one. ``by_unit`` sparse, (contacts·flanks, coordinates) [rad per unit]. ``pin`` of each contact, counted
    over all discs, in the shape of ``base``; ``arm`` of each pin about its disc, shape (poses, 2, pins), 0 where out of
    reach [mm].
    """

    reducer: AsBuiltReducer
    base: FloatArray
    by_unit: Any
    pin: IntArray
    arm: FloatArray

    @property
    def poses(self) -> int:
        """Number of poses over the turn of the output."""
        return int(self.base.shape[1]) // 2

    def by_pose(self, x: FloatArray) -> FloatArray:
        """Backlash at each pose of reducers with coordinates ``x``, shape (reducers, poses) [rad]."""
        from cycloid_profile.tolerance.model._compiled import least_turns

        turn = np.empty((len(x), self.base.shape[1]))
        matrix = self.by_unit
        least_turns(matrix.indptr, matrix.indices, matrix.data, self.base, np.ascontiguousarray(x), turn)
        return turn[:, : self.poses] + turn[:, self.poses :]

    def extremes(self, x: FloatArray) -> FloatArray:
        """Largest and least backlash over the turn, between the poses too, shape (reducers, 2) [rad].

        The pins are interpolated: fewer than some 20 poses per turn of the crank give no sensible value.
        """
        from cycloid_profile.tolerance.model._extremes import turn_extremes

        found = np.empty((len(x), 2))
        turn_extremes(*self._by_pose, np.ascontiguousarray(x), found)
        return found

    @cached_property
    def _by_pose(self) -> tuple[Any, ...]:
        """Contacts in the order of the poses: sparse rows, closing turns as drawn, and their pins."""
        most, flanks = self.base.shape
        order = np.arange(most * flanks).reshape(most, 2, self.poses).transpose(2, 1, 0)
        matrix = self.by_unit[order.ravel()]
        pin = np.where(np.isfinite(self.base), self.pin, -1).reshape(-1)[order]
        row_of = np.full(self.arm.shape, -1)
        pose, flank, slot = np.nonzero(pin >= 0)
        row_of[pose, flank, pin[pose, flank, slot]] = (2 * pose + flank) * most + slot
        base = np.ascontiguousarray(self.base.reshape(-1)[order])
        return (matrix.indptr, matrix.indices, matrix.data, base, np.ascontiguousarray(pin), row_of,
                np.ascontiguousarray(self.arm))  # fmt: skip


def crank_locked_backlash(
    reducer: AsBuiltReducer, changes: Sequence[ReducerChange], poses: int = 47
) -> CrankLockedBacklash:
    """Closing rotations at about ``poses`` poses over one revolution of the output.

    Raises ``SolveError`` where a disc as drawn finds no first touch.
    """
    drive = reducer.case.drive
    trochoid = drive.trochoid
    meshing = mesh(trochoid, output_turn(trochoid, poses), drive.discs)
    discs = _UnloadedDiscs(reducer, meshing)
    from_drawing = ReducerChange(as_drawn(reducer.case), reducer)
    base: list[FloatArray] = []
    pins: list[IntArray] = []
    arms: list[FloatArray] = []
    columns: list[list[FloatArray | None]] = []
    for direction in (1.0, -1.0):
        rotation, found = _touched(reducer.case.profile, drive.pin_radius, meshing, direction)
        arm = direction * found.lever
        contacts = _Contacts(arm > LEAST_REACH * trochoid.longest_lever)
        points = ContactPoints.on_grid(found.foot, meshing.lobe, found.normal)
        opened = discs.opened(from_drawing, points, found.lever)
        gap = found.gap if opened is None else found.gap + opened
        with np.errstate(divide="ignore"):
            base.append(contacts.packed(direction * rotation[..., np.newaxis] + gap / arm, np.inf))
        pins.append(contacts.order.T)
        arms.append(np.where(contacts.stops, arm, 0.0).reshape(len(arm), -1))
        columns.append([contacts.divided(discs.opened(one, points, found.lever), arm) for one in changes])
    most = max(len(one) for one in base)
    whole = np.ascontiguousarray(np.concatenate([_padded(one, most, np.inf) for one in base], axis=1))
    shape = (most, len(meshing.phase))
    both = [_both(forward, backward, shape) for forward, backward in zip(*columns, strict=True)]
    pin = np.concatenate([np.pad(one, ((0, most - len(one)), (0, 0))) for one in pins], axis=1)
    return CrankLockedBacklash(reducer, whole, sparse_columns(both, whole.size), pin, np.stack(arms, axis=1))


def backlash_derivatives(
    reducer: AsBuiltReducer, changes: Sequence[ReducerChange], crank_angle: FloatArray
) -> tuple[FloatArray, list[DirectionalDerivative]]:
    """Backlash at each pose, shape (poses,) [rad], and its derivatives by the coordinates.

    Exact first touches of a reducer as built, its discs displaced by the misfits of their bearings.

    Raises ``SolveError`` where a disc finds no first touch.
    """
    drive = reducer.case.drive
    meshing = mesh(drive.trochoid, crank_angle, drive.discs)
    discs = _UnloadedDiscs(reducer, meshing)
    moved = discs.motion(support_misfit(drive, meshing.crank_angle, reducer.deviations))
    shift, turn = moved[..., 0] + 1j * moved[..., 1], moved[..., 2]
    placed = replace(meshing, pin_centre=meshing.pin_in_lobe(shift, turn, reducer.pin_shift))
    radius = drive.pin_radius + reducer.pin_oversize
    flanks = []
    for direction in (1.0, -1.0):
        touches = [_touched(tooth, radius, placed.disc(j), direction) for j, tooth in enumerate(reducer.teeth)]
        rotation, found = np.concatenate([t[0] for t in touches], axis=1), Gaps.of_discs([t[1] for t in touches])
        # The first touch rotates the disc; normals refer to the disc after its rotation by the bearing misfits.
        normal = found.normal * np.exp(1j * turn)[..., np.newaxis]
        points = ContactPoints.on_grid(found.foot, meshing.lobe, normal)
        arm = direction * found.lever
        closing = direction * rotation[..., np.newaxis] + closing_turn(reducer.case.profile, found.gap, arm)
        opened = np.zeros((len(changes), *closing.shape))
        for number, change in enumerate(changes):
            gained = discs.opened(change, points, found.lever)
            opened[number] = 0.0 if gained is None else gained
        flanks.append(_first(closing, opened, arm))
    (forward, to), (backward, back) = flanks
    return forward + backward, [weighted_sum(both) for both in zip(to, back, strict=True)]


def pose_count(about: int, orders: int) -> int:
    """Number of poses near ``about`` that no order in ``orders`` divides: a prime that is not in it.

    Errors of these orders are then sampled at a different phase in every pose.
    """
    number = max(about, 3)
    while any(number % d == 0 for d in range(2, int(number**0.5) + 1)) or orders % number == 0:
        number += 1
    return number


def sparse_columns(columns: Sequence[FloatArray | None], size: int) -> Any:
    """Sparse matrix, shape (``size``, columns), whose columns are these arrays flattened; zero for None."""
    from scipy.sparse import csc_array, csr_array, hstack

    if not columns:
        return csr_array((size, 0))
    return csr_array(hstack([csc_array((size, 1) if one is None else one.reshape(-1, 1)) for one in columns]))


class _UnloadedDiscs:
    """Discs that follow the misfits of their bearings, no load on any pin."""

    def __init__(self, reducer: AsBuiltReducer, meshing: Meshing) -> None:
        self._crank_angle = meshing.crank_angle
        model = support_model(reducer.case.drive, meshing.crank_angle)
        stretch = model.spring_stretch.reshape(len(meshing.phase), reducer.discs, -1, model.arm.size)
        self._inverse = [
            # A disc on a central eccentric turns with the carrier: its bearing has no misfit to follow.
            -np.linalg.pinv(stretch[:, j][:, :, own]) if np.all(own > 0) else np.zeros((len(stretch), 3, 2))
            for j, own in enumerate(model.disc_unknowns)
        ]

    def motion(self, misfit: FloatArray) -> FloatArray:
        """(x, y, θ) of each disc, shape (poses, discs, 3) [mm, mm, rad], by misfits of shape (poses, bearings, 2)."""
        fits = misfit.reshape(len(misfit), len(self._inverse), -1)
        return np.stack([np.einsum("pus,ps->pu", one, fits[:, j]) for j, one in enumerate(self._inverse)], axis=1)

    def opened(self, change: ReducerChange, at: ContactPoints, lever: FloatArray) -> FloatArray | None:
        """Gaps gained per unit of a change, shape (poses, discs, pins) [mm]; None where there are none."""
        gap, misfit = change.gap(at), change.misfit(self._crank_angle)
        if misfit is None:
            return gap
        moved = self.motion(misfit)[:, :, np.newaxis]
        closed = at.normal.real * moved[..., 0] + at.normal.imag * moved[..., 1] + lever * moved[..., 2]
        return -closed if gap is None else gap - closed


class _Contacts:
    """Contacts of one flank, one column per pose, padded to the length of the longest."""

    def __init__(self, stops: BoolArray) -> None:
        self.stops = stops
        flat = stops.reshape(len(stops), -1)
        self.order = np.argsort(~flat, axis=1, kind="stable")[:, : int(np.max(np.sum(flat, axis=1)))]
        self.real = np.take_along_axis(flat, self.order, axis=1)

    def packed(self, values: FloatArray, missing: float) -> FloatArray:
        """``values`` over (poses, discs, pins) as (contacts, poses), ``missing`` where there is none."""
        packed = np.take_along_axis(values.reshape(len(values), -1), self.order, axis=1)
        return np.where(self.real, packed, missing).T

    def divided(self, opened: FloatArray | None, arm: FloatArray) -> FloatArray | None:
        """Closing rotations of opened gaps [rad]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return None if opened is None else self.packed(opened / arm, 0.0)


def _touched(
    tooth: ToothProfile, pin_radius: float | FloatArray, meshing: Meshing, direction: float
) -> tuple[FloatArray, Gaps]:
    touch = first_touch(tooth, pin_radius, meshing, direction)
    if not np.all(touch.settled):
        remedy = "bring modification.equidistant_um and radial_moving_um nearer to zero, or take smaller effects"
        raise SolveError("first touch", "not found", "at some pose", remedy, " ")
    return touch.rotation, touch.gaps


def _first(closing: FloatArray, opened: FloatArray, arm: FloatArray) -> tuple[FloatArray, list[DirectionalDerivative]]:
    """Least closing rotation at each pose [rad] with its derivative."""
    turn = closing.reshape(len(closing), -1)
    by_unit = opened.reshape(len(opened), *turn.shape)
    found: list[DirectionalDerivative] = []
    for p, (row, reach) in enumerate(zip(turn, arm.reshape(turn.shape), strict=True)):
        first = np.flatnonzero(row <= np.min(row) + _TIE)
        found.append(least(row[first], [Gradient(by_unit[:, p, i] / reach[i]) for i in first], _TIE))
    return np.min(turn, axis=1), found


def _padded(values: FloatArray, most: int, missing: float) -> FloatArray:
    return np.pad(values, ((0, most - len(values)), (0, 0)), constant_values=missing)


def _both(forward: FloatArray | None, backward: FloatArray | None, shape: tuple[int, int]) -> FloatArray | None:
    if forward is None and backward is None:
        return None
    halves = [np.zeros(shape) if one is None else _padded(one, shape[0], 0.0) for one in (forward, backward)]
    return np.concatenate(halves, axis=1)
