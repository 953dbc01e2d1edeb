"""Contracts of the effects: names, parameters and bounds, tables of a spec file there and back, and refusals."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
import pytest
import tomli_w
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import (
    EFFECTS,
    Effect,
    EffectLocation,
    ReducerChange,
    apply_effects,
    as_drawn,
    effect_from_table,
    effect_to_table,
    parameters,
)
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.spec import parse_spec
from cycloid_profile.spec.model import EFFECT_NAMES
from cycloid_profile.units import ARCMIN
from tests.spec_texts import DRIVE

UNITS = {
    "_um": "[µm]",
    "_deg": "[°]",
    "_k": "[K]",
    "_nm": "[N·m]",
    "_arcmin": "[arcmin]",
    "_arcsec": "[arcsec]",
    "_um_per_kn": "[µm/kN]",
    "_nm_per_arcmin": "[N·m/′]",
}
# A ratio and a count have no unit.
PLAIN = {"coefficient", "waves_per_turn"}
SHAPES = {
    "exponent", "relaxation_share", "spread", "breakaway_ratio", "travel_share", "load_share", "start_in_lobe",
    "blend_rad",
}  # fmt: skip
PARTS = {"disc", "crank", "planet", "pin", "lobe", "first_lobe", "flank", "form", "waves"}
# How many there are of each part in an RV-40E; flank and form are choices of two, waves at most twenty.
COUNT = {
    "disc": 2,
    "crank": 3,
    "planet": 3,
    "pin": 40,
    "lobe": 39,
    "first_lobe": 39,
    "flank": 2,
    "form": 2,
    "waves": 20,
}
NEEDS_CRANKS = {
    "crank_eccentricity_error", "crank_phase_error", "crank_hole_error", "carrier_bore_error", "planet_runout",
    "common_planet_runout", "sun_runout",
}  # fmt: skip
every = pytest.mark.parametrize("name", sorted(EFFECTS))


def values_of(kind: type[Effect], required_only: bool = False) -> dict[str, Any]:
    """Some values that can be, sizes as the workshop holds them."""
    chosen: dict[str, Any] = {}
    for p in parameters(kind):
        if p.required or not required_only:
            number = 1 if p.whole else p.tolerance or (0.5 if p.name in SHAPES else 30.0)
            chosen[p.name] = p.options[-1] if p.options else number
    return chosen


def tables_of(name: str) -> st.SearchStrategy[dict[str, Any]]:
    """Tables with any allowed values, optional ones there or not."""
    sure, may = {}, {}
    for p in parameters(EFFECTS[name]):
        number = st.integers(1, COUNT[p.name]) if p.whole else st.floats(p.low, p.high)
        (sure if p.required else may)[p.name] = st.sampled_from(p.options) if p.options else number
    return st.fixed_dictionaries({"name": st.just(name), **sure}, optional=may)


@every
@given(st.data())
def test_a_table_comes_back_as_the_same_effect(name, data):
    wanted = data.draw(tables_of(name))
    made = effect_from_table(wanted)
    assert made == effect_from_table(effect_to_table(made))
    # Everything the user gave is in it, through the text of a spec file too.
    assert wanted.items() <= effect_to_table(made).items()
    spec = parse_spec(tomli_w.dumps({"effects": [effect_to_table(made)]}) + DRIVE)
    assert effect_from_table(spec.effects[0]) == made
    assert hash(made) == hash(effect_from_table(wanted))


@every
def test_notes_of_a_diagnosis_are_no_parameters(name):
    given = {"name": name, **values_of(EFFECTS[name], required_only=True)}
    noted = {**given, "uncertainty": {"amount_um": 0.1}, "origin": "scan.csv"}
    assert effect_from_table(noted) == effect_from_table(given)


@every
def test_bounds_hold(name):
    kind = EFFECTS[name]
    for p in (p for p in parameters(kind) if not p.options):
        for bad in (p.low - 1.0, p.high + 1.0):
            with pytest.raises(SpecError) as refused:
                kind(**{**values_of(kind), p.name: int(bad) if p.whole else bad})
            assert refused.value.what == f"{name}.{p.name}"
            assert refused.value.limit.startswith("is outside")
        kind(**{**values_of(kind), p.name: int(p.low) if p.whole else p.low})


@every
def test_values_that_are_not_numbers_are_refused(name):
    kind = EFFECTS[name]
    bad_values = (math.nan, math.inf, -math.inf, "3", True, [1.0])
    for p, bad in itertools.product(parameters(kind), bad_values):
        with pytest.raises(SpecError, match="is not a") as refused:
            kind(**{**values_of(kind), p.name: bad})
        assert refused.value.what == f"{name}.{p.name}"


@pytest.mark.parametrize(("word", "remedy"), [("c_axes", "did you mean c_axis?"), ("xyzzy", "choose from generating,")])
def test_a_word_that_is_no_choice_brings_the_nearest_or_all(word, remedy):
    with pytest.raises(SpecError, match="is not a choice") as refused:
        effect_from_table(
            {"name": "grinding_chatter", **values_of(EFFECTS["grinding_chatter"]), "constant_speed": word}
        )
    assert refused.value.remedy.startswith(remedy)


@every
def test_half_a_part_is_refused(name):
    kind = EFFECTS[name]
    for p in (p for p in parameters(kind) if p.whole):
        with pytest.raises(SpecError, match="is not a whole number"):
            kind(**{**values_of(kind), p.name: 1.5})


def test_whole_numbers_beyond_every_float_are_refused():
    # TOML can write them.
    with pytest.raises(SpecError, match=r"disc_oval\.amplitude_um"):
        effect_from_table({"name": "disc_oval", "amplitude_um": 10**400})


def test_none_is_all_parts_where_that_is_the_default_and_refused_elsewhere(case):
    # In a table None is a key left out. Where that means part 1 or an angle of 0, None must not mean anything else.
    lost = []
    for name, kind in EFFECTS.items():
        for p in parameters(kind):
            try:
                made = kind(**{**values_of(kind), p.name: None})
            except SpecError:
                continue
            if effect_from_table(effect_to_table(made)) == made:
                apply_effects(case, [made])
            else:
                lost.append(f"{name}.{p.name}")
    assert not lost


@every
def test_a_part_beyond_the_count_is_refused(name, case):
    kind = EFFECTS[name]
    for p in (p for p in parameters(kind) if p.whole):
        with pytest.raises(SpecError) as refused:
            apply_effects(case, [kind(**{**values_of(kind), p.name: COUNT[p.name] + 1})])
        assert refused.value.what == f"{name}.{p.name}"
        assert str(COUNT[p.name]) in f"{refused.value.limit} {refused.value.remedy}"


@every
def test_a_missing_size_is_asked_for(name):
    for p in (p for p in parameters(EFFECTS[name]) if p.required):
        given = {"name": name, **values_of(EFFECTS[name])}
        del given[p.name]
        with pytest.raises(SpecError, match="is required") as refused:
            effect_from_table(given)
        assert refused.value.what == f"{name}.{p.name}"
        assert p.text in refused.value.remedy


@every
def test_a_misspelled_parameter_brings_the_nearest(name):
    for p in parameters(EFFECTS[name]):
        misspelled = p.name[:1] + p.name[2:]
        given = {"name": name, **values_of(EFFECTS[name]), misspelled: 1.0}
        with pytest.raises(SpecError, match="is not a parameter of this effect") as refused:
            effect_from_table(given)
        assert refused.value.what == f"{name}.{misspelled}"
        assert refused.value.remedy == f"did you mean {p.name}?"


@every
def test_a_misspelled_name_brings_the_nearest(name):
    with pytest.raises(SpecError, match="is not known") as refused:
        effect_from_table({"name": name[:2] + name[3:]})
    assert refused.value.remedy == f"did you mean {name}? (an effect of a plug-in needs --plugin)"


@pytest.mark.parametrize("name", ["", "xyzzy", 7, None])
def test_a_name_like_no_other_is_refused(name):
    with pytest.raises(SpecError, match="is not known"):
        effect_from_table({"name": name, "amount_um": 1.0})


def test_names_are_those_of_the_spec_file():
    assert set(EFFECTS) == EFFECT_NAMES
    assert all(kind.name == name for name, kind in EFFECTS.items())


@every
def test_every_effect_has_its_description_and_cure(name):
    kind = EFFECTS[name]
    assert kind.__doc__ is not None
    assert len(kind.__doc__) > 30
    assert kind.remedy
    assert isinstance(kind.location, EffectLocation)
    # Frozen and comparable, so that it can be a key.
    made = kind(**values_of(kind))
    assert {made: 1}[kind(**values_of(kind))] == 1


@every
def test_every_parameter_has_its_unit_and_every_size_its_tolerance(name):
    sizes = 0
    for p in parameters(EFFECTS[name]):
        if p.options:
            assert not p.required
            assert len(set(p.options)) > 1
            continue
        assert p.low < p.high
        if p.whole:
            assert p.name in PARTS
            assert p.tolerance is None
            continue
        if p.name in SHAPES:
            assert not p.required
            assert p.text.endswith("[rad]") if p.name.endswith("_rad") else not p.text.endswith("]")
            continue
        unit = max((suffix for suffix in UNITS if p.name.endswith(suffix)), key=len, default=None)
        if unit is None:
            assert p.name in PLAIN
        else:
            assert p.text.endswith(UNITS[unit])
        if p.name.endswith("_deg"):
            assert p.tolerance is None
            assert not p.required
            continue
        sizes += 1
        assert p.required
        assert p.tolerance is not None
        assert 0.0 < p.tolerance <= p.high
    assert sizes >= 1


@every
def test_no_size_is_no_effect(name, case):
    kind = EFFECTS[name]
    sized = [p.name for p in parameters(kind) if p.required and p.low <= 0.0]
    none = apply_effects(case, [kind(**{**values_of(kind), **dict.fromkeys(sized, 0.0)})])
    if name == "series_compliance":
        # Its size is a stiffness: the larger the less.
        assert kind(stiffness_nm_per_arcmin=1e6).apply(as_drawn(case)).series_compliance < 1e-3 / case.torque
        return
    drawn = as_drawn(case)
    assert none.series_compliance == drawn.series_compliance
    assert not np.any(none.series_twist(np.array([-1.0, 1.0]) * case.torque))
    assert (none.coulomb_torque, none.proportional_friction, none.encoder) == (0.0, 0.0, 0j)
    assert (none.breakaway_torque, none.friction_spread) == (0.0, 0.0)
    assert (none.sun_shift, none.input_error) == (0j, 0j)
    for part in ("pin_shift", "pin_oversize", "eccentric_shift", "bore_shift", "crank_lead"):
        assert not getattr(none, part).any()
    psi = [[0.7, 100.0, 200.0]]
    for tooth in none.teeth:
        assert abs(tooth.at(psi).position - case.profile.at(psi).position).max() < 1e-12


@every
def test_effects_build_on_a_drive_of_another_kind_or_say_why_not(name):
    # One disc on a central eccentric, eleven pins, no first stage.
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    case = LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 5e3)
    made = EFFECTS[name](**values_of(EFFECTS[name]))
    if name in NEEDS_CRANKS:
        with pytest.raises(SpecError, match="which this drive has not") as refused:
            apply_effects(case, [made])
        assert refused.value.what == name
    else:
        reducer = apply_effects(case, [made])
        reducer.deviations.check(drive)
        assert len(reducer.teeth) == 1


def test_a_softer_series_twists_further_in_proportion(case, built_with):
    stiff, soft = (
        built_with({"name": "series_compliance", "stiffness_nm_per_arcmin": stiffness}) for stiffness in (134.0, 100.0)
    )
    torque = np.array([-1.0, 0.0, 0.5]) * case.torque
    expected = torque * 1e-3 * (1.0 / 100.0 - 1.0 / 134.0) * ARCMIN
    np.testing.assert_allclose(ReducerChange(stiff, soft).series_twist(torque), expected, rtol=1e-12)
    # Per unit of a parameter: half as much for a step of two.
    np.testing.assert_allclose(ReducerChange(stiff, soft, 2.0).series_twist(torque), 0.5 * expected, rtol=1e-12)
