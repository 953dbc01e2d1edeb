"""Physics properties of the removals of whole discs and of every tooth: derivatives, smoothness and period."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from cycloid_profile.effects._removals import (
    ArcLength,
    OneLobe,
    PitchDeviationWave,
    PolarAngle,
    Ramp,
    Shift,
    ToothForm,
    Wave,
)
from cycloid_profile.effects.patterns import removal_between
from cycloid_profile.geometry import ToothProfile, Trochoid
from cycloid_profile.modification import DeformationCompensation, Equidistant, RadialMoving, modify

TROCHOID = Trochoid(40, 64.0, 1.3)
PERIOD = TROCHOID.phase_period
STEP = 1e-3
JUMP, FLANK_END = 0.5, 0.15

angles = st.floats(-7.0, 7.0)
phases = st.floats(-2.0 * PERIOD, 2.0 * PERIOD)
removals = st.one_of(
    st.builds(Wave, st.just(1.0), st.integers(0, 400).map(float), angles),
    st.builds(Wave, st.just(1.0), st.floats(3.0, 400.0), angles),
    st.builds(Shift, st.just(1.0), angles),
    st.builds(PitchDeviationWave, st.just(1.0), st.integers(0, 20).map(float), angles),
    st.builds(Wave, st.just(1.0), st.integers(1, 20).map(float), angles, st.none(), st.just(PolarAngle(3.0))),
    st.builds(Wave, st.just(1.0), st.integers(1, 20).map(float), angles, st.none(), st.just(ArcLength(3.0))),
    st.builds(Ramp, st.just(1.0), st.floats(0.0, PERIOD)),
    st.builds(OneLobe, st.just(1.0), st.integers(0, 38)),
    st.builds(ToothForm, st.just(1.0), st.integers(1, 20), angles, st.sampled_from([-1, 0, 1])),
)


def jet(removal, phase):
    psi = np.atleast_1d(np.asarray(phase, dtype=np.float64))
    return removal.derivatives(psi, np.ones_like(psi), TROCHOID)


def slope(values):
    """First derivative from five neighbours a step apart, to fourth order."""
    return (values[0] - 8.0 * values[1] + 8.0 * values[3] - values[4]) / (12.0 * STEP)


@pytest.mark.parametrize("flank", [1, -1])
@pytest.mark.parametrize(
    "phase", [0.04, 0.1, 0.21, 0.29, math.pi - 0.29, math.pi - 0.21, math.pi - 0.1, math.pi - 0.04]
)
def test_a_form_of_one_flank_ends_smoothly_at_root_and_tip(flank, phase):
    form = ToothForm(1.0, 3, 0.4, flank)
    found = jet(form, flank * phase + STEP * np.arange(-2, 3))
    # The ends are 0.3 rad long: the fourth order of the step leaves 1e-6 of their sixth derivative.
    assert found.first[2] == pytest.approx(slope(found.value), rel=1e-4, abs=1e-4)
    assert found.second[2] == pytest.approx(slope(found.first), rel=1e-4, abs=1e-3)
    assert not np.any(jet(form, -flank * phase))


@given(removals, phases)
def test_derivatives_are_those_of_the_value(removal, phase):
    if isinstance(removal, Wave) and removal.waves % 1.0:
        # Waves that do not come out even meet at the tip before the first lobe.
        phase = np.clip(np.mod(phase + math.pi, PERIOD), 0.01, PERIOD - 0.01) - math.pi
    found = jet(removal, phase + STEP * np.arange(-2, 3))
    # Jumps have no third derivative: there a step counts once, not to the fourth power.
    jump = JUMP if isinstance(removal, Ramp | OneLobe) else math.inf
    if isinstance(removal, ToothForm):
        ends = np.array([0.0, 2.0 * FLANK_END, math.pi - 2.0 * FLANK_END, math.pi])
        assume(np.min(np.abs(np.mod(phase, math.pi) - ends)) > 3.0 * STEP)
    assert found.first[2] == pytest.approx(slope(found.value), abs=2e-6 + 50.0 * STEP**2 / jump**3)
    assert found.second[2] == pytest.approx(slope(found.first), abs=2e-5 + 400.0 * STEP / jump**4)


@given(removals, phases)
def test_a_turn_of_the_disc_later_it_is_the_same(removal, phase):
    if isinstance(removal, Wave) and removal.waves % 1.0:
        phase = np.clip(np.mod(phase + math.pi, PERIOD), 0.01, PERIOD - 0.01) - math.pi
    here, later = jet(removal, phase), jet(removal, phase + PERIOD)
    for one, other in zip(here, later, strict=True):
        np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-9)


@given(removals, st.floats(0.1, 50.0), phases)
def test_removal_goes_with_its_size(removal, factor, phase):
    sized = type(removal)(factor, *[getattr(removal, name) for name in removal.__slots__[1:]])
    for one, other in zip(jet(removal, phase), jet(sized, phase), strict=True):
        np.testing.assert_allclose(other, factor * one, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("lobe", [0, 1, 20, 38])
@pytest.mark.parametrize("kind", [Ramp, OneLobe])
def test_ramp_and_lobe_have_two_continuous_derivatives(kind, lobe):
    # All round in steps of 1e-3 rad: no more change than the next derivative of the smooth step allows, which rises
    # over ±JUMP by at most 15/16, 1.45 and 7.5 per JUMP, JUMP² and JUMP³.
    step = 1e-3
    psi = np.arange(0.0, PERIOD, step)
    found = jet(kind(1.0, lobe), psi)
    assert np.max(np.abs(np.diff(found.value, append=found.value[0]))) < step * 1.0 / JUMP
    assert np.max(np.abs(np.diff(found.first, append=found.first[0]))) < step * 1.5 / JUMP**2
    assert np.max(np.abs(np.diff(found.second, append=found.second[0]))) < step * 7.6 / JUMP**3


@pytest.mark.parametrize("first", [0, 5, 38])
def test_a_ramp_falls_from_lobe_to_lobe_and_jumps_once(first):
    roots = 2.0 * math.pi * (first + np.arange(39))
    at_roots = jet(Ramp(1.0, (2.0 * first - 1.0) * math.pi), roots).value
    # Half a lobe of 39 has gone by at the root of the first lobe, and half a lobe is left at the last.
    np.testing.assert_allclose(at_roots, -(np.arange(39) + 0.5) / 39.0, atol=1e-12)


@pytest.mark.parametrize("lobe", [0, 17, 38])
def test_one_lobe_is_one_lobe(lobe):
    inside = 2.0 * math.pi * lobe + np.linspace(-math.pi + JUMP, math.pi - JUMP, 101)
    np.testing.assert_allclose(jet(OneLobe(1.0, lobe), inside).value, 1.0, atol=1e-12)
    outside = 2.0 * math.pi * lobe + np.linspace(math.pi + JUMP, PERIOD - math.pi - JUMP, 5001)[:-1]
    for values in jet(OneLobe(1.0, lobe), outside):
        np.testing.assert_allclose(values, 0.0, atol=1e-12)


@given(st.floats(3.0, 400.0), angles)
def test_waves_that_do_not_come_out_even_jump_at_a_tip_alone(waves, angle):
    # A removal is one function of the lobe and the phase in it, from −π to π, wherever the phase is counted from.
    removal = Wave(1.0, waves, angle)
    within = np.linspace(-3.1, 3.1, 41)
    here, later = jet(removal, within), jet(removal, within + PERIOD)
    for one, other in zip(here, later, strict=True):
        np.testing.assert_allclose(other, one, rtol=0.0, atol=1e-6)


@given(st.integers(1, 20), angles, st.sampled_from([-1, 1]))
def test_a_form_of_one_flank_leaves_the_other_as_drawn(waves, angle, flank):
    psi = np.linspace(-math.pi, math.pi, 2001)
    alone, both = (jet(ToothForm(1.0, waves, angle, side), psi) for side in (flank, 0))
    other, inside = flank * psi <= 0.0, (flank * psi > 2.0 * FLANK_END) & (flank * psi < math.pi - 2.0 * FLANK_END)
    for one, whole in zip(alone, both, strict=True):
        np.testing.assert_array_equal(one[other], 0.0)
        np.testing.assert_allclose(one[inside], whole[inside], rtol=1e-12, atol=1e-12)


@given(st.integers(1, 20), angles, st.sampled_from([-1, 1]))
def test_the_ends_of_a_form_have_two_continuous_derivatives(waves, angle, flank):
    # As of ramp and lobe, the smooth step rises over ±FLANK_END; the wave adds its own derivatives.
    step = 1e-4
    found = jet(ToothForm(1.0, waves, angle, flank), np.arange(-math.pi, math.pi, step))
    for k, one in enumerate((found.value, found.first, found.second), start=1):
        assert np.max(np.abs(np.diff(one))) < step * (waves + 2.5 / FLANK_END) ** k


@pytest.mark.parametrize(
    ("modification", "shape"),
    [
        (Equidistant(1e-4), lambda psi, _: np.ones_like(psi)),
        (RadialMoving(1e-4), lambda psi, S: (1.0 - 0.8125 * np.cos(psi)) * S),
        (DeformationCompensation(-1e-4), lambda psi, S: np.abs(np.sin(psi)) * S),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_change_of_the_tooth_is_its_removal_to_first_order(modification, shape):
    # docs/theory.md, Eqs. 13 to 16: a change of the curve itself, of its parallel distance, and a further removal.
    before = ToothProfile(TROCHOID, 3.0, (Wave(2e-3, 39.0, 0.3),))
    psi, lobe = np.array([-2.5, -1.0, -0.5, 0.5, 1.0, 2.5]), np.array([0.0, 3.0, 38.0, 0.0, 3.0, 38.0])
    S = 1.0 / np.sqrt(1.0 + 0.8125**2 - 2.0 * 0.8125 * np.cos(psi))
    found = removal_between(before, modify(before, modification), psi, lobe)
    np.testing.assert_allclose(found, 1e-4 * shape(psi, S), rtol=0.02, atol=1e-7)
