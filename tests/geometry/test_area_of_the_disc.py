"""Area of the disc against closed forms: Steiner's theorem on the parallel curve, and first order in a removal."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scipy.special import ellipe

from cycloid_profile.geometry import (
    DiscOutline,
    RemovalDerivatives,
    ToothProfile,
    Trochoid,
    circular_contour,
    ring_of_holes,
    undercut_limit,
)
from cycloid_profile.modification import DeformationCompensation, FlankRemoval, modify


@dataclass(frozen=True)
class OneFlank(FlankRemoval):
    """A flank removal on the flank ``only`` (±1)."""

    only: float = 1.0
    whole_disc: ClassVar[bool] = False

    def derivatives(self, phase, side, trochoid):
        jet = super().derivatives(phase, side, trochoid)
        return RemovalDerivatives(*(np.where(side == self.only, each, 0.0) for each in jet))


class OneFlankTurnByTurn(OneFlank):
    """The same, said to differ from lobe to lobe."""

    whole_disc: ClassVar[bool] = True


@pytest.mark.parametrize(("pins", "K1", "share"), [(3, 0.3, 0.5), (13, 0.95, 0.9), (40, 0.8125, 0.65), (60, 0.1, 0.2)])
def test_area_is_that_of_steiner(pins, K1, share):
    trochoid = Trochoid(pins, 50.0, K1 * 50.0 / pins)
    r = share * min(undercut_limit(trochoid), 25.0)
    # The pin centre's path encloses π(r_p² + z_p a²); its length is a complete elliptic integral.
    around = math.pi * (50.0**2 + pins * trochoid.eccentricity**2)
    length = 4.0 * 50.0 * (1.0 + K1) * float(ellipe(4.0 * K1 / (1.0 + K1) ** 2))
    expected = around - r * length + math.pi * r**2
    assert DiscOutline(ToothProfile(trochoid, r)).area == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("kind", [OneFlank, OneFlankTurnByTurn])
@pytest.mark.parametrize("only", [1.0, -1.0])
def test_a_removal_takes_its_integral_over_one_flank(theoretical, kind, only):
    amount = 1e-4
    ground = ToothProfile(theoretical.trochoid, theoretical.pin_radius, (kind(amount, only),))
    psi = np.linspace(0.0, math.pi, 20_001)
    taken = 39 * np.trapezoid(
        amount * theoretical.trochoid.lever_function(psi) * np.abs(theoretical.at(psi).first), psi
    )
    change = DiscOutline(theoretical).area - DiscOutline(ground).area
    assert change == pytest.approx(float(taken), rel=1e-4)  # second order: half the curvature times the amount


def test_compensation_adds_the_same_on_both_flanks(theoretical):
    one = ToothProfile(theoretical.trochoid, theoretical.pin_radius, (OneFlank(-1e-4),))
    both = DiscOutline(modify(theoretical, DeformationCompensation(1e-4))).area - DiscOutline(theoretical).area
    assert both == pytest.approx(2.0 * (DiscOutline(one).area - DiscOutline(theoretical).area), rel=1e-9)


def test_openings_take_their_own_area(theoretical):
    holes = (circular_contour("bore", 0j, 10.0), *ring_of_holes("crank hole", 3, 36.0, 8.0))
    taken = DiscOutline(theoretical).area - DiscOutline(theoretical, holes).area
    assert taken == pytest.approx(math.pi * (10.0**2 + 3 * 8.0**2), rel=1e-12)
