"""Empirical effects: what is fitted, how it is kept, and that every use of a spec sees it.

The foreign shapes are formulas that no effect of the library has. Noise is drawn once per seed.
"""

from __future__ import annotations

import hashlib
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.contact import LoadCase
from cycloid_profile.correction import correction
from cycloid_profile.design import as_built_reducer, design_disc, effects_of
from cycloid_profile.effects import (
    EFFECTS,
    AsBuiltReducer,
    FormDeviation,
    TorqueTwistResidual,
    as_drawn,
    data_file,
    effect_from_table,
    empirical_from_spec,
    empirical_to_table,
    fit_torque_twist,
    form_deviation_of,
    loop_branches,
    removal_between,
)
from cycloid_profile.errors import MeasurementError, SpecError
from cycloid_profile.measurement import read_measurement
from cycloid_profile.modification import NormalDeviation
from cycloid_profile.report.diagnosis import spec_with_effects
from cycloid_profile.rig import Settings, hysteresis_loop, measurement_residual, simulate
from cycloid_profile.spec import format_spec, parse_spec, validated
from cycloid_profile.spec.model import EmpiricalSpec
from cycloid_profile.tolerance.inputs import typical_tolerances
from cycloid_profile.tolerance.study import Draws, Study
from cycloid_profile.units import ARCMIN, NEWTON_METRE, UM
from tests.spec_texts import PLAIN, RV40E

SIGMA = 0.01  # arcmin
DATA = data_file("loop.csv", b"torque_nm,angle_arcmin\n", "2026-02-28")


def foreign(torque_nm: np.ndarray, branch: np.ndarray) -> np.ndarray:
    """A twist [arcmin] that no effect has: a soft step, an uneven stiffness, an opening that depends on the torque."""
    share = torque_nm / 412.0
    return (
        0.4 * np.tanh(torque_nm / 40.0)
        + np.where(share > 0.0, 0.5, 0.1) * share**2
        + branch * 0.15 * (1.0 - share**2)
    )  # fmt: skip


def fitted(seed: int, points: int = 400, sigma: float = SIGMA) -> tuple[TorqueTwistResidual | None, np.ndarray]:
    """A fit to the foreign shape with noise, and the error of its curve at the rows [arcmin]."""
    torque, branch = path(points)
    true = foreign(torque, branch)
    noise = sigma * np.random.default_rng(seed).standard_normal(torque.size)
    found = fit_torque_twist(torque, branch, true + noise, sigma)
    assert found is not None
    off = found.twist.along(torque * NEWTON_METRE, torque * NEWTON_METRE) / ARCMIN - true
    return found, off - np.mean(off)


def path(points: int) -> tuple[np.ndarray, np.ndarray]:
    quarter = points // 5
    legs = [np.arange(quarter), np.arange(quarter, -quarter, -1), np.arange(-quarter, quarter + 1)]
    torque = 412.0 * np.concatenate(legs) / quarter
    return torque, loop_branches(torque)


def form(lobes: int, points: int, disc: int | None = 1) -> FormDeviation:
    t = 2.0 * math.pi * np.arange(points) / points
    removal = 1.5 * np.cos(t - 0.4) + 0.7 * np.sin(2.0 * t)
    return FormDeviation(tuple(removal.tolist()), lobes, disc, 0.05, data=(DATA,))


@pytest.mark.parametrize("points", [150, 400, 3000])
def test_the_fit_follows_a_foreign_shape_within_its_noise(points: int) -> None:
    found, off = fitted(1, points)
    knots = len(found.rising_torque_nm) + len(found.falling_torque_nm)
    # Noise alone gives σ √(knots/rows); a spline of few knots adds as much again.
    assert np.sqrt(np.mean(off**2)) < 2.0 * SIGMA * math.sqrt(knots / points)
    assert knots < points / 4


