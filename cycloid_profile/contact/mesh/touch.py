"""First touch of a disc and its pins, and backlash with the crank locked (docs/theory.md, Eqs. 32–33)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from cycloid_profile._display import Described
from cycloid_profile.arrays import ArrayLike, BoolArray, FloatArray
from cycloid_profile.contact.bodies import crank_turn_per_carrier_turn
from cycloid_profile.contact.mesh.foot_point import Gaps, gaps
from cycloid_profile.contact.mesh.meshing import Meshing, mesh, mesh_cycle
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry import Drive, ToothProfile
from cycloid_profile.units import ARCMIN, UM

_MAX_STEPS = 40
# A gap of this share of the pin circle is rounding.
_ROUNDING = 1.5e-15
# A pin near root or tip has almost no lever: turning cannot open or close its gap.
LEAST_REACH = 0.05
OVERLAP_TOLERANCE = 1e-5  # mm; 10 nm of overlap is below any grinding error, and does not bind a drive


@dataclass(frozen=True, eq=False, slots=True)
class FirstTouch:
    """Rotation of each disc at which its first pin touches, with the gaps there.

    ``rotation`` shape (poses, discs), signed [rad]; ``gaps`` at that rotation, shape (poses, discs, pins);
    ``settled`` shape (poses, discs), True where the iteration ended at a touch.
    """

    rotation: FloatArray
    gaps: Gaps
    settled: BoolArray


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class Backlash(Described):
    """Rotation between the two flanks at poses over one mesh cycle, arrays of shape (poses,) [rad].

    ``least_gap`` is the smallest gap with the disc midway between its two touches [mm]: below zero the
    disc cannot be assembled without force.
    """

    forward: FloatArray
    backward: FloatArray
    least_gap: float

    def _key_figures(self) -> Mapping[str, str]:
        return {
            "poses": f"{len(self.forward)}",
            "backlash": f"{self.least / ARCMIN:.4f}′ to {self.worst / ARCMIN:.4f}′",
            "least gap midway": f"{self.least_gap / UM:.3f} µm",
        }

    @property
    def values(self) -> FloatArray:
        """Backlash at each pose, shape (poses,) [rad]."""
        return self.forward - self.backward

    @property
    def worst(self) -> float:
        """Largest over the mesh cycle [rad]."""
        return float(np.max(self.values))

    @property
    def least(self) -> float:
        """Smallest over the mesh cycle [rad]; negative where the drive binds."""
        return float(np.min(self.values))

    @property
    def binds(self) -> bool:
        """Whether disc and pins overlap at some pose whatever the rotation."""
        return self.least_gap < -OVERLAP_TOLERANCE


def first_touch(profile: ToothProfile, pin_radius: ArrayLike, meshing: Meshing, direction: ArrayLike) -> FirstTouch:
    """Turn each disc by itself in ``direction`` (±1, broadcast to poses × discs) until a pin touches, exactly.

    ``pin_radius`` is one for all or one for each pin [mm].
    Each step closes the smallest gap/lever, which converges quadratically because the levers hardly
    change. Where disc and pins overlap to begin with, the rotation is against ``direction``.
    """
    rotation = np.zeros(meshing.phase.shape[:-1])
    way = np.broadcast_to(np.asarray(direction, dtype=np.float64), rotation.shape)
    rounding = _ROUNDING * profile.trochoid.pin_circle_radius
    seen = gaps(profile, pin_radius, meshing, rotation=rotation)
    settled = np.zeros(rotation.shape, dtype=np.bool_)
    active = np.arange(len(rotation))
    for _ in range(_MAX_STEPS):
        turn = closing_turn(profile, seen.gap[active], way[active, :, np.newaxis] * seen.lever[active])
        first = np.argmin(turn, axis=-1)[..., np.newaxis]
        step, left = (np.take_along_axis(value, first, axis=-1)[..., 0] for value in (turn, seen.gap[active]))
        touching = (np.abs(left) < rounding) & np.isfinite(step) & ~np.any(np.isnan(seen.gap[active]), axis=-1)
        settled[active] = touching
        rotation[active] += way[active] * np.where(touching | ~np.isfinite(step), 0.0, step)
        # A pose that has settled is left alone, so that it does not depend on the others.
        active = active[~np.all(touching, axis=-1)]
        if not active.size:
            break
        start = seen.foot[active]
        seen.put(active, gaps(profile, pin_radius, meshing.poses(active), rotation=rotation[active], start=start))
    return FirstTouch(rotation, seen, settled)


def closing_turn(profile: ToothProfile, gap: FloatArray, arm: FloatArray) -> FloatArray:
    """Turn that closes each gap by its arm, infinite for pins with too little arm to be closed [rad]."""
    least = LEAST_REACH * profile.trochoid.longest_lever
    turn: FloatArray = np.where(arm > least, gap / np.maximum(arm, least), np.inf)
    return turn


def backlash(drive: Drive, profile: ToothProfile, poses: int = 24) -> Backlash:
    """Crank-locked backlash of one disc over ``poses`` poses of a mesh cycle, by exact contact.

    Raises ``SolveError`` if at some pose no first touch is found.
    """
    meshing = mesh(drive.trochoid, mesh_cycle(drive.trochoid, poses))
    forward, backward = (_settled_touch(profile, drive, meshing, direction) for direction in (+1.0, -1.0))
    middle = gaps(profile, drive.pin_radius, meshing, rotation=0.5 * (forward + backward))
    return Backlash(forward[:, 0], backward[:, 0], float(np.min(middle.gap)))


def _settled_touch(profile: ToothProfile, drive: Drive, meshing: Meshing, direction: float) -> FloatArray:
    touch = first_touch(profile, drive.pin_radius, meshing, direction)
    if not np.all(touch.settled):
        raise SolveError(
            "first touch",
            "not found",
            f"within {_MAX_STEPS} steps",
            "bring modification.equidistant_um and radial_moving_um nearer to zero",
            " ",
        )
    return touch.rotation


def first_order_backlash(drive: Drive, equidistant: float, radial_moving: float) -> float:
    """2[Δr_rp + Δr_p √(1−K1²)]/(a z_c), amounts in mm [rad] (Eq. 32)."""
    K1 = drive.trochoid.short_width_ratio
    return 2.0 * (equidistant + radial_moving * math.sqrt(1.0 - K1**2)) / drive.trochoid.longest_lever


def input_locked_factor(drive: Drive) -> float:
    """Backlash with the input held, over backlash with the crank held: z_c/(z_p + z1/z2) (Eq. 33)."""
    return drive.trochoid.lobes / (drive.trochoid.lobes + crank_turn_per_carrier_turn(drive))
