"""Planar equilibrium of the whole stage: carrier and all discs on elastic bearings (docs/theory.md, Eqs. 35–38).

Quasi-static, input held, housing fixed. Pins are one-sided nonlinear springs along their own normals,
bearings are springs with play. ``minimise`` finds the least energy with gaps linear about a place; the
gaps are then computed anew, exactly, until every force balances.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeVar

from cycloid_profile.arrays import ArrayLike
from cycloid_profile.contact.as_built import AS_DRAWN, AsBuilt
from cycloid_profile.contact.batch import over_blocks, poses_and_torques
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.meshing import mesh, mesh_cycle, remembered_mesh
from cycloid_profile.contact.sharing import LoadSharing, StagePlace, joined
from cycloid_profile.contact.stage_block import StageBlock

Summary = TypeVar("Summary")
# Poses × pins of one call from which compiled code pays, the one time that it must be compiled all but made up for.
_MANY = 500_000


@dataclass(frozen=True, slots=True)
class StageEquilibrium:
    """Solves for the carrier's rotation and the motion of every disc.

    ``poses`` over a mesh cycle for ``solve``; ``tolerance`` bounds the balance of forces and moments over
    the torque; ``as_built`` holds errors of single parts.
    """

    poses: int = 24
    tolerance: float = 1e-10
    as_built: AsBuilt = AS_DRAWN

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of all discs over one mesh cycle."""
        return self.at(case, mesh_cycle(case.drive.trochoid, self.poses))

    def at(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        torque: ArrayLike | None = None,
        near: StagePlace | None = None,
    ) -> LoadSharing:
        """Load on the pins at crank angles of disc 1 [rad], under ``torque`` [N·mm] or that of the case.

        Crank angles and torques are broadcast to poses. A pose that fails keeps its status and never
        disturbs another; the answer of a pose does not depend on what it is solved with.

        ``near``, where a slightly different reducer rests at the same poses under the same torques: the search
        begins there, and the answer is the same within the tolerance. First touch is not looked for then: ``gap``
        and ``touch`` are NaN, and an overlap before load is not reported.

        Raises
        ------
        LoadError
            If a crank angle or torque is not finite, a torque is zero, or ``as_built`` has other parts.
        """
        return joined(list(self.blocks(case, crank_angle, torque, near)))

    def blocks(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        torque: ArrayLike | None = None,
        near: StagePlace | None = None,
    ) -> Iterator[LoadSharing]:
        """The same, a block of poses at a time in order: for more poses than the memory holds pins of."""
        self.as_built.check(case.drive)
        phi, T = poses_and_torques(crank_angle, case.torque if torque is None else torque)
        compiled = phi.size * case.drive.trochoid.pins * case.drive.discs >= _MANY

        def solved(cut: slice) -> LoadSharing:
            # Beside a known place one reducer after another is looked at in the same poses.
            meshed = mesh if near is None else remembered_mesh
            meshing = meshed(case.drive.trochoid, phi[cut], case.drive.discs)
            block = StageBlock(case, self.as_built, self.tolerance, meshing, T[cut])
            return block.solved(None if near is None else near.poses(cut), compiled)

        return over_blocks(solved, phi.size)

    def summaries(
        self,
        case: LoadCase,
        crank_angle: ArrayLike,
        summary: Callable[[LoadSharing], Summary],
        torque: ArrayLike | None = None,
    ) -> list[Summary]:
        """``summary`` of each block, in order; nothing else is kept."""
        return [summary(block) for block in self.blocks(case, crank_angle, torque)]
