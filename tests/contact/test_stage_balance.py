"""Physics of the whole stage: free bodies in balance, least energy, mirror, play, closed forms of one pin.

The checks start from what a solve reports, pins' forces and the place of every disc, and work out the rest
again: pins, cranks and bores as points of the plane, moments as cross products, energy by quadrature.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, LoadSharing, SolveStatus
from cycloid_profile.contact.bodies import NO_DEVIATIONS, PartDeviations
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import LAWS, Palmgren, Roark
from cycloid_profile.contact.mesh import Meshing, gaps, mesh_cycle
from cycloid_profile.contact.stage import StageEquilibrium, energy_about, minimise
from cycloid_profile.geometry import CentralEccentric, Cranks, Drive, InvoluteStage, Trochoid, undercut_limit
from cycloid_profile.modification import Equidistant, MeasuredDeviation, NormalDeviation, RadialMoving, modify
from tests.contact.plain_search import plain_search

UM = 1e-3
GROUND = (Equidistant(0.006), RadialMoving(0.001))
# Nodes for the energy of one contact; δ = δ_end·t³ takes the logarithm of the force law off the end.
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
NODES, WEIGHTS = 0.5 * (NODES + 1.0), 0.5 * WEIGHTS


def cross(arm, force):
    """Moment of a force about the foot of its arm."""
    return (np.conj(arm) * force).imag


@dataclass(frozen=True)
class Pose:
    """One pose as points of the plane: carrier at ``turn``, each disc at (``shift``, ``own_turn``)."""

    case: LoadCase
    deviations: PartDeviations
    meshing: Meshing
    turn: float
    shift: np.ndarray
    own_turn: np.ndarray

    @property
    def drive(self) -> Drive:
        return self.case.drive

    @property
    def crank(self) -> np.ndarray:
        """Crank angle of each disc, shape (discs, 1)."""
        return self.meshing.crank_angle[0][:, np.newaxis]

    @property
    def gear(self) -> float:
        """Turn of the cranks against the housing per turn of the carrier, input held: 1 + z1/z2."""
        first = self.drive.first_stage
        return 0.0 if first is None else 1.0 + first.sun_teeth / first.planet_teeth

    @property
    def crank_axes(self) -> np.ndarray:
        """Axes of the cranks, nominal, shape (1, cranks)."""
        cranks, lobes = self.drive.support, self.drive.trochoid.lobes
        around = 2.0 * math.pi * np.arange(cranks.count) / cranks.count
        return cranks.circle_radius * np.exp(1j * (around - self.crank[0] / lobes))[np.newaxis]

    @property
    def eccentric(self) -> np.ndarray:
        """Nominal eccentricity of each disc's eccentrics, shape (discs, 1)."""
        return self.drive.trochoid.eccentricity * np.exp(1j * self.crank)

    def misfit(self) -> np.ndarray | float:
        """Eccentric minus bore that the errors of parts leave in the nominal place, exact."""
        reducer, found = self.deviations, 0.0
        carrier = np.exp(-1j * self.crank[0] / self.drive.trochoid.lobes)
        own = np.exp(1j * self.crank)
        if reducer.eccentric_shift is not None:
            found = found + reducer.eccentric_shift * own
        if reducer.bore_shift is not None:
            found = found - reducer.bore_shift * carrier
        return found

    def lead(self) -> np.ndarray | float:
        """How far each crank runs ahead of its planet's nominal angle."""
        planet, found = self.crank[0] * (1.0 + 1.0 / self.drive.trochoid.lobes), 0.0
        if self.deviations.crank_lead is not None:
            found = found + (self.deviations.crank_lead * np.exp(1j * planet)).real[np.newaxis]
        if self.deviations.sun_shift:
            # The sun's pitch circle moves on along a planet's by so much; the planet rolls back on it.
            first, lobes = self.drive.first_stage, self.drive.trochoid.lobes
            sun = self.deviations.sun_shift * np.exp(-1j * planet * first.planet_teeth / first.sun_teeth)
            axes = self.crank_axes * np.exp(1j * self.crank[0] / lobes)
            forwards = 1j * axes / np.abs(axes)
            along = sun.real * forwards.real + sun.imag * forwards.imag
            found = found - 2.0 * along / (first.module * first.planet_teeth)
        return found

    def stretch(self) -> np.ndarray:
        """Eccentric's centre minus bore's centre to first order (Eq. 35), shape (discs, bearings)."""
        own = self.shift[:, np.newaxis]
        if isinstance(self.drive.support, CentralEccentric):
            return -own
        swung = 1j * self.eccentric * (self.gear * self.turn + self.lead())
        axes = self.crank_axes
        return 1j * axes * self.turn + swung + self.misfit() - own - 1j * axes * self.own_turn[:, np.newaxis]

    def finite_stretch(self) -> np.ndarray:
        """The same with carrier, cranks and discs turned by their whole angles."""
        axes, own = self.crank_axes, self.shift[:, np.newaxis]
        eccentric = axes * np.exp(1j * self.turn) + self.eccentric * np.exp(1j * (self.gear * self.turn + self.lead()))
        bore = self.eccentric + own + axes * np.exp(1j * self.own_turn[:, np.newaxis])
        return eccentric + self.misfit() - bore

    def bearing_force(self) -> np.ndarray:
        """What each eccentric pulls its bore with: the spring acts on the stretch beyond the play."""
        stretch, support = self.stretch(), self.drive.support
        length = np.abs(stretch)
        beyond = np.maximum(length - support.bearing_play, 0.0)
        return support.bearing_stiffness * beyond * stretch / np.where(length > 0.0, length, 1.0)

    def gaps(self):
        """Exact gaps, disc by disc, shape (discs, pins) each."""
        reducer, trochoid = self.deviations, self.drive.trochoid
        radius = self.drive.pin_radius + (0.0 if reducer.pin_oversize is None else reducer.pin_oversize)
        pins = np.zeros(trochoid.pins) if reducer.pin_shift is None else reducer.pin_shift
        teeth = reducer.teeth or (self.case.profile,) * self.drive.discs
        return [
            gaps(
                tooth,
                radius,
                self.meshing.disc(j),
                self.shift[np.newaxis, j : j + 1],
                self.own_turn[np.newaxis, j : j + 1],
                pins,
            )
            for j, tooth in enumerate(teeth)
        ]

    def stacked(self, name) -> np.ndarray:
        return np.concatenate([getattr(found, name)[0] for found in self.gaps()])

    def pin_force(self) -> np.ndarray:
        """Force of every pin from its own gap, shape (discs, pins)."""
        return self.case.law.force(-self.stacked("gap"), self.case.line_contact(self.stacked("curvature")))

    def pin_arm(self) -> np.ndarray:
        """From the centre of each disc to each pin, where the line of its force passes."""
        trochoid = self.drive.trochoid
        pin = trochoid.pin_circle_radius * np.exp(2j * math.pi * np.arange(trochoid.pins) / trochoid.pins)
        if self.deviations.pin_shift is not None:
            pin = pin + self.deviations.pin_shift
        return pin - (self.eccentric[:, 0] + self.shift)[:, np.newaxis]

    def potential(self, curvature) -> float:
        """Energy of pins and bearings less the work of the torque, by quadrature of the force law."""
        delta = np.maximum(-self.stacked("gap"), 0.0)[..., np.newaxis]
        force = self.case.law.force(delta * NODES**3, self.case.line_contact(curvature[..., np.newaxis]))
        pins = float(np.sum(force * delta * 3.0 * NODES**2 * WEIGHTS))
        support = self.drive.support
        beyond = np.maximum(np.abs(self.stretch()) - support.bearing_play, 0.0)
        return pins + 0.5 * support.bearing_stiffness * float(np.sum(beyond**2)) - self.case.torque * self.turn


