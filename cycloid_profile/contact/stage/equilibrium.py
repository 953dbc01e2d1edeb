"""Planar equilibrium of the whole stage: carrier and all discs on elastic bearings (docs/theory.md, Eqs. 35–38).

Quasi-static, input held, housing fixed. Pins are one-sided nonlinear springs along their own normals,
bearings are springs with play. ``minimise`` finds the least energy with gaps linearised at a configuration; the
gaps are then recomputed exactly until every force balances.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from cycloid_profile.arrays import ArrayLike
from cycloid_profile.contact._blocks import over_blocks, poses_and_torques, poses_per_block
from cycloid_profile.contact.bodies import NO_DEVIATIONS, PartDeviations, kept_compliance
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.mesh import mesh, remembered_mesh
from cycloid_profile.contact.result import LoadSharing, StagePositions, joined
from cycloid_profile.contact.stage._block import StageBlock

Summary = TypeVar("Summary")
# Poses × pins of one call from which compiled code saves more time than its compilation takes once.
_MANY = 500_000


@dataclass(frozen=True, slots=True)
class StageEquilibrium:
    """Solves for the carrier's rotation and the motion of every disc.

    ``poses`` over a mesh cycle for ``solve``; ``tolerance`` bounds the balance of forces and moments over
    the torque; ``deviations`` holds errors of single parts. Without ``stiffness``, the torsional stiffness is NaN: of
    elastic discs it takes a sixth of the time.
    """

    poses: int = 24
    tolerance: float = 1e-10
    deviations: PartDeviations = NO_DEVIATIONS
    stiffness: bool = True

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of all discs over the cycle in which it repeats, ``LoadCase.cycle``."""
        return self.at(case, case.cycle(self.poses))

    def at(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        torque: ArrayLike | None = None,
        near: StagePositions | None = None,
    ) -> LoadSharing:
        """Load on the pins at crank angles of disc 1 [rad], under ``torque`` [N·mm] or that of the case.

        Crank angles and torques are broadcast to poses. A pose that fails keeps its status; the
        answer of a pose does not depend on the other poses.

        ``near``, equilibrium of a slightly different reducer at the same poses under the same torques: the search
        starts there, and the answer is the same within the tolerance. With ``near``, ``gap`` and ``touch`` are
        NaN, and interference of the unloaded parts is not reported.

        Raises
        ------
        LoadError
            If a crank angle or torque is not finite, a torque is zero, or ``deviations`` has other parts.
        """
        return joined(list(self.blocks(case, crank_angle, torque, near)))

    def blocks(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        torque: ArrayLike | None = None,
        near: StagePositions | None = None,
    ) -> Iterator[LoadSharing]:
        """Results of ``at`` for consecutive blocks of poses, when all poses together exceed the memory."""
        self.deviations.check(case.drive)
        phi, T = poses_and_torques(crank_angle, case.torque if torque is None else torque)
        # Callers with a nearby equilibrium solve one reducer after another at the same poses.
        if near is not None:
            kept_compliance(case.disc_bodies, case.drive.trochoid, phi)
        compiled = phi.size * case.drive.trochoid.pins * case.drive.discs >= _MANY

        def solved(cut: slice) -> LoadSharing:
            meshed = mesh if near is None else remembered_mesh
            meshing = meshed(case.drive.trochoid, phi[cut], case.drive.discs)
            block = StageBlock(case, self.deviations, self.tolerance, meshing, T[cut], stiffness=self.stiffness)
            return block.solved(None if near is None else near.poses(cut), compiled)

        forces = case.drive.discs * case.drive.trochoid.pins if case.elastic else 0
        return over_blocks(solved, phi.size, poses_per_block(forces))

    def summaries(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        summary: Callable[[LoadSharing], Summary],
        torque: ArrayLike | None = None,
    ) -> list[Summary]:
        """``summary`` of each block, in order; the blocks themselves are discarded."""
        return [summary(block) for block in self.blocks(case, crank_angle, torque)]
