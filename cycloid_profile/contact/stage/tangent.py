"""The stage linearised about an equilibrium: its response to small changes of gaps, bearing fits and flank geometry.

Without geometric terms only the contact forces change with the motion (docs/theory.md, Eq. 50). With geometric terms
normals, levers and curvatures change with it as well, and the derivatives are exact (docs/tolerance.md, Eqs. 62–64).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cycloid_profile.arrays import FloatArray, IntArray
from cycloid_profile.contact.bodies import NO_DEVIATIONS, PartDeviations, SupportModel, support_model
from cycloid_profile.contact.mesh import Gaps
from cycloid_profile.contact.result import LoadSharing
from cycloid_profile.contact.stage._linear_compliance import solve_linear_compliance
from cycloid_profile.contact.stage.energy import EnergyPoint, StageEnergy
from cycloid_profile.contact.stage.loaded_contacts import (
    ContactChange,
    LoadedContacts,
    curved_contacts,
    loaded_contacts,
)
from cycloid_profile.errors import LoadError

_RCOND = 1e-13


class StageResponse(NamedTuple):
    """Response to changes: ``motion`` of carrier and discs, shape (poses, unknowns, changes) [rad, mm]; change of
    ``pressure`` at the loaded contacts, shape (contacts, changes) [MPa].
    """

    motion: FloatArray
    pressure: FloatArray


@dataclass(frozen=True, eq=False)
class StageTangent:
    """Linearisation about the equilibria ``sharing`` of a whole stage with part ``deviations``.

    If ``geometric``, normals, levers and curvatures change with the motion. Every property raises ``LoadError`` for
    solvers of a single disc.
    """

    sharing: LoadSharing
    deviations: PartDeviations = NO_DEVIATIONS
    geometric: bool = False

    @cached_property
    def energy(self) -> StageEnergy:
        """Energy about the equilibria; its gaps are correct for loaded pins only."""
        return energy_about(self.sharing, self.deviations)

    @cached_property
    def point(self) -> EnergyPoint:
        """Forces at the equilibria."""
        return self.energy.at(np.zeros((len(self.energy.torque), self.energy.arm.size)))

    @property
    def crank_angle(self) -> FloatArray:
        """Crank angle of each disc, shape (poses, discs) [rad]."""
        assert self.sharing.stage is not None
        return self.sharing.stage.meshing.crank_angle

    @cached_property
    def bearing_tangent(self) -> FloatArray:
        """Tangent stiffness of each bearing, shape (poses, bearings, 2, 2) [N/mm]."""
        return self.energy.bearing_tangent(self.point)

    @cached_property
    def contacts(self) -> LoadedContacts:
        """Contacts that carry a force; with geometric terms, at their exact foot points."""
        if self.geometric:
            return curved_contacts(self.sharing, self.deviations)
        return loaded_contacts(self.sharing)

    @property
    def pins(self) -> FloatArray:
        """Rotation of the output per gap at each pin, normals fixed, shape (poses, discs, pins) [rad/mm]."""
        pins = self.sharing.force[0].size
        return -self._unit_torque[1][:, :pins].reshape(self.sharing.force.shape)

    @property
    def bearings(self) -> FloatArray:
        """Rotation of the output per unloaded deflection of each bearing, shape (poses, bearings, 2) [rad/mm]."""
        pins = self.sharing.force[0].size
        return self._unit_torque[1][:, pins:].reshape(self.energy.stretch.shape)

    @property
    def motion_per_deformation(self) -> FloatArray:
        """Motion of carrier and discs per deformation of every pin and bearing, normals fixed, shape (poses, unknowns,
        forces), zero without equilibrium [rad/mm, 1].
        """
        _, forces, motion = self._by_unit_loads()
        return np.swapaxes(self._balancing(forces, motion), 1, 2)

    @property
    def torsional_compliance(self) -> FloatArray:
        """Rotation of the output per torque with every disc free to follow, shape (poses,), zero without equilibrium
        [rad/(N·mm)].
        """
        return self._unit_torque[0]

    @cached_property
    def _unit_torque(self) -> tuple[FloatArray, FloatArray]:
        """Rotation of the output per torque, shape (poses,), and per deformation, shape (poses, forces)."""
        _, forces, motion = self._by_unit_loads()
        return _finite(motion[:, 0, 0]), self._balancing(forces, motion[..., :1])[..., 0]

    def _by_unit_loads(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Deformations J per motion, the forces that they need, and the motion by a unit load on each part.

        Shape (poses, forces, unknowns), the last (poses, unknowns, unknowns); not kept, since they are large.
        """
        J = self.energy.by_motion
        forces = self.energy.stiffness_times(self.point, J)
        unit = np.broadcast_to(np.eye(J.shape[2]), (len(J), J.shape[2], J.shape[2]))
        return J, forces, solve_linear_compliance(np.swapaxes(J, 1, 2) @ forces, unit, _RCOND)

    def _balancing(self, forces: FloatArray, motion: FloatArray) -> FloatArray:
        """Motion of a loaded part per deformation of every pin and bearing, shape (poses, forces, loads).

        By reciprocity: the forces of pins and bearings that balance the loads, which cause this ``motion`` of all
        parts, shape (poses, unknowns, loads).
        """
        return -_finite((forces @ motion)[:, : self.energy.pins_and_bearings])

    def forces_per_deformation(self, pins: IntArray) -> FloatArray:
        """Force of some ``pins`` of each pose, shape (poses, some), per deformation of every pin and bearing, carrier
        and discs free to follow, shape (poses, some, forces), zero without equilibrium [N/mm].
        """
        J, by_motion, motion = self._by_unit_loads()
        unit = np.zeros((*J.shape[:2], pins.shape[1]))
        np.put_along_axis(unit, pins[:, np.newaxis], 1.0, axis=1)
        follow = motion @ (np.swapaxes(by_motion, 1, 2) @ unit)
        # The matrix is symmetric: a deformation at A loads B as one at B loads A.
        forces = np.swapaxes(self.energy.stiffness_times(self.point, unit - J @ follow), 1, 2)
        return _finite(forces[..., : self.energy.pins_and_bearings])

    def rotation(self, gap: FloatArray | float, misfit: FloatArray | float = 0.0) -> FloatArray:
        """Rotation of the output due to changes of gaps and bearing fits [mm], shape (poses,) [rad].

        The result is of first order, with fixed normals.
        """
        turned: FloatArray = np.sum(self.pins * gap, axis=(1, 2)) + np.sum(self.bearings * misfit, axis=(1, 2))
        return turned

    def response(self, changes: Sequence[ContactChange], misfits: Sequence[FloatArray | None]) -> StageResponse:
        """Response to changes at the ``contacts`` and of bearing fits [mm], by the implicit function theorem."""
        energy, contacts, pins = self.energy, self.contacts, self.sharing.force[0].size
        own = energy.disc_unknowns[contacts.disc]
        row = contacts.disc * self.sharing.force.shape[2] + contacts.pin
        moving, derived = contacts.by_motion(), [contacts.by_change(change) for change in changes]
        # A force that changes at a fixed approach, with the curvature, acts like a deformation.
        deformation = np.concatenate([energy.by_motion, np.zeros((*energy.by_motion.shape[:2], len(derived)))], axis=2)
        deformation[contacts.pose[:, np.newaxis], row[:, np.newaxis], own] = _per(contacts.stiffness, moving.force)
        unknowns = energy.arm.size
        for number, (one, misfit) in enumerate(zip(derived, misfits, strict=True), start=unknowns):
            deformation[contacts.pose, row, number] = one.force / contacts.stiffness
            if misfit is not None:
                deformation[:, pins : pins + misfit[0].size, number] = misfit.reshape(len(misfit), -1)
        forces = energy.stiffness_times(self.point, deformation)
        balance = np.swapaxes(energy.by_motion, 1, 2) @ forces
        where = (contacts.pose[:, np.newaxis, np.newaxis], own[:, :, np.newaxis], own[:, np.newaxis, :])
        np.add.at(balance, where, moving.turned)
        for number, one in enumerate(derived, start=unknowns):
            np.add.at(balance[..., number], (contacts.pose[:, np.newaxis], own), one.turned)
        matrix, load = balance[..., :unknowns], balance[..., unknowns:]
        motion = -solve_linear_compliance(matrix, load, _RCOND, symmetric=not self.geometric)
        changed = forces[..., unknowns:] + forces[..., :unknowns] @ motion
        moved = motion[contacts.pose[:, np.newaxis], own]
        bent = np.stack([one.curvature for one in derived], axis=-1) + np.einsum("ci,cin->cn", moving.curvature, moved)
        return StageResponse(motion, contacts.pressure_change(changed[contacts.pose, row], bent))