def test_its_standard_error_is_that_of_repeats() -> None:
    at = np.array([-300.0, -100.0, 150.0, 350.0]) * NEWTON_METRE
    fits = [fitted(seed)[0] for seed in range(20)]
    spread = np.std([one.twist.rising.at(at) / ARCMIN for one in fits], axis=0)
    stated = np.mean(
        [np.interp(at / NEWTON_METRE, one.rising_torque_nm, one.rising_uncertainty_arcmin) for one in fits]
    )
    # 20 repeats give a deviation to 16 %; knots differ from repeat to repeat, which adds to the spread.
    assert 0.6 < np.mean(spread) / stated < 1.6


def test_noise_alone_is_no_effect() -> None:
    torque, branch = path(300)
    rng = np.random.default_rng(5)
    fits = [fit_torque_twist(torque, branch, SIGMA * rng.standard_normal(torque.size), SIGMA) for _ in range(100)]
    assert sum(one is not None for one in fits) <= 3


def test_correlated_noise_is_given_by_its_correlation() -> None:
    torque, branch = path(300)
    rng, rho = np.random.default_rng(6), 0.6
    found = 0
    for _ in range(40):
        noise = np.zeros(torque.size)
        for i in range(1, torque.size):
            noise[i] = rho * noise[i - 1] + math.sqrt(1.0 - rho**2) * SIGMA * rng.standard_normal()
        found += fit_torque_twist(torque, branch, noise, SIGMA, correlation=rho) is not None
    assert found <= 4


def test_one_branch_alone_may_differ() -> None:
    torque, branch = path(400)
    residual = np.where(branch > 0.0, 0.3 * np.sin(torque / 100.0), 0.0)
    noise = SIGMA * np.random.default_rng(2).standard_normal(torque.size)
    found = fit_torque_twist(torque, branch, residual + noise, SIGMA)
    assert len(found.falling_torque_nm) == 2
    assert len(set(found.falling_twist_arcmin)) == 1


def test_beyond_the_knots_it_is_constant_and_at_zero_torque_nothing() -> None:
    found, _ = fitted(3)
    twist = found.twist
    far = np.array([-900.0, 900.0]) * NEWTON_METRE
    np.testing.assert_array_equal(twist.rising.at(far), twist.rising.at(far / 900.0 * 412.0))
    assert twist.settled(np.zeros(1)) == pytest.approx(0.0, abs=1e-9 * ARCMIN)
    np.testing.assert_allclose(twist.settled(far), 0.5 * (twist.rising.at(far) + twist.falling.at(far)))


@pytest.mark.parametrize(
    ("change", "limit"),
    [
        ({"residual": np.zeros(3)}, "differ"),
        ({"sigma": 0.0}, "is not above zero"),
        ({"torque": np.zeros(120)}, "has one torque"),
        ({"branch": np.ones(120)}, "has 0 rows"),
    ],
)
def test_loops_without_a_curve_are_refused(change: dict[str, np.ndarray], limit: str) -> None:
    torque, branch = (values[:120] for values in path(120))
    given = {"torque": torque, "branch": branch, "residual": np.zeros(120), "sigma": SIGMA} | change
    with pytest.raises(MeasurementError, match=limit):
        fit_torque_twist(given["torque"], given["branch"], given["residual"], given["sigma"])


@pytest.mark.parametrize("noise", [0.0, 1.0])
def test_branches_change_where_the_torque_turns(noise: float) -> None:
    torque, _ = path(400)
    # 1 N·m of noise on 824: the turns are found within some rows.
    measured = torque + noise * np.random.default_rng(1).standard_normal(torque.size)
    turns = np.flatnonzero(np.diff(loop_branches(measured)))
    assert turns.size == 2
    np.testing.assert_allclose(turns, [80, 240], atol=2.0 * noise)
    np.testing.assert_array_equal(loop_branches(-measured), -loop_branches(measured))
    assert loop_branches(np.zeros(0)).size == 0
    assert np.all(loop_branches(np.zeros(3)) == 1.0)


