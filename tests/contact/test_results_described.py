"""Results introduce themselves in a few lines, and as a table."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.contact import Equilibrium, LoadCase, StageEquilibrium, backlash, gaps, mesh_cycle
from cycloid_profile.contact.mesh import mesh
from cycloid_profile.modification import Equidistant, modify


@pytest.fixture
def case(rv40e, rated_torque):
    return LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)


@pytest.mark.parametrize("solver", [Equilibrium(poses=3), StageEquilibrium(poses=3)])
def test_load_sharing(case, solver):
    sharing = solver.solve(case)
    text = repr(sharing)
    assert len(text.splitlines()) <= 15
    assert f"{sharing.max_force:.1f} N" in text
    frame = pytest.importorskip("pandas") and sharing.to_frame()
    assert len(frame) == sharing.force.size
    one = frame[(frame.pose == 2) & (frame.disc == 0) & (frame.pin == 7)].iloc[0]
    assert one.force == sharing.force[2, 0, 7]
    assert one.crank_angle == sharing.crank_angle[2]


def test_gaps_and_backlash(case, rv40e):
    found = gaps(case.profile, rv40e.pin_radius, mesh(rv40e.trochoid, mesh_cycle(rv40e.trochoid, 2)))
    assert "2 × 1 × 40" in repr(found)
    assert f"{np.min(found.gap) * 1e3:.3f} µm" in repr(found)
    assert "′" in repr(backlash(rv40e, case.profile, 4))
