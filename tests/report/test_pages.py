"""Reports as their readers meet them: verdict, meaning, terms, links, narrow screens."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile._display import FigureRow
from cycloid_profile.cli.main import run
from cycloid_profile.design import CheckStatus
from cycloid_profile.export.inspection import CheckResult, Inspection
from cycloid_profile.report import TERMS, inspection_meaning, inspection_verdict
from cycloid_profile.report.design import design_meaning, design_verdict
from cycloid_profile.report.diagnosis import correction_verdict, diagnosis_meaning, odds
from cycloid_profile.report.page import at_an_arm, figure_table
from cycloid_profile.report.terms import explained
from cycloid_profile.report.tolerance.text import yield_tables
from cycloid_profile.tolerance.inputs import Limit
from tests.report.pages import Page, read_page

ROOT = Path(__file__).parents[2]
GLOSSARY = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
MEASURED = ROOT / "examples" / "measured"
SHORT = """
name = "short <name>"
[drive]
pins = 12
pin_circle_radius_mm = 30.0
pin_radius_mm = 2.5
eccentricity_mm = 1.5
disc_width_mm = 8.0
discs = 1
[load]
rated_torque_nm = 10.0
disc_body = "rigid"
[modification]
equidistant_um = 40.0
deformation_compensation = false
[export]
formats = ["csv"]
"""


def measured(command: str, page: str) -> Callable[[Path], Path]:
    def written(folder: Path) -> Path:
        words = [command, str(MEASURED / "rv40e.toml"), str(MEASURED / "scan.csv"), "--out", str(folder), "-q"]
        assert run(words) == 0
        return folder / page

    return written


def built(folder: Path) -> Path:
    spec = folder.parent / "short.toml"
    spec.write_text(SHORT, encoding="utf-8")
    assert run(["build", str(spec), "--out", str(folder), "-q"]) == 0
    return folder / "report.html"


def tolerated(folder: Path) -> Path:
    spec = folder.parent / "short.toml"
    spec.write_text(SHORT + "[tolerance]\nloaded_samples = 0\nsamples = 500\n", encoding="utf-8")
    assert run(["tolerance", str(spec), "--out", str(folder), "-q"]) == 0
    return folder / "report.html"


slow = pytest.mark.slow
REPORTS = [
    pytest.param(measured("inspect", "inspection.html"), id="inspection"),
    pytest.param(measured("diagnose", "report.html"), id="diagnosis", marks=slow),
    pytest.param(measured("correct", "correction.html"), id="correction", marks=slow),
    pytest.param(built, id="design", marks=slow),
    pytest.param(tolerated, id="tolerance", marks=slow),
]


@pytest.fixture(scope="module", params=REPORTS)
def report(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Page]:
    path = request.param(tmp_path_factory.mktemp("report") / "out")
    return path, read_page(path)


def test_the_page_begins_with_a_verdict_in_one_sentence(report: tuple[Path, Page]) -> None:
    verdict = report[1].verdict
    assert verdict.endswith(".")
    assert not re.search(r"[.!?] [A-Z]", verdict), verdict


def test_every_file_is_linked_and_every_link_leads_to_a_file(report: tuple[Path, Page]) -> None:
    path, page = report
    folder = path.parent
    written = {file.relative_to(folder).as_posix() for file in folder.rglob("*") if file.is_file()} - {path.name}
    folders = {link for link in page.links if link.endswith("/")}
    assert written == {link for link in page.links if not link.endswith("/")} | {
        file for file in written if file.startswith(tuple(folders))
    }


def test_the_page_fits_a_narrow_screen(report: tuple[Path, Page]) -> None:
    page = report[1]
    assert any(meta.get("name") == "viewport" for meta in page.metas)
    # The two tables of an effect's sizes are narrow.
    assert page.tables_that_scroll >= page.tables - 1


def test_terms_are_explained_on_hover_and_in_a_legend(report: tuple[Path, Page]) -> None:
    page = report[1]
    assert page.explained
    legend = {text for tag, text in page.texts if tag == "dd"}
    assert legend == set(page.explained.values())
    assert legend <= {term.meaning for term in TERMS}


def test_no_page_prints_odds_as_a_power_of_e(report: tuple[Path, Page]) -> None:
    assert "e^" not in report[1].text
    assert "None" not in report[1].text


def test_terms_have_the_words_of_the_glossary() -> None:
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in GLOSSARY.splitlines() if line[:1] == "|"]
    known = {row[0]: row[3] if len(row) > 4 else row[1] for row in rows}
    assert {term.name: known.get(term.name) for term in TERMS} == {term.name: term.meaning for term in TERMS}


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_every_term_is_found_in_some_text(term: Any) -> None:
    sample = {"order": "order 40", "p-value": "p = 0.1", "arc minute, arc second": "[″]"}
    words = [sample.get(term.name, ""), *re.split(", ", term.name), term.name]
    words += re.findall(r"[\w-]+(?: [\w-]+)*|F_α|χ² per row", re.sub(r"\(\?\w*[:=!]|[()|\\?]", " ", term.pattern))
    assert any(term in explained(word)[1] for word in words), words


def test_a_term_is_explained_once_a_section_and_never_in_pictures_or_links() -> None:
    page, terms = explained("<h2>ψ</h2><td>ψ0, ψ and ψ</td><svg><text>ψ</text></svg><a href='ψ'>ψ</a><h2>b</h2>ψ")
    assert [term.name for term in terms] == ["phase", "critical phase"]
    assert page.count("<abbr") == 3
    assert "<svg><text>ψ</text></svg><a href='ψ'>ψ</a>" in page


def test_columns_of_equal_figures_are_one() -> None:
    rows = (FigureRow("a", "first", "mm"), FigureRow("b", "second", "N"))
    one, other = {"a": 1.0, "b": 2.0}, {"a": 1.0, "b": 3.0}
    assert figure_table("", rows, [one, one], ("disc 1", "disc 2")).head == ("", "disc 1 and disc 2", "unit")
    assert figure_table("", rows, [one, other], ("disc 1", "disc 2")).head == ("", "disc 1", "disc 2", "unit")


def test_an_angle_is_shown_in_degrees_and_at_an_arm() -> None:
    # 46.8′ = 0.78° = 13.6 mrad, 1.36 mm at 100 mm.
    assert at_an_arm(46.8).startswith("0.78°, 1.36 mm at the end of a 100 mm arm")
    assert "29.1 µm" in at_an_arm(1.0)


@pytest.mark.parametrize(
    ("evidence", "words"), [(7806.0, "practically certain"), (3.0, "20 to 1"), (0.0, "1 to 1"), (-1.0, "less probable")]
)
def test_odds_in_words(evidence: float, words: str) -> None:
    assert odds(evidence).startswith(words)


@given(st.lists(st.sampled_from(sorted(CheckStatus, key=str)), min_size=1))
def test_the_verdict_of_a_design_contradicts_no_check(statuses: list[CheckStatus]) -> None:
    failed = [status.value for status in statuses if status is CheckStatus.FAILED]
    figures = {"failures": failed, "checks": [{"status": one.value} for one in statuses], "as_built": None}
    sentence, kind = design_verdict(figures)
    good = {CheckStatus.PASSED, CheckStatus.ESTIMATED}
    assert ("cannot work" in sentence) == bool(failed) == (kind == "failed")
    assert sentence.startswith("All") == (set(statuses) <= good)
    if sentence.startswith("All"):
        assert ("assumed" in sentence) == (CheckStatus.ESTIMATED in statuses)
    elif not failed:
        assert ("advise" in sentence) == (CheckStatus.ADVISED_AGAINST in statuses)
        assert ("want of data" in sentence) == (CheckStatus.NOT_CHECKED in statuses)


CHECK = CheckResult("runout", "F_r", "radius", 2e-3, False, "IT4, ground", 1e-3, 1e-4, 0.0)


@pytest.mark.parametrize(
    ("value", "verdict", "meaning"),
    [
        (1e-3, "all 1 checks passed", "50 % of its tolerance"),
        (3e-3, "out of tolerance: runout F_r", "150 % of its tolerance"),
        (None, "does not show runout F_r", "bore as datum"),
        (1.9e-3, "all 1 checks passed", "measure again"),
        (1e-4, "all 1 checks passed", "noise alone explains it"),
    ],
)
def test_the_verdict_of_an_inspection_follows_its_checks(value: float | None, verdict: str, meaning: str) -> None:
    result = Inspection.__new__(Inspection)
    object.__setattr__(result, "checks", (replace(CHECK, value=value),))
    assert verdict in inspection_verdict(result).sentence
    assert meaning in inspection_meaning(result)[0]


def test_the_verdict_of_a_correction_names_what_remains() -> None:
    values: dict[str, Any] = {"disc": 2, "effects": [{"name": "disc_oval"}], "known_effects": [], "remainder": None}
    whole = correction_verdict({**values, "not_ground_away": []}).sentence
    assert whole == "The corrected program of disc 2 removes disc oval."
    assert "but not 1 other error" in correction_verdict({**values, "not_ground_away": ["chatter"]}).sentence


def test_a_drive_that_binds_has_no_free_motion() -> None:
    figures: dict[str, Any] = {
        "conventional": {"backlash_arcmin": 1.0},
        "compensated": {"backlash_arcmin": -0.5, "transmission_error_arcsec": None},
        "compensation": {"applied": False},
        "under_load": {"twist_arcmin": float("nan"), "output_speed_rpm": 15.0},
        "rated_torque_nm": 10.0,
        "strength": {"crank_bearing_life_h": None},
        "losses": {"likely": {"heat_w": 1.0}},
    }
    free, twist, *_ = design_meaning(figures)
    assert "binds" in free
    assert "by hand" not in free
    assert "–" in twist


def test_gaps_of_angles_are_also_lengths() -> None:
    gap = SimpleNamespace(
        recording=SimpleNamespace(name="loop.csv", unit="arcsec"), noise=6.0, fit_before=12.0, fit_after=6.0,
        held_out_before=18.0, held_out_after=6.0,
    )  # fmt: skip
    gap_only_fitted = SimpleNamespace(**{**vars(gap), "held_out_before": float("nan"), "held_out_after": float("nan")})
    sentences = diagnosis_meaning(SimpleNamespace(gaps=[gap, gap_only_fitted], effects=[]))  # type: ignore[arg-type]
    assert "no part in the fit differ by 3.00 times the noise." in sentences[0]
    # 6″ = 0.1′ = 29.1 µrad, 2.91 µm at 100 mm.
    assert "2.91 µm at the end of a 100 mm arm" in sentences[1]
    assert "differ by 2.00 times the noise." in sentences[2]


def test_a_study_of_fewer_limits_does_not_claim_all_of_them() -> None:
    def study(samples: int, *limits: Limit) -> SimpleNamespace:
        share = SimpleNamespace(value=0.5, low=0.4, high=0.6)
        every = [SimpleNamespace(limit=limit, share=share) for limit in (*limits, None)]
        return SimpleNamespace(samples=samples, yields=every)

    backlash, motion = Limit("backlash_arcmin", at_most=0.65), Limit("lost_motion_arcmin", at_most=0.85)
    least = Limit("least_backlash_arcmin", at_least=0.0)
    record = SimpleNamespace(summaries=[study(1000, backlash, least), study(40, backlash, least, motion)])
    (table,) = yield_tables(record)  # type: ignore[arg-type]
    names = [row[0] for row in table.rows]
    assert names[2] == "these 2 limits together"
    assert names[-1] == "all limits together"
    assert names[0] == "backlash ≤ 0.65′"
