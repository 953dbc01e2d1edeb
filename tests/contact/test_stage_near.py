"""An equilibrium sought near that of a similar reducer is the one that is found from the first touch."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, StagePositions
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.geometry import CentralEccentric
from cycloid_profile.modification import Equidistant, RadialMoving, modify

SOLVER = StageEquilibrium()


def case_of(drive, torque, *changes):
    return LoadCase(drive, modify(drive.theoretical_profile, *changes), torque)


def assert_same(near, cold):
    assert np.all(near.settled)
    np.testing.assert_allclose(near.rotation, cold.rotation, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(near.place.motion, cold.place.motion, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(near.force, cold.force, rtol=0.0, atol=1e-6 * cold.max_force)
    np.testing.assert_allclose(near.torsional_stiffness, cold.torsional_stiffness, rtol=1e-6)


@settings(max_examples=12, deadline=None)
@given(
    before=st.tuples(st.floats(0.0, 0.012), st.floats(-0.004, 0.004), st.floats(0.0, 0.006)),
    after=st.tuples(st.floats(0.0, 0.012), st.floats(-0.004, 0.004), st.floats(0.0, 0.006)),
    share=st.sampled_from([-1.0, -0.03, 0.03, 1.0]),
    central=st.booleans(),
)
def test_the_way_there_does_not_matter(rv40e, rated_torque, before, after, share, central):
    crank = output_turn(rv40e.trochoid, 5)
    found = []
    for equidistant, radial, play in (before, after):
        support = CentralEccentric(2e5, play) if central else replace(rv40e.support, bearing_play=play)
        drive = replace(rv40e, support=support, first_stage=None if central else rv40e.first_stage)
        case = case_of(drive, share * rated_torque, Equidistant(0.004 + equidistant), RadialMoving(radial))
        found.append((case, SOLVER.at(case, crank)))
    (_, start), (case, cold) = found
    assume(start.converged and cold.converged)
    assert_same(SOLVER.at(case, crank, near=start.place), cold)


def test_blocks_take_their_own_part_of_the_place(rv40e, rated_torque):
    case = case_of(rv40e, rated_torque, Equidistant(0.006))
    crank = output_turn(rv40e.trochoid, 300)  # more than a block
    cold = SOLVER.at(case, crank)
    near = SOLVER.at(case, crank, near=cold.place)
    assert_same(near, cold)
    assert np.all(np.isnan(near.touch))
    assert np.all(np.isnan(near.gap))


def test_a_place_far_away_is_left_for_the_right_one_or_reported(rv40e, rated_torque):
    case = case_of(rv40e, rated_torque, Equidistant(0.006))
    crank = output_turn(rv40e.trochoid, 4)
    cold = SOLVER.at(case, crank)
    # Resting on the other flank, as under the torque turned round.
    other = SOLVER.at(case, crank, -rated_torque).place
    assert_same(SOLVER.at(case, crank, near=other), cold)
    nowhere = StagePositions(np.full(4, np.nan), np.full((4, 2, 3), np.nan))
    assert not np.any(SOLVER.at(case, crank, near=nowhere).settled)


def test_only_first_touch_is_missing(rv40e, rated_torque):
    case = case_of(rv40e, rated_torque, Equidistant(0.006))
    crank = output_turn(rv40e.trochoid, 3)
    cold = SOLVER.at(case, crank)
    near = SOLVER.at(case, crank, near=cold.place)
    arrays = {f.name for f in fields(cold) if isinstance(getattr(cold, f.name), np.ndarray)}
    missing = {name for name in arrays if np.any(np.isnan(np.asarray(getattr(near, name), dtype=float)))}
    assert missing == {"gap", "touch"}
    assert near.delta_max == pytest.approx(cold.delta_max, rel=1e-6)
