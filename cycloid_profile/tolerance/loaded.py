"""Rotation and pin loads of many reducers under torque, gaps linear about the equilibrium as drawn.

The errors of a reducer open its gaps and stretch its bearings; its own pins then find their own balance, nonlinear and
one-sided as ever. Only where a contact lies is taken from the drawing (docs/tolerance.md, Eq. 59).
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import LEAST_REACH
from cycloid_profile.contact.energy import StageEnergy, minimise
from cycloid_profile.contact.gap import gaps
from cycloid_profile.contact.law_forms import Logarithmic
from cycloid_profile.contact.meshing import mesh
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.contact.support import support_model
from cycloid_profile.effects.built import Built, as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.patterns import GapPlace, UnitChange, gap_change, misfit_change, rows

_TOLERANCE = 1e-7  # of the torque, out of balance
_BLOCK = 24  # reducers at once


@dataclass(frozen=True)
class LoadedStage:
    """The stage as drawn at some loads, a crank angle and a torque each, and what errors change of it.

    ``energy`` about the equilibria, its poses are the loads; ``gap_by_unit`` sparse (loads·discs·pins, coordinates)
    [mm per unit]; ``stretch_by_unit`` sparse (loads·bearings·2, coordinates) [mm per unit]; ``play_by_unit``,
    ``compliance_by_unit`` shape (coordinates,) [mm, rad/(N·mm) per unit]; ``read_by_unit`` shape (loads, coordinates),
    what a sensor adds to the rotation [rad per unit]; ``pressure_per_root_force`` peak pressure of each contact under
    1 N, shape (loads, discs, pins) [MPa]. ``rigid_motion`` shape (loads, unknowns) of all discs with the carrier;
    ``closing``, by how much a turn that way closes each gap, 0 where too little [mm]; ``overclosure``, a further turn
    that surely presses some pins, shape (loads,) [rad].
    """

    built: Built
    crank_angle: FloatArray
    energy: StageEnergy
    gap_by_unit: Any
    stretch_by_unit: Any
    play_by_unit: FloatArray
    compliance_by_unit: FloatArray
    read_by_unit: FloatArray
    pressure_per_root_force: FloatArray
    rigid_motion: FloatArray
    closing: FloatArray
    overclosure: FloatArray

    @property
    def loads(self) -> int:
        """Number of loads."""
        return len(self.crank_angle)

    def answers(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation of the output [rad] and highest peak pressure [MPa] at each load, shape (reducers, loads).

        NaN where a reducer finds no equilibrium.
        """
        blocks = [self._block(x[at : at + _BLOCK]) for at in range(0, len(x), _BLOCK)]
        rotation, pressure = (np.concatenate(each) for each in zip(*blocks, strict=True))
        return rotation, pressure

    def _block(self, x: FloatArray) -> tuple[FloatArray, FloatArray]:
        columns = np.ascontiguousarray(x.T)
        errors = Errors(
            (self.gap_by_unit @ columns).T.reshape(len(x), *self.energy.gap.shape),
            (self.stretch_by_unit @ columns).T.reshape(len(x), *self.energy.stretch.shape),
            np.maximum(self.energy.play + _weighted(x, self.play_by_unit), 0.0),
        )
        turned, pressure = self._solver(self, errors)
        through = self.built.series_compliance + _weighted(x, self.compliance_by_unit)
        read = np.stack([_weighted(x, row) for row in self.read_by_unit], axis=1)
        return turned + through[:, np.newaxis] * self.energy.torque + read, pressure

    @cached_property
    def _solver(self) -> Callable[[LoadedStage, Errors], tuple[FloatArray, FloatArray]]:
        """Compiled where numba is installed and knows the contact law."""
        if importlib.util.find_spec("numba") and isinstance(self.energy.law, Logarithmic):
            return minimised_compiled
        return minimised_plainly


