"""Shear and bending of the pins against numerical integration of section and beam."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase, pin_stress
from cycloid_profile.contact.stage import StageEquilibrium
from cycloid_profile.errors import LoadError
from cycloid_profile.modification import Equidistant, modify

lengths = st.floats(0.0, 40.0)


@pytest.fixture(scope="module")
def sharing(rv40e, rated_torque):
    return StageEquilibrium(6).solve(
        LoadCase(rv40e, modify(rv40e.theoretical_profile, Equidistant(0.006)), rated_torque)
    )


def largest_moment(load, x, supports):
    """Largest moment of a beam under ``load`` [N/mm] at ``x``, on two simple supports or held at x = 0 [N·mm]."""
    total, first = np.trapezoid(load, x), np.trapezoid(load * x, x)
    if supports == 1:
        return first
    left = total - first / x[-1]
    shear = left - np.concatenate([[0.0], np.cumsum(0.5 * (load[1:] + load[:-1]) * np.diff(x))])
    moment = np.concatenate([[0.0], np.cumsum(0.5 * (shear[1:] + shear[:-1]) * np.diff(x))])
    return float(np.max(moment))


def test_shear_is_that_of_a_round_section(sharing):
    # τ = V Q/(I t) on the neutral axis, with the first moment Q of half the section.
    y = np.linspace(0.0, 3.0, 200_001)
    chord = 2.0 * np.sqrt(9.0 - y**2)
    Q, inertia = np.trapezoid(y * chord, y), 2.0 * np.trapezoid(y**2 * chord, y)
    found = pin_stress(sharing)
    assert found.shear == pytest.approx(found.force * Q / (inertia * 6.0), rel=1e-6)
    assert found.equivalent_shear == pytest.approx(math.sqrt(3.0) * found.shear)
    # Two opposite discs never load one pin.
    assert found.force == pytest.approx(sharing.max_force)


def test_a_pin_in_a_whole_groove_does_not_bend(sharing):
    assert pin_stress(sharing).bending == 0.0


@settings(max_examples=40)
@given(lengths)
def test_span_bends_as_a_beam_on_two_supports(sharing, span):
    width = 11.5
    x = np.linspace(0.0, span, 20_001)
    loaded = np.abs(x - 0.5 * span) <= 0.5 * width
    found = pin_stress(sharing, span=span)
    moment = largest_moment(np.where(loaded, found.force / width, 0.0), x, 2) if span > 0.01 else 0.0
    section = math.pi * 3.0**3 / 4.0
    assert found.bending == pytest.approx(moment / section, rel=2e-3, abs=0.01)


@settings(max_examples=40)
@given(lengths)
def test_overhang_bends_as_a_beam_held_at_one_end(sharing, overhang):
    width = 11.5
    x = np.linspace(0.0, overhang, 20_001)
    found = pin_stress(sharing, overhang=overhang)
    # The disc lies at the free end, the worst place.
    moment = largest_moment(np.where(x >= overhang - width, found.force / width, 0.0), x, 1)
    assert found.bending == pytest.approx(moment / (math.pi * 3.0**3 / 4.0), rel=2e-3, abs=0.01)


@given(lengths, lengths)
def test_longer_free_lengths_bend_more(sharing, span, overhang):
    here = pin_stress(sharing, span, overhang).bending
    assert pin_stress(sharing, span + 1.0, overhang + 1.0).bending > here
    assert here == max(pin_stress(sharing, span).bending, pin_stress(sharing, 0.0, overhang).bending)


def test_loads_of_three_discs_on_one_pin_add_up(rv40e, rated_torque):
    three = replace(rv40e, discs=3)
    # Without clearance the flank carries from root to tip, so that discs 120° apart meet on some pins.
    found = StageEquilibrium(6).solve(LoadCase(three, three.theoretical_profile, rated_torque))
    assert pin_stress(found).force == pytest.approx(float(np.max(found.force.sum(axis=1))))
    assert pin_stress(found).force > found.max_force


@pytest.mark.parametrize("change", [{"span": -1.0}, {"overhang": math.inf}])
def test_impossible_lengths_are_refused(sharing, change):
    with pytest.raises(LoadError) as caught:
        pin_stress(sharing, **change)
    assert caught.value.what == next(iter(change))
