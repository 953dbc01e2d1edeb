"""The compiled short cut beside a known equilibrium against the numpy search that it stands for."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import near
from cycloid_profile.contact.meshing import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.ground import built_reducer
from cycloid_profile.effects.built import Built
from cycloid_profile.effects.crank import CrankBearingClearance, CrankHoleError
from cycloid_profile.effects.process import (
    CumulativePitchError,
    DiscRunout,
    FlankWear,
    GrindingChatter,
    MissingDeformationCompensation,
    SingleToothError,
    WheelWearDrift,
)
from cycloid_profile.effects.ring import PinRingOval
from cycloid_profile.spec.read import read_spec

POSES = 60  # with 80 pins as many as are worth compiling
TOLERANCES = {"rotation": 1e-12, "motion": 1e-9}  # rad, mm

pytest.importorskip("numba")
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
def drawn() -> Built:
    spec = read_spec(Path(__file__).parents[1] / "rig" / "measured" / "spec.toml")
    return built_reducer(spec)


def solved(built: Built, share: float, place=None):
    crank = output_turn(built.case.drive.trochoid, POSES)
    return StageEquilibrium(as_built=built.parts).at(built.case, crank, share * built.case.torque, near=place)


def both_ways(built: Built, share: float, place):
    """Compiled and in numpy."""
    before = near._NUMBA
    try:
        near._NUMBA = True
        compiled = solved(built, share, place)
        near._NUMBA = False
        return compiled, solved(built, share, place)
    finally:
        near._NUMBA = before


def assert_alike(found, expected):
    assert np.all(found.settled)
    np.testing.assert_allclose(found.rotation, expected.rotation, rtol=0.0, atol=TOLERANCES["rotation"])
    np.testing.assert_allclose(found.place.motion, expected.place.motion, rtol=0.0, atol=TOLERANCES["motion"])
    np.testing.assert_allclose(found.force, expected.force, rtol=0.0, atol=1e-6 * expected.max_force)
    np.testing.assert_allclose(found.place.foot, expected.place.foot, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found.lever, expected.lever, rtol=0.0, atol=1e-6)
    np.testing.assert_allclose(found.curvature, expected.curvature, rtol=1e-4, atol=1e-6)
    np.testing.assert_allclose(found.stage.normal, expected.stage.normal, rtol=0.0, atol=1e-7)
    np.testing.assert_allclose(found.torsional_stiffness, expected.torsional_stiffness, rtol=1e-6)


@pytest.mark.slow
@settings(max_examples=12, deadline=None)
@given(some=effects, share=st.sampled_from([1.0, -1.0, 0.03, -0.03]))
def test_whatever_effects_a_reducer_has(drawn, some, share):
    place = solved(drawn, share).place
    built = drawn
    for effect in some:
        built = effect.apply(built)
    assert_alike(*both_ways(built, share, place))


@pytest.mark.parametrize("foot_known", [True, False])
def test_the_feet_need_not_be_known(drawn, foot_known):
    place = solved(drawn, 1.0).place
    built = CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn)
    asked = place if foot_known else type(place)(place.rotation, place.motion)
    assert_alike(*both_ways(built, 1.0, asked))


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

    monkeypatch.setattr("cycloid_profile.contact.stage_block.settled_near", watched)
    assert np.all(solved(effect.apply(drawn), 1.0, place).settled)
    assert [answer is not None and bool(np.mean(answer[2]) > 0.9) for answer in answers] == [taken]


@pytest.mark.parametrize("share", [1.0, -0.03])
def test_many_poses_from_first_touch_on(drawn, share, monkeypatch):
    """No place is known beforehand: first touch is looked for, and told, as ever."""
    built = FlankWear(amount_um=1.0).apply(CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn))
    plain = solved(built, share)
    monkeypatch.setattr("cycloid_profile.contact.stage._MANY", POSES * 80)
    compiled = solved(built, share)
    assert len(compiled.history) < len(plain.history)
    assert_alike(compiled, plain)
    np.testing.assert_array_equal(compiled.touch, plain.touch)
    np.testing.assert_array_equal(compiled.gap, plain.gap)
    np.testing.assert_array_equal(compiled.outcome, plain.outcome)


def test_poses_that_the_short_cut_leaves_are_searched_for(drawn, monkeypatch):
    place = solved(drawn, 1.0).place
    built = CumulativePitchError(amplitude_um=3.0, phase_deg=20.0).apply(drawn)
    compiled, plain = both_ways(built, 1.0, place)
    whole = near.settled_near

    def half(*args):
        u, seen, settled = whole(*args)
        u[::2], settled[::2] = 7.0, False
        return u, seen, settled

    monkeypatch.setattr("cycloid_profile.contact.stage_block.settled_near", half)
    mixed = solved(built, 1.0, place)
    assert_alike(mixed, plain)
    np.testing.assert_array_equal(mixed.rotation[1::2], compiled.rotation[1::2])


def test_a_place_that_is_none_is_left_to_the_plain_search(drawn):
    place = solved(drawn, 1.0).place
    nowhere = type(place)(np.full(POSES, np.nan), np.full((POSES, 2, 3), np.nan))
    assert not np.any(solved(drawn, 1.0, nowhere).settled)