def _finite(values: FloatArray) -> FloatArray:
    return np.asarray(np.nan_to_num(values, posinf=0.0, neginf=0.0))


def _per(stiffness: FloatArray, force: FloatArray) -> FloatArray:
    return force / stiffness[:, np.newaxis]


def energy_about(sharing: LoadSharing, deviations: PartDeviations = NO_DEVIATIONS) -> StageEnergy:
    """Energy of the stage with ``deviations`` about its equilibrium; its gaps are correct for loaded pins only.

    Raises
    ------
    LoadError
        If the solver treated a single disc.
    """
    stage = sharing.stage
    if stage is None:
        raise LoadError(
            "solver", sharing.solver, "keeps the crank fixed and has no bearing model", "solve the whole stage"
        )
    support = support_model(sharing.case.drive, stage.meshing.crank_angle, deviations, sharing.case.width)
    # An unloaded pin is out of reach: with the recession of its disc alone, rounding would decide whether it touches.
    receded = sum(sharing.receded_supports.values(), sharing.receded)
    gap = np.where(sharing.force > 0.0, -sharing.approach - receded, np.inf)
    lever = np.sign(sharing.torque)[:, np.newaxis, np.newaxis] * sharing.lever
    return energy_with(sharing, support, Gaps(gap, stage.foot, stage.normal, lever, sharing.curvature))


def energy_with(sharing: LoadSharing, support: SupportModel, gaps: Gaps) -> StageEnergy:
    """Energy about solved equilibria of a whole stage at which the pins have these ``gaps``."""
    assert sharing.stage is not None
    u = np.zeros((len(sharing.torque), support.arm.size))
    u[:, 0] = sharing.rotation
    for j, own in enumerate(support.disc_unknowns):
        u[:, own] = sharing.stage.motion[:, j]
    if sharing.stage.tilt is not None:
        u[:, support.tilt_unknowns] = sharing.stage.tilt
    compliance = sharing.case.body_compliance(sharing.stage.meshing)
    return StageEnergy.about(sharing.case, support, gaps, u, sharing.torque, compliance, sharing.load)