def pose(state: LoadSharing, i: int, deviations: PartDeviations = NO_DEVIATIONS) -> Pose:
    motion = state.stage.motion[i]
    return Pose(
        case=replace(state.case, torque=float(state.torque[i])),
        deviations=deviations,
        meshing=state.stage.meshing.poses(slice(i, i + 1)),
        turn=float(state.rotation[i]),
        shift=motion[:, 0] + 1j * motion[:, 1],
        own_turn=motion[:, 2],
    )


class AsBuiltReducer(NamedTuple):
    case: LoadCase
    deviations: PartDeviations
    crank: float


@st.composite
def built_stages(draw) -> AsBuiltReducer:
    """Reducers of all kinds, with parts a few micrometres off."""
    pins = draw(st.integers(8, 44))
    trochoid = Trochoid(pins, 64.0, draw(st.floats(0.4, 0.85)) * 64.0 / pins)
    r_rp = 0.6 * min(undercut_limit(trochoid), 64.0 * math.sin(math.pi / pins))
    discs, play = draw(st.integers(1, 3)), draw(st.sampled_from([0.0, 0.002, 0.008]))
    count = draw(st.sampled_from([0, 2, 3, 4]))
    if count:
        support = Cranks(count, 36.0, draw(st.sampled_from([1e5, 4e5, 2e6])), play)
        first = draw(st.sampled_from([None, InvoluteStage(12, 36, 1.5)]))
    else:
        support, first = CentralEccentric(draw(st.sampled_from([1e5, 4e5])), play), None
    drive = Drive(trochoid, r_rp, 11.5, discs, support, first)
    ground = modify(drive.theoretical_profile, Equidistant(0.006))
    torque = draw(st.sampled_from([1.0, -1.0])) * draw(st.floats(0.05, 1.0)) * 200.0 * pins * trochoid.longest_lever
    case = LoadCase(drive, ground, torque, law=draw(st.sampled_from(list(LAWS.values()))))
    return AsBuiltReducer(case, draw(parts(drive, ground, count)), draw(st.floats(-50.0, 50.0)))


