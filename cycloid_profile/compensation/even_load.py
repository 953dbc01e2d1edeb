"""A tooth with clearance that shares the rated load as the theoretical tooth does (docs/theory.md, Eqs. 95–97)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.compensation.fixed_point import LoadSharingSolver
from cycloid_profile.contact import LoadCase, LoadSharing, SolveStatus
from cycloid_profile.contact.mesh import Backlash, backlash
from cycloid_profile.errors import CompensationError, SolveError
from cycloid_profile.geometry import ToothProfile, least_radii
from cycloid_profile.modification import FlankRotation, RootAndTipRelief, modify
from cycloid_profile.units import ARCMIN, UM

# An equilibrium whose forces balance this well, over the torque, is good enough to compare forces.
_BALANCED = 1e-6
_BISECTIONS = 30
_LONGEST_RELIEF = 0.98  # of the longest lever


@dataclass(frozen=True, slots=True, repr=False)
class EvenLoad(Described):
    """A tooth of even load and its two load sharings.

    ``profile`` is the tooth; ``root_reach`` and ``tip_reach``, shares of the longest lever at which its working flank
    begins and ends; ``sharing`` its load sharing under the torque of the case; ``theoretical`` that of the theoretical
    tooth; ``play``, its backlash.
    """

    profile: ToothProfile
    root_reach: float
    tip_reach: float
    sharing: LoadSharing
    theoretical: LoadSharing
    play: Backlash

    @property
    def force_rise(self) -> float:
        """Largest force over that of the theoretical tooth, minus 1."""
        return self.sharing.max_force / self.theoretical.max_force - 1.0

    def _key_figures(self) -> Mapping[str, str]:
        pair = (self.sharing, self.theoretical)
        pins = " / ".join(f"{one.fewest_loaded_pins} to {one.loaded_pins}" for one in pair)
        return {
            "working flank": f"from {self.root_reach:.3f} at the root to {self.tip_reach:.3f} at the tip",
            "largest pin force, even / theoretical": " / ".join(f"{one.max_force:.1f} N" for one in pair),
            "peak pressure, even / theoretical": " / ".join(f"{one.max_pressure:.0f} MPa" for one in pair),
            "loaded pins, even / theoretical": pins,
            "worst backlash": f"{self.play.worst / ARCMIN:.4f}′",
        }


def even_load_profile(
    case: LoadCase,
    radial_clearance: float,
    play: float,
    solver: LoadSharingSolver,
    relieved_share: float = 0.01,
    least_root_radius: float | None = None,
    poses: int = 24,
) -> EvenLoad:
    """Tooth with clearance that shares ``case.torque`` as the theoretical tooth of ``case.drive`` does.

    A removal proportional to the lever is a rotation of the flank. Once that is taken up all pins touch together, and
    each carries its force on the theoretical tooth, on rigid and elastic discs (Eqs. 95, 96). Root and tip are relieved
    (Eq. 97): as short as possible, yet so far that pins with ``relieved_share`` of the torque on the theoretical tooth
    lie in the relief of either end, and that a pin fits into the root. ``case.profile`` is not used.

    Parameters
    ----------
    case : drive, torque, materials, contact law and disc bodies
    radial_clearance : at root and tip [mm]
    play : backlash with the crank locked, to first order [rad]
    solver : one with exact gaps, ``Equilibrium`` or ``StageEquilibrium``
    relieved_share : between 0 and 1
    least_root_radius : concave radius of the tooth [mm]; absent: pin radius plus twice the clearance. A smaller one
        makes the relief of the root shorter, and asks for a grinding wheel as small
    poses : of the backlash, over a mesh cycle

    Raises
    ------
    CompensationError
        If clearance or play is not positive, the share outside 0 to 1, or the root too narrow for the clearance.
    SolveError
        If a load solve fails.
    GeometryError
        If the tooth cannot exist.
    """
    for name, value in (("radial_clearance", radial_clearance), ("play", play)):
        if not (math.isfinite(value) and value > 0.0):
            raise CompensationError(name, value, "is not positive", "give a positive amount")
    if not 0.0 < relieved_share < 1.0:
        raise CompensationError(
            "relieved_share", relieved_share, "is outside 0 to 1", "0.01 relieves 1 % of the torque"
        )
    drive = case.drive
    theoretical = _solved(solver, replace(case, profile=drive.theoretical_profile))
    near_root, near_tip = (_lever_share(theoretical, relieved_share, root) for root in (True, False))
    smallest = drive.pin_radius + 2.0 * radial_clearance if least_root_radius is None else least_root_radius

    def tooth(root_reach: float) -> ToothProfile:
        relief = RootAndTipRelief(radial_clearance, root_reach, near_tip)
        return modify(drive.theoretical_profile, FlankRotation(0.5 * play), relief)

    root_reach = _shortest(lambda reach: least_radii(tooth(reach)).concave >= smallest, near_root)
    if root_reach is None:
        raise CompensationError(
            "radial_clearance",
            f"{radial_clearance / UM:.3f} µm",
            f"leaves the root no concave radius of {smallest:.4f} mm",
            "give a smaller clearance or least_root_radius",
        )
    profile = tooth(root_reach)
    sharing = _solved(solver, replace(case, profile=profile))
    return EvenLoad(profile, root_reach, near_tip, sharing, theoretical, backlash(drive, profile, poses))


def _lever_share(sharing: LoadSharing, share: float, root: bool) -> float:
    """Lever over the longest, below which pins on one side of ψ0 carry ``share`` of the torque of all poses."""
    trochoid = sharing.case.drive.trochoid
    carried = np.where((np.cos(sharing.phase) > trochoid.short_width_ratio) == root, sharing.force * sharing.lever, 0.0)
    lever = np.abs(sharing.lever).ravel()
    order = np.argsort(lever)
    total = np.cumsum(carried.ravel()[order])
    below = int(np.searchsorted(total, share * float(np.sum(sharing.force * sharing.lever))))
    at = float(lever[order[min(below, order.size - 1)]]) / trochoid.longest_lever
    return min(max(at, 1e-3), _LONGEST_RELIEF)


def _shortest(fits: Callable[[float], bool], least: float) -> float | None:
    """The least reach from ``least`` on that ``fits``, which longer ones do as well; None without any."""
    if fits(least):
        return least
    low, high = least, _LONGEST_RELIEF
    if not fits(high):
        return None
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if fits(middle) else (middle, high)
    return high


def _solved(solver: LoadSharingSolver, case: LoadCase) -> LoadSharing:
    sharing = solver.solve(case)
    if sharing.status is not SolveStatus.CONVERGED and not (sharing.converged or sharing.max_residual < _BALANCED):
        what = f"ended with '{sharing.status.value}'"
        raise SolveError("load sharing", sharing.solver, what, "raise relieved_share, or check the torque")
    return sharing
