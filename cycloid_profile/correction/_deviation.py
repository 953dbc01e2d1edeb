"""Size, slope and curvature of the deviation of one tooth from another, round the whole disc."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import removal_between
from cycloid_profile.geometry import ToothProfile

_POINTS_PER_LOBE = 721  # every half degree: shorter waves are given by ``_POINTS_PER_SPACING``
_MOST_POINTS = 8001  # per lobe; bounds the memory for a wave of any number
_POINTS_PER_SPACING = 2  # of a removal's own points: its extremes lie between them


@dataclass(frozen=True, eq=False)
class DeviationFigures:
    """Key figures of the deviation of a program from the drawing.

    ``largest`` deviation and the largest ``stock`` it leaves [mm]; ``max_slope`` slope [mm/mm]; ``curvature_change``,
    the largest [1/mm]; ``least_concave_radius`` of the program [mm], infinite if it is convex.
    """

    largest: float
    stock: float
    max_slope: float
    curvature_change: float
    least_concave_radius: float


def deviation_from_nominal(drawing: ToothProfile, program: ToothProfile) -> DeviationFigures:
    """Key figures of the program against the drawing, on a grid that resolves both."""
    along = phases_round_disc(drawing, program)
    h = removal_along(drawing, program, along)
    old, new = drawing.at(along), program.at(along)
    # Differences within each lobe, so that a corner does not count as slope; the arc length is that of the drawing.
    slope = np.diff(h) / np.maximum(np.abs(np.diff(old.position)), 1e-12)
    least_concave_radius = float(np.max(new.curvature))
    return DeviationFigures(
        largest=float(np.max(np.abs(h))),
        stock=float(np.max(-h, initial=0.0)),
        max_slope=float(np.max(np.abs(slope))),
        curvature_change=float(np.max(np.abs(new.curvature - old.curvature))),
        least_concave_radius=1.0 / least_concave_radius if least_concave_radius > 0.0 else math.inf,
    )


def removal_along(before: ToothProfile, after: ToothProfile, along: FloatArray) -> FloatArray:
    """Removal from ``before`` to ``after`` at phases along the disc, in their shape [mm]."""
    lobe = np.round(along / (2.0 * math.pi))
    return removal_between(before, after, along - 2.0 * math.pi * lobe, lobe)


def phases_round_disc(*teeth: ToothProfile) -> FloatArray:
    """Phases round the whole disc [rad] that resolve the shortest wave of any of the teeth."""
    spacing = [one.point_spacing for tooth in teeth for one in tooth.removals if one.point_spacing is not None]
    wanted = _POINTS_PER_LOBE
    if spacing:
        wanted = max(wanted, math.ceil(_POINTS_PER_SPACING * 2.0 * math.pi / min(spacing)))
    lobes = teeth[0].trochoid.lobes
    count = lobes * min(wanted, _MOST_POINTS)
    # Offset by half a step from roots and tips, so that no point is on a corner.
    return np.linspace(0.5, count - 0.5, count) * (2.0 * math.pi * lobes / count)
