"""What changed between two measurements of one specimen, where nature does not follow the model of the diagnosis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cycloid_profile as cp
from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import (
    Comparison,
    Diagnosis,
    NamedEffect,
    compare_diagnoses,
    comparison_to_json,
    diagnose,
)
from cycloid_profile.diagnosis.change.comparison import pairs_of
from cycloid_profile.diagnosis.model.candidate import Candidate, candidates
from cycloid_profile.diagnosis.model.exact_model import ExactModel
from cycloid_profile.diagnosis.model.flank_grid import FlankGrid
from cycloid_profile.diagnosis.model.residuals import Residuals
from cycloid_profile.diagnosis.verdict import workflow
from cycloid_profile.effects import (
    AsBuiltReducer,
    CoulombFriction,
    CrankBearingClearance,
    CumulativePitchError,
    Effect,
    ElastoslideFriction,
    EquidistantError,
    NonlinearSeriesCompliance,
    SeriesCompliance,
    ToothFormError,
    ViscoelasticCreep,
    loop_branches,
)
from cycloid_profile.measurement import Measurement, read_measurement
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.spec_texts import PRINTED, RV40E, UNCOMPENSATED

REAL = Path(__file__).parent / "real_printed_13to1"
ACTUATOR = PRINTED + UNCOMPENSATED
# What both times have: a softening compliance of an exponent that the library lacks, and creep.
PRINTED_PARTS = (NonlinearSeriesCompliance(twist_arcmin=150.0, exponent=0.5), ViscoelasticCreep(twist_arcmin=15.0))


def measured(text: str, effects: Sequence[Effect], kind: str = "hysteresis", **settings: Any) -> Measurement:
    reducer = as_built_reducer(parse_spec(text))
    for one in effects:
        reducer = one.apply(reducer)
    return simulate(reducer, kind, Settings(**settings))


def diagnosed(reducer: AsBuiltReducer, file: Measurement, effects: Sequence[Effect]) -> Diagnosis:
    """A diagnosis that names some ``effects`` with their sizes, and misses all others."""
    read = workflow._read(reducer, [file], None, ())
    grid = FlankGrid(reducer)
    model = ExactModel(reducer, read.recordings, grid, [Residuals(r, reducer, grid) for r in read.recordings])
    library = candidates(reducer, read.scanned, read.curves)
    found = workflow._agreement(workflow._detect_all_rows(model, library), read, {})
    return replace(found, effects=tuple(as_named(one, library) for one in effects))


def as_named(effect: Effect, library: Sequence[Candidate]) -> NamedEffect:
    """The effect as a diagnosis names it, with the nearest shape that the library has."""
    of_kind = [one for one in library if one.kind is type(effect)]
    shape = getattr(effect, "exponent", 0.0)
    nearest = min(of_kind, key=lambda one: abs(float(one.choice.get("exponent", 0.0)) - shape))
    size = getattr(effect, nearest.size)
    coordinates = np.array([1.0 / size if nearest.inverse else size])
    return NamedEffect(nearest, coordinates, 0.01 * np.outer(coordinates, coordinates), (nearest.name,), None, 10.0)


def compared(
    text: str, before: Measurement, after: Measurement, named: tuple[Sequence[Effect], Sequence[Effect]]
) -> Comparison:
    reducer = as_built_reducer(parse_spec(text))
    return compare_diagnoses(*(diagnosed(reducer, *one) for one in zip((before, after), named, strict=True)))


def figures(comparison: Comparison) -> dict[str, tuple[float, float]]:
    """Change of each figure of the loop, and the same in standard deviations."""
    return {one.name: (one.change, np.sign(one.change) * one.significance) for one in comparison.figures}


@pytest.mark.slow
def test_play_that_rose_is_named_and_nothing_else() -> None:
    # The truth has elastic discs and their contact law; the diagnosis takes the discs for rigid.
    elastic = RV40E.replace('disc_body = "rigid"', 'disc_body = "elastic"')
    assert elastic != RV40E
    parts = [SeriesCompliance(stiffness_nm_per_arcmin=150.0), CoulombFriction(torque_nm=6.0)]
    before, after = (
        measured(elastic, [*parts, CrankBearingClearance(radial_um=play)], noise=0.004, points=250, seed=seed)
        for play, seed in ((3.0, 1), (5.0, 2))
    )
    found = compared(RV40E, before, after, (parts, parts))
    # On a loop alone, play may come from pins, flanks or bearings; what it does to the loop is known.
    (change,) = found.changes
    assert change.candidate.angle is None
    assert figures(found)["lost_motion_arcmin"][1] > 5.0
    assert abs(figures(found)["friction_torque_nm"][1]) < 3.0
    for one in found.unchanged:
        assert one.significance < 3.0


def printed(play: float, friction: float, seed: int) -> Measurement:
    parts = [CrankBearingClearance(radial_um=play), ElastoslideFriction(torque_nm=friction, spread=0.6)]
    return measured(ACTUATOR, [*PRINTED_PARTS, *parts], noise=0.1, seed=seed, points=140)


def compared_printed(before: tuple[float, float], after: tuple[float, float]) -> Comparison:
    """Play and friction of a printed drive before and after. Its diagnoses name friction and softening only."""
    files = [printed(*one, seed) for seed, one in enumerate((before, after), start=1)]
    named = [(PRINTED_PARTS[0], CoulombFriction(torque_nm=friction)) for _, friction in (before, after)]
    return compared(ACTUATOR, *files, (named[0], named[1]))


@pytest.fixture(scope="module")
def preload() -> Comparison:
    """More preload: half the play, more friction of another form than Coulomb's, the same compliance."""
    return compared_printed((120.0, 2.5), (60.0, 4.0))


