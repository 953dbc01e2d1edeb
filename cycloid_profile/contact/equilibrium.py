"""True moment balance of one disc on a rigid crank: every pin nonlinear, with its own curvature."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.backlash import OVERLAP_TOLERANCE, first_touch
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.hertz import LineContact
from cycloid_profile.contact.meshing import mesh, mesh_cycle
from cycloid_profile.contact.sharing import LoadSharing, Status


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """Solves Σ F_i(β l_i − Δ_i) l_i = T/discs for the rotation β (docs/theory.md, Eq. 34).

    Gaps Δ_i are exact and taken where the disc first touches; levers and curvatures stay those of first touch
    (at rated torque of an RV-40E that costs 0.1 % of the rotation); ``poses`` cover one mesh cycle.
    ``tolerance`` bounds the relative error of the moment balance.
    """

    poses: int = 24
    tolerance: float = 1e-12
    max_iterations: int = 60

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of one disc that carries its ideal share of the torque."""
        trochoid = case.drive.trochoid
        direction = math.copysign(1.0, case.torque)
        meshing = mesh(trochoid, mesh_cycle(trochoid, self.poses))
        touch = first_touch(case.profile, case.drive.pin_radius, meshing, direction)
        found = touch.gaps
        # Rounding leaves the touching gap a few 1e-16 either side of zero.
        gap, lever = np.maximum(found.gap[:, 0], 0.0), direction * found.lever[:, 0]
        contact = case.line_contact(found.curvature[:, 0])
        disc_torque = abs(case.torque) / case.drive.discs

        beta = _upper_bound(case, contact, gap, lever, disc_torque)
        history: list[tuple[float, float]] = []
        status, residual = Status.NOT_CONVERGED, math.inf
        for _ in range(self.max_iterations):
            approach = np.maximum(beta[:, np.newaxis] * lever - gap, 0.0)
            force = case.law.force(approach, contact)
            moment = np.sum(force * lever, axis=-1)
            residual = float(np.max(np.abs(moment / disc_torque - 1.0)))
            history.append((float(np.max(force)), float(np.max(beta)) * trochoid.longest_lever))
            if residual < self.tolerance:
                status = Status.CONVERGED
                break
            stiffness = np.where(approach > 0.0, case.law.stiffness(force, contact), 0.0)
            # The carried moment is convex and rising in β: Newton from above descends without overshoot.
            beta = beta - (moment - disc_torque) / np.sum(stiffness * lever**2, axis=-1)
        if not touch.settled:
            status = Status.NO_CONTACT
        elif float(np.min(found.gap)) < -OVERLAP_TOLERANCE:
            status = Status.INTERFERENCE
        return LoadSharing(
            case=case,
            solver="equilibrium",
            phase=direction * meshing.phase[:, 0],
            gap=gap,
            approach=approach,
            force=force,
            pressure=contact.peak_pressure(force),
            lever=lever,
            rotation=beta,
            max_force=float(np.max(force)),
            delta_max=float(np.max(beta)) * trochoid.longest_lever,
            status=status,
            residual=residual,
            history=tuple(history),
        )


def _upper_bound(case: LoadCase, contact: LineContact, gap: FloatArray, lever: FloatArray, torque: float) -> FloatArray:
    """Rotation at which one pin alone would carry all, least over the pins, shape (poses,) [rad]."""
    # Pins with a short lever are left out: alone they would need a force no contact law covers.
    long_arm = 0.5 * np.max(lever, axis=-1, keepdims=True)
    arm = np.maximum(lever, long_arm)
    alone = (gap + case.law.approach(torque / arm, contact)) / arm
    bound: FloatArray = np.min(np.where(lever >= long_arm, alone, np.inf), axis=-1)
    return bound
