"""How far, how steeply and how sharply one tooth departs from another, round the whole disc."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects.pattern import removal_between
from cycloid_profile.geometry.profile import ToothProfile

_POINTS_PER_LOBE = 721
_MOST_POINTS = 8001
_POINTS_PER_SPACING = 2


@dataclass(frozen=True, eq=False)
class Shape:
    """How a program departs from the drawing.

    ``largest`` departure and the part of it that leaves material on (``added``) [mm]; ``steepest`` [mm/mm];
    ``bending``, largest change of curvature [1/mm]; ``concave``, least concave radius of the program [mm], or inf.
    """

    largest: float
    added: float
    steepest: float
    bending: float
    concave: float


def shape_of(drawing: ToothProfile, program: ToothProfile) -> Shape:
    """How far, how steeply and how sharply the program departs from the drawing, on a grid fine enough for both."""
    along = round_disc(drawing, program)
    h = removal_along(drawing, program, along)
    old, new = drawing.at(along), program.at(along)
    # Lobe by lobe, so that a corner is no slope; the arc is that of the drawing.
    slope = np.diff(h) / np.maximum(np.abs(np.diff(old.position)), 1e-12)
    concave = float(np.max(new.curvature))
    return Shape(
        largest=float(np.max(np.abs(h))),
        added=float(np.max(-h, initial=0.0)),
        steepest=float(np.max(np.abs(slope))),
        bending=float(np.max(np.abs(new.curvature - old.curvature))),
        concave=1.0 / concave if concave > 0.0 else math.inf,
    )


def removal_along(before: ToothProfile, after: ToothProfile, along: FloatArray) -> FloatArray:
    """What ``after`` lacks at phases along the disc, in their shape [mm]."""
    lobe = np.round(along / (2.0 * math.pi))
    return removal_between(before, after, along - 2.0 * math.pi * lobe, lobe)


def round_disc(*teeth: ToothProfile) -> FloatArray:
    """Phases round the whole disc, fine enough for the shortest wave of any of the teeth [rad]."""
    spacing = [one.spacing for tooth in teeth for one in tooth.removals if one.spacing is not None]
    wanted = _POINTS_PER_LOBE
    if spacing:
        wanted = max(wanted, math.ceil(_POINTS_PER_SPACING * 2.0 * math.pi / min(spacing)))
    lobes = teeth[0].trochoid.lobes
    count = lobes * min(wanted, _MOST_POINTS)
    # Half a step off the roots and tips, so that no point falls on a corner.
    return np.linspace(0.5, count - 0.5, count) * (2.0 * math.pi * lobes / count)
