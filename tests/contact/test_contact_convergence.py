"""Observed convergence orders: poses of a mesh cycle, points of a measured curve, load, finite displacement.

Each error is measured against a much finer solve or an exact formula, and its slope over a range of sizes must be the
order that the mathematics gives.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.disc import Equilibrium
from cycloid_profile.contact.laws import Palmgren
from cycloid_profile.contact.mesh import backlash, first_touch, gaps, mesh, mesh_cycle
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.geometry import CentralEccentric, RemovalDerivatives, ToothProfile
from cycloid_profile.modification import (
    DeformationCompensation,
    Equidistant,
    MeasuredDeviation,
    NormalDeviation,
    RadialMoving,
    modify,
)

POSES = (6, 12, 24, 48, 96)


def order(sizes, errors):
    """Slope of the error over the size, both logarithmic."""
    return np.polyfit(np.log(sizes), np.log(errors), 1)[0]


def missed(values):
    """What the largest and the least of fewer poses miss on average over where the first pose stands.

    ``values`` at many even poses of a mesh cycle; every subset that is even itself is one such choice.
    """
    highest, least = [], []
    for count in POSES:
        chosen = values.reshape(count, -1)
        highest.append(float(np.mean(np.max(values) - np.max(chosen, axis=0))))
        least.append(float(np.mean(np.min(chosen, axis=0) - np.min(values))))
    return np.array(highest), np.array(least)


def test_extremes_of_the_backlash_over_the_poses(rv40e):
    # Each touch is the least over the pins of a smooth turn: minima are smooth and found to second order, maxima are
    # the kinks where another pin takes over, and found to first order.
    highest, least = missed(backlash(rv40e, modify(rv40e.theoretical_profile, RadialMoving(0.010)), 3840).values)
    assert order(POSES, least) == pytest.approx(-2.0, abs=0.02)
    assert order(POSES, highest) == pytest.approx(-1.0, abs=0.2)


@pytest.mark.parametrize("share", [0.03, 1.0])
def test_extremes_of_the_transmission_error_over_the_poses(rv40e, rated_torque, share):
    case = LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), share * rated_torque)
    rotation = StageEquilibrium().at(case, mesh_cycle(rv40e.trochoid, 1920)).rotation
    highest, least = missed(rotation)
    assert order(POSES, least) == pytest.approx(-2.0, abs=0.02)
    assert order(POSES, highest) == pytest.approx(-1.0, abs=0.2)


@dataclass(frozen=True)
class Wave:
    """A removal by formula, amount·e^{cos(k ψ + 1)}/e with k = 1/every: smooth, and no polynomial."""

    amount: float
    every: int
    corners = ()
    point_spacing = None

    @property
    def whole_disc(self) -> bool:
        return self.every != 1

    def derivatives(self, phase, side, trochoid) -> RemovalDerivatives:
        del side, trochoid
        x, k = phase / self.every + 1.0, 1.0 / self.every
        h = self.amount * np.exp(np.cos(x) - 1.0)
        return RemovalDerivatives(h, -k * np.sin(x) * h, k * k * (np.sin(x) ** 2 - np.cos(x)) * h)


@pytest.mark.parametrize("lobes", [1, 39], ids=["lobe", "disc"])
def test_gaps_of_a_measured_curve_over_its_points(rv40e, lobes):
    # A cubic spline through exact points is of fourth order in its values, and so are the gaps.
    formula = Wave(0.01, lobes)
    ground = modify(rv40e.theoretical_profile, Equidistant(0.006))
    exact = replace(ground, removals=(formula,))
    meshing = mesh(rv40e.trochoid, np.linspace(0.0, 200.0, 7), 2)
    reference = gaps(exact, 3.0, meshing).gap
    counts, errors = np.array([12, 24, 48, 96]), []
    for points in counts:
        phase = np.linspace(0.0, 2.0 * math.pi * lobes, points, endpoint=False)
        removal = formula.derivatives(phase, np.ones_like(phase), rv40e.trochoid).value
        tooth = MeasuredDeviation(NormalDeviation(phase, removal, lobes)).apply(ground)
        errors.append(np.max(np.abs(gaps(tooth, 3.0, meshing).gap - reference)))
    assert order(counts, errors) == pytest.approx(-4.0, abs=0.4)
    # 96 points leave less than a nanometre of 10 µm.
    assert errors[-1] < 1e-6


@pytest.mark.parametrize("lifted", [0.0, 0.3], ids=["smooth", "with corners"])
def test_first_touch_over_the_amount(rv40e, lifted):
    # Levers hardly change on the way: the first-order turn (gap/lever of the nearest pin) errs with its square.
    amounts, errors = np.array([2e-3, 4e-3, 8e-3, 16e-3]), []
    meshing = mesh(rv40e.trochoid, mesh_cycle(rv40e.trochoid, 3))
    for amount in amounts:
        tooth = modify(rv40e.theoretical_profile, Equidistant(amount), DeformationCompensation(lifted * amount))
        found = gaps(tooth, 3.0, meshing)
        useful = found.lever > 0.5 * rv40e.trochoid.longest_lever
        first_order = np.min(np.where(useful, found.gap / np.where(useful, found.lever, 1.0), np.inf), axis=-1)
        touch = first_touch(tooth, 3.0, meshing, 1.0)
        errors.append(np.max(np.abs(touch.rotation - first_order)))
    assert order(amounts, errors) == pytest.approx(2.0, abs=0.1)


def test_frozen_levers_over_the_load(rv40e, rated_torque):
    # Equilibrium keeps normals and levers of first touch; the stage takes them under load. On rigid bearings the twists
    # differ by a share that goes with the load. Palmgren's law does not look at the curvature, whose change on the way
    # has kinks of its own.
    drive = replace(rv40e, support=CentralEccentric(1e13), first_stage=None)
    profile = modify(drive.theoretical_profile, Equidistant(0.006))
    crank = 0.02 + mesh_cycle(drive.trochoid, 6)
    loads, errors = np.array([0.003, 0.01, 0.03, 0.1, 0.3, 1.0]), []
    for load in loads:
        case = LoadCase(drive, profile, load * rated_torque, law=Palmgren())
        exact, frozen = StageEquilibrium(tolerance=1e-6).at(case, crank), Equilibrium().at(case, crank)
        assert exact.converged
        errors.append(np.max(np.abs((exact.rotation - frozen.rotation) / frozen.twist)))
    assert order(loads, errors) == pytest.approx(1.0, abs=0.25)
    assert errors[-1] < 1e-3


def test_removal_by_formula_is_its_own_derivative(rv40e):
    # The reference of this module: derivatives against central differences, errors of second order.
    assert isinstance(replace(rv40e.theoretical_profile, removals=(Wave(0.01, 1),)), ToothProfile)
    psi, side = np.linspace(0.0, 6.0, 50), np.ones(50)
    for every in (1, 39):
        wave, h = Wave(0.01, every), 1e-4
        less, here, more = (wave.derivatives(psi + s, side, rv40e.trochoid) for s in (-h, 0.0, h))
        np.testing.assert_allclose((more.value - less.value) / (2.0 * h), here.first, rtol=0.0, atol=1e-9)
        np.testing.assert_allclose((more.first - less.first) / (2.0 * h), here.second, rtol=0.0, atol=1e-9)
