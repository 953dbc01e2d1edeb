"""Many poses at once: the same numbers as pose by pose, in order, and loads that are none are refused.

Sizes are those of real use: more poses than a block holds, of a drive whose arrays are large enough for numpy to
reuse temporaries.
"""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase, LoadSharing, SolveStatus
from cycloid_profile.contact._blocks import BLOCK, over_blocks
from cycloid_profile.contact.bodies import PartDeviations
from cycloid_profile.contact.disc import Equilibrium, equilibrium
from cycloid_profile.contact.mesh import Meshing, mesh
from cycloid_profile.contact.result import StageMotion, joined
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.contact.stage import equilibrium as stage
from cycloid_profile.errors import LoadError
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive, Trochoid
from cycloid_profile.modification import DeformationCompensation, Equidistant, RadialMoving, modify

TEETH = {
    "equidistant": (Equidistant(0.006),),
    "pair": (Equidistant(0.050), RadialMoving(-0.0275)),
    "compensated": (Equidistant(0.006), DeformationCompensation(0.0019)),
}
SUPPORTS = {
    "cranks": Cranks(3, 36.0, 4e5),
    "play": Cranks(3, 36.0, 4e5, bearing_play=0.005),
    "central": CentralEccentric(2e5),
}
SOLVERS = {"equilibrium": Equilibrium(), "stage": StageEquilibrium()}


def case_of(drive, changes, torque=412e3):
    return LoadCase(drive, modify(drive.theoretical_profile, *changes), torque)


def loads(count):
    """Crank angles over several turns and torques of either sign over three decades, without a pattern."""
    draw = np.random.default_rng(11)
    angle, sign = draw.uniform(-7.0, 7.0, count), draw.choice([-1.0, 1.0], count)
    return angle, sign * 10.0 ** draw.uniform(2.7, 5.7, count)


def numbers(result):
    """Every array of a result over poses, by name."""
    parts = [("", result)]
    if result.stage is not None:
        parts += [("stage.", result.stage), ("meshing.", result.stage.meshing)]
    return {
        prefix + field.name: getattr(part, field.name)
        for prefix, part in parts
        for field in fields(part)
        if isinstance(getattr(part, field.name), np.ndarray)
    }


def assert_same(one, other, name=""):
    np.testing.assert_array_equal(one, other, err_msg=name, strict=True)


def assert_poses_equal(solver, case, angle, torque, which):
    """What all poses together say of some is what each says alone, to the last bit."""
    together = solver.at(case, angle, torque)
    assert together.torque.size == angle.size
    whole = numbers(together)
    assert set(whole) >= {"force", "rotation", "residual", "outcome"}
    for i in which:
        for name, value in numbers(solver.at(case, angle[i], torque[i])).items():
            assert_same(whole[name][i : i + 1], value, f"{name} at pose {i}")


@pytest.mark.parametrize("tooth", TEETH)
def test_discs_pose_does_not_depend_on_the_others(rv40e, tooth):
    size = equilibrium._POSES_PER_BLOCK
    angle, torque = loads(size + 40)
    assert_poses_equal(
        Equilibrium(), case_of(rv40e, TEETH[tooth]), angle, torque, [0, 1, 500, *range(size - 8, size + 8)]
    )


@pytest.mark.slow
@pytest.mark.parametrize("tooth", TEETH)
@pytest.mark.parametrize("support", SUPPORTS)
def test_stages_pose_does_not_depend_on_the_others(rv40e, support, tooth):
    drive = replace(rv40e, support=SUPPORTS[support], first_stage=None if support == "central" else rv40e.first_stage)
    angle, torque = loads(BLOCK + 20)
    which = [0, 1, 100, *range(BLOCK - 5, BLOCK + 5)]
    assert_poses_equal(StageEquilibrium(), case_of(drive, TEETH[tooth]), angle, torque, which)


@pytest.mark.parametrize("solver", SOLVERS)
def test_pose_that_overlaps_before_any_load_does_not_depend_on_the_others(solver):
    # Overlapping pins take most steps to the first touch, and a different number at every pose.
    drive = Drive(Trochoid(12, 40.0, 2.0), 4.0, 10.0, 2, CentralEccentric(2e5))
    angle, torque = loads(60)
    case = case_of(drive, (Equidistant(-0.001),))
    assert SolveStatus.INTERFERENCE in SOLVERS[solver].at(case, angle, torque).statuses
    assert_poses_equal(SOLVERS[solver], case, angle, torque, range(0, 60, 4))


