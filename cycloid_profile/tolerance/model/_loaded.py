"""Rotation and pin loads under torque: of many reducers with gaps linear about the drawing, and derivatives about one.

The errors of a reducer open its gaps and stretch its bearings; load equilibrium is then solved separately for each
simulated reducer, nonlinear and one-sided. Only the place of a contact is taken from the drawing (docs/tolerance.md,
Eq. 59).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.contact.bodies import support_model
from cycloid_profile.contact.mesh import gaps, mesh
from cycloid_profile.contact.result import LoadSharing
from cycloid_profile.contact.stage import (
    ContactPoints,
    CurvedContacts,
    StageEnergy,
    StageEquilibrium,
    StageTangent,
    energy_with,
)
from cycloid_profile.effects import AsBuiltReducer, ReducerChange, as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.model._crank_locked import sparse_columns

if TYPE_CHECKING:
    from cycloid_profile.contact.stage._kernels import StageArrays
    from cycloid_profile.tolerance.model._compiled import SearchStart

TOLERANCE = 1e-7  # of the torque, out of balance
_BLOCK = 24  # reducers at once
_WATCHED = 6  # contacts of a pose, those with the highest pressure as drawn; 4 and 16 find the same poses


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """Rotation and highest pressure of reducers to first order about the drawing: a cheap estimate at many loads.

    ``rotation`` as drawn, shape (loads,) [rad], and ``rotation_by_unit``, shape (loads, coordinates) [rad per unit];
    ``force`` of the watched contacts, shape (loads, some) [N], ``force_by_unit``, shape (loads·some, coordinates)
    [N per unit], and their peak pressure under 1 N, ``per_root_force``, shape (loads, some) [MPa].
    """

    rotation: FloatArray
    rotation_by_unit: FloatArray
    force: FloatArray
    force_by_unit: FloatArray
    per_root_force: FloatArray

    def rotations(self, x: FloatArray) -> FloatArray:
        """Rotation at each load, shape (reducers, loads) [rad]."""
        return np.asarray(self.rotation + x @ self.rotation_by_unit.T)

    def pressures(self, x: FloatArray) -> FloatArray:
        """Highest peak pressure at each load, shape (reducers, loads) [MPa]."""
        force = self.force + (x @ self.force_by_unit.T).reshape(len(x), *self.force.shape)
        return np.asarray(np.max(np.sqrt(np.maximum(force, 0.0)) * self.per_root_force, axis=2))


class LoadedAnswers(NamedTuple):
    """Rotation of the output [rad] and highest peak pressure [MPa], shape (reducers, loads).

    ``followed``: pressure of the contact that was asked for, else the highest. ``contact``: the one with the highest.
    """

    rotation: FloatArray
    pressure: FloatArray
    followed: FloatArray
    contact: IntArray


@dataclass(frozen=True, eq=False)
class LoadedStage:
    """The stage as drawn at some loads, a crank angle and a torque each, and its change by errors.

    ``energy`` of the stage about each equilibrium, one pose per load; ``gap_by_unit`` sparse (loads·discs·pins,
    coordinates) [mm per unit]; ``stretch_by_unit`` sparse (loads·bearings·2, coordinates) [mm per unit];
    ``play_by_unit`` shape (coordinates,) [mm per unit]; ``read_by_unit`` sparse (loads, coordinates), twist in series
    and angle errors [rad per unit]; ``pressure_per_root_force`` peak pressure of each contact under
    1 N, shape (loads, discs, pins) [MPa]. ``start`` of the search; ``first_order``, estimates about the drawing.
    """

    reducer: AsBuiltReducer
    crank_angle: FloatArray
    energy: StageEnergy
    gap_by_unit: Any
    stretch_by_unit: Any
    play_by_unit: FloatArray
    read_by_unit: Any
    pressure_per_root_force: FloatArray
    start: SearchStart
    first_order: FirstOrder

    def answers(self, x: FloatArray, chosen: IntArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Rotation of the output [rad] and highest peak pressure [MPa] at each load, shape (reducers, loads).

        At the loads ``chosen`` for each reducer, shape (reducers, some), at all of them unless given. NaN where a
        reducer finds no equilibrium.
        """
        every = np.arange(len(self.energy.torque))
        some = np.broadcast_to(every, (len(x), every.size)) if chosen is None else chosen
        found = self.following(x, some)
        return found.rotation, found.pressure

    def following(self, x: FloatArray, chosen: IntArray, contact: IntArray | None = None) -> LoadedAnswers:
        """The same at the loads ``chosen``, with the pressure of one ``contact`` at each, shape (reducers, some)."""
        blocks = [
            self._block(x[at], chosen[at], None if contact is None else contact[at])
            for at in (slice(first, first + _BLOCK) for first in range(0, len(x), _BLOCK))
        ]
        return LoadedAnswers(*(np.concatenate(each) for each in zip(*blocks, strict=True)))

    def errors(self, x: FloatArray, chosen: IntArray | None = None) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Gaps, unloaded bearing displacements and bearing play of reducers with coordinates ``x`` [mm].

        Shapes (reducers, loads, discs, pins), (reducers, loads, bearings, 2) and (reducers,).
        """
        from cycloid_profile.tolerance.model._compiled import chosen_rows

        every = np.arange(len(self.energy.torque))
        some = np.ascontiguousarray(np.broadcast_to(every, (len(x), every.size)) if chosen is None else chosen)
        found = []
        for drawn, matrix in ((self.energy.gap, self.gap_by_unit), (self.energy.stretch, self.stretch_by_unit)):
            made = drawn[some].reshape(*some.shape, -1)
            chosen_rows(matrix.indptr, matrix.indices, matrix.data, np.ascontiguousarray(x), some, made)
            found.append(made.reshape(*some.shape, *drawn.shape[1:]))
        return (
            found[0],
            found[1],
            np.maximum(self.energy.play + _weighted(x, self.play_by_unit), self.energy.bearing.least_play),
        )

    @cached_property
    def _arrays(self) -> StageArrays:
        """The stage as drawn in the form of the compiled search, made once for all reducers."""
        return self.energy.arrays()

    def _block(self, x: FloatArray, chosen: IntArray, contact: IntArray | None) -> LoadedAnswers:
        from cycloid_profile.tolerance.model._compiled import balanced_reducers, chosen_rows

        gap, stretch, play = self.errors(x, chosen)
        some = np.ascontiguousarray(chosen)
        turned, pressure, followed, first = balanced_reducers(
            self._arrays, np.ascontiguousarray(self.energy.load), gap, stretch, play, self.pressure_per_root_force,
            self.start, TOLERANCE, some, contact,
        )  # fmt: skip
        turned += self.reducer.series_twist(self.energy.torque)[some]
        read = self.read_by_unit
        chosen_rows(read.indptr, read.indices, read.data, np.ascontiguousarray(x), some, turned[..., np.newaxis])
        return LoadedAnswers(turned, pressure, followed, first)


def _weighted(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Σ x·weights of each row, added in an order that does not depend on how many rows there are."""
    some = np.flatnonzero(weights)
    return np.asarray(np.sum(x[:, some] * weights[some], axis=1))