@st.composite
def parts(draw, drive, ground, cranks) -> PartDeviations:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))

    def scattered(*shape):
        return rng.uniform(-2 * UM, 2 * UM, shape) + 1j * rng.uniform(-2 * UM, 2 * UM, shape)

    pins, lobes = drive.trochoid.pins, drive.trochoid.lobes
    teeth = None
    if draw(st.booleans()):
        phase = np.linspace(0.0, 2.0 * math.pi * lobes, 8 * lobes, endpoint=False)
        curve = NormalDeviation(phase, rng.uniform(-2 * UM, 2 * UM, phase.size), lobes)
        teeth = (MeasuredDeviation(curve).apply(ground), *(ground,) * (drive.discs - 1))
    return PartDeviations(
        pin_shift=scattered(pins),
        pin_oversize=rng.uniform(-UM, UM, pins),
        teeth=teeth,
        eccentric_shift=scattered(drive.discs, cranks) if cranks else None,
        bore_shift=scattered(drive.discs, cranks) if cranks else None,
        crank_lead=scattered(cranks) / 20.0 if cranks else None,
        sun_shift=complex(scattered(1)[0]) if drive.first_stage else 0j,
    )


@given(built_stages())
@settings(max_examples=60)
def test_every_free_body_is_in_balance(reducer):
    case, drive = reducer.case, reducer.case.drive
    state = StageEquilibrium(deviations=reducer.deviations).at(case, [reducer.crank])
    assert state.settled[0], state.status
    here = pose(state, 0, reducer.deviations)
    normal, bearing = here.stacked("normal"), state.stage.bearing_force[0]
    # The solver's tolerance is 1e-9 of the torque, forces at the arm of the pin circle. Gaps are rounded to some
    # 1e-14 mm, which a stiff contact turns into 1e-7 N.
    r_p = drive.trochoid.pin_circle_radius
    torque = abs(case.torque) + 100.0 * r_p
    force = torque / r_p
    # The curvature that goes with a foot is that of one Newton step before, up to 1e-8 rad off.
    np.testing.assert_allclose(state.force[0], here.pin_force(), rtol=3e-8, atol=1e-9 * force)
    np.testing.assert_allclose(bearing, here.bearing_force(), rtol=1e-9, atol=1e-9 * force)
    pushed = state.force[0] * normal
    # Disc: pins push it inwards, against the normal; the eccentrics pull at its bores.
    np.testing.assert_allclose(np.sum(bearing, axis=1), np.sum(pushed, axis=1), rtol=0.0, atol=2e-9 * force)
    of_pins = np.sum(cross(here.pin_arm(), pushed), axis=1)
    if isinstance(drive.support, CentralEccentric):
        # The disc hands its moment to the output through pins in holes; the eccentric's centre has no arm.
        carried = np.sum(of_pins)
    else:
        axes = here.crank_axes
        np.testing.assert_allclose(np.sum(cross(axes, bearing), axis=1), of_pins, rtol=0.0, atol=2e-9 * torque)
        # Crank with its planet: the moment of its eccentrics is held by the sun's tooth force, which acts a
        # planet's radius from the crank's axis and a sun's radius from the centre of the drive.
        first = drive.first_stage
        to_sun = 0.0 if first is None else first.sun_teeth / first.planet_teeth
        own = np.sum(cross(here.eccentric, bearing))
        on_sun = to_sun * own
        # Held cranks without a first stage give their own moment to the housing, not to the carrier.
        carried = np.sum(cross(axes, bearing)) + (0.0 if first is None else own) + on_sun
    assert carried == pytest.approx(case.torque, abs=2e-9 * torque)


