"""Physics of the reversal run: its backlash against geometry, its energy, and where the output stands."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cycloid_profile.compensation import compensate_by
from cycloid_profile.contact.mesh import input_locked_factor
from cycloid_profile.effects import as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.rig import PUBLISHED_REVERSAL_SPEED, backlash_map, reversal_run
from cycloid_profile.units import ARCMIN, DEGREE

DELTA = 1.6e-3


@pytest.fixture(scope="module")
def run(drawn):
    """The run of the article with a brake of 5 %."""
    return reversal_run(drawn)


@pytest.fixture(scope="module")
def geometric(drawn) -> float:
    """Backlash with the input held, mean over the turn [rad]."""
    return float(np.mean(backlash_map(drawn, 240).value))


@pytest.mark.slow
def test_the_input_turns_as_the_article_says(run):
    # v(t) = 15000 sin(30 t) + 10890 °/s, which goes backwards between the roots of the sine at −0.726.
    A, omega, C = PUBLISHED_REVERSAL_SPEED
    assert (A / DEGREE, omega, C / DEGREE) == pytest.approx((15000.0, 30.0, 10890.0))
    root = math.asin(10890.0 / 15000.0)
    turns = [(math.pi + root + 2.0 * math.pi * k) / 30.0 for k in range(7)]
    back = [(2.0 * math.pi - root + 2.0 * math.pi * k) / 30.0 for k in range(7)]
    expected = [t for t in sorted(turns + back) if t < run.time[-1]]
    # Each but the last, after which the run may end before the output follows.
    np.testing.assert_allclose(run.reversal_time, expected[: run.reversal_time.size], atol=2e-5)
    assert run.reversal_time.size >= len(expected) - 1
    speed = np.gradient(run.input_angle, run.time)
    np.testing.assert_allclose(speed[5:-5], (A * np.sin(omega * run.time) + C)[5:-5], rtol=1e-3, atol=1e-3 * A)


def test_every_reversal_shows_the_backlash(run, geometric):
    # The twist of the stage under the brake is on top: a tenth and less at 5 %.
    assert np.all(run.follow_time > run.reversal_time)
    np.testing.assert_allclose(run.backlash, geometric, rtol=0.15)
    assert np.all(run.backlash > geometric)


@pytest.mark.slow
def test_a_lighter_brake_comes_nearer(drawn, run, geometric):
    # Above what the inertia needs, 0.8 % of the rated torque: below it the output runs on by itself.
    light = reversal_run(drawn, brake=0.015, duration=0.6)
    assert np.mean(light.backlash) < np.mean(run.backlash)
    assert np.mean(light.backlash) == pytest.approx(geometric, rel=0.06)


def test_backlash_is_read_from_the_input(run):
    at, after = (np.interp(t, run.time, run.input_angle) for t in (run.reversal_time, run.follow_time))
    np.testing.assert_allclose(run.backlash, np.abs(after - at) / 121.0, rtol=1e-3, atol=1e-8)


@pytest.mark.slow
def test_an_unmodified_tooth_has_no_backlash(drawn):
    tooth = drawn.case.drive.theoretical_profile
    tight = reversal_run(as_drawn(replace(drawn.case, profile=tooth)), duration=0.6)
    # What is left is the twist of the stage from the brake one way to the brake the other.
    assert np.all(tight.backlash < 0.1 * ARCMIN)


@pytest.mark.slow
def test_compensation_reduces_backlash_by_its_amount(drawn, run):
    case = drawn.case
    compensated = reversal_run(as_drawn(replace(case, profile=compensate_by(case, DELTA).profile)), duration=0.6)
    wanted = 2.0 * DELTA / case.drive.trochoid.longest_lever * input_locked_factor(case.drive)
    count = min(run.backlash.size, compensated.backlash.size)
    less = run.backlash[:count] - compensated.backlash[:count]
    np.testing.assert_allclose(less, wanted, rtol=0.05)


def test_energy_is_not_created(run):
    # Work of the input less that of the output, through the stage: stored or lost, and never less than nothing.
    middle = 0.5 * (run.torque[1:] + run.torque[:-1])
    spent = np.cumsum(middle * np.diff(run.lag))
    assert np.min(spent) > -1e-4 * np.max(spent)
    assert spent[-1] > 0.0


def test_the_output_follows_the_input(drawn, run, geometric):
    # It never lags by more than the backlash and the twist of the largest torque that passed.
    stiffness = 450e3 / ARCMIN
    twist = np.max(np.abs(run.torque)) / stiffness
    assert np.ptp(run.lag) < geometric + 2.0 * twist + 0.1 * ARCMIN
    output = run.input_angle / 121.0 + run.lag
    gone = output[-1] - output[0]
    assert gone == pytest.approx(run.input_angle[-1] / 121.0, abs=geometric + 2.0 * twist)
    # The brake acts: on the mean it takes 5 % of the rated torque times the way.
    way = np.abs(np.diff(output))
    power = -np.sum(0.5 * (run.torque[1:] + run.torque[:-1]) * np.diff(output))
    assert power == pytest.approx(0.05 * drawn.case.torque * np.sum(way), rel=0.05)


@pytest.mark.slow
def test_a_run_of_one_direction_has_no_reversal(drawn):
    steady = reversal_run(drawn, speed=(1000.0 * DEGREE, 30.0, 10890.0 * DEGREE), duration=0.3)
    assert steady.backlash.size == 0


@pytest.mark.slow
def test_a_reducer_that_binds_does_not_run(built_with):
    bound = built_with({"name": "pin_circle_radius_error", "amount_um": -200.0})
    with pytest.raises(SolveError, match="reversal run"):
        reversal_run(bound)
