"""Extremes over a turn against many more poses, and an allocation judged by reducers and poses not searched with.

The reference takes the largest of plain values at poses one after the other: no interpolation, no choice of poses.
"""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.arrays import FloatArray
from cycloid_profile.catalog import catalog_drive
from cycloid_profile.contact import LoadCase
from cycloid_profile.design import as_built_reducer
from cycloid_profile.effects import AsBuiltReducer, as_drawn
from cycloid_profile.geometry import Cranks, Drive, InvoluteStage, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.allocation import SampleSizes, allocate
from cycloid_profile.tolerance.inputs import Tolerances, limits_of, tolerances_of
from cycloid_profile.tolerance.model import QuantityModel, unit_changes
from cycloid_profile.tolerance.model._crank_locked import crank_locked_backlash
from cycloid_profile.tolerance.model._loaded import loaded_stage
from cycloid_profile.tolerance.model.quantities import SolvedPoses, largest_over_turn, lost_motion_loads, rated_loads
from cycloid_profile.tolerance.study import Draws
from cycloid_profile.units import ARCMIN, ARCSEC

PARTS = (
    {"name": "single_pin_error", "each": "pin", "amount_um": {"plus_minus": 0.5}, "cost": 4.0},
    {"name": "pin_position_error", "each": "pin", "amplitude_um": {"plus_minus": 1.5}, "cost": 8.0},
    {"name": "pin_circle_radius_error", "amount_um": {"plus_minus": 2.0}, "cost": 3.0},
    {"name": "equidistant_error", "each": "disc", "amount_um": {"plus_minus": 1.0}, "cost": 4.0},
    {"name": "disc_runout", "each": "disc", "amplitude_um": {"plus_minus": 1.0}, "cost": 3.0},
    {"name": "crank_hole_error", "each": ["crank", "disc"], "amplitude_um": {"plus_minus": 1.0}, "cost": 4.0},
)


def of_poses(reducer: AsBuiltReducer, tolerances: Tolerances, x: FloatArray, poses: int) -> FloatArray:
    """Largest backlash at so many poses [′]."""
    dense = crank_locked_backlash(reducer, unit_changes(reducer, tolerances), poses)
    parts = np.array_split(x, max(len(x) // 64, 1))
    return np.concatenate([np.max(dense.by_pose(some), axis=1) for some in parts]) / ARCMIN


def studied(reducer: AsBuiltReducer, tolerances: Tolerances, names: tuple[str, ...], x: FloatArray) -> FloatArray:
    return QuantityModel(reducer, unit_changes(reducer, tolerances), names).of(x)


@pytest.mark.slow
def test_yield_of_the_backlash_is_that_of_many_poses(large):
    """10,000 reducers, limits at three quantiles: the yield is right to 0.2 %, at the median to 1 %."""
    tolerances = tolerances_of(PARTS, (), large)
    x = Draws(tolerances).coordinates(0, 10_000, 0)
    found, wanted = (
        studied(large, tolerances, ("backlash_arcmin",), x)[:, 0],
        of_poses(large, tolerances, x, 4999),
    )
    assert np.mean(found) == pytest.approx(np.mean(wanted), rel=0.002)
    for share in (0.5, 0.95, 0.99):
        limit = np.quantile(wanted, share)
        assert np.mean(found <= limit) == pytest.approx(share, abs=0.002 if share > 0.9 else 0.01)


@pytest.fixture
def twenty_pins() -> AsBuiltReducer:
    """Two discs on two cranks, 8 µm of clearance."""
    drive = Drive(Trochoid(20, 40.0, 1.2), 2.5, 10.0, 2, Cranks(2, 20.0, 2e5), InvoluteStage(12, 36, 1.0))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.008)), 1e5))


@pytest.fixture
def rv20e_like() -> AsBuiltReducer:
    return as_built_reducer(catalog_drive("rv20e_like"))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "reducers"), [("twenty_pins", 16), ("large", 64), ("rv20e_like", 32)])
