"""Deformation compensation: load → δmax → profile → load, until δmax converges (docs/theory.md, Eq. 39)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.contact import LoadCase, LoadSharing, SolveStatus
from cycloid_profile.contact.mesh import Backlash, backlash
from cycloid_profile.errors import CompensationError, SolveError
from cycloid_profile.geometry import ToothProfile
from cycloid_profile.modification import DeformationCompensation
from cycloid_profile.units import ARCMIN, NM, UM

_TOLERANCE = 0.1 * NM
_MAX_ROUNDS = 20
# Backlash this far below zero is rounding: 1e-9 rad is 0.05 nm at the flank.
_BACKLASH_ROUNDING = 1e-9


class LoadSharingSolver(Protocol):
    """Any load-sharing solver: ``Classical``, ``Equilibrium``, ``StageEquilibrium``."""

    def solve(self, case: LoadCase) -> LoadSharing:
        """Load on the pins of one disc, or of all discs for a whole-stage solver."""
        ...


@dataclass(frozen=True, slots=True, repr=False)
class Compensation(Described):
    """A compensated profile and how it was found.

    ``case`` holds the profile before compensation; ``profile`` is the compensated one; ``delta_max`` [mm];
    ``history`` δmax after each round [mm]; ``sharing`` the last load sharing, None for a prescribed δmax.

    ``delta_max_least`` and ``delta_max_largest`` are the spread of δmax over the poses [mm]: with elastic discs over
    the carrier angles, as the disc is stiffer where a web stands behind the loaded pins than where a hole does.
    """

    case: LoadCase
    profile: ToothProfile
    delta_max: float
    before: Backlash
    after: Backlash
    history: tuple[float, ...]
    sharing: LoadSharing | None

    def _key_figures(self) -> Mapping[str, str]:
        return {
            "δmax": f"{self.delta_max / UM:.3f} µm after {len(self.history)} rounds",
            "δmax over the poses": f"{self.delta_max_least / UM:.3f} to {self.delta_max_largest / UM:.3f} µm",
            "worst backlash": f"{self.before.worst / ARCMIN:.4f}′ before, {self.after.worst / ARCMIN:.4f}′ after",
        }

    @property
    def delta_max_least(self) -> float:
        """Least deformation of the poses [mm]; ``delta_max`` where that is prescribed."""
        return self.delta_max if self.sharing is None else float(np.min(self.sharing.deformation))

    @property
    def delta_max_largest(self) -> float:
        """Largest deformation of the poses [mm]; ``delta_max`` where that is prescribed."""
        return self.delta_max if self.sharing is None else float(np.max(self.sharing.deformation))

    @property
    def backlash_change(self) -> float:
        """Largest backlash of the mesh cycle, after minus before [rad]; −2 δmax/(a z_c) to first order (Eq. 40)."""
        return self.after.worst - self.before.worst


def compensate(
    case: LoadCase, solver: LoadSharingSolver, tolerance: float = _TOLERANCE, poses: int = 24
) -> Compensation:
    """Compensate the deformation under ``case.torque`` by a fixed-point iteration of profile and load.

    Each round solves the load on the profile with the last δmax added. The iteration ends when δmax changes by
    less than ``tolerance`` [mm]. Radial clearance is unchanged: δ vanishes at root and tip.

    Raises
    ------
    CompensationError
        If the backlash would become negative at some pose.
    SolveError
        If a load solve fails or the iteration does not converge.
    """
    history: list[float] = []
    profile, delta_max = case.profile, 0.0
    for _ in range(_MAX_ROUNDS):
        sharing = solver.solve(replace(case, profile=profile))
        if sharing.status is SolveStatus.INTERFERENCE and history:
            # The last δmax closed the gap completely; the error reports the resulting backlash.
            break
        if sharing.status is not SolveStatus.CONVERGED:
            raise SolveError(
                "load sharing",
                sharing.solver,
                f"ended with '{sharing.status.value}'",
                "bring modification.equidistant_um, radial_moving_um and the torque nearer to zero",
            )
        change = abs(sharing.delta_max - delta_max)
        delta_max = sharing.delta_max
        history.append(delta_max)
        if change < tolerance:
            break
        profile = DeformationCompensation(delta_max).apply(case.profile)
    else:
        raise SolveError(
            "delta_max",
            f"{delta_max / UM:.4f} µm",
            f"still changes by {change / UM:.2g} µm after {_MAX_ROUNDS} rounds",
            "give deformation_compensation as a number in µm",
        )
    return _compensation_result(case, delta_max, tuple(history), sharing, poses)


def compensate_by(case: LoadCase, delta_max: float, poses: int = 24) -> Compensation:
    """Compensate by a given ``delta_max`` [mm]; raises ``CompensationError`` as ``compensate`` does."""
    if not (math.isfinite(delta_max) and delta_max >= 0.0):
        raise CompensationError(
            "delta_max", f"{delta_max} mm", "is negative or not finite", "give the deformation as a positive amount"
        )
    return _compensation_result(case, delta_max, (delta_max,), None, poses)


def _compensation_result(
    case: LoadCase, delta_max: float, history: tuple[float, ...], sharing: LoadSharing | None, poses: int
) -> Compensation:
    profile = DeformationCompensation(delta_max).apply(case.profile)
    before = backlash(case.drive, case.profile, poses)
    after = backlash(case.drive, profile, poses)
    if after.least < -_BACKLASH_ROUNDING or after.binds:
        limit = max(0.0, 0.5 * before.least * case.drive.trochoid.longest_lever)
        raise CompensationError(
            "deformation compensation delta_max",
            f"{delta_max / UM:.3f} µm",
            f"would leave a backlash of {after.least / ARCMIN:.3f}′, the most is {limit / UM:.3f} µm",
            f"raise the equidistant modification or set deformation_compensation to at most {limit / UM:.3f}",
        )
    return Compensation(case, profile, delta_max, before, after, history, sharing)
