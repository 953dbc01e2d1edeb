"""How rotation and pressure under load answer to a small change of any part (docs/tolerance.md, Eqs. 62–64).

Implicit function theorem at the exact equilibrium: the tangent of all forces, geometry included, is solved against
what a change puts out of balance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.energy import EnergyPoint, StageEnergy
from cycloid_profile.contact.influence import energy_about
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects.built import Built
from cycloid_profile.errors import SolveError
from cycloid_profile.tolerance.contact_slopes import ChangeSlopes, LoadedContacts, MotionSlopes, loaded_contacts
from cycloid_profile.tolerance.patterns import UnitChange, misfit_change


@dataclass(frozen=True)
class LoadedSlopes:
    """Answers at some loads and their derivatives by the coordinates of the changes.

    ``rotation`` as an encoder reads it, shape (loads,) [rad], and ``rotation_by_unit``, shape (loads, coordinates);
    ``pressure`` of every loaded contact of all loads, shape (contacts,) [MPa], and ``pressure_by_unit``.
    """

    rotation: FloatArray
    rotation_by_unit: FloatArray
    pressure: FloatArray
    pressure_by_unit: FloatArray


def loaded_slopes(built: Built, changes: list[UnitChange], crank_angle: FloatArray, torque: FloatArray) -> LoadedSlopes:
    """The stage as built at crank angles of disc 1 [rad] under torques [N·mm], shape (loads,) both.

    Raises
    ------
    SolveError
        If the stage has no equilibrium at one of the loads.
    LoadError
        If a torque is zero or not finite.
    """
    solved = StageEquilibrium(as_built=built.parts).at(built.case, crank_angle, torque)
    if not solved.converged:
        raise SolveError("load sharing", solved.status.value, "", "take smaller effects", ": ")
    contacts = loaded_contacts(built, solved)
    moving = contacts.by_motion()
    balance = _Balance(built, solved, contacts, moving)
    own = balance.energy.disc_unknowns[contacts.disc]
    rotation = np.empty((len(solved.torque), len(changes)))
    pressure = np.empty((len(contacts.force), len(changes)))
    angle = -solved.crank_angle / built.case.drive.trochoid.lobes
    for number, change in enumerate(changes):
        by_change = contacts.by_change(change)
        u = balance.answer(change, by_change)
        read = change.series_compliance * solved.torque + (change.encoder * np.exp(-1j * angle)).real
        rotation[:, number] = u[:, 0] + read
        moved = u[contacts.load[:, np.newaxis], own]
        force = by_change.force + np.sum(moving.force * moved, axis=1)
        bent = by_change.curvature + np.sum(moving.curvature * moved, axis=1)
        # Hertz: the pressure goes with the root of the force.
        pressure[:, number] = 0.5 * contacts.pressure * force / contacts.force + contacts.pressure_by_curvature * bent
    through = built.series_compliance * solved.torque + (built.encoder * np.exp(-1j * angle)).real
    return LoadedSlopes(solved.rotation + through, rotation, contacts.pressure, pressure)


class _Balance:
    """Tangent of all generalised forces about the equilibria."""

    def __init__(self, built: Built, solved: LoadSharing, contacts: LoadedContacts, moving: MotionSlopes) -> None:
        self.built, self.solved, self.contacts = built, solved, contacts
        self.energy: StageEnergy = energy_about(solved, built.parts)
        self.point: EnergyPoint = self.energy.at(np.zeros((len(solved.torque), self.energy.arm.size)))
        self.bearing_tangent = self.energy.bearing_tangent(self.point)
        stretch = self.energy.spring_stretch
        flat = (len(stretch), -1, self.energy.arm.size)
        matrix = np.swapaxes(stretch.reshape(flat), 1, 2) @ (self.bearing_tangent @ stretch).reshape(flat)
        own = self.energy.disc_unknowns[contacts.disc]
        where = (contacts.load[:, np.newaxis, np.newaxis], own[:, :, np.newaxis], own[:, np.newaxis, :])
        np.add.at(matrix, where, moving.push)
        self._own = own
        # A disc afloat in the play of its bearings has nothing to answer with: it stays where it is.
        self._inverse = np.linalg.pinv(matrix, rcond=1e-13)

    def answer(self, change: UnitChange, by_change: ChangeSlopes) -> FloatArray:
        """How carrier and discs move per unit of a change, shape (loads, unknowns) [rad and mm per unit]."""
        out_of_balance = np.zeros((len(self.solved.torque), self.energy.arm.size))
        np.add.at(out_of_balance, (self.contacts.load[:, np.newaxis], self._own), by_change.push)
        bearings = self._of_bearings(change)
        if bearings is not None:
            out_of_balance += np.einsum("psdu,psd->pu", self.energy.spring_stretch, bearings)
        found: FloatArray = -(self._inverse @ out_of_balance[..., np.newaxis])[..., 0]
        return found

    def _of_bearings(self, change: UnitChange) -> FloatArray | None:
        """Force on every bearing per unit, the stage held, shape (loads, bearings, 2) [N]; None for nothing."""
        stage = self.solved.stage
        assert stage is not None
        misfit = misfit_change(change, stage.meshing.crank_angle)
        total = None if misfit is None else np.einsum("psde,pse->psd", self.bearing_tangent, misfit)
        old, new = change.before.case.drive.support, change.after.case.drive.support
        softer = (1.0 / new.bearing_stiffness - 1.0 / old.bearing_stiffness) / change.step
        if not (softer or change.play):
            return total
        stretch = self.point.stretch
        length = np.hypot(stretch[..., 0], stretch[..., 1])[..., np.newaxis]
        way = np.where(length > self.energy.play, stretch / np.where(length > 0.0, length, 1.0), 0.0)
        stiffness = self.energy.bearing_stiffness
        eased: FloatArray = -stiffness * (change.play * way + softer * self.point.bearing_force)
        return eased if total is None else total + eased
