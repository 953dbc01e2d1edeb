"""Published and twice-computed numbers of the RV-40E tooth.

Source: the tooth-profile article (RV-40E: z_p = 40, r_p = 64, r_rp = 3, a = 1.3 mm) for the data; the
results were computed twice independently by direct numerical geometry.
Symbols: ψ = 0 at the root; ρ of the tooth, convex negative; docs/theory.md, Eqs. 2–12.
Tolerances: half a unit of the last digit the source states; closed forms (radii at root and tip) 1e-12 mm.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from cycloid_profile.geometry import inflection_phase, least_radii, undercut_limit


def test_short_width_ratio(rv40e):
    assert rv40e.trochoid.short_width_ratio == pytest.approx(0.8125, abs=1e-15)


def test_root_and_tip_radius(theoretical):
    assert abs(theoretical.at(0.0).position) == pytest.approx(59.7, abs=1e-12)
    assert abs(theoretical.at(math.pi).position) == pytest.approx(62.3, abs=1e-12)


def test_undercut_limit(rv40e):
    assert undercut_limit(rv40e.trochoid) == pytest.approx(4.6117, abs=5e-5)


def test_least_radii(theoretical):
    radii = least_radii(theoretical)
    assert radii.convex == pytest.approx(1.6117, abs=5e-5)
    assert radii.concave == pytest.approx(3.0714, abs=5e-5)
    assert radii.largest_corner == 0.0


def test_inflection_and_longest_lever_lie_a_degree_apart(theoretical):
    assert math.degrees(inflection_phase(theoretical)) == pytest.approx(34.64, abs=5e-3)
    assert math.degrees(theoretical.trochoid.critical_phase) == pytest.approx(35.66, abs=5e-3)


def test_curvature_radius_at_the_longest_lever(theoretical):
    # The source gives ρ = −34.3095: near the inflection it changes by 1 mm in 0.03°.
    rho = 1.0 / theoretical.at(theoretical.trochoid.critical_phase).curvature
    assert float(rho) == pytest.approx(-34.3095, abs=5e-5)


def test_reduction_ratio_of_the_whole_reducer(rv40e):
    assert rv40e.reduction_ratio == 121.0


def test_whole_disc_closes(theoretical):
    assert theoretical.trochoid.phase_period == pytest.approx(78.0 * math.pi)
    ends = theoretical.at(np.array([0.0, theoretical.trochoid.phase_period])).position
    assert abs(ends[1] - ends[0]) < 1e-11