@pytest.mark.slow
def test_preload_takes_play_and_adds_friction(preload: Comparison) -> None:
    change = figures(preload)
    assert change["lost_motion_arcmin"][1] < -5.0
    assert change["friction_torque_nm"][1] > 5.0
    assert abs(change["friction_torque_nm"][0] - 1.5) < 0.25


@pytest.mark.slow
def test_preload_leaves_the_compliance(preload: Comparison) -> None:
    assert abs(figures(preload)["compliance_arcmin_per_nm"][1]) < 3.0
    (friction,) = [one for one in preload.changes if "friction" in one.candidate.name]
    assert friction.parameters[0].change > 0.0
    assert all(one.significance < 3.0 for one in preload.unchanged)


@pytest.mark.slow
def test_run_in_takes_friction_and_adds_play() -> None:
    change = figures(compared_printed((60.0, 4.0), (90.0, 3.0)))
    assert change["lost_motion_arcmin"][1] > 5.0
    assert change["friction_torque_nm"][1] < -5.0
    assert abs(change["friction_torque_nm"][0] + 1.0) < 0.2


@pytest.mark.slow
def test_a_repeat_has_no_change() -> None:
    found = compared_printed((120.0, 2.5), (120.0, 2.5))
    assert found.changes == ()
    assert all(abs(value) < 3.0 for _, value in figures(found).values())


@pytest.mark.slow
def test_less_hysteresis_of_a_real_loop_is_less_friction() -> None:
    """A measured loop, and the same with branches 30 % closer to their middle: friction falls, and creep may."""
    before = read_measurement(REAL / "stiff_initial.csv")
    torque, angle = before["torque_nm"], before["angle_arcmin"]
    branch = loop_branches(torque)
    rising, falling = (
        np.interp(torque, *(values[branch == sign][np.argsort(torque[branch == sign])] for values in (torque, angle)))
        for sign in (1.0, -1.0)
    )
    narrower = angle - 0.3 * branch * 0.5 * (rising - falling)
    narrower += np.random.default_rng(1).normal(0.0, 0.05, angle.size)
    after = replace(before, columns={**before.columns, "angle_arcmin": narrower})
    named = (NonlinearSeriesCompliance(twist_arcmin=190.0, exponent=0.4), CoulombFriction(torque_nm=3.0))
    found = compared((REAL / "spec.toml").read_text(encoding="utf-8"), before, after, (named, named))
    names = {one.candidate.name for one in found.changes}
    assert "coulomb_friction" in names
    assert names <= {"coulomb_friction", "viscoelastic_creep"}
    assert all(one.parameters[0].change < 0.0 for one in found.changes)
    assert abs(figures(found)["lost_motion_arcmin"][1]) < 3.0
    unexplained, without, with_change = found.files[0].rms
    # Nine tenths of what the change adds to the error that this model of a printed drive has before it.
    assert with_change**2 - unexplained**2 < 0.1 * (without**2 - unexplained**2)


