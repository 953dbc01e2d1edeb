"""Design under load: checks with value, limit and remedy, and the keys that control them."""

from __future__ import annotations

import math
import re
import typing
from functools import cache

import msgspec
import numpy as np
import pytest

from cycloid_profile.contact.laws import LAWS
from cycloid_profile.design import CheckStatus, design_disc, summary
from cycloid_profile.design.from_spec import STEEL_FATIGUE_LIMIT, allowable_pressure
from cycloid_profile.errors import CycloidError, SpecError
from cycloid_profile.report.design import warnings
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model.load import LoadSpec
from cycloid_profile.units import UM
from tests.spec_texts import CRANKS, DRIVE

DESIGN = f"""{DRIVE}{CRANKS}{{cranks}}
[load]
rated_torque_nm = {{torque}}
{{load}}
disc_body = "{{body}}"
[modification]
equidistant_um = {{equidistant}}
{{modification}}
"""
# All data that the checks of stresses and life ask for, but the life itself.
SEATED = """[drive.crank_bearing]
dynamic_load_rating_n = 13000.0
roller_count = 16
roller_diameter_mm = 3.0
roller_length_mm = 9.0
[drive.pin_seat]
span_mm = 0.0
"""
LIMITS = "allowable_pin_stress_mpa = 300.0\nlubricant_viscosity_mm2_per_s = 60.0\n"


def text_of(**changes):
    words = {"cranks": "", "torque": 412.0, "load": "", "body": "rigid", "equidistant": 6.0, "modification": ""}
    return DESIGN.format(**words | changes)


@cache
def designed(**changes):
    return design_disc(parse_spec(text_of(**changes)))


def check(record, name):
    return next(c for c in record.checks if c.name.startswith(name))


def test_spec_file_offers_every_contact_law():
    annotation = typing.get_type_hints(LoadSpec, include_extras=True)["contact_law"]
    # Optional, annotated, literal.
    assert set(typing.get_args(typing.get_args(typing.get_args(annotation)[0])[0])) == set(LAWS)
    for name in LAWS:
        assert designed(load=f'contact_law = "{name}"').case.law is LAWS[name]


def test_sound_design_passes_every_check():
    record = designed(cranks=SEATED, load=f"{LIMITS}required_life_h = 5000.0")
    assert [c.name for c in record.checks if not c.passed] == []
    assert len(record.checks) == 13
    assert record.failures == ()


def test_checks_without_data_name_the_key_and_have_not_passed():
    record = designed()
    missing = {c.name: c for c in record.checks if c.status is CheckStatus.NOT_CHECKED}
    assert len(record.checks) - len(missing) == 9
    assert {c.missing.split()[0] for c in missing.values()} == {
        "load.allowable_pin_stress_mpa",
        "drive.pin_seat.span_mm",
        "load.required_life_h",
        "load.lubricant_viscosity_mm2_per_s",
    }
    for one in missing.values():
        assert not one.passed
        assert f"not checked: give {one.missing}" in one.sentence
    assert all(c.passed for c in record.checks if c.name not in missing)
    # Each key is one of the spec file.
    for one in missing.values():
        assert record.spec.replace(one.missing.split()[0], 3.0) != record.spec
    assert record.failures == ()
    assert [sentence for sentence in warnings(summary(record)) if sentence.startswith("not checked")] == [
        f"not checked: {'; '.join(f'{one.name}: {one.remedy}' for one in missing.values())}"
    ]


def test_assumed_data_advise_and_given_data_fail():
    # 10 000 hours are more than the rollers assumed in the hole of the crank reach, and more than a C of 13 kN.
    assumed = designed(load="required_life_h = 10000.0")
    life = check(assumed, "life of a crank bearing")
    assert life.status is CheckStatus.ADVISED_AGAINST
    assert "estimated: " in life.sentence
    assert "assumed" in life.assumed
    assert assumed.failures == ()
    given = designed(cranks=SEATED, load="required_life_h = 10000.0")
    life = check(given, "life of a crank bearing")
    assert life.status is CheckStatus.FAILED
    assert "dynamic_load_rating_n" in life.remedy
    assert given.failures == (life.sentence,)