def test_a_form_common_to_all_lobes_is_kept_once() -> None:
    at = 2.0 * math.pi * np.arange(39 * 48) / 48
    common = form_deviation_of(NormalDeviation(at, 0.002 * np.cos(2.0 * at), 39), 1e-4, disc=2)
    assert (common.lobes, len(common.removal_um), common.disc) == (1, 48, 2)
    assert common.uncertainty_um == pytest.approx(0.1)
    whole = form_deviation_of(NormalDeviation(at, 0.002 * np.cos(at / 39.0), 39), 1e-4, data=[DATA])
    assert (whole.lobes, len(whole.removal_um), whole.data) == (39, 39 * 48, (DATA,))
    np.testing.assert_allclose(np.array(whole.removal_um) * UM, 0.002 * np.cos(at / 39.0), atol=1e-9)


@pytest.mark.parametrize("one", [form(1, 48), form(39, 390, None), fitted(4)[0]], ids=["lobe", "disc", "loop"])
def test_a_spec_keeps_it_exactly(one: FormDeviation | TorqueTwistResidual) -> None:
    table = empirical_to_table(replace(one, data=(DATA,)))
    assert table["label"] == "empirical, not physical"
    assert table["data"][0]["sha256"] == hashlib.sha256(b"torque_nm,angle_arcmin\n").hexdigest()
    text = spec_with_effects(RV40E, [], [table])
    spec = parse_spec(text)
    again = parse_spec(format_spec(spec))
    assert again == spec
    assert effects_of(again) == (replace(one, data=(DATA,)),)
    assert empirical_to_table(effects_of(again)[0]) == table
    # Never among the effects, neither in the file nor in the library.
    assert spec.effects == ()
    assert one.name not in EFFECTS


def test_tables_go_behind_an_inline_list_of_effects() -> None:
    text = f"effects = [{{ name = 'disc_oval', amplitude_um = 1.0 }}]\n{RV40E}"
    grown = parse_spec(spec_with_effects(text, [{"name": "disc_runout", "amplitude_um": 1.0}],
                                         [empirical_to_table(form(1, 12))]))  # fmt: skip
    assert [one["name"] for one in grown.effects] == ["disc_oval", "disc_runout"]
    assert effects_of(grown)[2] == form(1, 12)


LOOP = {"name": "torque_twist_residual", "label": "empirical, not physical",
        "rising_torque_nm": [-1.0, 1.0], "rising_twist_arcmin": [0.0, 1.0], "rising_uncertainty_arcmin": [0.1, 0.1],
        "falling_torque_nm": [-1.0, 1.0], "falling_twist_arcmin": [0.0, 1.0], "falling_uncertainty_arcmin": [0.1, 0.1],
        }  # fmt: skip
FORM = {"name": "form_deviation", "label": "empirical, not physical", "removal_um": [0.0, 1.0, 0.0, -1.0]}


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ({**LOOP, "rising_torque_nm": [1.0, -1.0]}, "does not rise"),
        ({**LOOP, "rising_torque_nm": [1.0]}, "give at least 2"),
        ({**LOOP, "falling_twist_arcmin": [1.0]}, "give at least 2"),
        ({**LOOP, "falling_twist_arcmin": [1.0, 1.0, 1.0]}, "has 3 numbers for 2 knots"),
        ({**LOOP, "removal_um": [1.0]}, "is no key of torque_twist_residual"),
        ({**FORM, "rising_torque_nm": [1.0]}, "is no key of form_deviation"),
        ({**FORM, "removal_um": [1.0, 2.0]}, "give at least 4"),
        ({**FORM, "lobes": 17}, "is neither 1 nor the 39 of the disc"),
        ({**FORM, "disc": 3}, "is not one of the 2 discs"),
        ({**FORM, "data": [{"file": "a.csv", "sha256": "12"}]}, "is no SHA-256"),
        ({**FORM, "label": "physics"}, "choose from empirical, not physical"),
        ({"name": "form_deviation", "removal_um": [1.0]}, "label is missing"),
        ({**FORM, "name": "disc_oval"}, "choose from form_deviation"),
    ],
)
def test_an_impossible_table_is_one_sentence(table: dict[str, object], says: str) -> None:
    case = design_case()
    with pytest.raises(SpecError) as refused:
        empirical_from_spec(validated(table, EmpiricalSpec, "empirical")).apply(as_drawn(case))
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def design_case() -> LoadCase:
    return as_built_reducer(parse_spec(RV40E)).case


