"""Pictures and page of a diagnosis: every kind of file, labels with units, and no more said than is known."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import (
    Detection,
    Diagnosis,
    FileGap,
    Finding,
    NamedEffect,
    NearestEffect,
    Residuals,
    candidate_of,
    diagnosis_to_json,
    nuisance_fitted,
    priors_of,
    record,
)
from cycloid_profile.effects import EFFECTS
from cycloid_profile.measurement import KINDS
from cycloid_profile.plot.diagnosis import pictures
from cycloid_profile.plot.style import style
from cycloid_profile.report.diagnosis import diagnosis_report, headline, odds, p_text, remedy_of, with_uncertainty
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.spec_texts import PLAIN

COORDINATES = {
    "profile_scan": "lobe",
    "hysteresis": "row",
    "transmission_error": "output_angle_deg",
    "lost_motion_map": "output_angle_deg",
}
UNITS = {"profile_scan": "µm", "hysteresis": "′", "transmission_error": "″", "lost_motion_map": "′"}


def _found() -> Diagnosis:
    """One file of each kind of a reducer whose discs are out of index."""
    reducer = as_built_reducer(parse_spec(PLAIN))
    candidate = candidate_of(EFFECTS["cumulative_pitch_error"], {"disc": 1}, priors_of(reducer))
    named = NamedEffect(candidate, np.array([3.0, 1.0]), 1e-4 * np.eye(2), ("cumulative_pitch_error",), None, 36.2)
    corrected = named.effect.apply(reducer)
    rng = np.random.default_rng(1)
    gaps, where = [], []
    for kind, coordinate in COORDINATES.items():
        measured = simulate(corrected, kind, Settings(points={"hysteresis": 80}.get(kind, 330)))
        columns = dict(measured.columns)
        if kind != "profile_scan":
            columns[KINDS[kind].value_column] = columns[KINDS[kind].value_column] + 0.002 * rng.standard_normal(
                columns[KINDS[kind].value_column].size
            )
        else:
            columns["x_mm"] = columns["x_mm"] + 1e-4 * rng.standard_normal(columns["x_mm"].size)
        recording = record(reducer, replace(measured, columns=columns, name=f"{kind}.csv"))
        unit = recording.unit
        gaps.append(
            FileGap(
                recording, Residuals(recording, reducer), Residuals(recording, corrected), 2.0, 0.11, 2.1, 0.12, 1.02
            )
        )
        where.append(Finding(recording.name, unit, coordinate, 2.2, 3.4, 1.7, 1e-50))
    before = Detection(1e-40, 20, tuple(where))
    after = Detection(0.4, 20, (replace(where[0], p_value=0.1),))
    hidden = {
        "disc_oval": (0.4, "amplitude_um"),
        "planet_runout": (math.inf, "amplitude_um"),
        "series_compliance": (1e-4, "stiffness_nm_per_arcmin"),
    }
    return Diagnosis(
        reducer, corrected, "effects_found", (named,), before, after, tuple(where), None, (), hidden,
        tuple(gaps), ("2 reading errors are omitted",), 36.2,
    )  # fmt: skip


@pytest.fixture(scope="module")
def found() -> Diagnosis:
    return _found()


NEAR = NearestEffect("disc_oval", {"amplitude_um": 1.2}, 0.41, "it explains 41 % of the gap")


@pytest.fixture(scope="module")
def agrees(found: Diagnosis) -> Diagnosis:
    gaps = tuple(replace(g, before=g.after, recording=g.after.recording) for g in found.gaps)
    return replace(
        found,
        verdict="agrees",
        effects=(),
        detection=found.residual_detection,
        where=(),
        gaps=gaps,
        corrected=found.reducer,
    )


@pytest.fixture(scope="module")
def unknown(found: Diagnosis) -> Diagnosis:
    gaps = tuple(replace(g, after=g.before) for g in found.gaps)
    return replace(
        found, verdict="unknown_effect", effects=(), remainder=found.where[0], nearest=(NEAR,),
        residual_detection=found.detection, gaps=gaps, corrected=found.reducer,
    )  # fmt: skip


@pytest.fixture(scope="module")
def pages(
    found: Diagnosis, agrees: Diagnosis, unknown: Diagnosis, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, str]:
    """The page of each verdict, with its pictures."""
    written = {}
    for diagnosis in (found, agrees, unknown):
        folder = tmp_path_factory.mktemp(diagnosis.verdict)
        (folder / "plots").mkdir()
        drawn = []
        for stem, caption, figure in pictures(diagnosis, "plain"):
            with style():
                figure.savefig(folder / "plots" / f"{stem}.svg")
            drawn.append((stem, caption))
        spec = "plain_diagnosed.toml" if diagnosis.effects else None
        page = diagnosis_report(diagnosis, "plain", folder, drawn, spec)
        written[diagnosis.verdict] = re.sub(r"</?abbr[^>]*>", "", page)
    return written


def test_every_file_has_a_picture_with_units(found: Diagnosis, agrees: Diagnosis, unknown: Diagnosis) -> None:
    for diagnosis in (found, agrees, unknown):
        drawn = pictures(diagnosis, "plain")
        assert [stem for stem, _, _ in drawn] == ["diagnosis_summary", *(f"gap_{kind}" for kind in COORDINATES)]
        for (_, caption, figure), gap in zip(drawn[1:], diagnosis.gaps, strict=True):
            assert caption.startswith(gap.recording.name)
            labels = [text for ax in figure.axes for text in (ax.get_xlabel(), ax.get_ylabel()) if text]
            assert all("[" in label for label in labels), labels
            assert any(f"[{UNITS[gap.recording.kind.name]}]" in label for label in labels), labels


def test_before_and_after_have_one_scale(found: Diagnosis) -> None:
    figure = next(figure for stem, _, figure in pictures(found, "plain") if stem == "gap_profile_scan")
    maps = [image.get_clim() for ax in figure.axes for image in ax.images]
    assert len(maps) == 2
    assert maps[0] == maps[1]
    assert maps[0][0] == -maps[0][1]
    assert "magnified" in figure.axes[0].get_title()


def test_only_what_the_error_of_the_model_cannot_explain_is_a_further_effect(found: Diagnosis, tmp_path: Path) -> None:
    within = replace(found, remainder=found.where[1])
    beyond = replace(within, residual_detection=found.detection)
    for diagnosis, inside in ((within, True), (beyond, False)):
        page = re.sub(r"</?abbr[^>]*>", "", diagnosis_report(diagnosis, "plain", tmp_path, [], None))
        assert ("within the error of the model: rows 2 to 3" in headline(diagnosis)) is inside
        assert ("further effect" in headline(diagnosis)) is not inside
        assert ("Residual within the error of the model" in page) is inside
        assert ("nexplained" in page) is not inside
        rest = diagnosis_to_json(diagnosis, "plain")["remainder"]
        assert rest["within_model_error"] is inside
        assert (rest["p_value"] is None) is inside


def test_files_of_one_name_have_files_of_their_own(found: Diagnosis) -> None:
    twice = replace(found, gaps=(found.gaps[0], found.gaps[0]))
    assert [stem for stem, _, _ in pictures(twice, "plain")][1:] == ["gap_profile_scan", "gap_profile_scan_2"]


def test_a_file_only_to_check_with_is_drawn(found: Diagnosis) -> None:
    held = [replace(g.recording, held_out=np.ones_like(g.recording.held_out)) for g in found.gaps]
    gaps = tuple(
        FileGap(r, Residuals(r, found.reducer), Residuals(r, found.corrected), math.nan, math.nan, 2.0, 0.1, 1.0)
        for r in held
    )
    assert len(pictures(replace(found, gaps=gaps), "plain")) == 1 + len(gaps)


def test_a_lobe_that_was_not_scanned_is_grey(found: Diagnosis) -> None:
    gap = found.gaps[0]
    rows = gap.recording.rows[gap.before.lobe != 3]
    held = gap.recording.held_out[gap.before.lobe != 3]
    recording = replace(gap.recording, rows=rows, held_out=held)
    less = replace(
        gap,
        recording=recording,
        before=Residuals(recording, found.reducer),
        after=Residuals(recording, found.corrected),
    )
    _, _, figure = pictures(replace(found, gaps=(less,)), "plain")[1]
    (first, _) = (image.get_array() for ax in figure.axes for image in ax.images)
    assert np.all(np.ma.getmaskarray(first)[3])
    assert "no points" in [text.get_text() for text in figure.legends[0].get_texts()]


def test_the_residual_after_is_noise(found: Diagnosis) -> None:
    for gap in found.gaps:
        residual = nuisance_fitted(gap.after)
        assert np.sqrt(np.mean(residual**2)) < 1.5 * gap.noise
        assert np.sqrt(np.mean(nuisance_fitted(gap.before) ** 2)) > 2.0 * np.sqrt(np.mean(residual**2))


@pytest.mark.slow
def test_a_found_effect_is_named_with_size_cure_and_evidence(pages: dict[str, str]) -> None:
    page = pages["effects_found"]
    assert "The simulation lacks cumulative pitch error (disc 1), 3.162 ± 0.010 µm." in page
    assert "correct the index or the encoder mounting of the work spindle" in page
    assert "practically certain" in page
    assert "ln B, evidence for the effect" in page
    assert "plain_diagnosed.toml" in page
    assert "anything below 0.4 µm" in page
    assert "anything stiffer than 10,000 N·m/′" in page
    assert "these files do not show it" in page
    assert "reading errors are omitted" in page
    assert "not in the library of effects" not in page


def test_a_group_is_one_of_these(found: Diagnosis, tmp_path: Path) -> None:
    ambiguous = replace(found.effects[0], group=("radial_moving_error", "thermal_growth"), separate_by="a second scan")
    page = diagnosis_report(replace(found, effects=(ambiguous,)), "plain", tmp_path, [], None)
    assert "one of these, which the files cannot distinguish: radial moving error, thermal growth" in page
    assert "Measurement that separates them: <strong>a second scan</strong>" in page
    assert "If it is thermal growth: let the disc reach the temperature of the ring" in page


@pytest.mark.slow
def test_agreement_and_the_unknown_read_differently(pages: dict[str, str]) -> None:
    assert "Measurement and simulation agree within the noise." in pages["agrees"]
    assert "What to do" not in pages["agrees"]
    unknown = pages["unknown_effect"]
    assert "differ by something that is not in the library of effects: lobe 2 from ψ = " in unknown
    assert "The difference is not in the library of effects and remains unnamed." in unknown
    assert "41 %" in unknown
    assert "odds" not in re.sub(r"<svg.*?</svg>", "", unknown, flags=re.DOTALL)


def test_agreement_by_the_accuracy_of_the_simulation_is_said(agrees: Diagnosis) -> None:
    below = replace(agrees, detection=replace(agrees.detection, p_value=1e-4))
    assert headline(below) == "Measurement and simulation agree within the accuracy of the simulation."


@pytest.mark.slow
def test_the_page_needs_nothing_else(pages: dict[str, str]) -> None:
    for page in pages.values():
        assert not re.findall(r'src="(?!#|data:)', page)
        # Links lead to files next to it only.
        assert not re.findall(r'href="(?!data:)(?:[a-z]+:|/|\.\.)', page)
        assert "<script" not in page
        ids = re.findall(r'\bid="([^"]+)"', page)
        assert len(ids) == len(set(ids))


def test_every_effect_has_a_cure() -> None:
    assert all(remedy_of(kind) for kind in EFFECTS.values())
    assert remedy_of(EFFECTS["thermal_growth"]).endswith("to rule out a wrong infeed")


def test_numbers_say_no_more_than_they_know() -> None:
    assert with_uncertainty(3.25907, 0.0213, "µm") == "3.259 ± 0.021 µm"
    assert with_uncertainty(-107.07, 2.1, "°") == "−107.1° ± 2.1°"
    assert p_text(0.0) == "p below 10⁻³⁰⁰"
    assert p_text(3.5e-6) == "p = 3.5·10⁻⁶"
    assert odds(36.2) == "practically certain"
    assert odds(4.0) == "55 to 1"