def test_given_limits_of_stress_fail_unless_the_torque_is_assumed():
    limits = "allowable_pressure_mpa = 1000.0\nallowable_pin_stress_mpa = 10.0"
    record = designed(cranks="[drive.pin_seat]\nspan_mm = 11.5", load=limits)
    for name in ("peak pressure", "pin shear", "pin bending"):
        assert check(record, name).status is CheckStatus.FAILED
    assert len(record.failures) == 3
    text = text_of(torque=1.0, load=limits)
    unrated = design_disc(parse_spec(text.replace("rated_torque_nm = 1.0\n", "")))
    for name in ("peak pressure", "pin shear"):
        assert check(unrated, name).status is CheckStatus.ADVISED_AGAINST
        assert "rated torque" in check(unrated, name).assumed
    assert unrated.failures == ()


def test_rollers_are_estimated_from_the_crank_hole_and_said_to_be():
    record = designed(modification="[disc]\ncrank_hole_radius_mm = 13.0")
    rolling = record.strength.crank_rollers
    assert rolling.assumed == ("count", "diameter", "length")
    rollers = rolling.rollers
    assert rollers.inner_raceway_radius + rollers.diameter == pytest.approx(13.0)
    assert (rollers.diameter, rollers.length) == pytest.approx((0.23 * 13.0, 0.75 * 11.5))
    assert record.strength.rating_estimated
    assert summary(record)["strength"]["dynamic_load_rating_estimated"]
    # Makers state 6000 h at rated torque and speed.
    assert 5000.0 < record.strength.life.least_life_h < 12000.0
    own = designed(cranks=SEATED)
    assert own.strength.crank_rollers.assumed == ()
    assert own.strength.life.load_rating == 13_000.0
    assert not own.strength.rating_estimated


def test_no_life_is_estimated_for_rollers_in_plastic_nor_at_rest():
    text = text_of(torque=20.0, equidistant=50.0)
    plastic = design_disc(parse_spec(f"{text}\n[materials.disc]\nyoungs_modulus_gpa = 2.5"))
    life = check(plastic, "life of a crank bearing")
    assert life.missing == "drive.crank_bearing.dynamic_load_rating_n"
    assert plastic.strength.life is None
    rest = designed(load=f"{LIMITS}required_life_h = 5000.0\noutput_speed_rpm = 0.0")
    assert check(rest, "life of a crank bearing").missing == "load.output_speed_rpm"
    assert check(rest, "viscosity ratio").missing == "load.output_speed_rpm"
    assert msgspec.json.encode(summary(rest))


def test_thin_oil_shortens_the_life():
    thick, thin = (
        designed(cranks=SEATED, load=f"lubricant_viscosity_mm2_per_s = {viscosity}") for viscosity in (100.0, 10.0)
    )
    assert check(thick, "viscosity ratio").passed
    assert check(thin, "viscosity ratio").status is CheckStatus.ADVISED_AGAINST
    figures = [summary(one)["strength"] for one in (thick, thin)]
    assert figures[0]["viscosity_ratio"] == pytest.approx(10.0 * figures[1]["viscosity_ratio"])
    assert figures[0]["crank_bearing_modified_life_h"] > 3.0 * figures[1]["crank_bearing_modified_life_h"]
    assert figures[0]["crank_bearing_life_h"] == figures[1]["crank_bearing_life_h"]


@pytest.mark.parametrize(
    ("sizes", "message"),
    [
        ("roller_diameter_mm = 30.0", "drive.crank_bearing.roller_diameter_mm = 30 mm is outside"),
        ("roller_count = 40", "drive.crank_bearing.roller_count = 40 is outside 1 to"),
        ("roller_length_mm = -1.0", "drive.crank_bearing.roller_length_mm"),
        ("dynamic_load_rating_kn = 13.0", "dynamic_load_rating_n"),
    ],
)
def test_impossible_rollers_are_refused_by_their_key(sizes, message):
    with pytest.raises(CycloidError, match=re.escape(message)):
        designed(cranks=f"[drive.crank_bearing]\n{sizes}")