@dataclass(frozen=True)
class Errors:
    """What the errors of some reducers add: ``gap`` shape (reducers, loads, discs, pins), ``stretch`` shape
    (reducers, loads, bearings, 2); and the whole ``play`` of their bearings, shape (reducers,) [mm].
    """

    gap: FloatArray
    stretch: FloatArray
    play: FloatArray

    def applied(self, stage: LoadedStage) -> StageEnergy:
        """Energies of all reducers at all loads, a reducer after the other."""
        count, drawn = len(self.gap), stage.energy

        def each(values: FloatArray) -> FloatArray:
            return np.broadcast_to(values, (count, *values.shape)).reshape(-1, *values.shape[1:])

        gap, stretch = drawn.gap + self.gap, drawn.stretch + self.stretch
        return replace(
            drawn,
            contact=replace(drawn.contact, curvature=each(drawn.contact.curvature)),
            gap=gap.reshape(-1, *drawn.gap.shape[1:]),
            normal_x=each(drawn.normal_x),
            normal_y=each(drawn.normal_y),
            lever=each(drawn.lever),
            spring_stretch=each(drawn.spring_stretch),
            spring_matrix=each(drawn.spring_matrix),
            stretch=stretch.reshape(-1, *drawn.stretch.shape[1:]),
            play=np.repeat(self.play, stage.loads)[:, np.newaxis],
            torque=each(drawn.torque),
            rotation=each(drawn.rotation),
        )


def minimised_plainly(stage: LoadedStage, errors: Errors) -> tuple[FloatArray, FloatArray]:
    """Rotation [rad] and peak pressure [MPa] of every reducer at every load; the readable reference."""
    energy = errors.applied(stage)
    found = minimise(energy, start(stage, errors).reshape(len(energy.gap), -1), _TOLERANCE)
    point = energy.at(found.step)
    per_root = np.broadcast_to(stage.pressure_per_root_force, errors.gap.shape).reshape(point.force.shape)
    pressure = np.max(np.sqrt(point.force) * per_root, axis=(1, 2))
    lost = ~(energy.imbalance(point) < 100.0 * _TOLERANCE)
    shape = errors.gap.shape[:2]
    rotation = np.where(lost, np.nan, energy.rotation + found.step[:, 0])
    return rotation.reshape(shape), np.where(lost, np.nan, pressure).reshape(shape)


def minimised_compiled(stage: LoadedStage, errors: Errors) -> tuple[FloatArray, FloatArray]:
    """The same by ``compiled.balanced``, for laws of the logarithm."""
    from cycloid_profile.tolerance.compiled import balanced

    drawn, law = stage.energy, stage.energy.law
    assert isinstance(law, Logarithmic)
    scale = law.scale(drawn.contact)
    size = drawn.contact.tooth_radius if scale.by_tooth_radius else 1.0
    constant = scale.K0 + math.log(scale.G) + np.log(size / drawn.contact.relative_radius)
    turned, pressure = np.empty(errors.gap.shape[:2]), np.empty(errors.gap.shape[:2])
    balanced(
        scale.G, constant, drawn.gap + errors.gap, np.stack([drawn.normal_x, drawn.normal_y, drawn.lever]),
        drawn.disc_unknowns, drawn.spring_stretch, drawn.stretch + errors.stretch, drawn.bearing_stiffness, errors.play,
        drawn.torque, drawn.rotation, drawn.arm, stage.pressure_per_root_force, start(stage, errors), _TOLERANCE,
        turned, pressure,
    )  # fmt: skip
    return turned, pressure


