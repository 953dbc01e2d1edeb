"""The compiled search from a known equilibrium against the search with exact gaps that it shortens."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import PinSeats, StagePositions, Supports
from cycloid_profile.contact.bodies import AxialRelief, FaceWidth
from cycloid_profile.contact.laws import STEEL
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium, equilibrium
from cycloid_profile.contact.stage import _nearby as near
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import (
    AsBuiltReducer,
    CrankBearingClearance,
    CrankHoleError,
    CumulativePitchError,
    DiscRunout,
    FlankWear,
    GrindingChatter,
    MissingDeformationCompensation,
    PinRingOval,
    RadialMovingError,
    SinglePinError,
    SingleToothError,
    WheelWearDrift,
)
from cycloid_profile.geometry import Trochoid
from cycloid_profile.modification import DeformationCompensation, modify
from cycloid_profile.spec import read_spec

FEW = output_turn(Trochoid(40, 64.0, 1.3), 3)
POSES = 60
# Few pins hold a disc within the play of its bearings: a balance to 1e-10 of a light torque leaves it 1e-8 mm free.
TOLERANCES = {"rotation": 1e-12, "motion": 1e-9, "motion in play": 1e-7}  # rad, mm, mm

signed = st.floats(-4.0, 4.0)
size = st.floats(0.1, 4.0)
angle = st.floats(0.0, 360.0)
effects = st.lists(
    st.one_of(
        st.builds(CumulativePitchError, amplitude_um=size, phase_deg=angle),
        st.builds(DiscRunout, amplitude_um=size, phase_deg=angle, form=st.sampled_from([1, 2]), disc=st.just(1)),
        st.builds(SingleToothError, amount_um=signed, lobe=st.integers(1, 39), disc=st.just(2)),
        st.builds(WheelWearDrift, amount_um=size, first_lobe=st.integers(1, 39)),
        st.builds(PinRingOval, amplitude_um=size, phase_deg=angle),
        st.builds(CrankHoleError, amplitude_um=size, direction_deg=angle, crank=st.integers(1, 3), disc=st.just(1)),
        st.builds(CrankBearingClearance, radial_um=size),
        # Corners at root and tip, a tooth known by points, and waves shorter than a contact is wide.
        st.builds(MissingDeformationCompensation, amount_um=signed),
        st.builds(FlankWear, amount_um=size),
        st.builds(GrindingChatter, amplitude_um=st.floats(0.05, 0.4), waves_per_turn=st.floats(100.0, 1500.0)),
    ),
    min_size=1,
    max_size=3,
)


@pytest.fixture(scope="module")
def drawn() -> AsBuiltReducer:
    spec = read_spec(Path(__file__).parents[1] / "rig" / "measured" / "spec.toml")
    return as_built_reducer(spec)


def solved(reducer: AsBuiltReducer, share: float, place=None):
    crank = output_turn(reducer.case.drive.trochoid, POSES)
    return StageEquilibrium(deviations=reducer.deviations).at(
        reducer.case, crank, share * reducer.case.torque, near=place
    )


def with_exact_gaps(reducer: AsBuiltReducer, share: float, place=None):
    """The search with exact gaps at every step, which the compiled one leaves nothing to as a rule."""
    whole = near.settled_near

    def none(*args):
        u, seen, settled = whole(*args)
        u[:] = args[-3]
        return u, seen, np.zeros_like(settled)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("cycloid_profile.contact.stage._block.settled_near", none)
        return solved(reducer, share, place)


def both_ways(reducer: AsBuiltReducer, share: float, place):
    """Compiled, and with exact gaps at every step."""
    return solved(reducer, share, place), with_exact_gaps(reducer, share, place)


def assert_equal(found, expected, rotation=TOLERANCES["rotation"]):
    assert np.all(found.settled)
    np.testing.assert_allclose(found.rotation, expected.rotation, rtol=0.0, atol=rotation)
    motion = TOLERANCES["motion in play" if expected.case.drive.support.bearing_play else "motion"]
    # A disc that no pin presses on floats in the play of its bearings: nothing determines where.
    held = np.any(expected.force > 0.0, axis=2)
    np.testing.assert_allclose(found.place.motion[held], expected.place.motion[held], rtol=0.0, atol=motion)
    np.testing.assert_allclose(found.force, expected.force, rtol=0.0, atol=1e-6 * expected.max_force)
    # A pin with a wide gap presses on nothing: the series about its foot is not renewed, and its foot may be off.
    near_touch = (expected.force > 0.0) | (expected.gap < 0.002)
    assert np.any(near_touch)
    for name, atol in (("lever", 1e-6), ("curvature", 1e-6)):
        mine, exact = (getattr(each, name)[near_touch] for each in (found, expected))
        np.testing.assert_allclose(mine, exact, rtol=1e-4 if name == "curvature" else 0.0, atol=atol)
    for mine, exact in ((found.place.foot, expected.place.foot), (found.stage.normal, expected.stage.normal)):
        np.testing.assert_allclose(mine[near_touch], exact[near_touch], rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found.torsional_stiffness, expected.torsional_stiffness, rtol=1e-6)


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(some=effects, share=st.sampled_from([1.0, -1.0, 0.03, -0.03]))
@example(some=[CumulativePitchError(2.0, 0.0), CrankBearingClearance(1.5)], share=0.03)
def test_whatever_effects_a_reducer_has(drawn, some, share):
    place = solved(drawn, share).place
    reducer = drawn
    for effect in some:
        reducer = effect.apply(reducer)
    assert_equal(*both_ways(reducer, share, place))


@pytest.mark.parametrize("foot_known", [True, False])
def test_the_feet_need_not_be_known(drawn, foot_known):
    place = solved(drawn, 1.0).place
    reducer = CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn)
    asked = place if foot_known else type(place)(place.rotation, place.motion)
    assert_equal(*both_ways(reducer, 1.0, asked))


@pytest.mark.parametrize("start", ["near", "within the backlash"])
@pytest.mark.parametrize("share", [1.0, -0.03])
@pytest.mark.parametrize(
    "body",
    [
        {},
        {"supports": Supports(PinSeats(3.0, 24.15, (-6.325, 6.325), 11.5, STEEL, STEEL, 0.006, 20.0, 35.0))},
        {"width": FaceWidth(11.5, 4, tooth=AxialRelief(taper=0.003), tilt_stiffness=2.5e6)},
    ],
    ids=["rigid", "on elastic pins", "tilting"],
)
def test_a_few_poses_settle_at_once_and_with_exact_gaps(drawn, share, body, start, monkeypatch):
    # No pose is left to the plain search, which would hide what the compiled one does wrong.
    rounds, whole = [], near.settled_near

    def all_of_them(*args):
        rounds.append(whole(*args))
        return rounds[-1]

    place = StagePositions(np.zeros(3), np.zeros((3, 2, 3)))
    if start == "near":
        place = StageEquilibrium().at(drawn.case, FEW, share * drawn.case.torque).place
    reducer = replace(drawn, case=replace(drawn.case, **body))
    for effect in (
        CumulativePitchError(amplitude_um=1.0, phase_deg=20.0), DiscRunout(amplitude_um=1.0, phase_deg=50.0, disc=2),
        RadialMovingError(amount_um=1.0), PinRingOval(amplitude_um=2.0, phase_deg=80.0),
        SinglePinError(amount_um=2.0, pin=3), CrankHoleError(amplitude_um=2.0, direction_deg=40.0, crank=2),
    ):  # fmt: skip
        reducer = effect.apply(reducer)
    solver, torque = StageEquilibrium(tolerance=1e-12, deviations=reducer.deviations), share * reducer.case.torque
    monkeypatch.setattr("cycloid_profile.contact.stage._block.settled_near", all_of_them)
    found = solver.at(reducer.case, FEW, torque, near=place)
    assert rounds
    assert all(np.all(settled) for _, _, settled in rounds)
    monkeypatch.undo()
    # Feet that came from further off leave the curvature of a removal, and with it the contact, less exact.
    rotation = TOLERANCES["rotation"] * (1.0 if start == "near" else 10.0)
    assert_equal(found, solver.at(reducer.case, FEW, torque), rotation)


@pytest.mark.parametrize(
    ("effect", "taken"),
    [
        (MissingDeformationCompensation(amount_um=1.0), True),
        (FlankWear(amount_um=2.0), True),
        (GrindingChatter(amplitude_um=0.1, waves_per_turn=800.5), True),
        # So steep that a pin has a foot on either side of a wave.
        (GrindingChatter(amplitude_um=1.0, waves_per_turn=1500.0), False),
    ],
    ids=["corners", "points", "waves", "steep waves"],
)
def test_the_short_cut_is_taken_where_it_can_be_and_only_there(drawn, effect, taken, monkeypatch):
    place = solved(drawn, 1.0).place
    answers = []
    whole = near.settled_near

    def watched(*args):
        answers.append(whole(*args))
        return answers[-1]

    monkeypatch.setattr("cycloid_profile.contact.stage._block.settled_near", watched)
    assert np.all(solved(effect.apply(drawn), 1.0, place).settled)
    assert [answer is not None and bool(np.mean(answer[2]) > 0.9) for answer in answers] == [taken]


@pytest.mark.parametrize("share", [1.0, -0.03])
def test_from_first_touch_on(drawn, share, monkeypatch):
    """Without a place to start from, first touch is found and reported."""
    reducer = FlankWear(amount_um=1.0).apply(CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn))
    plain = solved(reducer, share)
    monkeypatch.setattr(equilibrium, "_MANY", POSES * 80)
    compiled = solved(reducer, share)
    assert len(compiled.history) < len(plain.history)
    assert_equal(compiled, plain)
    np.testing.assert_array_equal(compiled.touch, plain.touch)
    np.testing.assert_array_equal(compiled.gap, plain.gap)
    np.testing.assert_array_equal(compiled.outcome, plain.outcome)


def test_poses_that_the_short_cut_leaves_are_searched_for(drawn, monkeypatch):
    place = solved(drawn, 1.0).place
    reducer = CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn)
    compiled, plain = both_ways(reducer, 1.0, place)
    whole = near.settled_near

    def half(*args):
        u, seen, settled = whole(*args)
        u[::2], settled[::2] = 7.0, False
        return u, seen, settled

    monkeypatch.setattr("cycloid_profile.contact.stage._block.settled_near", half)
    mixed = solved(reducer, 1.0, place)
    assert_equal(mixed, plain)
    np.testing.assert_array_equal(mixed.rotation[1::2], compiled.rotation[1::2])


@pytest.mark.parametrize("cornered", [(0,), (0, 1)], ids=["one disc", "both"])
def test_balances_of_teeth_with_corners_are_checked(drawn, cornered, monkeypatch):
    # Whatever the compiled search says: next to a corner its foot may lie on the wrong flank.
    plain = drawn.case.profile
    edged = modify(plain, DeformationCompensation(0.001))
    reducer = replace(drawn, teeth=tuple(edged if disc in cornered else plain for disc in range(2)))
    place, exact, whole = solved(drawn, 1.0).place, with_exact_gaps(reducer, 1.0), near.settled_near

    def wrong(*args):
        u, seen, _ = whole(*args)
        u[::2] += 1e-4
        return u, seen, np.ones(len(u), dtype=bool)

    monkeypatch.setattr("cycloid_profile.contact.stage._block.settled_near", wrong)
    assert_equal(solved(reducer, 1.0, place), exact)


def test_a_place_that_is_none_is_left_to_the_plain_search(drawn):
    place = solved(drawn, 1.0).place
    nowhere = type(place)(np.full(POSES, np.nan), np.full((POSES, 2, 3), np.nan))
    assert not np.any(solved(drawn, 1.0, nowhere).settled)
