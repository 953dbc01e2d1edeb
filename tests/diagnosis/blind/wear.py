"""Where a flank wears: pressure times sliding, after Archard, of one disc on a fixed crank at rated torque."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from .contact import Line, line, peak_pressure
from .reducer import Reducer
from .units import NEWTON_METRE, UM

Array = np.ndarray
_POSES = 60


@lru_cache(maxsize=8)
def wear_shape(reducer: Reducer) -> tuple[Array, Array]:
    """Phases from −π to π and the wear there on the flank of positive torque, 1 at its deepest."""
    r = reducer
    K1 = r.short_width_ratio
    psi = np.linspace(-math.pi, math.pi, _POSES * r.pins, endpoint=False)
    w = np.sqrt(1.0 + K1 * K1 - 2.0 * K1 * np.cos(psi))
    lever = r.eccentricity_mm * r.lobes * np.sin(psi) / w
    gap = (r.equidistant_um + r.radial_moving_um * (1.0 - K1 * np.cos(psi)) / w) * UM
    gap = gap - r.compensation_um * UM * np.abs(np.sin(psi)) / w
    # The centre of a pin rolls on the radius w³ r_p/(...): the tooth is parallel to its path.
    bend = (K1 * (r.pins + 1) * np.cos(psi) - 1.0 - r.pins * K1 * K1) / (r.pin_circle_radius_mm * w**3)
    curvature = bend / (1.0 + bend * (r.pin_radius_mm + r.equidistant_um * UM))
    law = line(
        curvature, np.full_like(psi, r.pin_radius_mm), r.disc_width_mm, r.contact_compliance, r.pin_circle_radius_mm
    )
    share = r.rated_torque_nm * NEWTON_METRE / r.discs
    force = np.zeros_like(psi)
    for pose in range(_POSES):
        mine = slice(pose, None, _POSES)

        def excess(turn: float, mine: slice = mine) -> float:
            return float(np.dot(_forces(law, turn * lever - gap)[mine], lever[mine]) - share)

        force[mine] = _forces(law, brentq(excess, 0.0, 0.002, xtol=1e-15) * lever - gap)[mine]
    sliding = np.abs(r.pin_circle_radius_mm * w - r.pin_radius_mm)
    depth = peak_pressure(force, law.relative_radius, r.disc_width_mm, r.contact_compliance) * sliding
    ends = np.append(psi, math.pi)
    return ends, np.append(depth, depth[0]) / np.max(depth)


def _forces(law: Line, approach: Array) -> Array:
    return law.answer(approach)[0]