def start(stage: LoadedStage, errors: Errors) -> FloatArray:
    """Where to start from: all discs turned with the carrier until a pin is pressed, shape (reducers, loads, unknowns).

    From a place without contact no force would say which way to go.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(stage.closing > 0.0, (stage.energy.gap + errors.gap) / stage.closing, np.inf)
    first = np.min(turn, axis=(2, 3)) + stage.overclosure
    begin: FloatArray = (np.sign(stage.energy.torque) * first)[..., np.newaxis] * stage.rigid_motion
    return begin


def _weighted(x: FloatArray, weights: FloatArray) -> FloatArray:
    """Σ x·weights of each row, added in an order that does not depend on how many rows there are."""
    some = np.flatnonzero(weights)
    total: FloatArray = np.sum(x[:, some] * weights[some], axis=1)
    return total


def loaded_stage(built: Built, changes: list[UnitChange], crank_angle: FloatArray, torque: FloatArray) -> LoadedStage:
    """The stage at crank angles of disc 1 [rad] under torques [N·mm], shape (loads,) both.

    The errors of ``built`` itself are taken as those of the reducers are: linear about the drawing.

    Raises
    ------
    SolveError
        If the stage as drawn has no equilibrium at one of the loads.
    LoadError
        If a torque is zero or not finite.
    """
    case = built.case
    solved = StageEquilibrium().at(case, crank_angle, torque)
    if not solved.converged:
        raise SolveError("load sharing of the drawing", solved.status.value, "", "check the spec with accuracy", ": ")
    meshing = mesh(case.drive.trochoid, crank_angle, case.drive.discs)
    support = support_model(case.drive, meshing.crank_angle)
    motion = solved.stage.motion if solved.stage is not None else np.zeros((len(crank_angle), built.discs, 3))
    found = gaps(case.profile, case.drive.pin_radius, meshing, motion[..., 0] + 1j * motion[..., 1], motion[..., 2])
    u = np.zeros((len(crank_angle), support.arm.size))
    u[:, 0] = solved.rotation
    for j, own in enumerate(support.disc_unknowns):
        u[:, own] = motion[:, j]
    place = GapPlace(found.foot, meshing.lobe, found.normal, meshing.crank_angle)
    own = UnitChange(as_drawn(case), built, 1.0)
    opened, stretched = gap_change(own, place), misfit_change(own, meshing.crank_angle)
    stretch = np.einsum("psdu,pu->psd", support.spring_stretch, u)
    contact = case.line_contact(found.curvature)
    energy = StageEnergy(
        law=case.law,
        contact=contact,
        gap=found.gap if opened is None else found.gap + opened,
        normal_x=found.normal.real.copy(),
        normal_y=found.normal.imag.copy(),
        lever=found.lever,
        disc_unknowns=support.disc_unknowns,
        spring_stretch=support.spring_stretch,
        spring_matrix=support.spring_matrix,
        stretch=stretch if stretched is None else stretch + stretched,
        bearing_stiffness=support.stiffness,
        play=support.play,
        torque=solved.torque,
        rotation=solved.rotation,
        arm=support.arm,
    )
    along = support.motion(support.rigid_motion)[:, :, np.newaxis]
    arm = energy.normal_x * along[..., 0] + energy.normal_y * along[..., 1] + energy.lever * along[..., 2]
    arm *= np.sign(solved.torque)[:, np.newaxis, np.newaxis]
    longest = case.drive.trochoid.longest_lever
    pressed = case.law.approach(np.abs(solved.torque) / longest, case.line_contact(np.zeros(len(solved.torque))))
    angle = -meshing.crank_angle[:, 0] / case.drive.trochoid.lobes
    return LoadedStage(
        built=built,
        crank_angle=np.asarray(crank_angle, dtype=np.float64),
        energy=energy,
        gap_by_unit=rows([gap_change(change, place) for change in changes], found.gap.size),
        stretch_by_unit=rows([misfit_change(change, meshing.crank_angle) for change in changes], stretch.size),
        play_by_unit=np.array([change.play for change in changes]),
        compliance_by_unit=np.array([change.series_compliance for change in changes]),
        read_by_unit=np.array([(change.encoder * np.exp(-1j * angle)).real for change in changes]).T,
        pressure_per_root_force=case.law.peak_pressure(np.ones_like(found.gap), contact),
        rigid_motion=support.rigid_motion,
        closing=np.where(arm > LEAST_REACH * longest, arm, 0.0),
        overclosure=0.5 * pressed / longest,
    )
