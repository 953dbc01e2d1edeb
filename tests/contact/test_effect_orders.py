"""Physics of periods: at which orders of the output turn an error can appear at all, whatever its shape.

Symmetry alone decides it (docs/conventions.md, "Mesh cycle and orders"). What stands still in the housing comes
back after one turn of the crank, z_c times per output turn; what turns with disc and carrier comes back when the
whole drive has gone on by one pin, z_p times. Two discs half a crank turn apart swap places in between: of an error
both share the odd multiples go, exactly for housing errors; for errors of discs and carrier the swapped drive stands
half a pin pitch off, so that odd multiples survive around the odd multiples of the mesh order z_c z_p only.

A small drive is followed over a whole turn. The number of poses is a multiple of 2 z_c z_p, so that an order beyond
half of it is folded onto an order of the same family.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cycloid_profile.contact import LoadCase
from cycloid_profile.contact.bodies import NO_DEVIATIONS, PartDeviations
from cycloid_profile.contact.mesh import output_turn
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.geometry import Cranks, Drive, InvoluteStage, Trochoid
from cycloid_profile.modification import Equidistant, MeasuredDeviation, NormalDeviation, modify

UM = 1e-3
PINS, LOBES = 12, 11
MESH = PINS * LOBES
# Energy off the rule's orders: solves end at 1e-9 of the torque, so that rounding leaves some 1e-18.
OFF_THE_RULE = 1e-12

# Below 5 µm together, less than the clearance: pins that overlap before any load are another matter.
small = st.floats(-2.0 * UM, 2.0 * UM)
load_shares = st.sampled_from([0.03, 0.3, 1.0, -1.0])


def errors(*shape):
    return arrays(np.float64, shape, elements=small)


class Spectrum(NamedTuple):
    """Energy at each order of the output turn, order 0 left out [rad²]."""

    energy: np.ndarray

    def at(self, chosen) -> float:
        order = np.arange(self.energy.size)
        return float(np.sum(self.energy[chosen(order)]))

    def off(self, base) -> float:
        """Share of the energy at orders that are no multiples of ``base``."""
        return self.at(lambda order: order % base != 0) / float(np.sum(self.energy))

    def odd(self, base) -> float:
        """Energy at odd multiples of ``base`` below half the mesh order, out of reach of what the mesh folds there."""
        return self.at(lambda order: (order % (2 * base) == base) & (order < 0.5 * MESH))


def spectrum(rotation) -> Spectrum:
    energy = np.abs(np.fft.rfft(rotation - np.mean(rotation)) / rotation.size) ** 2
    energy[1:] *= 2.0
    return Spectrum(energy)


@pytest.fixture(scope="module")
def drive() -> Drive:
    return Drive(Trochoid(PINS, 40.0, 2.0), 4.0, 10.0, 2, Cranks(3, 18.0, 2e5), first_stage=InvoluteStage(12, 36, 1.0))


@pytest.fixture(scope="module")
def case(drive) -> LoadCase:
    return LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.006)), 1e5)


@pytest.fixture(scope="module")
def turned(case):
    """Rotation of the carrier over one output turn with parts as built, at a share of the torque [rad]."""

    def over_a_turn(reducer=NO_DEVIATIONS, share=1.0):
        crank = output_turn(case.drive.trochoid, 2 * MESH)
        state = StageEquilibrium(deviations=reducer).at(case, crank, share * case.torque)
        assert state.converged
        return state.rotation

    return over_a_turn


def on_disc(case, removal):
    """The tooth with removals at evenly spaced points once round the disc, the first in a root."""
    removal = np.asarray(removal)
    period = 2.0 * math.pi * case.drive.trochoid.lobes
    phase = np.linspace(0.0, period, removal.size, endpoint=False)
    return MeasuredDeviation(NormalDeviation(phase, removal, case.drive.trochoid.lobes)).apply(case.profile)


def one_crank(value, discs):
    shift = np.zeros((2, 3), dtype=np.complex128)
    shift[:discs, 0] = value
    return shift


def test_equal_parts_show_the_mesh_alone(turned):
    for share in (0.03, 1.0):
        found = spectrum(turned(share=share))
        assert found.off(MESH) < OFF_THE_RULE


@pytest.mark.slow
@given(errors(2, PINS), errors(PINS), load_shares)
def test_housing_errors_show_even_multiples_of_the_lobes(turned, shift, oversize, share):
    # Both discs meet the same pins: 2 z_c, 4 z_c … and not z_c.
    found = spectrum(turned(PartDeviations(pin_shift=shift[0] + 1j * shift[1], pin_oversize=oversize), share))
    assert found.off(2 * LOBES) < OFF_THE_RULE


@pytest.mark.slow
@given(errors(2, PINS), errors(PINS), errors(3 * LOBES), load_shares)
def test_housing_errors_show_the_lobes_where_the_discs_differ(case, turned, shift, oversize, form, share):
    # Another form on disc 2, equal on all its lobes: the discs no longer swap, but the crank's turn still returns.
    phase = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
    other = MeasuredDeviation(NormalDeviation(phase, form[:8], 1)).apply(case.profile)
    reducer = PartDeviations(pin_shift=shift[0] + 1j * shift[1], pin_oversize=oversize, teeth=(case.profile, other))
    assert spectrum(turned(reducer, share)).off(LOBES) < OFF_THE_RULE


def test_a_lone_lobe_order_means_that_the_discs_differ(case, turned):
    phase = np.linspace(0.0, 2.0 * math.pi, 8, endpoint=False)
    other = MeasuredDeviation(NormalDeviation(phase, np.full(8, 3.0 * UM), 1)).apply(case.profile)
    ring = PartDeviations(pin_shift=np.full(PINS, 3.0 * UM + 0j), teeth=(case.profile, other))
    found = spectrum(turned(ring))
    assert found.at(lambda order: order == LOBES) > 0.1 * found.at(lambda order: order < 0.5 * MESH)


@pytest.mark.slow
@given(errors(3 * LOBES), errors(3 * LOBES), load_shares)
@settings(max_examples=15)
def test_disc_errors_show_multiples_of_the_pins(case, turned, one, other, share):
    for teeth in ((on_disc(case, one), case.profile), (on_disc(case, one), on_disc(case, other))):
        assert spectrum(turned(PartDeviations(teeth=teeth), share)).off(PINS) < OFF_THE_RULE


@given(errors(2, 2, 3), errors(2, 2, 3), errors(2, 3), errors(2), load_shares)
def test_carrier_errors_show_multiples_of_the_pins(turned, eccentric, bore, lead, sun, share):
    # Eccentrics, bores and leads of all cranks and the sun at random; a lead of 3 µm on the planet's 18 mm. The sun
    # makes three whole turns on the carrier per pin pitch.
    reducer = PartDeviations(
        eccentric_shift=eccentric[0] + 1j * eccentric[1],
        bore_shift=bore[0] + 1j * bore[1],
        crank_lead=(lead[0] + 1j * lead[1]) / 18.0,
        sun_shift=complex(*sun),
    )
    assert spectrum(turned(reducer, share)).off(PINS) < OFF_THE_RULE


@pytest.mark.slow
@given(st.floats(1.0, 3.0), st.floats(0.0, 6.2), st.floats(-1.0, 1.0), st.floats(0.0, 6.2), load_shares)
@settings(max_examples=15)
def test_discs_equal_on_the_carrier_cancel_odd_multiples(case, turned, once, at, twice, where, share):
    # Disc 2 is mounted half a lobe on: in its own angle t along the curve the same error stands π/z_c earlier.
    def waves(t):
        return once * UM * np.cos(t + at) + twice * UM * np.cos(2.0 * t + where)

    t = np.linspace(0.0, 2.0 * math.pi, 6 * LOBES, endpoint=False)
    first, second = on_disc(case, waves(t)), on_disc(case, waves(t + math.pi / LOBES))
    alone = spectrum(turned(PartDeviations(teeth=(first, case.profile)), share)).odd(PINS)
    both = spectrum(turned(PartDeviations(teeth=(first, second)), share)).odd(PINS)
    # At 3 % of the torque two or three pins carry, and single pins come through: 2 % of the energy.
    assert both < (0.02 if abs(share) < 0.1 else 0.005) * alone


@pytest.mark.slow
@given(small, small, st.sampled_from(["eccentric_shift", "bore_shift"]), load_shares)
def test_a_crank_equal_in_both_discs_cancels_odd_multiples(turned, x, y, part, share):
    error = complex(x, y)
    if abs(error) < 0.5 * UM:
        error = 0.5 * UM
    alone, both = (spectrum(turned(PartDeviations(**{part: one_crank(error, n)}), share)).odd(PINS) for n in (1, 2))
    assert both < 0.01 * alone


@pytest.mark.slow
@given(st.sampled_from([-1.0, 1.0]), st.floats(1.0, 3.0), st.floats(0.0, 6.2), load_shares)
@settings(max_examples=15)
def test_an_error_of_one_disc_shows_the_pins_themselves(case, turned, sign, amount, at, share):
    t = np.linspace(0.0, 2.0 * math.pi, 6 * LOBES, endpoint=False)
    runout = on_disc(case, sign * amount * UM * np.cos(t + at))
    crank = one_crank(amount * UM * np.exp(1j * at), 1)
    nominal = spectrum(turned(share=share)).at(lambda order: order == PINS)
    assert nominal < 1e-24
    for reducer in (PartDeviations(teeth=(runout, case.profile)), PartDeviations(eccentric_shift=crank)):
        found = spectrum(turned(reducer, share))
        below = found.at(lambda order: order < 0.5 * MESH)
        assert found.at(lambda order: order == PINS) > 0.3 * below


@pytest.mark.slow
@given(st.floats(-1e-4, 1e-4), load_shares)
def test_a_tooth_turned_on_both_discs_turns_the_output_and_nothing_else(case, turned, angle, share):
    # h = a z_c β sinψ S, signed. The output follows by β z_c/(z_p + z1/z2), as with the input held each pin's arm is
    # longer by that ratio, the same for all pins. What is left goes with β times clearance/size, some 1e-4 β.
    trochoid = case.drive.trochoid
    phase = np.linspace(0.0, 2.0 * math.pi, 256, endpoint=False)
    removal = trochoid.longest_lever * angle * trochoid.lever_function(phase)
    tooth = MeasuredDeviation(NormalDeviation(phase, removal, 1)).apply(case.profile)
    change = turned(PartDeviations(teeth=(tooth, tooth)), share) - turned(share=share)
    expected = angle * LOBES / (PINS + 12.0 / 36.0)
    assert np.mean(change) == pytest.approx(expected, abs=1e-4 * abs(expected) + 1e-12)
    assert np.ptp(change) < 4e-4 * abs(angle) + 1e-12


class Rv40e(NamedTuple):
    """The RV-40E over a whole output turn, 3120 poses, at 3 % of its torque."""

    case: LoadCase

    def spectrum(self, reducer) -> Spectrum:
        crank = output_turn(self.case.drive.trochoid, 3120)
        state = StageEquilibrium(deviations=reducer).at(self.case, crank, 0.03 * self.case.torque)
        assert state.converged
        return spectrum(state.rotation)


@pytest.fixture(scope="module")
def whole_rv40e(rv40e, rated_torque) -> Rv40e:
    return Rv40e(LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque))


def test_orders_of_random_housing_errors_of_the_rv40e(whole_rv40e):
    rng = np.random.default_rng(40)
    x, y, oversize = rng.uniform(-2.0 * UM, 2.0 * UM, (3, 40))
    found = whole_rv40e.spectrum(PartDeviations(pin_shift=x + 1j * y, pin_oversize=oversize))
    assert found.off(78) < OFF_THE_RULE
    assert found.at(lambda order: order == 78) > 0.1 * np.sum(found.energy)


@pytest.mark.slow
def test_orders_of_a_random_disc_error_of_the_rv40e(whole_rv40e):
    rng = np.random.default_rng(39)
    case = whole_rv40e.case
    disc = on_disc(case, rng.uniform(-2.0 * UM, 2.0 * UM, 6 * 39))
    crank = PartDeviations(teeth=(disc, case.profile), eccentric_shift=one_crank(3.0 * UM, 1))
    found = whole_rv40e.spectrum(crank)
    assert found.off(40) < OFF_THE_RULE
    assert found.at(lambda order: order == 40) > 0.1 * np.sum(found.energy)


@pytest.mark.slow
def test_crank_error_in_both_discs_of_the_rv40e_leaves_order_eighty(whole_rv40e):
    alone, both = (whole_rv40e.spectrum(PartDeviations(eccentric_shift=one_crank(3.0 * UM, n))) for n in (1, 2))
    assert int(np.argmax(alone.energy)) == 40
    assert int(np.argmax(both.energy)) == 80
    # 40 pins are close to a continuum: hardly a thousandth of the lone amplitude is left.
    assert both.at(lambda order: order == 40) < 1e-5 * alone.at(lambda order: order == 40)
