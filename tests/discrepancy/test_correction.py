"""Closing the loop: scan, diagnose, correct, grind again with the error still there, scan again."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact.case import LoadCase
from cycloid_profile.discrepancy.correction import Correction, correction
from cycloid_profile.discrepancy.departure import removal_along
from cycloid_profile.discrepancy.diagnosis import diagnose
from cycloid_profile.discrepancy.opposite import opposite
from cycloid_profile.effects.built import as_drawn
from cycloid_profile.effects.effect import Effect
from cycloid_profile.effects.registry import EFFECTS, build, effect
from cycloid_profile.errors import GeometryError, MeasurementError
from cycloid_profile.geometry.drive import CentralEccentric, Drive
from cycloid_profile.geometry.profile import undercut_limit
from cycloid_profile.geometry.trochoid import Trochoid
from cycloid_profile.modification.setup import DeformationCompensation, modify
from cycloid_profile.rig.gap import gap
from cycloid_profile.rig.simulate import Settings, simulate
from cycloid_profile.units import UM
from tests.discrepancy.correcting import (
    CLOSED,
    HIDDEN,
    NOISE,
    drawn,
    every_effect,
    found,
    named,
    of_table,
    reground,
    scan_of,
)


@every_effect
def test_an_error_that_comes_again_grinds_the_drawing(hidden: dict[str, Any]) -> None:
    error = of_table(hidden)
    result = correction(found(drawn(), [named(error)], scan_of(error.apply(drawn()), 3)))
    assert result.residual < 1e-6  # 1 nm: what is of second order
    assert reground(result, [error]) < 1.03 * NOISE
    (outlook,) = result.scans
    assert outlook.rms_after < 1.03 * NOISE < outlook.rms_before
    assert result.rms_expected == pytest.approx(NOISE, rel=0.05)


def closed_loop(hidden: list[Effect], seed: int) -> tuple[float, Correction]:
    """Scan, diagnosis, correction, regrinding and new scan, its gap [µm, rms]."""
    built = build(drawn().case, hidden)
    diagnosis = diagnose(drawn(), [scan_of(built, seed)])
    assert diagnosis.verdict == "effects_found"
    result = correction(diagnosis)
    return reground(result, hidden, seed + 1), result


def test_the_loop_closes_on_a_hidden_pitch_error() -> None:
    error = of_table({"name": "cumulative_pitch_error", "amplitude_um": 2.0, "phase_deg": 100.0})
    left, result = closed_loop([error], 11)
    assert left < CLOSED * NOISE
    assert [one.candidate.name for one in result.named] == ["cumulative_pitch_error"]


@pytest.mark.slow
@every_effect
def test_the_loop_closes_on_every_effect_of_the_flank(hidden: dict[str, Any]) -> None:
    left, result = closed_loop([of_table(hidden)], 21)
    assert left < CLOSED * NOISE
    assert result.scans[0].rms_before > 1.2 * NOISE


@pytest.mark.slow
def test_the_loop_closes_on_two_effects() -> None:
    errors = [of_table(HIDDEN[7]), of_table(HIDDEN[10])]
    assert closed_loop(errors, 31)[0] < CLOSED * NOISE


def test_what_the_spec_already_holds_is_cancelled_too() -> None:
    known, new = of_table(HIDDEN[6]), of_table(HIDDEN[1])
    result = correction(found(known.apply(drawn()), [named(new)]), known=[known])
    assert result.known == (known,)
    assert result.residual < 1e-6
    assert reground(result, [known, new]) < 1.03 * NOISE


def test_a_drawing_with_corners_is_met_again() -> None:
    case = drawn().case
    built = as_drawn(replace(case, profile=modify(case.profile, DeformationCompensation(1.9 * UM))))
    error = of_table(HIDDEN[7])
    result = correction(found(built, [named(error)]))
    again = error.apply(built.with_tooth(0, result.program))
    assert gap(built, simulate(again, "profile_scan", Settings(points=2000)), 0).rms < 1e-3


def test_only_errors_of_this_flank_are_ground_away() -> None:
    pin = effect({"name": "pin_radius_error", "amount_um": 2.0})
    other = effect({"name": "disc_oval", "amplitude_um": 2.0, "disc": 2})
    doubtful = named(of_table(HIDDEN[0]), "pin_radius_error")
    result = correction(found(drawn(), [named(pin), named(other), doubtful]))
    assert result.nothing
    assert result.program is result.drawing
    assert len(result.left) == 3
    assert "pin ring" in result.left[0]
    assert "another disc" in result.left[1]
    assert "pin_radius_error" in result.left[2]


@pytest.mark.parametrize(
    ("values", "options", "told"),
    [
        ({"name": "equidistant_error", "amount_um": 12.0}, {}, "12.00 µm is more than the limit of 10 µm"),
        ({"name": "disc_oval", "amplitude_um": 3.0}, {"limit": 2.0 * UM}, "--limit-um"),
        ({"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 3000.0}, {}, "µm/mm is more than"),
        ({"name": "disc_oval", "amplitude_um": 3.0}, {"wheel_radius": 3.2}, "is below the wheel radius 3.2000 mm"),
        # The edge of deep wear is sharper than a wheel.
        ({"name": "flank_wear", "amount_um": 3.0}, {}, "least concave radius of the corrected tooth"),
    ],
)
def test_limits_refuse_in_one_sentence(values: dict[str, Any], options: dict[str, float], told: str) -> None:
    with pytest.raises(GeometryError, match=r"^[^\n]+$") as refusal:
        correction(found(drawn(), [named(of_table(values))]), **options)
    assert told in str(refusal.value)
    assert refusal.value.exit_code == 2


def test_a_correction_that_undercuts_is_refused() -> None:
    # Thick pins, hardly below the undercut: what makes the tooth thinner needs a program that cuts deeper.
    trochoid = Trochoid(40, 64.0, 1.3)
    radius = undercut_limit(trochoid) - 1.0 * UM
    drive = Drive(trochoid, radius, 11.5, 1, CentralEccentric(4.0e5))
    built = as_drawn(LoadCase(drive, drive.theoretical_profile, 412_000.0))
    error = of_table({"name": "equidistant_error", "amount_um": -3.0})
    with pytest.raises(GeometryError, match=r"corrected tooth: .* set the machine right"):
        correction(found(built, [named(error)]))


def test_a_disc_that_is_not_there() -> None:
    with pytest.raises(MeasurementError, match="not one of the 2 discs"):
        correction(found(drawn(), []), 2)


@given(
    which=st.lists(st.sampled_from(range(len(HIDDEN))), min_size=1, max_size=3, unique=True),
    scale=st.floats(0.1, 2.0),
)
def test_twice_with_opposite_signs_is_nothing(which: list[int], scale: float) -> None:
    built = drawn()
    for i in which:
        one = candidate_of_table(HIDDEN[i], scale)
        built = one.apply(built)
    drawing, tooth = drawn().teeth[0], built.teeth[0]
    turned = opposite(drawing, tooth)
    along = (np.arange(39 * 61) + 0.5) * 2.0 * math.pi / 61
    size = np.max(np.abs(removal_along(drawing, tooth, along)))
    there_and_back = removal_along(drawing, turned, along) + removal_along(drawing, tooth, along)
    # Second order: the square of the size over the least radius of the pin's path, 0.07 mm at the root.
    assert np.max(np.abs(there_and_back)) <= size**2 / 0.07 + 1e-12
    assert np.allclose(removal_along(tooth, opposite(drawing, turned), along), 0.0, atol=1e-12)


def candidate_of_table(values: dict[str, Any], scale: float) -> Effect:
    """The effect with its size scaled."""
    one = named(of_table(values))
    scaled = one.candidate.effect(scale * one.coordinates)
    assert scaled is not None
    return scaled


def test_every_effect_of_the_flank_is_tried() -> None:
    assert {t["name"] for t in HIDDEN} == {name for name, kind in EFFECTS.items() if kind.place.name == "FLANK"}