def test_losses_have_a_range_and_its_assumption():
    record = designed()
    figures = summary(record)
    low, likely, high = (figures["losses"][name] for name in ("low", "likely", "high"))
    assert low["heat_w"] < likely["heat_w"] < high["heat_w"]
    assert low["efficiency"] > likely["efficiency"] > high["efficiency"]
    for key in ("mesh_loss_w", "bearing_loss_w", "efficiency"):
        assert likely[key] == figures["under_load"][key]
    assert record.losses is record.loss_range.likely
    for word in ("seals", "churning", "first stage", "excluded", "0.03", "0.12", "0.002"):
        assert word in figures["losses"]["assumption"]


@pytest.mark.slow
def test_too_little_clearance_for_the_wheel_radius_interferes():
    # Radial-moving alone, with the sign that leaves material: the pins overlap the disc at every pose.
    record = designed(equidistant=0.0, modification="radial_moving_um = -8.0")
    midway = check(record, "gap left midway")
    assert not midway.passed
    assert midway.severe
    assert "raise equidistant_um" in midway.sentence
    assert any("gap left midway" in sentence for sentence in record.failures)


def test_heavy_load_is_advised_against_not_refused():
    record = designed(torque=800.0)
    pressure = check(record, "peak pressure")
    assert not pressure.passed
    assert not pressure.severe
    assert f"{record.under_load.max_pressure:.0f} MPa" in pressure.sentence
    assert "limit at most 1500 MPa" in pressure.sentence
    assert record.failures == ()


def test_allowable_pressure_is_the_fatigue_limit_for_steel_alone():
    assert allowable_pressure(designed().spec) == STEEL_FATIGUE_LIMIT
    assert allowable_pressure(designed(load="allowable_pressure_mpa = 1100.0").spec) == 1100.0
    plastic = "[materials.disc]\nyoungs_modulus_gpa = 2.5\n[load]\nallowable_pressure_mpa = 60.0"
    text = text_of(torque=20.0, equidistant=50.0)
    record = design_disc(parse_spec(text.replace("[load]", "[materials.disc]\nyoungs_modulus_gpa = 2.5\n[load]")))
    assert allowable_pressure(record.spec) is None
    assert check(record, "peak pressure").missing == "load.allowable_pressure_mpa"
    given = design_disc(parse_spec(text.replace("[load]", plastic)))
    assert check(given, "peak pressure").status in (CheckStatus.PASSED, CheckStatus.FAILED)


def test_wide_clearance_leaves_pins_idle():
    record = designed(equidistant=60.0, torque=60.0)
    sharing = check(record, "pins of a disc that share")
    assert not sharing.passed
    assert f"{record.under_load.fewest_loaded_pins} to {record.under_load.loaded_pins} of 19" in sharing.value
    assert record.under_load.fewest_loaded_pins < 4


def test_theoretical_tooth_presses_on_the_edges_of_the_flank():
    record = designed(equidistant=0.0)
    edge = check(record, "active flank")
    assert not edge.passed
    assert "raise the radial clearance" in edge.sentence


def test_law_outside_its_range_fails_its_check():
    text = text_of(torque=20.0, load='contact_law = "palmgren"', equidistant=50.0)
    plastic = text.replace("[load]", "[materials.disc]\nyoungs_modulus_gpa = 2.5\n[load]", 1)
    record = design_disc(parse_spec(plastic))
    law = check(record, "contact law (palmgren)")
    assert not law.passed
    assert "steel" in law.limit