@given(st.floats(0.02, 1.0), st.sampled_from([1.0, -1.0]), st.floats(-40.0, 40.0), st.sampled_from([0.0, 0.005]))
@settings(max_examples=15)
def test_first_order_supports_miss_a_few_nanometres(rv40e, rated_torque, share, sign, crank, play):
    # Carrier, cranks and discs turned by finite angles Θ and θ: (a/2)(1.33 Θ)² and r_c Θ(Θ − θ), some 2 nm together
    # at the largest rotations that occur here, 1e-3 rad.
    drive = replace(rv40e, support=Cranks(3, 36.0, 4e5, play))
    case = LoadCase(drive, modify(drive.theoretical_profile, *GROUND), sign * share * rated_torque)
    reducer = PartDeviations(
        eccentric_shift=np.full((2, 3), 2e-3 + 1e-3j), crank_lead=np.array([1e-4, 2e-4j, 0.0]), sun_shift=2e-3 + 4e-3j
    )
    state = StageEquilibrium(deviations=reducer).at(case, [crank])
    assert state.converged
    here = pose(state, 0, reducer)
    np.testing.assert_allclose(here.finite_stretch(), here.stretch(), rtol=0.0, atol=5e-6)


@given(built_stages(), st.integers(0, 2**32 - 1))
@settings(max_examples=20)
def test_equilibrium_is_the_least_energy(reducer, seed):
    state = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, [reducer.crank])
    here = pose(state, 0, reducer.deviations)
    # The force law takes the curvature of the contact it is in; the energy of that contact keeps it.
    curvature = here.stacked("curvature")
    least = here.potential(curvature)
    # What is stored less the torque's work: a small difference of two, known to 1e-9 of either.
    work = abs(reducer.case.torque * state.rotation[0])
    assert state.stage.energy[0] == pytest.approx(least, rel=1e-9, abs=1e-9 * work)
    rng = np.random.default_rng(seed)
    central = isinstance(reducer.case.drive.support, CentralEccentric)
    for size in (1e-4, 1e-5):
        for _ in range(5):
            discs = reducer.case.drive.discs
            shift = size * (rng.normal(size=discs) + 1j * rng.normal(size=discs))
            turn, own = size / 36.0 * rng.normal(), size / 36.0 * rng.normal(size=discs)
            moved = replace(
                here,
                turn=here.turn + turn,
                shift=here.shift + shift,
                own_turn=here.own_turn + (turn if central else own),
            )
            assert moved.potential(curvature) > least


@given(built_stages())
@settings(max_examples=20)
def test_no_step_of_the_plain_search_has_less_energy(reducer):
    solved = StageEquilibrium(deviations=reducer.deviations).at(reducer.case, reducer.crank + np.linspace(0.0, 0.1, 3))
    problem = energy_about(solved, reducer.deviations)
    begin = np.zeros((3, problem.arm.size))
    begin[:, 0] = 1e-4 * np.sign(problem.torque)
    least = problem.at(minimise(problem, begin, 1e-11)[0]).energy
    energies = [problem.at(plain_search(problem, begin, 1e-11, steps)).energy for steps in range(12)]
    # Rounding of the two large parts, the stored energy and the work of the torque.
    rounding = 3e-13 * (np.abs(energies).max(axis=0) + np.abs(problem.torque * problem.rotation))
    assert np.all(least <= np.min(energies, axis=0) + rounding)
    assert np.all(least < energies[0])


