"""(c) The whole stage, seven unknowns a pose, against a plain loop with a general root finder."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import root

import cycloid_profile as cp
from cycloid_profile.arrays import ComplexArray, FloatArray

POSES = 3_000
EVERY = 101  # the plain loop takes every so manieth pose, 30 in all; prime to the mesh cycles in a turn


class PlainStage:
    """Equilibrium of one pose after docs/theory.md, "The whole stage", written as plainly as it reads.

    Unknowns u = (Θ, x1, y1, θ1, x2, y2, θ2). Only the exact gaps and the contact law are the package's.
    """

    def __init__(self, case: cp.LoadCase) -> None:
        self.case, drive = case, case.drive
        cranks, stage = drive.support, drive.first_stage
        assert isinstance(cranks, cp.Cranks)
        assert stage is not None
        self.bearing_stiffness = cranks.bearing_stiffness
        self.at_zero = 1j * cranks.circle_radius * np.exp(2j * np.pi * np.arange(cranks.count) / cranks.count)
        self.swing_rate = 1j * drive.trochoid.eccentricity * (1.0 + stage.sun_teeth / stage.planet_teeth)
        self.radius = drive.trochoid.pin_circle_radius

    def solve(self, crank_angle: float) -> tuple[FloatArray, FloatArray]:
        """Unknowns, and the force on each pin, shape (discs, pins)."""
        meshing = cp.mesh(self.case.drive.trochoid, crank_angle, discs=2)
        arm = self.at_zero * np.exp(1j * meshing.carrier_angle[0])  # A_m, carried round
        swing = self.swing_rate * np.exp(1j * meshing.crank_angle[0])
        start = self._pressed(swing)
        # Every unknown is of the size of 1 and changes the pose by about 10 µm at the pins: the root finder
        # takes its difference steps relative to the unknowns.
        per_unknown = 0.01 / np.array([self.radius, 1.0, 1.0, self.radius, 1.0, 1.0, self.radius])

        def unbalance(z: FloatArray) -> FloatArray:
            return self.unbalance(start + (z - 1.0) * per_unknown, meshing, arm, swing)[0]

        found = root(unbalance, np.ones(7), tol=1e-12)
        assert found.success, found.message
        u: FloatArray = start + (found.x - 1.0) * per_unknown
        return u, self.unbalance(u, meshing, arm, swing)[1]

    def unbalance(
        self, u: FloatArray, meshing: cp.Meshing, arm: ComplexArray, swing: ComplexArray
    ) -> tuple[FloatArray, FloatArray]:
        """Moments and forces times the pin circle's radius over the torque (Eq. 38), and the pin forces."""
        carrier, shift, turn = u[0], u[[1, 4]] + 1j * u[[2, 5]], u[[3, 6]]
        touch = cp.gaps(self.case.profile, self.case.drive.pin_radius, meshing, shift[np.newaxis], turn[np.newaxis])
        force = self.case.law.force(-touch.gap[0], self.case.line_contact(touch.curvature[0]))
        eccentric = arm + swing[:, np.newaxis]
        stretch = eccentric * carrier - shift[:, np.newaxis] - arm * turn[:, np.newaxis]  # Eq. 35
        bearing = self.bearing_stiffness * stretch
        on_disc = np.sum(force * touch.normal[0], axis=1) - np.sum(bearing, axis=1)
        about_disc = np.sum(force * touch.lever[0], axis=1) - np.sum((np.conj(bearing) * arm).real, axis=1)
        about_carrier = np.sum((np.conj(bearing) * eccentric).real) - self.case.torque
        rows = [about_carrier]
        for j in range(2):
            rows += [self.radius * on_disc[j].real, self.radius * on_disc[j].imag, about_disc[j]]
        return np.array(rows) / self.case.torque, force

    def _pressed(self, swing: ComplexArray) -> FloatArray:
        """Carrier, cranks and discs turned as one through the clearance and until one pin could carry a disc."""
        lever = self.case.drive.trochoid.longest_lever
        clearance = self.case.profile.pin_radius - self.case.drive.pin_radius
        flat = self.case.line_contact(np.zeros(()))
        turn = (clearance + float(self.case.law.approach(self.case.torque / 2 / lever, flat))) / lever
        moved = swing * turn
        return np.array([turn, moved[0].real, moved[0].imag, turn, moved[1].real, moved[1].imag, turn])


def test_stage(side_by_side: Callable[..., Any], rv40e: cp.LoadCase) -> None:
    crank_angle = cp.output_turn(rv40e.drive.trochoid, POSES)
    stage, some = PlainStage(rv40e), np.arange(0, POSES, EVERY)

    def looped() -> list[tuple[FloatArray, FloatArray]]:
        return [stage.solve(float(phi)) for phi in crank_angle[some]]

    answer = side_by_side(
        ours=lambda: cp.StageEquilibrium().at(rv40e, crank_angle),
        plain=looped,
        rounds=7,
        row="(c) whole stage, 7 unknowns, 3,000 poses × 2 discs × 40 pins over an output turn",
        against="`scipy.optimize.root` pose by pose, same gaps and law",
        figure="loop / ours",
        poses=POSES,
        looped=some.size,
        least=20.0,
        most_seconds=2.0,
    )

    assert answer.converged
    for i, (u, force) in zip(some, looped(), strict=True):
        assert answer.stage is not None
        assert abs(answer.rotation[i] / u[0] - 1.0) < 1e-7
        np.testing.assert_allclose(answer.stage.motion[i].ravel(), u[1:], rtol=1e-7, atol=1e-7 * 0.01)
        np.testing.assert_allclose(answer.force[i], force, rtol=0.0, atol=1e-7 * answer.max_force)