def test_modification_figures():
    record = designed(modification="radial_moving_um = -1.0\nrotation_arcmin = 0.1")
    found, spec = summary(record)["modification"], record.spec.modification
    assert found["radial_clearance_um"] == spec.equidistant_um - 1.0
    # Eq. 32 with a z_c = 50.7 mm and √(1 − K1²) = 0.582961, and twice the rotation.
    by_hand = 2.0 * (spec.equidistant_um - 0.582961) / 50.7e3 * 10800.0 / math.pi + 0.2
    assert found["backlash_arcmin"] == pytest.approx(by_hand, rel=1e-6)
    assert found["backlash_arcmin"] == pytest.approx(summary(record)["conventional"]["backlash_arcmin"], rel=5e-3)


@pytest.mark.slow
def test_compensated_load_can_be_chosen():
    full, half = (
        designed(modification=f"deformation_compensation = true\ncompensation_load_share = {share}")
        for share in (1.0, 0.5)
    )
    assert half.compensation.case.torque == pytest.approx(0.5 * full.compensation.case.torque)
    assert half.compensation.delta_max < full.compensation.delta_max
    # Half the load is less than half the clearance taken up: the deformation goes down by less than half.
    assert half.compensation.delta_max > 0.5 * full.compensation.delta_max
    assert summary(half)["compensation"]["load_share"] == 0.5
    # Accuracy and checks stay those of the rated torque.
    assert half.case.torque == full.case.torque
    assert half.under_load.torque[0] == full.case.torque


@pytest.mark.slow
def test_whole_stage_can_find_the_deformation():
    record = designed(modification='deformation_compensation = true\ncompensation_solver = "stage"')
    alone = designed(modification="deformation_compensation = true")
    assert record.compensation.sharing.solver == "stage"
    assert record.compensation.delta_max == pytest.approx(alone.compensation.delta_max, rel=0.05)


def test_bearing_play_comes_from_the_spec_file():
    tight, loose = designed(), designed(cranks="bearing_play_um = 5.0")
    added = (loose.conventional_accuracy.lost_motion - tight.conventional_accuracy.lost_motion) * 36.0
    # Twice the radial play over the crank circle, less what the first torque takes up.
    assert added == pytest.approx(2.0 * 5e-3, rel=0.03)
    with pytest.raises(SpecError, match="bearing_play_um"):
        designed(cranks="bearing_play_um = -1.0")


def test_figures_under_load_are_those_of_the_stage():
    record = designed()
    figures = summary(record)["under_load"]
    assert figures["max_force_n"] == record.under_load.max_force
    assert figures["max_subsurface_shear_mpa"] == pytest.approx(0.3003 * figures["max_pressure_mpa"], rel=1e-3)
    assert 0.0 < figures["mesh_loss_w"] < 0.1 * 412.0 * 2.0 * np.pi * 15.0 / 60.0
    assert 0.8 < figures["efficiency"] < 1.0
    assert figures["residual"] < 1e-9
    assert msgspec.json.encode(figures)


def test_rollers_report_their_stiffness():
    # Stiffer than the spring under load, and looser by their clearance at rest.
    spring, rollers = (
        designed(cranks=f"[drive.crank_bearing]\nroller_count = 14\n{more}\n[disc]\ncrank_hole_radius_mm = 13.0")
        for more in ("", "radial_clearance_um = 5.0")
    )
    sprung, rolling = (summary(one)["under_load"] for one in (spring, rollers))
    assert (sprung["crank_bearing_model"], rolling["crank_bearing_model"]) == ("spring", "rollers")
    assert sprung["crank_bearing_stiffness_n_per_mm"] == 4e5
    assert sprung["roller_passage_variation"] is None
    assert rolling["crank_bearing_clearance_um"] == pytest.approx(5.0)
    assert 4e5 < rolling["crank_bearing_stiffness_n_per_mm"] < 7e5
    assert 0.0 < rolling["roller_passage_variation"] < 0.02
    lost = [one.conventional_accuracy.lost_motion for one in (spring, rollers)]
    assert lost[1] - lost[0] > 2.0 * 2.5 * UM / 36.0
