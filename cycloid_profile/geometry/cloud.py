"""Position, normal and curvature at very many points: what a grinding or measuring point cloud holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cycloid_profile.arrays import ArrayLike, ComplexArray, FloatArray
from cycloid_profile.geometry.profile import ToothProfile

_BLOCK = 16_384  # points; a block and its temporaries stay in the cache


@dataclass(frozen=True, slots=True)
class PointCloud:
    """Points of a tooth curve, each shape (points,).

    ``phase`` [rad]; ``position`` x + iy [mm]; ``normal``, outward and unit; ``curvature``, negative where
    the tooth is convex [1/mm].
    """

    phase: FloatArray
    position: ComplexArray
    normal: ComplexArray
    curvature: FloatArray


def point_cloud(profile: ToothProfile, phase: ArrayLike) -> PointCloud:
    """Points at the given phases, shape (points,) [rad]; the numbers are those of ``ToothProfile.at``."""
    psi = np.asarray(phase, dtype=np.float64)
    position, normal = (np.empty(psi.shape, dtype=np.complex128) for _ in range(2))
    curvature = np.empty(psi.shape)
    for start in range(0, psi.size, _BLOCK):
        cut = slice(start, start + _BLOCK)
        points = profile.at(psi[cut])
        position[cut], normal[cut], curvature[cut] = points.position, points.normal, points.curvature
    return PointCloud(psi, position, normal, curvature)
