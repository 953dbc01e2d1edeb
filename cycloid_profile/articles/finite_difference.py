"""Sensitivity of the backlash to part errors by finite differences of the exact model (docs/budget.md).

Each kind of error has a method; all give the change of the backlash per mm of the error, over poses of one turn of the
output. The crank is locked, so the first stage has no influence; the bearings are undeflected.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.articles.formulas import InvolutePair
from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import PartDeviations
from cycloid_profile.contact.mesh import first_touch, mesh, output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.effects import AsBuiltReducer, CrankBearingClearance, Effect, as_drawn
from cycloid_profile.errors import SolveError
from cycloid_profile.geometry import Cranks
from cycloid_profile.rig import lost_motion_map
from cycloid_profile.units import UM

# No factor in common with the mesh cycles of any usual drive: every pose has its own place in a mesh cycle.
POSES = 101
# For costlier poses, and for many random rings.
_FEW_POSES = 31
_SEED = 1
# Far above the elastic deflection of the bearings under a light torque, so that the measured quantity is their play.
_BEARING_PLAY = 5.0 * UM
_LIGHT_TORQUE_SHARE = 1e-3
_LEAD = 1e-5  # rad; small against every tooth, large against rounding
_REMEDY = "bring modification.equidistant_um and radial_moving_um nearer to zero"


@dataclass(frozen=True, slots=True)
class BacklashSlope:
    """Change of the backlash per mm of an error [rad/mm], positive where the error increases play.

    ``mean``, ``least`` and ``greatest`` over the poses of the reducer, where the first disc in contact limits the
    rotation; ``one_disc`` is the mean of disc 1 alone, None for errors outside the mesh; ``statistic``, averaging range
    and reference length as text.
    """

    mean: float
    least: float
    greatest: float
    one_disc: float | None
    statistic: str


@dataclass(frozen=True)
class DifferenceSetup:
    """``case`` with the modified tooth, ``step`` of the errors [mm], number of ``poses``."""

    case: LoadCase
    step: float = 1.0 * UM
    poses: int = POSES

    @cached_property
    def crank_angle(self) -> FloatArray:
        """Crank angles of one turn of the output, shape (poses,) [rad]."""
        return output_turn(self.case.drive.trochoid, self.poses)

    @cached_property
    def nominal_backlash(self) -> FloatArray:
        """Backlash of the reducer without errors, as ``backlash`` gives it."""
        return self.backlash(as_drawn(self.case))

    def backlash(self, reducer: AsBuiltReducer) -> FloatArray:
        """Backlash with the crank locked, of the reducer and of disc 1 alone, shape (2, poses) [rad].

        Common rotation of all discs between contact on either flank at each pose, by exact contact.

        Raises ``SolveError`` if at some pose no first touch is found.
        """
        drive = reducer.case.drive
        meshing = mesh(drive.trochoid, self.crank_angle, drive.discs)
        meshing = replace(meshing, pin_centre=meshing.pin_in_lobe(pin_shift=reducer.pin_shift))
        radius = drive.pin_radius + reducer.pin_oversize
        turned = np.empty((2, drive.discs, self.poses))
        for j, tooth in enumerate(reducer.teeth):
            for k, direction in enumerate((1.0, -1.0)):
                touch = first_touch(tooth, radius, meshing.disc(j), direction)
                if not np.all(touch.settled):
                    raise SolveError("first touch", "not found", "at some pose", _REMEDY, " ")
                turned[k, j] = touch.rotation[:, 0]
        forward, backward = turned
        return np.stack([np.min(forward, axis=0) - np.max(backward, axis=0), forward[0] - backward[0]])


# Change of the backlash per mm of one kind of error.
Method = Callable[[DifferenceSetup], BacklashSlope]
# The reducer with an error, by its size [mm].
WithError = Callable[[LoadCase, float], AsBuiltReducer]


def by_effect(effect: Callable[[float], Effect]) -> WithError:
    """The reducer with one effect, by its size [mm]; ``effect`` takes it in µm."""
    return lambda case, amount: effect(amount / UM).apply(as_drawn(case))


def one_sided(reducer: WithError, reference: str = "") -> Method:
    """One-sided difference in the direction that increases backlash, so that a tight tooth does not bind.

    ``reference`` names the length the slope refers to.
    """

    def slope(setup: DifferenceSetup) -> BacklashSlope:
        change = setup.backlash(reducer(setup.case, setup.step)) - setup.nominal_backlash
        per = f" per mm of {reference}" if reference else ""
        return _over_poses(change / setup.step, f"mean over a turn{per}, at {setup.step / UM:g} µm")

    return slope


def central(reducer: WithError) -> Method:
    """An error that may close play in either sense: half the difference between more and less of it."""

    def slope(setup: DifferenceSetup) -> BacklashSlope:
        more, less = (setup.backlash(reducer(setup.case, sign * setup.step)) for sign in (1.0, -1.0))
        return _over_poses(0.5 / setup.step * (more - less), f"mean over a turn, from ±{setup.step / UM:g} µm")

    return slope


def scattered_pins(setup: DifferenceSetup, rings: int = 24) -> BacklashSlope:
    """Every pin hole displaced along the circle by a normal number, in ``rings`` random rings at a few poses each."""
    setup = replace(setup, poses=min(setup.poses, _FEW_POSES))
    pins = setup.case.drive.trochoid.pins
    along = 1j * np.exp(2j * np.pi * np.arange(pins) / pins)
    random, drawn = np.random.default_rng(_SEED), as_drawn(setup.case)
    found = [
        setup.backlash(replace(drawn, pin_shift=setup.step * random.standard_normal(pins) * along))
        - setup.nominal_backlash
        for _ in range(rings)
    ]
    return _over_poses(
        np.concatenate(found, axis=1) / setup.step,
        f"mean over a turn of {rings} drawn rings per mm of standard deviation, at {setup.step / UM:g} µm",
    )


def bearing_play(setup: DifferenceSetup) -> BacklashSlope:
    """Play of every crank bearing, per mm of diametral clearance: its part of the lost motion of the stage."""
    # With the cranks as the input the answer does not depend on the first stage.
    case = replace(setup.case, drive=replace(setup.case.drive, first_stage=None))
    torque, poses = _LIGHT_TORQUE_SHARE * abs(case.torque), min(setup.poses, _FEW_POSES)
    looser = CrankBearingClearance(_BEARING_PLAY / UM).apply(as_drawn(case))
    lost = [lost_motion_map(reducer, torque, poses).value for reducer in (as_drawn(case), looser)]
    if not np.all(np.isfinite(lost)):
        raise SolveError("lost motion", "not found", "at some pose", _REMEDY, " ")
    return _over_poses(
        (lost[1] - lost[0]) / (2.0 * _BEARING_PLAY),
        f"mean over a turn of the lost motion at ±{100.0 * _LIGHT_TORQUE_SHARE:g} % torque, "
        f"{_BEARING_PLAY / UM:g} µm radial play",
    )


def sun_play(play: Callable[[InvolutePair, float], float], statistic: str, turning: bool = False) -> Method:
    """An error of the involute stage: play of the pair by exact involutes, referred to the output by the stage model.

    ``turning`` where the error is an offset that turns with the planet, ±``step`` instead of ``step``.
    """

    def slope(setup: DifferenceSetup) -> BacklashSlope:
        stage = setup.case.drive.first_stage
        assert stage is not None
        pair, output = InvolutePair(stage), output_per_sun_play(setup.case)
        angle = 2.0 * np.pi * np.arange(24) / 24
        amounts = setup.step * np.cos(angle) if turning else np.array([setup.step])
        turned = np.array([play(pair, float(amount)) for amount in amounts]) * output / setup.step
        return _over_poses(turned, statistic)

    return slope


def output_per_sun_play(case: LoadCase) -> float:
    """Rotation of the output per rotation of the sun within the play of the gears, by the stage model.

    All planets are rotated by ± the same small angle and the carrier follows, at crank angle 0 (docs/budget.md,
    Eq. B6). The torque is 0.1 % of the rated one: the wind-up depends on the crank angle, which moves with the planets.
    At rated torque it would add 0.16 % with elastic discs of an RV-40E, 0.014 % with rigid ones. Needs a first stage;
    kinematics alone give 1/ratio.
    """
    drive = case.drive
    assert drive.first_stage is not None
    assert isinstance(drive.support, Cranks)
    turned = []
    for sign in (0.5, -0.5):
        lead = np.full(drive.support.count, sign * _LEAD, dtype=np.complex128)
        stage = StageEquilibrium(deviations=PartDeviations(crank_lead=lead))
        solved = stage.at(case, [0.0], _LIGHT_TORQUE_SHARE * case.torque)
        if not solved.converged:
            raise SolveError("equilibrium of the stage", solved.status.value, "", _REMEDY, ": ")
        turned.append(float(solved.rotation[0]))
    return abs(turned[0] - turned[1]) / _LEAD * drive.first_stage.tooth_ratio


def _over_poses(change: FloatArray, statistic: str) -> BacklashSlope:
    """The slope from its values at the poses; two rows are those of the reducer and of disc 1 alone."""
    reducer, one_disc = (change[0], float(np.mean(change[1]))) if change.ndim == 2 else (change, None)
    return BacklashSlope(float(np.mean(reducer)), float(np.min(reducer)), float(np.max(reducer)), one_disc, statistic)