@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)
@pytest.mark.parametrize("count", [0, 2, 3])
def test_one_loaded_pin_is_hertz_and_bearings_in_series(rv40e, law, count):
    # A millimetre of clearance, one disc and a light load: one pin carries. Then F follows from the torque by
    # virtual work, and the twist is contact, shift of the disc and turn of the disc in series:
    # Θ l_eff = δ(F) + F/(n k) + F l²/(n k r_c²).
    stiffness = 4e5
    support = Cranks(count, 36.0, stiffness) if count else CentralEccentric(stiffness)
    drive = replace(rv40e, discs=1, support=support, first_stage=rv40e.first_stage if count else None)
    torque = 412.0
    state = StageEquilibrium(poses=5).solve(
        LoadCase(drive, modify(drive.theoretical_profile, Equidistant(1.0)), torque, law=law)
    )
    assert state.converged
    assert np.all(np.sum(state.loaded, axis=(1, 2)) == 1)
    for i in range(5):
        here = pose(state, i)
        k = int(np.argmax(state.force[i, 0]))
        normal = here.stacked("normal")[0, k]
        lever = cross(here.pin_arm()[0, k], normal)
        effective = lever + (np.conj(normal) * 1j * here.gear * here.eccentric[0, 0]).real
        force = torque / effective
        contact = state.case.line_contact(here.stacked("curvature")[0, k : k + 1])
        delta = float(law.approach(force, contact)[0])
        assert state.force[i, 0, k] == pytest.approx(force, rel=2e-9)
        assert state.approach[i, 0, k] == pytest.approx(delta, rel=1e-8)
        assert state.pressure[i, 0, k] == pytest.approx(float(law.peak_pressure(force, contact)[0]), rel=1e-8)
        bearings = max(count, 1)
        turned = lever**2 / (bearings * stiffness * 36.0**2) if count else 0.0
        closed = (delta + force / (bearings * stiffness) + force * turned) / effective
        # The pin's normal turns by motion/size, 1e-6, on the way from touch.
        assert state.twist[i] == pytest.approx(closed, rel=1e-4)


@given(st.floats(-40.0, 40.0), st.floats(0.03, 1.0), st.integers(2, 4), st.integers(1, 3), st.booleans())
@settings(max_examples=15)
def test_mirrored_stage_under_reversed_torque_is_the_mirror_image(
    rv40e, rated_torque, crank, share, count, discs, play
):
    # Mirror in the x axis: crank and torque change sign, pin k and crank k go to −k, disc j to −j.
    drive = replace(rv40e, discs=discs, support=Cranks(count, 36.0, 4e5, 0.004 if play else 0.0))
    case = LoadCase(drive, modify(drive.theoretical_profile, *GROUND), share * rated_torque)
    there = StageEquilibrium().at(case, [crank])
    back = StageEquilibrium().at(case, [-crank], -case.torque)
    pin, disc, bearing = (-np.arange(n) % n for n in (40, discs, count))
    assert there.converged
    assert back.converged
    assert back.rotation[0] == pytest.approx(-there.rotation[0], rel=1e-8)
    force = np.max(there.force)
    mirrored = back.force[0][disc][:, pin]
    np.testing.assert_allclose(mirrored, there.force[0], rtol=0.0, atol=1e-6 * force)
    # On the unit circle, where −π and π are one.
    np.testing.assert_allclose(*(np.exp(1j * psi) for psi in (back.phase[0][disc][:, pin], there.phase[0])), atol=1e-12)
    bearings = np.conj(back.stage.bearing_force[0])[disc][:, bearing]
    np.testing.assert_allclose(bearings, there.stage.bearing_force[0], rtol=0.0, atol=1e-6 * force)
    motion = back.stage.motion[0][disc] * (1.0, -1.0, -1.0)
    np.testing.assert_allclose(motion, there.stage.motion[0], rtol=0.0, atol=1e-9 * 64.0)


def slope_error(solver, case, share):
    """Worst relative difference between the reported stiffness and a central difference over 2·10⁻⁴ of the torque."""
    torque = share * case.torque
    step = 1e-4 * torque
    crank = 0.013 + mesh_cycle(case.drive.trochoid, 6)
    less, here, more = (solver.at(case, crank, torque + s) for s in (-step, 0.0, step))
    slope = 2.0 * step / (more.rotation - less.rotation)
    return np.max(np.abs(here.torsional_stiffness / slope - 1.0))


