"""How the output answers to a small change of any gap or bearing fit, about an equilibrium (docs/theory.md, Eq. 50)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.as_built import AS_DRAWN, AsBuilt
from cycloid_profile.contact.energy import StageEnergy
from cycloid_profile.contact.following import following
from cycloid_profile.contact.sharing import LoadSharing
from cycloid_profile.contact.support import support_model
from cycloid_profile.errors import LoadError


@dataclass(frozen=True, slots=True)
class Influence:
    """Rotation of the output per gap and per bearing fit [rad/mm].

    ``pins`` shape (poses, discs, pins); ``bearings`` shape (poses, bearings, 2), of a stretch at rest in x and y. A
    change of many parts turns the output by the sum of change times influence.
    """

    sharing: LoadSharing
    pins: FloatArray
    bearings: FloatArray

    def rotation(self, gap: FloatArray, misfit: FloatArray | float = 0.0) -> FloatArray:
        """Turn of the output by changes of gaps and fits [mm], shape (poses,) [rad]; first order."""
        turned: FloatArray = np.sum(self.pins * gap, axis=(1, 2)) + np.sum(self.bearings * misfit, axis=(1, 2))
        return turned


def influence(sharing: LoadSharing, as_built: AsBuilt = AS_DRAWN) -> Influence:
    """Influences about a solved stage, whose parts were ``as_built``; raises ``LoadError`` for solvers of one disc."""
    energy = energy_about(sharing, as_built)
    point = energy.at(np.zeros((len(energy.torque), energy.arm.size)))
    hessian = energy.hessian(point)
    carrier = np.zeros_like(point.gradient)
    carrier[:, 0] = 1.0
    answer = following(hessian, carrier[..., np.newaxis], rcond=1e-13)[..., 0]
    moved = answer[:, energy.disc_unknowns][..., np.newaxis, :]
    along = energy.normal_x * moved[..., 0] + energy.normal_y * moved[..., 1] + energy.lever * moved[..., 2]
    stretched = np.einsum("psdu,pu->psd", energy.spring_stretch, answer)
    bearings = -np.einsum("psde,pse->psd", energy.bearing_tangent(point), stretched)
    return Influence(sharing, sharing.pin_stiffness * along, bearings)


def energy_about(sharing: LoadSharing, as_built: AsBuilt = AS_DRAWN) -> StageEnergy:
    """Energy of the stage about its equilibrium, whose parts were ``as_built``; only loaded pins have their gap.

    Raises
    ------
    LoadError
        If the solver was one of a single disc.
    """
    stage = sharing.stage
    if stage is None:
        raise LoadError("solver", sharing.solver, "holds the crank and knows no bearings", "solve the whole stage")
    support = support_model(sharing.case.drive, stage.meshing.crank_angle, as_built)
    u = np.zeros((len(sharing.torque), support.arm.size))
    u[:, 0] = sharing.rotation
    for j, own in enumerate(support.disc_unknowns):
        u[:, own] = stage.motion[:, j]
    return StageEnergy(
        law=sharing.case.law,
        contact=sharing.case.line_contact(sharing.curvature),
        gap=-sharing.approach,
        normal_x=stage.normal.real,
        normal_y=stage.normal.imag,
        lever=np.sign(sharing.torque)[:, np.newaxis, np.newaxis] * sharing.lever,
        disc_unknowns=support.disc_unknowns,
        spring_stretch=support.spring_stretch,
        spring_matrix=support.spring_matrix,
        stretch=support.misfit + np.einsum("psdu,pu->psd", support.spring_stretch, u),
        bearing_stiffness=support.stiffness,
        play=support.play,
        torque=sharing.torque,
        rotation=sharing.rotation,
        arm=support.arm,
    )