def test_pose_of_parts_as_built_does_not_depend_on_the_others(rv40e):
    draw = np.random.default_rng(5)
    tooth = modify(rv40e.theoretical_profile, Equidistant(0.006))
    solver = StageEquilibrium(
        deviations=PartDeviations(
            pin_shift=0.001 * (draw.normal(size=40) + 1j * draw.normal(size=40)),
            pin_oversize=0.0005 * draw.normal(size=40),
            teeth=(tooth, modify(tooth, DeformationCompensation(0.001))),
            eccentric_shift=0.001 * (draw.normal(size=(2, 3)) + 1j * draw.normal(size=(2, 3))),
            bore_shift=0.001 * (draw.normal(size=(2, 3)) + 1j * draw.normal(size=(2, 3))),
            crank_lead=1e-4 * (draw.normal(size=3) + 1j * draw.normal(size=3)),
        )
    )
    angle, torque = loads(BLOCK + 20)
    assert_poses_equal(solver, case_of(rv40e, (Equidistant(0.006),)), angle, torque, range(BLOCK - 5, BLOCK + 5))


def test_pins_stand_where_they_stand_however_many_are_asked_for(rv40e):
    angle = loads(2 * BLOCK)[0]
    whole = mesh(rv40e.trochoid, angle, 2)
    for i in range(0, 2 * BLOCK, 37):
        alone = mesh(rv40e.trochoid, angle[i], 2)
        for name in ("crank_angle", "phase", "lobe", "pin_centre", "into_lobe"):
            assert_same(getattr(whole, name)[i : i + 1], getattr(alone, name), name)


def test_two_blocks_say_the_same_again(rv40e):
    case, (angle, torque) = case_of(rv40e, TEETH["pair"]), loads(BLOCK + 3)
    once, again = (numbers(StageEquilibrium().at(case, angle, torque)) for _ in range(2))
    for name, value in once.items():
        assert_same(value, again[name], name)


@pytest.mark.parametrize(
    ("poses", "lengths"), [(0, [0]), (1, [1]), (3, [3]), (4, [2, 2]), (7, [2, 2, 3]), (9, [3, 3, 3])]
)
def test_blocks_cover_every_pose_once_in_order(poses, lengths):
    cuts = list(over_blocks(lambda cut: np.arange(poses)[cut], poses, 3))
    assert [len(cut) for cut in cuts] == lengths
    np.testing.assert_array_equal(np.concatenate(cuts), np.arange(poses))


def test_blocks_are_solved_only_when_asked_for():
    solved = []
    blocks = over_blocks(solved.append, 7, 3)
    assert solved == []
    next(blocks)
    assert solved == [slice(0, 2)]


def small_blocks(monkeypatch, size):
    monkeypatch.setattr(equilibrium, "_POSES_PER_BLOCK", size)
    monkeypatch.setattr(stage, "over_blocks", lambda solve, poses, _: over_blocks(solve, poses, size))


@pytest.mark.parametrize("solver", SOLVERS)
def test_joined_blocks_keep_the_order_of_the_poses(rv40e, monkeypatch, solver):
    small_blocks(monkeypatch, 3)
    angle, torque = loads(8)
    blocks = list(SOLVERS[solver].blocks(case_of(rv40e, TEETH["pair"]), angle, torque))
    assert [block.rotation.size for block in blocks] == [2, 3, 3]
    whole = joined(blocks)
    assert_same(whole.crank_angle, angle)
    assert_same(whole.torque, torque)
    for name, value in numbers(whole).items():
        start = 0
        for block in blocks:
            part = numbers(block)[name]
            assert_same(value[start : start + len(part)], part, name)
            start += len(part)
        assert start == len(value) == 8
    assert whole.case is blocks[0].case
    assert whole.solver == solver


@pytest.mark.parametrize("solver", SOLVERS)
def test_joined_blocks_report_the_largest_of_all(rv40e, monkeypatch, solver):
    small_blocks(monkeypatch, 3)
    # The heaviest pose stands neither first nor last.
    torque = np.array([1e4, 2e4, 3e4, 4e4, 4e5, 5e4, 6e4, 7e4])
    blocks = list(SOLVERS[solver].blocks(case_of(rv40e, TEETH["equidistant"]), 0.02 * np.arange(8), torque))
    whole = joined(blocks)
    assert whole.max_force == blocks[1].max_force == np.max(whole.force)
    assert whole.max_force > max(blocks[0].max_force, blocks[2].max_force)
    assert whole.delta_max == blocks[1].delta_max
    assert whole.iterations == max(block.iterations for block in blocks)
    for i, (force, delta) in enumerate(whole.history):
        going = [block.history[i] for block in blocks if i < block.iterations]
        assert force == max(f for f, _ in going)
        assert delta == max(d for _, d in going)