@pytest.mark.parametrize("share", [-1.0, -0.3, 0.05, 0.3, 1.0])
def test_torsional_stiffness_of_a_disc_is_the_slope_of_its_twist(rv40e, rated_torque, share):
    # Levers and curvatures are those of first touch at every torque: the slope is exact.
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, *GROUND), rated_torque)
    assert slope_error(Equilibrium(), case, share) < 1e-6


@pytest.mark.parametrize("play", [0.0, 0.005])
@pytest.mark.parametrize("share", [-1.0, -0.3, 0.05, 0.3, 1.0])
@pytest.mark.parametrize(("law", "tolerance"), [(Palmgren(), 1e-4), (Roark(), 1e-3)], ids=["palmgren", "roark"])
def test_torsional_stiffness_of_the_stage_is_the_slope_of_its_twist(rv40e, rated_torque, share, play, law, tolerance):
    # Solves end at 1e-11 of the torque, so that the slope is good to 1e-6. The reported stiffness holds every normal
    # and lever, which turn by motion/size: 6e-5 at the rated torque. Roark's law also depends on the curvature at the
    # foot, which wanders along the flank under load and is held as well: 6e-4.
    drive = replace(rv40e, support=Cranks(3, 36.0, 4e5, play))
    case = LoadCase(drive, modify(drive.theoretical_profile, *GROUND), rated_torque, law=law)
    assert slope_error(StageEquilibrium(tolerance=1e-11), case, share) < tolerance


@pytest.mark.parametrize("play", [0.002, 0.005, 0.010])
def test_bearing_play_adds_its_angle_on_the_crank_circle(rv40e, rated_torque, play):
    # Diametral play over the radius of the crank circle, 2c/r_c. Of the forces on a bearing only the part along
    # the circle turns the carrier: the pins also push the disc sideways, and the sum falls short by 1–2 %.
    crank = mesh_cycle(rv40e.trochoid, 8)

    def lost_motion(play):
        drive = replace(rv40e, support=Cranks(3, 36.0, 4e5, play))
        case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006)), 0.03 * rated_torque)
        there, back = (StageEquilibrium().at(case, crank, sign * case.torque) for sign in (1.0, -1.0))
        assert there.converged
        assert back.converged
        return there.rotation - back.rotation

    added = lost_motion(play) - lost_motion(0.0)
    np.testing.assert_allclose(added, 2.0 * play / 36.0, rtol=0.03)
    assert np.ptp(added) < 0.01 * np.mean(added)


@pytest.mark.parametrize("play", [0.0, 0.005])
def test_an_impossible_pose_leaves_the_others_untouched(rv40e, rated_torque, play):
    # 10⁸ times the rated torque pushes the carrier round by more than a radian.
    drive = replace(rv40e, support=Cranks(3, 36.0, 4e5, play))
    case = LoadCase(drive, modify(drive.theoretical_profile, *GROUND), rated_torque)
    crank = mesh_cycle(drive.trochoid, 5)
    torque = rated_torque * np.array([1.0, -0.2, 1e8, 0.5, -1.0])
    together = StageEquilibrium().at(case, crank, torque)
    assert together.statuses[2] in (SolveStatus.LOST, SolveStatus.NOT_CONVERGED)
    for i in (0, 1, 3, 4):
        alone = StageEquilibrium().at(case, crank[i : i + 1], torque[i : i + 1])
        assert together.statuses[i] is SolveStatus.CONVERGED
        # Sums over another number of poses are rounded otherwise; nothing else may differ.
        assert together.rotation[i] == pytest.approx(alone.rotation[0], rel=1e-11)
        force = alone.max_force
        np.testing.assert_allclose(together.force[i], alone.force[0], rtol=0.0, atol=1e-9 * force)
        bearings = together.stage.bearing_force[i], alone.stage.bearing_force[0]
        np.testing.assert_allclose(*bearings, rtol=0.0, atol=1e-9 * force)


def test_absurdly_soft_bearings_are_reported_as_lost(rv40e, rated_torque):
    # 0.1 N/mm: the bearings would have to stretch by metres. Every pose says so and none stops the solve.
    drive = replace(rv40e, support=Cranks(3, 36.0, 0.1))
    case = LoadCase(drive, modify(drive.theoretical_profile, *GROUND), rated_torque)
    state = StageEquilibrium(poses=3).solve(case)
    assert state.statuses == (SolveStatus.LOST,) * 3
    assert not np.any(state.settled)
    assert np.all(np.isfinite(state.rotation))
