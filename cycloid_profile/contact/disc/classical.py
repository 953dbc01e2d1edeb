"""The published engagement iteration: which pins touch, linear in the deformation, one curvature.

Kept as the reference that articles and textbooks use; ``equilibrium`` is the accurate solver.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.case import LoadCase
from cycloid_profile.contact.laws import LineContact
from cycloid_profile.contact.mesh import OVERLAP_TOLERANCE, first_order_backlash
from cycloid_profile.contact.result import STATUSES, LoadSharing, SolveStatus
from cycloid_profile.geometry import modification_sizes


@dataclass(frozen=True, slots=True)
class Classical:
    """Iterates F_max ↔ δmax with pins at multiples of one pitch (docs/theory.md, Eqs. 28–31).

    ``tolerance`` bounds the relative error of the moment balance; the articles stop at 1e-3.
    """

    tolerance: float = 1e-12
    max_iterations: int = 200

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of one disc that carries ``case.disc_share`` of the torque."""
        trochoid = case.drive.trochoid
        count = np.arange(1, (trochoid.pins + 1) // 2, dtype=np.float64)
        psi: FloatArray = 2.0 * math.pi / trochoid.pins * count
        reach = trochoid.lever_function(psi)
        lever = trochoid.longest_lever * reach
        gap = take_up_gap(case, psi)
        contact = _critical_contact(case)

        def carried(force: float, delta: float) -> float:
            return force * float(np.sum(lever * np.maximum(delta * reach - gap, 0.0))) / delta

        history, status, residual = self._iterate(case, contact, carried)
        force, delta = history[-1]
        if _overlaps(case):
            status = SolveStatus.INTERFERENCE
        approach = np.maximum(delta * reach - gap, 0.0)
        forces = force * approach / delta
        stiffness = np.where(approach > 0.0, force / delta, 0.0)
        turn = math.copysign(delta / trochoid.longest_lever, case.torque)

        def one_pose(value: FloatArray) -> FloatArray:
            return value[np.newaxis, np.newaxis]

        return LoadSharing(
            case=replace(case, width=None),
            solver="classical",
            crank_angle=np.zeros(1),
            torque=np.array([case.torque]),
            phase=one_pose(psi),
            gap=one_pose(gap),
            approach=one_pose(approach),
            force=one_pose(forces),
            pressure=one_pose(contact.peak_pressure(forces)),
            lever=one_pose(lever),
            curvature=one_pose(np.full_like(psi, contact.curvature)),
            pin_stiffness=one_pose(stiffness),
            receded=one_pose(np.zeros_like(psi)),
            rotation=np.array([turn]),
            touch=np.zeros(1),
            torsional_stiffness=np.array([np.sum(stiffness * lever**2) / case.disc_share]),
            residual=np.array([residual]),
            outcome=np.array([STATUSES.index(status)]),
            max_force=force,
            deformation=np.array([delta]),
            history=tuple(history),
        )

    def _iterate(
        self, case: LoadCase, contact: LineContact, carried: Callable[[float, float], float]
    ) -> tuple[list[tuple[float, float]], SolveStatus, float]:
        """Pairs (F_max, δmax) until the ``carried`` moment is the disc's torque; how it ended; relative error."""
        disc_torque = case.disc_share * abs(case.torque)
        force = _first_estimate(case)
        least_force = 1e-9 * force
        # The carried moment rises with the force, so the answer stays between these two.
        too_low, too_high = 0.0, math.inf
        history: list[tuple[float, float]] = []
        residual = math.inf
        for _ in range(self.max_iterations):
            delta = float(case.law.approach(force, contact))
            history.append((force, delta))
            moment = carried(force, delta)
            last, residual = residual, abs(moment / disc_torque - 1.0)
            if residual < self.tolerance:
                return history, SolveStatus.CONVERGED, residual
            if moment < disc_torque:
                too_low = force
            else:
                too_high = force
            if too_high < least_force:
                break  # overlapping pins alone carry more than the torque
            published = force * disc_torque / moment if moment > 0.0 and residual < 0.5 * last else math.inf
            force = _inside(published, too_low, too_high)
        return history, SolveStatus.NOT_CONVERGED, residual


def _overlaps(case: LoadCase) -> bool:
    """Whether the set-up leaves less than no backlash, before any load and to first order."""
    equidistant, radial_moving = modification_sizes(case.drive, case.profile)
    removed = first_order_backlash(case.drive, equidistant, radial_moving) * case.drive.trochoid.longest_lever
    return removed < -2.0 * OVERLAP_TOLERANCE


def take_up_gap(case: LoadCase, phase: FloatArray) -> FloatArray:
    """Gap with the disc turned until ψ0 touches, first order in the modification [mm] (Eq. 28).

    Δ(ψ) = Δr_rp(1 − sinψ S) + Δr_p S(1 − K1 cosψ − √(1−K1²) sinψ). A flank removal drops out: on one
    flank it is a rotation.
    """
    nominal = case.drive.trochoid
    equidistant, radial_moving = modification_sizes(case.drive, case.profile)
    K1 = nominal.short_width_ratio
    w = nominal.speed_ratio(phase)
    sin, cos = np.sin(phase), np.cos(phase)
    gap: FloatArray = (
        equidistant * (1.0 - sin / w) + radial_moving * (1.0 - K1 * cos - math.sqrt(1.0 - K1**2) * sin) / w
    )
    return gap


def _critical_contact(case: LoadCase) -> LineContact:
    """The contact at ψ0 of the unmodified tooth, which the scheme uses for every pin."""
    point = case.drive.theoretical_profile.at(case.drive.trochoid.critical_phase)
    return case.line_contact(np.asarray(point.curvature))


def _first_estimate(case: LoadCase) -> float:
    """Mean of the two usual estimates: evenly loaded pins, and one pin at the longest lever [N] (Eq. 31)."""
    trochoid, torque = case.drive.trochoid, abs(case.torque)
    spread = 2.2 * torque / (trochoid.short_width_ratio * trochoid.lobes * trochoid.pin_circle_radius)
    return 0.5 * (spread + case.disc_share * torque / trochoid.longest_lever)


def _inside(force: float, too_low: float, too_high: float) -> float:
    """The published step where it stays in the bracket, else one that halves it (or doubles the force)."""
    if too_low < force < too_high:
        return force
    return 2.0 * too_low if math.isinf(too_high) else 0.5 * (too_low + too_high)