def loaded_stage(
    reducer: AsBuiltReducer, changes: Sequence[ReducerChange], crank_angle: FloatArray, torque: FloatArray
) -> LoadedStage:
    """The stage at crank angles of disc 1 [rad] under torques [N·mm], shape (loads,) both.

    The gaps and bearing displacements change linearly with the errors of ``reducer``, about the nominal stage.

    Raises
    ------
    SolveError
        If the stage as drawn has no equilibrium at one of the loads.
    LoadError
        If a torque is zero or not finite.
    """
    from cycloid_profile.tolerance.model._compiled import SearchStart

    case = reducer.case
    solved = StageEquilibrium().at(case, crank_angle, torque)
    if not solved.converged:
        raise SolveError("load sharing of the drawing", solved.status.value, "", "check the spec with accuracy", ": ")
    meshing = mesh(case.drive.trochoid, crank_angle, case.drive.discs)
    support = support_model(case.drive, meshing.crank_angle, width=case.width)
    assert solved.stage is not None
    motion = solved.stage.motion
    found = gaps(case.profile, case.drive.pin_radius, meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])
    points = ContactPoints.on_grid(found.foot, meshing.lobe, found.normal)
    own = ReducerChange(as_drawn(case), reducer)
    energy = energy_with(solved, support, found)
    opened, stretched = own.gap(points), own.misfit(meshing.crank_angle)
    energy = replace(
        energy,
        gap=energy.gap if opened is None else energy.gap + opened,
        stretch=energy.stretch if stretched is None else energy.stretch + stretched,
    )
    angle = -meshing.crank_angle[:, 0] / case.drive.trochoid.lobes
    gap_by_unit = sparse_columns([one.gap(points) for one in changes], energy.gap.size)
    stretch_by_unit = sparse_columns([one.misfit(meshing.crank_angle) for one in changes], energy.stretch.size)
    read_by_unit = sparse_columns(
        [one.series_twist(solved.torque) + one.angle_error(angle) for one in changes], len(angle)
    )
    pressure_per_root_force = case.law.peak_pressure(np.ones_like(found.gap), energy.contact)
    loaded, tangent = _loaded(solved, energy.stretch[0].size), StageTangent(solved)
    by_deformation = tangent.forces_per_deformation(loaded)
    watched = loaded[:, :_WATCHED]
    by_gap, by_stretch = np.split(-by_deformation[:, :_WATCHED], [found.gap[0].size], axis=2)
    rotated = _per_load(tangent.pins[:, np.newaxis]) @ gap_by_unit
    rotated += _per_load(tangent.bearings[:, np.newaxis]) @ stretch_by_unit
    forced = _per_load(by_gap) @ gap_by_unit - _per_load(by_stretch) @ stretch_by_unit
    return LoadedStage(
        reducer=reducer,
        crank_angle=np.asarray(crank_angle, dtype=np.float64),
        energy=energy,
        gap_by_unit=gap_by_unit,
        stretch_by_unit=stretch_by_unit,
        play_by_unit=np.array([one.play for one in changes]),
        read_by_unit=read_by_unit,
        pressure_per_root_force=pressure_per_root_force,
        start=SearchStart(
            place=loaded,
            motion=np.take_along_axis(tangent.motion_per_deformation, loaded[:, np.newaxis], axis=2),
            force=np.take_along_axis(by_deformation, loaded[:, np.newaxis], axis=2),
        ),
        first_order=FirstOrder(
            rotation=energy.rotation,
            rotation_by_unit=(rotated + read_by_unit).toarray(),
            force=_of_watched(solved.force, watched),
            force_by_unit=forced.toarray(),
            per_root_force=_of_watched(pressure_per_root_force, watched),
        ),
    )


