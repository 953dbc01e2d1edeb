"""Closed loop: scan, diagnose, correct, regrind with the same machine error, scan again."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase
from cycloid_profile.correction import Correction, correction
from cycloid_profile.correction._deviation import removal_along
from cycloid_profile.correction._profile import correction_profile
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.effects import EFFECTS, Effect, apply_effects, as_drawn, effect_from_table
from cycloid_profile.errors import GeometryError, MeasurementError
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid, undercut_limit
from cycloid_profile.modification import DeformationCompensation, modify
from cycloid_profile.rig import Settings, measurement_residual, simulate
from cycloid_profile.units import UM
from tests.diagnosis.correcting import (
    CLOSED,
    HIDDEN,
    NOISE,
    drawn,
    every_effect,
    every_proposed_effect,
    found,
    named,
    of_table,
    reground,
    scan_of,
)


@every_effect
def test_a_recurring_error_grinds_the_drawing(hidden: dict[str, Any]) -> None:
    error = of_table(hidden)
    result = correction(found(drawn(), [named(error)], scan_of(error.apply(drawn()), 3)))
    assert result.residual < 1e-6  # 1 nm: second-order error
    assert reground(result, [error]) < 1.03 * NOISE
    (outlook,) = result.scans
    assert outlook.rms_after < 1.03 * NOISE < outlook.rms_before
    assert result.rms_expected == pytest.approx(NOISE, rel=0.05)


SHAPED = (
    {"name": "equidistant_error", "amount_um": 3.0, "flank": 2},
    {"name": "wheel_wear_drift", "amount_um": 2.0, "first_lobe": 5, "start_in_lobe": 0.4, "blend_rad": 0.3},
    {"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 120.0, "constant_speed": "c_axis"},
    {"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 120.0, "constant_speed": "surface"},
    {"name": "flank_wear", "amount_um": 2.0, "by": "lever", "exponent": 1.5},
    {"name": "flank_wear", "amount_um": 2.0, "exponent": 2.0, "load_share": 0.5},
)


@pytest.mark.parametrize("hidden", SHAPED, ids=lambda table: f"{table['name']}, {list(table.values())[-1]}")
def test_an_error_of_any_shape_is_ground_away(hidden: dict[str, Any]) -> None:
    error = of_table(hidden)
    result = correction(found(drawn(), [named(error)], scan_of(error.apply(drawn()), 3)))
    assert result.residual < 1e-6
    assert reground(result, [error]) < 1.03 * NOISE


def closed_loop(hidden: list[Effect], seed: int) -> tuple[float, Correction]:
    """Scan, diagnose, correct, regrind and scan again; residual [µm, rms] and correction."""
    reducer = apply_effects(drawn().case, hidden)
    diagnosis = diagnose(drawn(), [scan_of(reducer, seed)])
    assert diagnosis.verdict == "effects_found"
    result = correction(diagnosis)
    return reground(result, hidden, seed + 1), result


def test_the_loop_closes_on_a_hidden_pitch_error() -> None:
    error = of_table({"name": "cumulative_pitch_error", "amplitude_um": 2.0, "phase_deg": 100.0})
    residual, result = closed_loop([error], 11)
    assert residual < CLOSED * NOISE
    assert [one.candidate.name for one in result.named] == ["cumulative_pitch_error"]


@pytest.mark.slow
@every_proposed_effect
def test_the_loop_closes_on_every_effect_of_the_flank(hidden: dict[str, Any]) -> None:
    residual, result = closed_loop([of_table(hidden)], 21)
    assert residual < CLOSED * NOISE
    assert result.scans[0].rms_before > 1.2 * NOISE


@pytest.mark.slow
def test_the_loop_closes_on_two_effects() -> None:
    errors = [of_table(HIDDEN[7]), of_table(HIDDEN[10])]
    assert closed_loop(errors, 31)[0] < CLOSED * NOISE


def test_effects_of_the_spec_are_cancelled() -> None:
    known, new = of_table(HIDDEN[6]), of_table(HIDDEN[1])
    result = correction(found(known.apply(drawn()), [named(new)]), known=[known])
    assert result.known == (known,)
    assert result.residual < 1e-6
    assert reground(result, [known, new]) < 1.03 * NOISE


def test_a_drawing_with_corners_is_reproduced() -> None:
    case = drawn().case
    reducer = as_drawn(replace(case, profile=modify(case.profile, DeformationCompensation(1.9 * UM))))
    error = of_table(HIDDEN[7])
    result = correction(found(reducer, [named(error)]))
    again = error.apply(reducer.with_tooth(0, result.program))
    assert measurement_residual(reducer, simulate(again, "profile_scan", Settings(points=2000)), 0).rms < 1e-3


def test_only_errors_of_this_flank_are_ground_away() -> None:
    pin = effect_from_table({"name": "pin_radius_error", "amount_um": 2.0})
    other = effect_from_table({"name": "disc_oval", "amplitude_um": 2.0, "disc": 2})
    doubtful = named(of_table(HIDDEN[0]), "pin_radius_error")
    result = correction(found(drawn(), [named(pin), named(other), doubtful]))
    assert result.is_unchanged
    assert result.program is result.drawing
    assert len(result.not_ground_away) == 3
    assert "pin ring" in result.not_ground_away[0]
    assert "another disc" in result.not_ground_away[1]
    assert "pin_radius_error" in result.not_ground_away[2]


@pytest.mark.parametrize(
    ("values", "options", "reported"),
    [
        ({"name": "equidistant_error", "amount_um": 12.0}, {}, "12.00 µm is more than the limit of 10 µm"),
        ({"name": "disc_oval", "amplitude_um": 3.0}, {"limit": 2.0 * UM}, "--limit-um"),
        ({"name": "grinding_chatter", "amplitude_um": 0.5, "waves_per_turn": 3000.0}, {}, "µm/mm is more than"),
        ({"name": "disc_oval", "amplitude_um": 3.0}, {"wheel_radius": 3.2}, "is below the wheel radius 3.2000 mm"),
        # The edge of deep wear has a smaller radius than the wheel.
        ({"name": "flank_wear", "amount_um": 3.0}, {}, "least concave radius of the corrected tooth"),
    ],
)
def test_limits_refuse_in_one_sentence(values: dict[str, Any], options: dict[str, float], reported: str) -> None:
    with pytest.raises(GeometryError, match=r"^[^\n]+$") as refusal:
        correction(found(drawn(), [named(of_table(values))]), **options)
    assert reported in str(refusal.value)
    assert refusal.value.exit_code == 2


def test_a_correction_that_undercuts_is_refused() -> None:
    # Thick pins close to undercut: the correction of a thin tooth needs a deeper program.
    trochoid = Trochoid(40, 64.0, 1.3)
    radius = undercut_limit(trochoid) - 1.0 * UM
    drive = Drive(trochoid, radius, 11.5, 1, CentralEccentric(4.0e5))
    reducer = as_drawn(LoadCase(drive, drive.theoretical_profile, 412_000.0))
    error = of_table({"name": "equidistant_error", "amount_um": -3.0})
    with pytest.raises(GeometryError, match=r"corrected tooth: .* correct the machine"):
        correction(found(reducer, [named(error)]))


def test_an_unknown_disc_is_refused() -> None:
    with pytest.raises(MeasurementError, match="not one of the 2 discs"):
        correction(found(drawn(), []), 2)


@given(
    which=st.lists(st.sampled_from(range(len(HIDDEN))), min_size=1, max_size=3, unique=True),
    scale=st.floats(0.1, 2.0),
)
def test_double_negation_gives_the_drawing(which: list[int], scale: float) -> None:
    reducer = drawn()
    for i in which:
        one = candidate_of_table(HIDDEN[i], scale)
        reducer = one.apply(reducer)
    drawing, tooth = drawn().teeth[0], reducer.teeth[0]
    turned = correction_profile(drawing, tooth)
    along = (np.arange(39 * 61) + 0.5) * 2.0 * math.pi / 61
    size = np.max(np.abs(removal_along(drawing, tooth, along)))
    there_and_back = removal_along(drawing, turned, along) + removal_along(drawing, tooth, along)
    # Second order: size² over the smallest radius of the pin path, 0.07 mm at the root.
    assert np.max(np.abs(there_and_back)) <= size**2 / 0.07 + 1e-12
    assert np.allclose(removal_along(tooth, correction_profile(drawing, turned), along), 0.0, atol=1e-12)


def candidate_of_table(values: dict[str, Any], scale: float) -> Effect:
    """The effect with its size multiplied by a factor."""
    one = named(of_table(values))
    scaled = one.candidate.effect(scale * one.coordinates)
    assert scaled is not None
    return scaled


def test_every_effect_of_the_flank_is_tried() -> None:
    assert {t["name"] for t in HIDDEN} == {name for name, kind in EFFECTS.items() if kind.location.name == "FLANK"}
