"""First-order patterns: what an effect adds to the gap of every pin and to the fit of every bearing.

To first order the answers follow from these by ``contact.influence``: one product instead of a new solve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.contact.gap import Gaps
from cycloid_profile.contact.meshing import Meshing
from cycloid_profile.contact.support import support_model
from cycloid_profile.effects.built import Built
from cycloid_profile.geometry.profile import ToothProfile
from cycloid_profile.geometry.removal import flank_side


@dataclass(frozen=True, slots=True)
class Pattern:
    """Changes between two reducers [mm]: ``gap`` shape (poses, discs, pins), ``misfit`` (poses, bearings, 2)."""

    gap: FloatArray
    misfit: FloatArray


def removal_between(before: ToothProfile, after: ToothProfile, phase: FloatArray, lobe: FloatArray) -> FloatArray:
    """Material that ``after`` lacks along the normal, in the shape of ``phase`` [mm]; first order.

    Points of the same phase are compared, which takes any change of the curve, whatever it was made by; where only
    removals were added, these are summed.
    """
    more = len(before.removals)
    same = after.trochoid == before.trochoid and after.pin_radius == before.pin_radius
    if same and after.removals[:more] == before.removals:
        along = phase + 2.0 * np.pi * lobe
        side = flank_side(phase)
        return sum((one.jet(along, side, after.trochoid).value for one in after.removals[more:]), np.zeros_like(along))
    old, new = before.at(phase, None, lobe), after.at(phase, None, lobe)
    h: FloatArray = -(np.conj(old.normal) * (new.position - old.position)).real
    return h


def pattern(before: Built, after: Built, meshing: Meshing, found: Gaps) -> Pattern:
    """What changed from one reducer to another at the gaps ``found`` of the first."""
    h = np.stack(
        [
            removal_between(old, new, found.foot[:, j], meshing.lobe[:, j])
            for j, (old, new) in enumerate(zip(before.teeth, after.teeth, strict=True))
        ],
        axis=1,
    )
    moved = (np.conj(found.normal) * (after.pin_shift - before.pin_shift)).real
    supports = (support_model(built.case.drive, meshing.crank_angle, built.parts).misfit for built in (before, after))
    old_fit, new_fit = supports
    return Pattern(h + moved - (after.pin_oversize - before.pin_oversize), new_fit - old_fit)