def test_an_error_names_the_table_of_the_file() -> None:
    spec = parse_spec(RV40E).replace("empirical", [FORM, {**FORM, "removal_um": [1.0]}])
    with pytest.raises(SpecError, match=r"empirical\[2\]: form_deviation\.removal_um"):
        as_built_reducer(spec)
    with pytest.raises(SpecError, match=r"\[\[empirical\]\]"):
        parse_spec(RV40E + "[[effects]]\nname = 'form_deviation'\n")


def test_the_form_is_removed_from_its_disc(case: LoadCase) -> None:
    one = form(39, 390)
    built = one.apply(as_drawn(case))
    assert built.teeth[1] is case.profile
    lobe = np.arange(39.0)
    found = removal_between(case.profile, built.teeth[0], np.zeros(39), lobe)
    # Point 10 m is the root of lobe m.
    np.testing.assert_allclose(found, np.array(one.removal_um)[::10] * UM, atol=1e-12)


def test_without_a_disc_the_form_turns_as_that_of_a_built_in_effect(case: LoadCase) -> None:
    t = 2.0 * math.pi * np.arange(390) / 390
    wave = FormDeviation(tuple((-2.0 * np.cos(2.0 * t)).tolist()), 39, None)
    oval = effect_from_table({"name": "disc_oval", "amplitude_um": 2.0})
    drawn, psi = as_drawn(case), np.linspace(-3.0, 3.0, 13)
    for j in (0, 1):
        one, other = (removal_between(case.profile, effect.apply(drawn).teeth[j], psi, np.full(13, 5.0))
                      for effect in (wave, oval))  # fmt: skip
        np.testing.assert_allclose(one, other, atol=1e-9)


