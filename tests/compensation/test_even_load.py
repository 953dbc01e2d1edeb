"""A tooth with clearance that shares the load as the theoretical one: forces, pins, clearance and refusals.

The reference is the load sharing of the theoretical tooth, which (Eq. 96) reproduces; no published number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.catalog import catalog_drive
from cycloid_profile.compensation import compensate, even_load_profile
from cycloid_profile.contact import SolveStatus
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.result import STATUSES
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.design.from_spec import conventional_profile, drive_of, load_case
from cycloid_profile.errors import CompensationError, GeometryError, SolveError
from cycloid_profile.geometry import least_radii
from cycloid_profile.modification import Equidistant, FlankRotation, FlankStock, RootAndTipRelief, modify
from cycloid_profile.units import ARCMIN, UM

CLEARANCE, PLAY = 6.0 * UM, 0.25 * ARCMIN
SOLVERS = [Equilibrium(poses=8), StageEquilibrium(poses=8)]


def case_with(body):
    spec = catalog_drive("rv40e").replace("load.disc_body", body)
    drive = drive_of(spec)
    return load_case(spec, drive, conventional_profile(spec, drive))


@pytest.fixture(scope="module", params=["rigid", "elastic"])
def case(request):
    return case_with(request.param)


@pytest.mark.parametrize("solver", SOLVERS, ids=["disc", "stage"])
def test_load_is_shared_as_on_the_theoretical_tooth(case, solver):
    found = even_load_profile(case, CLEARANCE, PLAY, solver)
    compensated = solver.solve(replace(case, profile=compensate(case, solver, poses=4).profile))
    even, theoretical = found.sharing, found.theoretical
    # Three quarters of the pins of the theoretical tooth carry at every pose.
    assert even.fewest_loaded_pins >= 0.75 * theoretical.fewest_loaded_pins
    assert even.fewest_loaded_pins >= compensated.loaded_pins + 3
    # Pressure and twist are those of the theoretical tooth; the compensated one exceeds them by 8 % and more.
    assert even.max_pressure < 1.04 * theoretical.max_pressure < compensated.max_pressure
    assert np.max(np.abs(even.twist)) < 1.05 * np.max(np.abs(theoretical.twist)) < np.max(np.abs(compensated.twist))
    trochoid = case.drive.trochoid
    off = np.cos(even.phase) - trochoid.short_width_ratio
    working = np.where(off > 0.0, found.root_reach, found.tip_reach) < even.lever / trochoid.longest_lever
    # Pins of the working flank: those next to the relief take over the load of the relieved ones.
    difference = (even.force - theoretical.force)[working] / theoretical.max_force
    assert np.sqrt(np.mean(difference**2)) < 0.1


def test_forces_approach_the_theoretical_ones_with_a_shorter_relief():
    case, solver = case_with("rigid"), Equilibrium(poses=8)
    radii = (3.012, 2.99, 2.96)
    found = [even_load_profile(case, CLEARANCE, PLAY, solver, least_root_radius=radius) for radius in radii]
    rise = [each.force_rise for each in found]
    assert rise[0] < 0.06
    assert 0.0 < rise[2] < rise[1] < rise[0]
    assert found[2].root_reach < found[1].root_reach < found[0].root_reach
    assert [least_radii(each.profile).concave for each in found[:2]] == pytest.approx(radii[:2], rel=1e-3)


def test_largest_force_of_one_disc_is_below_that_of_the_compensated_tooth(case):
    solver = Equilibrium(poses=8)
    found = even_load_profile(case, CLEARANCE, PLAY, solver)
    assert found.sharing.max_force < 0.9 * compensate(case, solver, poses=4).sharing.max_force


@pytest.mark.parametrize("play", [0.02, 0.1, 0.5])
def test_clearance_and_backlash_are_those_wanted(play):
    case = case_with("rigid")
    found = even_load_profile(case, CLEARANCE, play * ARCMIN, Equilibrium(poses=4))
    assert not found.play.binds
    # Pins next to the critical phase have less lever: below 0.7 % of the play.
    assert found.play.worst == pytest.approx(play * ARCMIN, rel=7e-3)
    ends = np.array([0.0, math.pi])
    drawn = np.abs(case.drive.theoretical_profile.at(ends).position)
    np.testing.assert_allclose(drawn - np.abs(found.profile.at(ends).position), CLEARANCE, rtol=1e-6)
    assert found.profile == modify(
        case.drive.theoretical_profile,
        FlankRotation(0.5 * play * ARCMIN),
        RootAndTipRelief(CLEARANCE, found.root_reach, found.tip_reach),
    )


@given(st.floats(0.1, 0.9), st.floats(1e-3, 20e-3))
def test_relief_by_finite_differences(theoretical, reach, amount):
    stock, trochoid = FlankStock(amount, reach, 0.5 * reach), theoretical.trochoid
    psi, step = np.linspace(-3.1, 3.1, 401), 1e-5
    # Away from root, tip, and the ends of the reliefs, where the curvature jumps.
    lever = np.abs(trochoid.lever_function(psi))
    psi = psi[np.min(np.abs(lever[:, np.newaxis] - np.array([0.0, reach, 0.5 * reach])), axis=1) > 1e-3]
    side = np.sign(psi)
    at = [stock.derivatives(psi + k * step, side, trochoid) for k in (-1.0, 0.0, 1.0)]
    np.testing.assert_allclose(at[1].first, (at[2].value - at[0].value) / (2.0 * step), atol=1e-4 * amount / reach**2)
    np.testing.assert_allclose(at[1].second, (at[2].first - at[0].first) / (2.0 * step), atol=1e-2 * amount / reach**3)
    assert np.all((at[1].value <= 0.0) & (at[1].value >= -amount))


def test_relief_keeps_the_working_flank(theoretical):
    relieved, psi = RootAndTipRelief(CLEARANCE, 0.3, 0.3).apply(theoretical), np.linspace(0.1, 3.0, 50)
    working = theoretical.trochoid.lever_function(psi) >= 0.3
    moved = np.abs(relieved.at(psi).position - theoretical.at(psi).position)
    np.testing.assert_allclose(moved[working], 0.0, atol=1e-12)
    equidistant = modify(theoretical, Equidistant(CLEARANCE)).at(np.zeros(1)).position
    np.testing.assert_allclose(relieved.at(np.zeros(1)).position, equidistant, atol=1e-12)


@dataclass(frozen=True)
class Ended:
    """A solver whose last pose ends with ``outcome``, and whose balances err by ``residual``."""

    outcome: SolveStatus
    residual: float

    def solve(self, case):
        found = SOLVERS[0].solve(case)
        outcomes = found.outcome.copy()
        outcomes[-1] = STATUSES.index(self.outcome)
        return replace(found, outcome=outcomes, residual=np.full_like(found.residual, self.residual))


@pytest.mark.parametrize("outcome", [SolveStatus.NOT_CONVERGED, SolveStatus.LOST])
def test_forces_out_of_balance_are_refused(outcome):
    with pytest.raises(SolveError, match="load sharing"):
        even_load_profile(case_with("rigid"), CLEARANCE, PLAY, Ended(outcome, 1e-3), poses=2)


@pytest.mark.parametrize("good", [Ended(SolveStatus.NOT_CONVERGED, 1e-9), Ended(SolveStatus.INTERFERENCE, 1e-3)])
def test_forces_in_balance_and_overlaps_before_the_load_are_used(good):
    case = case_with("rigid")
    found, plain = (even_load_profile(case, CLEARANCE, PLAY, solver, poses=2) for solver in (good, SOLVERS[0]))
    assert found.profile == plain.profile


@pytest.mark.parametrize(
    "wrong", [{"radial_clearance": -1.0}, {"play": 0.0}, {"play": math.nan}, {"relieved_share": 1.0}]
)
def test_impossible_amounts_are_refused(wrong):
    given_amounts = {"radial_clearance": CLEARANCE, "play": PLAY, "relieved_share": 0.01, **wrong}
    with pytest.raises(CompensationError):
        even_load_profile(case_with("rigid"), solver=Equilibrium(poses=2), **given_amounts)


def test_too_much_clearance_for_the_root_is_refused():
    with pytest.raises(CompensationError, match="leaves the root no concave radius") as caught:
        even_load_profile(case_with("rigid"), 22.5 * UM, PLAY, Equilibrium(poses=2))
    assert caught.value.exit_code == 1


@pytest.mark.parametrize("reach", [0.0, 1.0, math.nan])
def test_impossible_reach_is_refused(theoretical, reach):
    with pytest.raises(GeometryError, match="outside 0 to 1"):
        RootAndTipRelief(CLEARANCE, 0.3, reach).apply(theoretical)
