"""Reduced blind test: effects of the independent generator, a sample of the protocol, and two fixed pairs.

They ask ``diagnose`` alone and state what is right, not how it is found.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from types import SimpleNamespace

import pytest

from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import diagnose
from cycloid_profile.measurement import parse_measurement
from cycloid_profile.spec import parse_spec
from tests.diagnosis import freeze, protocol
from tests.diagnosis.blind import Hidden, Reducer, draw_case, spec_text
from tests.diagnosis.blind.cases import measured
from tests.diagnosis.protocol import BENCH, JUDGED, WIDE_GROUP, Question, ask, judged, questions, run, score


def test_outcomes_of_score():
    found = "effects_found"
    assert score([], "agrees", [], False) == "exact"
    assert score([], found, [["disc_runout"]], False) == "wrong"
    assert score(["disc_runout"], found, [["disc_runout"]], False) == "exact"
    assert score(["thermal_growth"], found, [["radial_moving_error", "thermal_growth"]], False) == "exact"
    assert score(["equidistant_error"], found, [["pin_radius_error", "equidistant_error"]], False) == "group"
    assert score(["disc_runout", "disc_oval"], found, [["disc_oval"]], False) == "subset"
    assert score(["disc_oval"], found, [["disc_oval"], ["disc_runout"]], False) == "more"
    assert score(["disc_oval"], found, [["disc_runout"]], False) == "wrong"
    assert score(["disc_oval"], "unknown_effect", [], False) == "unknown"
    assert score(["disc_oval"], "agrees", [], False) == "agrees"
    assert score(["x_pit"], "unknown_effect", [], False) == "exact"
    assert score(["x_pit"], found, [["single_tooth_error"]], False) == "wrong"
    assert score(["x_pit"], found, [["single_tooth_error"]], True) == "remainder"


def test_what_outcomes_are_worth():
    assert judged("remainder", ["x_pit"], "outside, scan") == "right"
    assert judged("exact", ["x_pit"], "outside, scan") == "right"
    assert judged("remainder", ["disc_oval"], "one, scan") == "unknown"
    assert judged("remainder", ["disc_oval"], "wide, one, scan") == "right"
    assert judged("wide", ["disc_oval"], "aliases, loop") == "right"
    assert judged("wide", ["disc_oval"], "one, loop") == "unknown"
    assert judged("unknown", [], "clean, scan") == "false alarm"
    assert judged("wrong", [], "clean, scan") == "false alarm"
    assert judged("more", ["disc_oval"], "one, scan") == "misnamed"
    assert judged("agrees", ["disc_oval"], "one, scan") == "missed"
    assert judged("failed", [], "clean, scan") == "failed"
    assert judged("within limit", ["disc_oval"], "wide, one, bench") == "within limit"


def test_a_limit_holds_for_sizes_below_it():
    found = SimpleNamespace(
        not_seen={
            "disc_oval": (0.3, "amplitude_um"),
            "series_compliance": (1.0 / 500.0, "stiffness_nm_per_arcmin"),
            "single_pin_error": (math.inf, "amount_um"),
        }
    )

    def within(**sizes):
        hidden = (Hidden(name, dict([size])) for name, size in sizes.items())
        return protocol._within_limits(SimpleNamespace(truth=tuple(hidden)), found)

    assert within(disc_oval=("amplitude_um", -0.2))
    assert not within(disc_oval=("amplitude_um", 0.4))
    # A compliance is small where its stiffness is large.
    assert within(series_compliance=("stiffness_nm_per_arcmin", 600.0))
    assert not within(disc_oval=("amplitude_um", 0.2), series_compliance=("stiffness_nm_per_arcmin", 400.0))
    assert not within(x_pit=("depth_um", 0.1))
    assert not within(single_pin_error=("amount_um", 3.0))


def test_questions_are_numbered_and_the_wide_ones_come_last():
    every = questions(100)
    assert [q.seed for q in every] == list(range(100, 100 + len(every)))
    wide = [q.wide for q in every]
    assert wide == sorted(wide)
    assert len({q.section for q in every if q.wide}) == 16


def test_frozen_questions_are_drawn_as_they_were():
    rows = freeze.read(freeze.FROZEN)
    for section in ("clean, scan", "one, scan", "λ_sep 6 to 60, one, scan"):
        row = next(row for row in rows if row["section"] == section)
        assert freeze.digest(freeze.redrawn(row)) == row["files"]
    assert {freeze.worth(row) for row in rows} <= set(JUDGED)


@pytest.mark.parametrize("seed", [21])
def test_a_clean_scan_agrees(seed):
    assert ask(Question("clean", seed, {"effects": 0, "files": ("scan",)})).verdict == "agrees"


@pytest.mark.parametrize("seed", [31])
def test_one_effect_on_a_scan_is_named_and_the_gap_closes(seed):
    answer = ask(Question("one", seed, {"effects": 1, "files": ("scan",), "sizes": (0.5, 2.0)}))
    assert answer.outcome in {"exact", "group"}, answer
    assert answer.held_out < 1.1


# Scans and clean loops, which take a second or two; the full protocol runs the rest.
IN_SMALL = {
    "clean, scan": 12,
    "clean, loop": 4,
    "one, scan": 12,
    "λ_sep 6 to 60, one, scan": 8,
    "λ_sep 3 to 6, one, scan": 8,
    "two, scan": 8,
    "λ_sep 8 to 60, two, scan": 4,
    "three, scan": 2,
    "outside, scan": 8,
}


def loop_outside_the_library(seed):
    of_loops = ("x_loop_creep", "x_rate_stiffening")
    asked = {"effects": 0, "outside": 1, "files": ("loop",), "sizes": (0.7, 2.0), "names": of_loops}
    return ask(Question("outside", seed, asked))


@pytest.mark.slow
def test_creep_on_a_loop_has_no_name():
    answer = loop_outside_the_library(2401100)
    assert [one["name"] for one in answer.truth] == ["x_loop_creep"]
    assert answer.verdict == "unknown_effect"


@pytest.mark.slow
def test_joints_of_another_law_are_named_without_the_effects_that_mend_their_form():
    # Each octave of torque errs by a tenth of the twist: play and wear of the flanks no longer explain the difference.
    answer = loop_outside_the_library(2501101)
    assert [one["name"] for one in answer.truth] == ["x_rate_stiffening"]
    assert answer.groups == [["nonlinear_series_compliance"]]


@pytest.mark.slow
def test_the_protocol_in_small():
    every = questions(500_000)
    asked = [q for section, count in IN_SMALL.items() for q in [q for q in every if q.section == section][:count]]
    answers = run(asked, min(2, os.cpu_count() or 1))
    assert len(answers) >= 60
    counts = Counter((a.section, a.judged) for a in answers)

    def share(section, worth):
        return counts[section, worth] / sum(a.section == section for a in answers)

    assert not any(a.outcome == "failed" for a in answers), [a.error for a in answers if a.error]
    assert share("clean, scan", "right") >= 0.9
    assert share("clean, loop", "right") >= 0.9
    assert share("one, scan", "right") >= 0.9
    assert share("one, scan", "misnamed") <= 0.05
    # At the target of 95 %, seven of eight or more have a probability of 94 %.
    assert share("λ_sep 6 to 60, one, scan", "right") >= 7 / 8
    # The target is one wrong name in twenty; with eight cases two would be too many.
    assert share("λ_sep 3 to 6, one, scan", "misnamed") <= 0.125
    assert share("λ_sep 8 to 60, two, scan", "right") >= 0.75
    assert share("two, scan", "right") >= 0.85
    assert share("outside, scan", "misnamed") <= 0.15
    z = [value for a in answers for value in a.z]
    assert sum(abs(value) < 1.96 for value in z) >= 0.85 * len(z)
    named = [a for a in answers if a.outcome in {"exact", "group"} and a.truth and not a.section.startswith("outside")]
    assert sum(a.held_out <= 1.1 for a in named) >= 0.95 * len(named)


def _one(name, **parameters):
    return Hidden(name, parameters)


# Two effects each, of two to four workshop tolerances: far above what laws of contact and bodies differ by.
PAIRS = (
    (_one("encoder_eccentricity", amplitude_arcsec=10.0, phase_deg=200.0), _one("disc_oval", amplitude_um=4.0)),
    (_one("wheel_wear_drift", amount_um=4.0, first_lobe=9, disc=1), _one("encoder_eccentricity", amplitude_arcsec=9.0)),
)
_SETTINGS = {"turn_deg": 1.7, "offset_um": [0.0, 0.0], "output_angle_deg": 47.0, "friction_form": "coulomb"}


def _label(pair):
    return "+".join(one.name for one in pair)


@pytest.mark.slow
@pytest.mark.parametrize("pair", PAIRS, ids=_label)
def test_two_effects_on_a_bench_are_named(pair):
    """Both true names, each in a group of at most five, and no other group."""
    reducer = as_built_reducer(parse_spec(spec_text(Reducer())))
    texts = measured(Reducer(), pair, BENCH, _SETTINGS, seed=17)
    found = diagnose(reducer, [parse_measurement(text, f"{name}.csv") for name, text in texts.items()])
    groups = [list(one.group) for one in found.effects]
    seen = f"truth {_label(pair)}, seen {found.verdict} {groups}"
    assert score([one.name for one in pair], found.verdict, groups, False) in {"exact", "group"}, seen
    assert max(len(group) for group in groups) <= WIDE_GROUP, seen


def _asked(counts):
    every = questions(600_000)
    return [q for section, count in counts.items() for q in [q for q in every if q.section == section][:count]]


@pytest.mark.slow
def test_foreign_physics_is_named_or_left_unknown():
    """A sample of the wide sections: nothing named on a clean disc, hardly a wrong name."""
    answers = run(
        _asked({"wide, clean, scan": 4, "wide, one, scan": 8, "wide, outside, scan": 2}), min(2, os.cpu_count() or 1)
    )
    worth = Counter(answer.judged for answer in answers)
    seen = [(a.section, a.seed, a.truth, a.groups, a.error) for a in answers if a.judged != "right"]
    assert worth["failed"] == worth["false alarm"] == 0, seen
    # Of fourteen at a rate of one in a hundred, two have a probability of one in a hundred.
    assert worth["misnamed"] <= 1, seen
    assert worth["right"] >= 13, seen


@pytest.mark.slow
def test_loops_of_foreign_physics_are_left_without_a_name():
    answers = run(_asked({"wide, clean, loop": 6}), 2)
    assert [(answer.named, answer.verdict) for answer in answers] == [([], "agrees")] * 6
    assert "drift" in {answer.forms["noise"] for answer in answers}


@pytest.mark.slow
def test_wear_that_lifts_the_flank_off_is_found():
    """Small wear acts the other way round, so no linear response leads to it; a pitch error explains less."""
    (answer,) = run([Question("wide, one, loop", 7460035, {"effects": 1, "files": ("loop",)}, wide=True)], 1)
    assert [one["name"] for one in answer.truth] == ["flank_wear"]
    assert answer.judged == "right", (answer.named, answer.groups)


@pytest.mark.slow
def test_two_effects_of_which_neither_fits_alone_are_found_together():
    """Without the compliance the pitch error leaves most where it is in truth; the compliance alone leaves 15,000."""
    (answer,) = run([Question("wide, two, loop", 10022094, {"effects": 2, "files": ("loop",)}, wide=True)], 1)
    assert {one["name"] for one in answer.truth} == {"series_compliance", "cumulative_pitch_error"}
    assert answer.judged == "right", (answer.named, answer.groups)


@pytest.mark.slow
def test_discs_that_are_equally_soft_all_round_are_no_effect():
    """With two cranks the spec's discs are softer in some directions; those of the generator never are."""
    seeds = (7440021, 7440050, 7441024, 7441038)
    asked = {"effects": 0, "files": ("loop",)}
    answers = run([Question("wide, clean, loop", seed, asked, wide=True) for seed in seeds], 2)
    assert all(one.forms["reducer"] == "29 lobes" and one.forms["disc"] == "elastic, stated elastic" for one in answers)
    assert [(one.verdict, one.error) for one in answers] == [("agrees", "")] * 4


@pytest.mark.slow
def test_phase_of_ring_runout_is_reported_up_to_180_degrees():
    """The phase of an effect common to both discs is reported with its value rotated by 180°."""
    asked = {"effects": 1, "files": ("loop",), "sizes": (1.0, 1.5), "names": ("pin_ring_runout",)}
    case = draw_case(5, **asked)
    reducer = as_built_reducer(parse_spec(spec_text(case.reducer)))
    found = diagnose(reducer, [parse_measurement(case.files["loop"], "loop.csv")])
    (effect,) = found.effects
    assert effect.candidate.name == "pin_ring_runout"
    assert any("plus 180°" in note for note in found.notes)
    off = (effect.parameters["phase_deg"] - case.truth[0]["phase_deg"] + 90.0) % 180.0 - 90.0
    assert abs(off) < 5.0 * effect.uncertainty["phase_deg"]