def measured_loop(reducer: AsBuiltReducer, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torque [N·m], angle with the foreign shape and noise, and angle predicted by the drawing [arcmin]."""
    loop = hysteresis_loop(reducer)
    torque = loop.torque / NEWTON_METRE
    predicted = loop.angle / ARCMIN
    noise = SIGMA * np.random.default_rng(seed).standard_normal(torque.size)
    return torque, predicted + foreign(torque, loop_branches(torque)) + noise, predicted


def test_a_loop_of_foreign_shape_is_closed_on_held_out_rows_through_the_spec() -> None:
    spec = parse_spec(RV40E)
    drawn = as_built_reducer(spec)
    torque, angle, predicted = measured_loop(drawn, 7)
    # Every fourth block of ten rows is held out.
    held = np.arange(torque.size) // 10 % 4 == 3
    found = fit_torque_twist(torque[~held], loop_branches(torque)[~held], (angle - predicted)[~held], SIGMA)
    again = as_built_reducer(parse_spec(spec_with_effects(RV40E, [], [empirical_to_table(found)])))
    closed = hysteresis_loop(again).angle / ARCMIN
    before, after = (np.var((angle - one)[held]) for one in (predicted, closed))
    assert 1.0 - (after - SIGMA**2) / (before - SIGMA**2) > 0.99
    assert math.sqrt(after) < 1.2 * SIGMA


def test_simulate_and_compare_use_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawn = as_built_reducer(parse_spec(RV40E))
    torque, angle, predicted = measured_loop(drawn, 8)
    found = fit_torque_twist(torque, loop_branches(torque), angle - predicted, SIGMA)
    (tmp_path / "mine.toml").write_text(spec_with_effects(RV40E, [], [empirical_to_table(found)]), encoding="utf-8")
    file = tmp_path / "loop.csv"
    assert run(["simulate", str(tmp_path / "mine.toml"), "--kind", "hysteresis", "--out", str(file)]) == 0
    capsys.readouterr()
    loop = read_measurement(file)
    # The loop of the rig opens by the foreign 0.3′ at zero torque, and has its angles.
    np.testing.assert_allclose(np.interp(300.0, torque[240:], angle[240:] - angle[320]),
                               np.interp(300.0, torque[240:], (loop["angle_arcmin"] - loop["angle_arcmin"][320])[240:]),
                               atol=6.0 * SIGMA)  # fmt: skip
    own = as_built_reducer(parse_spec((tmp_path / "mine.toml").read_text(encoding="utf-8")))
    compared = measurement_residual(own, loop)
    assert compared.rms < 1e-3
    plain = measurement_residual(drawn, loop)
    assert plain.rms > 0.1


@pytest.mark.slow
def test_a_study_holds_it_fixed() -> None:
    spec = parse_spec(PLAIN + "[load]\ndisc_body = 'rigid'\n")
    twist = TorqueTwistResidual((-40.0, 40.0), (-3.0, 3.0), (0.1, 0.1), (-40.0, 40.0), (-3.0, 3.0), (0.1, 0.1))
    curves = [empirical_to_table(one) for one in (twist, replace(form(1, 24), removal_um=(5.0,) * 24))]
    drawn, built = (as_built_reducer(one) for one in (spec, spec.replace("empirical", curves)))
    studies = [Study(one, Draws(typical_tolerances(drawn)), ("backlash_arcmin", "lost_motion_arcmin"), 16, chunk=16)
               for one in (drawn, built)]  # fmt: skip
    more = np.mean(studies[1].values(0) - studies[0].values(0), axis=0)
    by_name = dict(zip(studies[0].quantity_model.names, more, strict=True))
    backlash, lost = by_name["backlash_arcmin"], by_name["lost_motion_arcmin"]
    # 2·5 µm/(a z_c) by the form, more where no pin has that lever; the twist adds its own between ±3 % torque.
    assert backlash == pytest.approx(2.0 * 0.005 / (1.5 * 10) / ARCMIN, rel=0.05)
    light = 0.03 * drawn.case.torque / NEWTON_METRE
    assert lost - backlash == pytest.approx(2.0 * light * 3.0 / 40.0, rel=0.1)
    assert studies[0].fingerprint != studies[1].fingerprint
    # A curve of the same range is another one.
    turned = (
        replace(form(1, 24), removal_um=(5.0, 4.0, *(5.0,) * 22)),
        replace(form(1, 24), removal_um=(4.0, *(5.0,) * 23)),
    )
    prints = [replace(studies[0], reducer=one.apply(drawn)).fingerprint for one in turned]
    assert prints[0] != prints[1]


def test_the_correction_cancels_the_form_and_leaves_the_twist() -> None:
    from tests.correction.test_correction import drawn, found

    twist = TorqueTwistResidual((-40.0, 40.0), (-3.0, 3.0), (0.1, 0.1), (-40.0, 40.0), (-3.0, 3.0), (0.1, 0.1))
    known = (form(1, 48), form(39, 39 * 12), replace(form(1, 48), disc=2), twist)
    reducer = drawn()
    for one in known:
        reducer = one.apply(reducer)
    result = correction(found(reducer, []), known=known)
    assert result.known == known[:2]
    assert result.residual < 1e-6
    assert result.shape.largest > 1e-3
    assert [text.split(" ")[0] for text in result.not_ground_away] == ["torque_twist_residual"]
    assert any("no known cause" in text for text in result.cautions)


def test_a_design_names_it_and_shows_the_accuracy_as_built() -> None:
    record = design_disc(parse_spec(PLAIN).replace("empirical", [{**FORM, "removal_um": [4.0] * 8}]))
    assert record.as_built is not None
    assert "form_deviation" in repr(record)


def test_a_simulated_scan_shows_the_form() -> None:
    drawn = as_built_reducer(parse_spec(RV40E))
    scan = simulate(form(39, 390).apply(drawn), "profile_scan", Settings(points=780))
    # The root mean square of 1.5 and 0.7 µm of two waves; the registration takes a little.
    assert measurement_residual(drawn, scan).rms == pytest.approx(math.hypot(1.5, 0.7) / math.sqrt(2.0), rel=0.03)
