"""Backlash of many reducers with the crank locked: the first touch of either flank, gaps linear in all errors.

Each disc is turned to its first touch exactly as drawn; from there the errors of a reducer open or close every gap by
so much a unit, and the least closing turn over all pins of all discs is the touch (docs/tolerance.md, Eq. 58).
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from cycloid_profile.arrays import BoolArray, FloatArray
from cycloid_profile.contact.as_built import AS_DRAWN
from cycloid_profile.contact.backlash import LEAST_REACH, first_touch
from cycloid_profile.contact.gap import Gaps
from cycloid_profile.contact.meshing import Meshing, mesh, output_turn
from cycloid_profile.contact.support import support_model
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.patterns import GapPlace, UnitChange, gap_change, misfit_change, rows

_BLOCK = 32  # reducers at once: their closing turns stay within a second-level cache


@dataclass(frozen=True)
class Clearance:
    """Closing turns of all contacts, linear in the coordinates.

    ``base`` shape (contacts, flanks) [rad] with the errors of the working point, infinite where a flank has fewer
    contacts than the others; flanks are those that stop a forward turn at each pose, then those that stop a backward
    one.
    ``by_unit`` sparse, (contacts·flanks, coordinates) [rad per unit].
    """

    built: Built
    base: FloatArray
    by_unit: Any

    @property
    def poses(self) -> int:
        """Number of poses over the turn of the output."""
        return int(self.base.shape[1]) // 2

    @cached_property
    def affine(self) -> Any:
        """``by_unit`` with ``base`` as one more column, which takes a coordinate 1."""
        from scipy.sparse import csr_array, hstack

        return csr_array(hstack([self.by_unit, csr_array(self.base.reshape(-1, 1))]))

    def by_pose(self, x: FloatArray) -> FloatArray:
        """Backlash at each pose of reducers with coordinates ``x``, shape (reducers, poses) [rad]."""
        least = self._solver(self, x)
        return least[:, : self.poses] + least[:, self.poses :]

    @cached_property
    def _solver(self) -> Callable[[Clearance, FloatArray], FloatArray]:
        """Compiled where numba is installed."""
        return least_turns_compiled if importlib.util.find_spec("numba") else least_turns_plainly

    def worst(self, x: FloatArray) -> FloatArray:
        """Largest backlash over the turn, shape (reducers,) [rad]."""
        largest: FloatArray = np.max(self.by_pose(x), axis=1)
        return largest

    def gradient(self, x: FloatArray) -> FloatArray:
        """Derivative of the largest backlash by every coordinate, shape (reducers, coordinates) [rad per unit].

        Exact wherever one contact alone is the first on its flank (Danskin's theorem).
        """
        matrix = self.by_unit.toarray().reshape(*self.base.shape, -1)
        found = np.empty((len(x), matrix.shape[-1]))
        for i, one in enumerate(x):
            turn = self.base + matrix @ one
            least = np.min(turn, axis=0)
            pose = int(np.argmax(least[: self.poses] + least[self.poses :]))
            found[i] = sum(matrix[np.argmin(turn[:, flank]), flank] for flank in (pose, self.poses + pose))
        return found


def least_turns_plainly(stage: Clearance, x: FloatArray) -> FloatArray:
    """Least closing turn of each flank, shape (reducers, flanks) [rad]; the readable reference."""
    found = np.empty((len(x), stage.base.shape[1]))
    for at in range(0, len(x), _BLOCK):
        some = x[at : at + _BLOCK]
        turn = stage.affine @ np.vstack([some.T, np.ones(len(some))])
        found[at : at + _BLOCK] = np.min(turn.reshape(*stage.base.shape, -1), axis=0).T
    return found


def least_turns_compiled(stage: Clearance, x: FloatArray) -> FloatArray:
    """The same by ``compiled.least_turns``."""
    from cycloid_profile.tolerance.compiled import least_turns

    found = np.empty((len(x), stage.base.shape[1]))
    matrix = stage.by_unit
    least_turns(matrix.indptr, matrix.indices, matrix.data, stage.base, np.ascontiguousarray(x), found)
    return found


def clearance(built: Built, changes: list[UnitChange], poses: int = 47) -> Clearance:
    """Closing turns at about ``poses`` poses over a turn of the output.

    Raises ``SolveError`` where a disc as drawn finds no first touch.
    """
    drive = built.case.drive
    trochoid = drive.trochoid
    meshing = mesh(trochoid, output_turn(trochoid, spread(poses, trochoid.lobes * trochoid.pins)), drive.discs)
    from_drawing = UnitChange(as_drawn(built.case), built, 1.0)
    base: list[FloatArray] = []
    columns: list[list[FloatArray | None]] = []
    for direction in (1.0, -1.0):
        touch = first_touch(built.case.profile, drive.pin_radius, meshing, direction)
        if not np.all(touch.settled):
            raise SolveError("first touch", "not found", "for the disc as drawn", "check the modification amounts", " ")
        arm = direction * touch.gaps.lever
        stops = arm > LEAST_REACH * trochoid.longest_lever
        place = GapPlace(touch.gaps.foot, meshing.lobe, touch.gaps.normal, meshing.crank_angle)
        follow = _Follow(built, meshing, touch.gaps)
        contacts = _Contacts(stops)
        opened = follow.opened(from_drawing, place)
        gap = touch.gaps.gap if opened is None else touch.gaps.gap + opened
        with np.errstate(divide="ignore"):
            base.append(contacts.packed(direction * touch.rotation[..., np.newaxis] + gap / arm, np.inf))
        columns.append([contacts.divided(follow.opened(change, place), arm) for change in changes])
    most = max(len(one) for one in base)
    whole = np.ascontiguousarray(np.concatenate([_padded(one, most, np.inf) for one in base], axis=1))
    shape = (most, len(meshing.phase))
    both = [_both(forward, backward, shape) for forward, backward in zip(*columns, strict=True)]
    return Clearance(built, whole, rows(both, whole.size))


class _Contacts:
    """Contacts of one flank at each pose, one column a pose, as long as the longest."""

    def __init__(self, stops: BoolArray) -> None:
        flat = stops.reshape(len(stops), -1)
        self.order = np.argsort(~flat, axis=1, kind="stable")[:, : int(np.max(np.sum(flat, axis=1)))]
        self.real = np.take_along_axis(flat, self.order, axis=1)

    def packed(self, values: FloatArray, missing: float) -> FloatArray:
        """``values`` over (poses, discs, pins) as (contacts, poses), ``missing`` where there is none."""
        packed = np.take_along_axis(values.reshape(len(values), -1), self.order, axis=1)
        return np.where(self.real, packed, missing).T

    def divided(self, opened: FloatArray | None, arm: FloatArray) -> FloatArray | None:
        """Closing turns of opened gaps [rad]."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return None if opened is None else self.packed(opened / arm, 0.0)


class _Follow:
    """How discs come to lie where misfits of their bearings put them, no load on any pin."""

    def __init__(self, built: Built, meshing: Meshing, found: Gaps) -> None:
        self.built, self.meshing, self.found = built, meshing, found
        model = support_model(built.case.drive, meshing.crank_angle, AS_DRAWN)
        discs = built.discs
        stretch = model.spring_stretch.reshape(len(meshing.phase), discs, -1, model.arm.size)
        self._answers = [
            -np.linalg.pinv(stretch[:, j][:, :, own]) if np.all(own > 0) else None
            for j, own in enumerate(model.disc_unknowns)
        ]

    def opened(self, change: UnitChange, place: GapPlace) -> FloatArray | None:
        """Gaps gained per unit, shape (poses, discs, pins) [mm]."""
        gap = gap_change(change, place)
        misfit = misfit_change(change, place.crank_angle)
        if misfit is None:
            return gap
        poses, discs, _ = place.foot.shape
        fits = misfit.reshape(poses, discs, -1)
        total = np.zeros(place.foot.shape) if gap is None else gap.copy()
        n, lever = self.found.normal, self.found.lever
        for j, answer in enumerate(self._answers):
            if answer is not None:
                moved = np.einsum("pus,ps->pu", answer, fits[:, j])[:, :, np.newaxis]
                total[:, j] -= n[:, j].real * moved[:, 0] + n[:, j].imag * moved[:, 1] + lever[:, j] * moved[:, 2]
        return total


def _padded(values: FloatArray, most: int, missing: float) -> FloatArray:
    return np.pad(values, ((0, most - len(values)), (0, 0)), constant_values=missing)


def _both(forward: FloatArray | None, backward: FloatArray | None, shape: tuple[int, int]) -> FloatArray | None:
    if forward is None and backward is None:
        return None
    halves = [np.zeros(shape) if one is None else _padded(one, shape[0], 0.0) for one in (forward, backward)]
    return np.concatenate(halves, axis=1)


def spread(about: int, orders: int) -> int:
    """Number of poses near ``about`` that no order in ``orders`` divides: a prime that is not in it.

    Errors that repeat so many times a turn are then met at as many different places.
    """
    number = max(about, 3)
    while any(number % d == 0 for d in range(2, int(number**0.5) + 1)) or orders % number == 0:
        number += 1
    return number
