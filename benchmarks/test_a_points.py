"""(a) Points of the tooth against the sines and cosines nobody can save."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import cycloid_profile as cp
from cycloid_profile.geometry import point_cloud

POINTS = 1_000_000


def test_point_cloud(side_by_side: Callable[..., Any], rv40e: cp.LoadCase) -> None:
    trochoid = rv40e.drive.trochoid
    psi = np.linspace(0.0, trochoid.phase_period, POINTS, endpoint=False)
    # The angles are divided beforehand: the bare side is nothing but sin and cos.
    half, slow = 0.5 * psi, psi / trochoid.lobes

    cloud = side_by_side(
        ours=lambda: point_cloud(rv40e.profile, psi),
        plain=lambda: (np.sin(half), np.cos(half), np.sin(slow), np.cos(slow)),
        rounds=15,
        row="(a) 1,000,000 points: profile, normal, curvature",
        against="two bare sin + cos pairs",
        figure="ours / bare",
        most=3.0,
    )

    assert np.all(np.abs(np.abs(cloud.normal) - 1.0) < 1e-12)