@pytest.fixture(scope="module")
def reground() -> Comparison:
    """Scans of one disc with a pitch error, before and after 3 µm were ground off."""
    pitch = CumulativePitchError(disc=1, amplitude_um=2.0, phase_deg=40.0)
    before, after = (
        measured(
            RV40E, [pitch, EquidistantError(disc=1, amount_um=amount)], "profile_scan", noise=0.3, points=900, seed=s
        )
        for amount, s in ((1.0, 1), (4.0, 2))
    )
    reducer = as_built_reducer(parse_spec(RV40E))
    return compare_diagnoses(diagnose(reducer, [before]), diagnose(reducer, [after]))


@pytest.mark.slow
def test_regrinding_changes_one_amount(reground: Comparison) -> None:
    (change,) = reground.changes
    assert change.candidate.name == "equidistant_error"
    (row,) = change.parameters
    assert abs(row.change - 3.0) < 1.96 * row.uncertainty
    (pitch,) = [one for one in reground.unchanged if one.candidate.name == "cumulative_pitch_error"]
    assert pitch.significance < 3.0
    before, without, after = reground.files[0].rms
    assert after == pytest.approx(before, rel=0.1)
    assert without > 5.0 * after


@pytest.mark.slow
def test_a_form_without_a_name_is_no_change() -> None:
    """The library has no steep form of one flank: as large as the change, it cancels in the difference."""
    form = ToothFormError(disc=1, amplitude_um=2.5, waves=3, flank=1)
    files = [
        measured(
            RV40E, [form, EquidistantError(disc=1, amount_um=amount)], "profile_scan", noise=0.3, points=900, seed=seed
        )
        for amount, seed in ((1.0, 1), (4.0, 2))
    ]
    reducer = as_built_reducer(parse_spec(RV40E))
    (change,) = compare_diagnoses(*(diagnose(reducer, [one]) for one in files)).changes
    assert change.candidate.name == "equidistant_error"
    (row,) = change.parameters
    assert abs(row.change - 3.0) < 1.96 * row.uncertainty
    assert row.uncertainty < 0.05


def test_json_holds_every_parameter(reground: Comparison) -> None:
    values = comparison_to_json(reground)
    assert set(values) == {"verdict_before", "files", "changes", "unchanged", "figures", "notes"}
    (row,) = values["changes"]
    assert row["change"] == pytest.approx(row["after"] - row["before"], abs=1e-4)
    assert {one["parameter"] for one in values["unchanged"]} >= {"amplitude_um", "phase_deg"}
    assert values["figures"] == []  # a scan shows no loop


def test_files_measured_in_the_same_way_are_pairs() -> None:
    reducer = as_built_reducer(parse_spec(RV40E))
    loops = [measured(RV40E, [], points=60, output_angle=angle) for angle in (0.0, 0.5)]
    recordings = workflow._read(reducer, loops, None, ()).recordings
    pairs = pairs_of(recordings, recordings[::-1])
    assert pairs == ((0, 1), (1, 0))
    assert pairs_of(recordings[:1], recordings[1:]) == ()


def test_picture_shows_both_times_and_what_is_left(reground: Comparison) -> None:
    axes = cp.plot.changes(reground)
    assert len(axes) == 3
    left = [np.sqrt(np.mean(line.get_ydata() ** 2)) for line in axes[1].get_lines()]
    fitted = [np.sqrt(np.mean(line.get_ydata() ** 2)) for line in axes[2].get_lines()]
    assert left[1] > 3.0 * fitted[1]