def test_joined_blocks_end_as_badly_as_their_worst(rv40e, monkeypatch):
    small_blocks(monkeypatch, 2)
    blocks = list(Equilibrium().blocks(case_of(rv40e, TEETH["equidistant"]), 0.02 * np.arange(6)))
    for one, outcome in ((1, SolveStatus.INTERFERENCE), (2, SolveStatus.NOT_CONVERGED)):
        blocks[one].outcome[1] = list(SolveStatus).index(outcome)
    whole = joined(blocks)
    assert whole.status is SolveStatus.NOT_CONVERGED
    assert [status.name for status in whole.statuses] == [
        *["CONVERGED"] * 3,
        "INTERFERENCE",
        "CONVERGED",
        "NOT_CONVERGED",
    ]
    assert list(whole.settled) == [True] * 5 + [False]
    assert not whole.converged


def test_one_block_is_not_copied(rv40e):
    blocks = list(StageEquilibrium().blocks(case_of(rv40e, TEETH["equidistant"]), [0.1, 0.2]))
    assert len(blocks) == 1
    assert joined(blocks) is blocks[0]


def test_every_array_of_a_result_runs_over_the_poses(rv40e):
    # What joins blocks finds arrays by their kind; one that did not run over poses would be torn.
    result = StageEquilibrium().at(case_of(rv40e, TEETH["equidistant"]), 0.02 * np.arange(5))
    assert all(len(value) == 5 for value in numbers(result).values())
    arrays = {"FloatArray", "IntArray", "ComplexArray", "BoolArray"}
    named = {
        field.name for kind in (LoadSharing, StageMotion, Meshing) for field in fields(kind) if field.type in arrays
    }
    assert {name.split(".")[-1] for name in numbers(result)} == named


def test_summaries_are_those_of_the_blocks_in_order(rv40e, monkeypatch):
    small_blocks(monkeypatch, 3)
    case, (angle, torque) = case_of(rv40e, TEETH["equidistant"]), loads(7)
    found = StageEquilibrium().summaries(case, angle, lambda block: block.rotation.copy(), torque)
    assert [part.size for part in found] == [2, 2, 3]
    assert_same(np.concatenate(found), StageEquilibrium().at(case, angle, torque).rotation)


@pytest.mark.parametrize("solver", SOLVERS)
def test_one_crank_angle_under_many_torques_and_many_under_one(rv40e, solver):
    case, torque, angle = case_of(rv40e, TEETH["equidistant"]), np.array([-4e5, 1e3, 2e5]), np.array([0.1, 0.5, -2.0])
    solve = SOLVERS[solver].at
    for spread, plain in (
        (solve(case, 0.3, torque), solve(case, np.full(3, 0.3), torque)),
        (solve(case, angle, 2e5), solve(case, angle, np.full(3, 2e5))),
        (solve(case, angle), solve(case, angle, np.full(3, 412e3))),
    ):
        for name, value in numbers(spread).items():
            assert_same(value, numbers(plain)[name], name)
    assert solve(case, 0.3).rotation.shape == (1,)
    # Torque on the pose it was given for: each sign turns its own way, and more turns more.
    turned = solve(case, 0.3, torque).rotation
    assert turned[0] < 0.0 < turned[1] < turned[2]


@pytest.mark.parametrize("solver", SOLVERS)
def test_shapes_that_do_not_fit_are_not_guessed_at(rv40e, solver):
    with pytest.raises(LoadError, match="does not go with"):
        SOLVERS[solver].at(case_of(rv40e, TEETH["equidistant"]), [0.1, 0.2, 0.3], [1e4, 2e4])


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("bad", [0.0, -0.0, math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", [0, 2])
def test_torque_that_is_no_load_is_refused(rv40e, solver, bad, place):
    torque = np.array([4e5, -2e5, 1e3])
    torque[place] = bad
    with pytest.raises(LoadError, match="zero or not finite") as caught:
        SOLVERS[solver].at(case_of(rv40e, TEETH["equidistant"]), [0.1, 0.2, 0.3], torque)
    assert caught.value.what == "torque"
    assert caught.value.value == f"{bad / 1e3:g} N·m"
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_crank_angle_that_is_no_number_is_refused(rv40e, solver, bad):
    with pytest.raises(LoadError, match="is not finite: give an angle in rad") as caught:
        SOLVERS[solver].at(case_of(rv40e, TEETH["equidistant"]), [0.1, bad, 0.3, math.nan])
    assert caught.value.what == "crank_angle"
    assert caught.value.value == f"{bad} rad at pose 2"
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("solver", SOLVERS)
def test_pose_of_a_bad_crank_angle_is_counted_from_the_first_of_all(rv40e, monkeypatch, solver):
    small_blocks(monkeypatch, 3)
    angle = 0.02 * np.arange(8)
    angle[7] = math.nan
    with pytest.raises(LoadError) as caught:
        SOLVERS[solver].at(case_of(rv40e, TEETH["equidistant"]), angle)
    assert caught.value.value == "nan rad at pose 8"