def test_extremes_at_rated_load_are_those_of_many_poses(name, reducers, request):
    """The mean peak pressure is right to 0.2 %, the mean transmission error to 0.5 %."""
    reducer = request.getfixturevalue(name)
    tolerances = tolerances_of(PARTS, (), reducer)
    x = Draws(tolerances).coordinates(0, reducers, 0)
    error, pressure = studied(reducer, tolerances, ("transmission_error_arcsec", "peak_pressure_mpa"), x).T
    stage = loaded_stage(reducer, unit_changes(reducer, tolerances), *rated_loads(reducer, 4999))
    rotation, pressed = stage.answers(x)
    wanted = np.max(pressed, axis=1)
    assert np.mean(pressure) == pytest.approx(np.mean(wanted), rel=0.002)
    np.testing.assert_allclose(pressure, wanted, rtol=0.01)
    assert np.mean(error) == pytest.approx(np.mean(np.ptp(rotation, axis=1) / ARCSEC), rel=0.005)


def test_largest_over_a_turn_is_the_vertex_near_the_best_estimate():
    """Parabolas with their tops between poses: the estimate names the pose, its neighbours give the top."""
    poses, top = 50, np.array([[3.3], [49.4]])
    away = (np.arange(poses) - top + poses / 2) % poses - poses / 2
    exact = 7.0 - away**2
    found = largest_over_turn(
        (exact + 0.1 * np.sin(np.arange(poses)))[np.newaxis],
        lambda chosen, _: SolvedPoses.smooth(np.take_along_axis(exact, chosen, axis=1)[np.newaxis]),
        3,
    )
    np.testing.assert_allclose(found, [[7.0], [7.0]], rtol=1e-12)


def test_largest_over_a_turn_follows_the_part_that_is_largest():
    """Another contact that takes over at the next pose does not raise the top of the one before."""
    poses = np.arange(50)
    parts = np.stack([7.0 - (poses - 20.2) ** 2, 6.9 - 0.2 * (poses - 21.0) ** 2])

    def solved(chosen, part):
        value = parts[:, chosen]
        first = np.argmax(value, axis=0)
        asked = first if part is None else part
        followed = np.take_along_axis(value, asked[np.newaxis], axis=0)
        return SolvedPoses(np.max(value, axis=0)[np.newaxis], followed, first)

    estimate = np.max(parts, axis=0)[np.newaxis, np.newaxis]
    np.testing.assert_allclose(largest_over_turn(estimate, solved, 3, kinked=[0]), [[7.0]], rtol=1e-12)


@pytest.mark.slow
def test_lost_motion_is_that_of_many_poses(large):
    """300 reducers at 1,567 poses."""
    tolerances = tolerances_of(PARTS, (), large)
    changes = unit_changes(large, tolerances)
    x = Draws(tolerances).coordinates(0, 300, 0)
    lost = studied(large, tolerances, ("lost_motion_arcmin",), x)[:, 0]
    there, back = np.split(loaded_stage(large, changes, *lost_motion_loads(large, 1567)).answers(x)[0], 2, axis=1)
    assert np.mean(lost) == pytest.approx(np.mean(np.max(there - back, axis=1) / ARCMIN), rel=0.01)


@pytest.mark.slow
def test_allocated_yield_holds_at_many_poses_of_other_reducers(large):
    """The promise of ``--allocate``, with a seed and poses that neither search nor confirmation has seen.

    Of errors of whole discs and the ring: those of each pin take a hundred times as long.
    """
    tolerances = tolerances_of(PARTS[2:], (), large)
    model = QuantityModel(large, unit_changes(large, tolerances), ("backlash_arcmin",))
    drawn = model.of(Draws(tolerances).coordinates(0, 1024, 0))[:, 0]
    limits = limits_of({"backlash_arcmin": float(np.quantile(drawn, 0.9))}, model.names)
    found = allocate(Draws(tolerances, 1), model, limits, 0.95, SampleSizes(128, 512))
    fresh = Draws(found.tolerances, 4711).coordinates(0, 1024, 0)
    passed = np.mean(of_poses(large, tolerances, fresh, 4999) <= limits[0].at_most)
    error = np.sqrt(0.95 * 0.05 / len(fresh))
    assert found.yield_after.low - 2.0 * error < passed < found.yield_after.high + 2.0 * error