def _loaded(solved: LoadSharing, bearings: int) -> IntArray:
    """The contacts of each pose that carry a force, by their pressure, then all forces of bearings, shape (poses,
    some), counted over all discs; unloaded contacts make up the number.
    """
    pressure = solved.pressure.reshape(len(solved.pressure), -1)
    some = max(_WATCHED, int(np.max(np.count_nonzero(pressure, axis=1))))
    pins = np.argsort(-pressure, axis=1, kind="stable")[:, :some]
    others = np.arange(pressure.shape[1], pressure.shape[1] + bearings)
    return np.concatenate([pins, np.broadcast_to(others, (len(pins), bearings))], axis=1)


def _of_watched(values: FloatArray, watched: IntArray) -> FloatArray:
    """Values of the ``watched`` contacts among those of all, shape (poses, discs, pins)."""
    return np.take_along_axis(values.reshape(len(values), -1), watched, axis=1)


def _per_load(weights: FloatArray) -> Any:
    """Sparse matrix, shape (loads·rows, loads·rest), that adds the rest of each load with ``weights``, shape (loads,
    rows, …), of each row.
    """
    from scipy.sparse import csr_array

    loads, rows = weights.shape[:2]
    rest = weights[0, 0].size
    column = np.repeat(np.arange(loads * rest).reshape(loads, 1, rest), rows, axis=1)
    begin = np.arange(loads * rows + 1) * rest
    return csr_array((weights.ravel(), column.ravel(), begin), shape=(loads * rows, loads * rest))


@dataclass(frozen=True, eq=False)
class LoadedDerivatives:
    """Answers at some loads and their derivatives by the coordinates of the changes.

    ``rotation`` as an encoder reads it, shape (loads,) [rad], and ``rotation_by_unit``, shape (loads, coordinates);
    ``pressure`` of every loaded contact of all loads, shape (contacts,) [MPa], and ``pressure_by_unit``.
    """

    rotation: FloatArray
    rotation_by_unit: FloatArray
    pressure: FloatArray
    pressure_by_unit: FloatArray


def loaded_derivatives(
    reducer: AsBuiltReducer, changes: Sequence[ReducerChange], crank_angle: FloatArray, torque: FloatArray
) -> LoadedDerivatives:
    """The stage as built at crank angles of disc 1 [rad] under torques [N·mm], shape (loads,) both.

    Raises
    ------
    SolveError
        If the stage has no equilibrium at one of the loads.
    LoadError
        If a torque is zero or not finite.
    """
    solved = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, crank_angle, torque)
    if not solved.converged:
        raise SolveError("load sharing", solved.status.value, "", "take smaller effects", ": ")
    tangent = StageTangent(solved, reducer.deviations, geometric=True)
    contacts = tangent.contacts
    assert isinstance(contacts, CurvedContacts)
    found = tangent.response(
        [one.contact_change(contacts) for one in changes], [_stretch(one, tangent) for one in changes]
    )
    angle = -solved.crank_angle / reducer.case.drive.trochoid.lobes
    read = [one.series_twist(solved.torque) + one.angle_error(angle) for one in changes]
    own = reducer.series_twist(solved.torque) + reducer.angle_error(angle)
    return LoadedDerivatives(
        solved.rotation + own, found.motion[:, 0] + np.stack(read, axis=-1), contacts.pressure, found.pressure
    )


def _stretch(change: ReducerChange, tangent: StageTangent) -> FloatArray | None:
    """Unloaded bearing displacement per unit, less the added deflection of softer or looser bearings."""
    misfit, bearing_deflection_change = (
        change.misfit(tangent.crank_angle),
        change.bearing_deflection_change(tangent.point.bearing_force),
    )
    if misfit is None or bearing_deflection_change is None:
        return misfit if bearing_deflection_change is None else -bearing_deflection_change
    return misfit - bearing_deflection_change
