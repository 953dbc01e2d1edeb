"""How free parts follow a load: the plain solution where all is held, the least motion where something floats."""

from __future__ import annotations

import numpy as np
import pytest

from cycloid_profile.contact.stage._linear_compliance import solve_linear_compliance

RCOND = 1e-12


def stiffnesses(poses: int, n: int, seed: int) -> np.ndarray:
    """Springs in random directions, some hundred times as stiff as others."""
    draw = np.random.default_rng(seed)
    along = draw.normal(size=(poses, n + 4, n))
    stiff = 10.0 ** draw.uniform(4.0, 6.0, size=(poses, n + 4, 1))
    return np.swapaxes(along, 1, 2) @ (stiff * along)


def test_forces_balance_where_everything_is_held():
    K = stiffnesses(50, 7, seed=1)
    load = np.random.default_rng(2).normal(size=(50, 7, 2))
    np.testing.assert_allclose(K @ solve_linear_compliance(K, load, RCOND), load, rtol=0.0, atol=1e-9)


def test_a_part_afloat_stays_where_it_is_and_the_others_follow():
    K = stiffnesses(4, 7, seed=3)
    K[1, 4:], K[1, :, 4:] = 0.0, 0.0
    load = np.random.default_rng(4).normal(size=(4, 7, 1))
    load[1, 4:] = 0.0
    motion = solve_linear_compliance(K, load, RCOND)
    np.testing.assert_array_equal(motion[1, 4:], 0.0)
    np.testing.assert_allclose(K @ motion, load, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("held", [6, 5, 3])
def test_of_many_motions_the_least(held):
    draw = np.random.default_rng(held)
    along = draw.normal(size=(1, held, 7))
    K = np.swapaxes(along, 1, 2) @ along
    load = K @ draw.normal(size=(1, 7, 1))
    found = solve_linear_compliance(K, load, RCOND)
    np.testing.assert_allclose(found, np.linalg.lstsq(K[0], load[0], rcond=RCOND)[0][np.newaxis], atol=1e-9)
