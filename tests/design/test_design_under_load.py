"""What a design says of itself under load: checks with value, limit and remedy, and the keys that steer them."""

from __future__ import annotations

import typing

import msgspec
import numpy as np
import pytest

from cycloid_profile.contact.laws import LAWS
from cycloid_profile.design.from_spec import STEEL_FATIGUE_LIMIT, allowable_pressure
from cycloid_profile.design.record import design_disc
from cycloid_profile.design.summary import summary
from cycloid_profile.errors import SpecError
from cycloid_profile.spec.load import LoadSpec
from cycloid_profile.spec.read import parse_spec
from tests.spec_texts import CRANKS, DRIVE

DESIGN = f"""{DRIVE}{CRANKS}{{cranks}}
[load]
rated_torque_nm = {{torque}}
{{load}}
[modification]
equidistant_um = {{equidistant}}
{{modification}}
"""


def designed(**changes):
    words = {"cranks": "", "torque": 412.0, "load": "", "equidistant": 6.0, "modification": "", **changes}
    return design_disc(parse_spec(DESIGN.format(**words)))


def check(record, name):
    return next(c for c in record.checks if c.name.startswith(name))


def test_spec_file_offers_every_contact_law():
    annotation = typing.get_type_hints(LoadSpec, include_extras=True)["contact_law"]
    assert set(typing.get_args(typing.get_args(annotation)[0])) == set(LAWS)
    for name in LAWS:
        assert designed(load=f'contact_law = "{name}"').case.law is LAWS[name]


def test_sound_design_passes_every_check():
    record = designed()
    assert [c.name for c in record.checks if not c.passed] == []
    assert len(record.checks) == 9
    assert record.failures == ()


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
    text = DESIGN.format(cranks="", torque=20.0, load="", equidistant=50.0, modification="")
    record = design_disc(parse_spec(text.replace("[load]", "[materials.disc]\nyoungs_modulus_gpa = 2.5\n[load]")))
    assert allowable_pressure(record.spec) is None
    assert not any(c.name.startswith("peak pressure") for c in record.checks)
    given = design_disc(parse_spec(text.replace("[load]", plastic)))
    assert any(c.name.startswith("peak pressure") for c in given.checks)


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


def test_law_outside_its_range_is_told():
    text = DESIGN.format(cranks="", torque=20.0, load='contact_law = "palmgren"', equidistant=50.0, modification="")
    plastic = text.replace("[load]", "[materials.disc]\nyoungs_modulus_gpa = 2.5\n[load]", 1)
    record = design_disc(parse_spec(plastic))
    law = check(record, "contact law (palmgren)")
    assert not law.passed
    assert "steel" in law.limit


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
