"""A cloud of points holds the numbers of the curve, however many points are asked for at once."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cycloid_profile.geometry import point_cloud
from cycloid_profile.modification import DeformationCompensation, Equidistant, modify

FLANKS = (Equidistant(0.006), DeformationCompensation(0.0019))


@pytest.mark.parametrize("changes", [(), FLANKS], ids=["plain", "flanks"])
def test_points_of_a_cloud_are_those_of_the_curve_to_the_last_bit(theoretical, changes):
    # Two whole blocks and a part of one; a hundred points across every seam are asked for alone.
    tooth = modify(theoretical, *changes)
    phase = np.linspace(0.0, 2.0 * math.pi * 39.0, 40_000, endpoint=False)
    cloud = point_cloud(tooth, phase)
    np.testing.assert_array_equal(cloud.phase, phase)
    for start in (0, 8_000, 16_334, 32_718, 39_900):
        cut = slice(start, start + 100)
        points = tooth.at(phase[cut])
        for name in ("position", "normal", "curvature"):
            np.testing.assert_array_equal(getattr(cloud, name)[cut], getattr(points, name), err_msg=name, strict=True)


@pytest.mark.parametrize("points", [0, 1])
def test_cloud_of_hardly_any_points(theoretical, points):
    cloud = point_cloud(theoretical, np.zeros(points))
    assert cloud.position.shape == cloud.normal.shape == cloud.curvature.shape == (points,)
    # The root: a disc's least radius, r_p − a − r_rp, on the x axis.
    np.testing.assert_allclose(cloud.position, 64.0 - 1.3 - 3.0, rtol=1e-15)
    np.testing.assert_allclose(cloud.normal, 1.0, rtol=1e-15)
