"""Tolerances from the tables of a spec file: what they become, and every refusal one sentence with its remedy."""

from __future__ import annotations

import math
from typing import Any

import pytest

from cycloid_profile.contact import LoadCase
from cycloid_profile.effects import EFFECTS, AsBuiltReducer, as_drawn, parameters
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import CentralEccentric, Drive, Trochoid
from cycloid_profile.modification import Equidistant, modify
from cycloid_profile.tolerance.inputs import Rayleigh, tolerances_of, typical_tolerances
from cycloid_profile.tolerance.inputs.distribution import Normal, Triangular, Uniform

BODY = {"name": "equidistant_error", "amount_um": {"plus_minus": 2.0}}
PIN = {"name": "single_pin_error", "each": "pin", "amount_um": {}}
RUNOUT = {"name": "disc_runout", "amplitude_um": {"plus_minus": 2.0}}


@pytest.fixture(scope="module")
def plain() -> AsBuiltReducer:
    """One disc on a central eccentric: no cranks, no planets."""
    drive = Drive(Trochoid(11, 25.0, 1.2), 2.5, 8.0, 1, CentralEccentric(2e4))
    return as_drawn(LoadCase(drive, modify(drive.theoretical_profile, Equidistant(0.02)), 5e3))


def size(**given: Any) -> dict[str, Any]:
    return {**BODY, "amount_um": given}


# What they become.


def test_plus_minus_is_three_sigma_over_cp(scattered):
    (one,) = scattered(size(plus_minus=3.0, cp=1.25, mean=0.5)).scatters
    assert one.size == Normal(0.5, 0.8)
    assert one.plus_minus == 3.0
    assert (one.unit, one.parameter) == ("µm", "equidistant_error.amount_um")
    (cut,) = scattered(size(plus_minus=3.0, inspected=True)).scatters
    assert cut.size == Normal(0.0, 1.0, 3.0)
    (bare,) = scattered(size(sigma=0.4)).scatters
    assert (bare.size, bare.plus_minus) == (Normal(0.0, 0.4), None)
    (even,) = scattered(size(plus_minus=3.0, distribution="uniform")).scatters
    assert even.size == Uniform(0.0, 3.0)
    (peaked,) = scattered(size(plus_minus=3.0, distribution="triangular")).scatters
    assert peaked.size == Triangular(0.0, 3.0)


def test_nothing_said_is_what_the_workshop_holds(scattered):
    for kind in (EFFECTS["equidistant_error"], EFFECTS["single_pin_error"], EFFECTS["disc_runout"]):
        own = next(p for p in parameters(kind) if p.tolerance is not None)
        (one,) = scattered({"name": kind.name, own.name: {}}).scatters
        assert one.plus_minus == own.tolerance


def test_an_offset_points_anywhere_and_has_a_length(scattered):
    (one,) = scattered(RUNOUT).scatters
    assert isinstance(one.size, Rayleigh)
    assert one.angle_deg == Uniform(0.0, 180.0)
    assert one.components
    # Half of what a run-out indicator reads; an inspected one is cut off, so that its components are not normal.
    (cut,) = scattered({**RUNOUT, "amplitude_um": {"plus_minus": 2.0, "inspected": True}}).scatters
    assert (cut.size.limit, cut.components) == (2.0, False)


def test_each_part_has_its_own(scattered, small):
    (pins,) = scattered(PIN).scatters
    assert [choice["pin"] for choice in pins.choices] == list(range(1, 12))
    (bores,) = scattered({"name": "crank_hole_error", "each": ["disc", "crank"], "amplitude_um": {}}).scatters
    assert [(one["disc"], one["crank"]) for one in bores.choices] == [(d, c) for d in (1, 2) for c in (1, 2, 3)]
    (bores,) = scattered({"name": "carrier_bore_error", "each": "crank", "amplitude_um": {}}).scatters
    assert [one["crank"] for one in bores.choices] == [1, 2, 3]
    (planets,) = scattered({"name": "planet_runout", "each": "planet", "amplitude_um": {}}).scatters
    assert [one["planet"] for one in planets.choices] == [1, 2, 3]
    (teeth,) = scattered({"name": "single_tooth_error", "each": ["disc", "lobe"], "amount_um": {}}).scatters
    assert len(teeth.choices) == small.discs * small.case.drive.trochoid.lobes
    (common,) = scattered(BODY).scatters
    assert common.choices == ({},)


def test_what_is_a_number_is_fixed(scattered):
    (one,) = scattered({"name": "single_pin_error", "pin": 3, "amount_um": {}}).scatters
    assert one.choices == ({"pin": 3},)
    (waves,) = scattered({"name": "grinding_chatter", "amplitude_um": {}, "waves_per_turn": 500.0}).scatters
    assert waves.choices == ({"waves_per_turn": 500.0},)


def test_names_are_distinguished(scattered):
    labels = [one.label for one in scattered(BODY, BODY, PIN).scatters]
    assert len(set(labels)) == 3
    assert [one.label for one in scattered({**BODY, "label": "wheel"}, PIN).scatters] == ["wheel", "single_pin_error"]


@pytest.mark.parametrize("value", [-0.99, 0.0, 0.3])
def test_correlations_that_can_be_are_taken(scattered, value):
    asked = ({"between": ["equidistant_error.amount_um", "disc_runout.amplitude_um"], "value": value},)
    (found,) = scattered(BODY, RUNOUT, correlations=asked).correlations
    assert (found.first, found.second, found.value) == (0, 1, value)


def test_a_workshop_has_tolerances_for_any_drive(small, plain):
    for reducer in (small, plain):
        tolerances = typical_tolerances(reducer)
        assert tolerances.assumed
        assert len({one.label for one in tolerances.scatters}) == len(tolerances.scatters)
        assert all(one.size.standard_deviation > 0.0 for one in tolerances.scatters)


def test_every_effect_can_be_a_tolerance_or_says_why_not(scattered):
    refused = set()
    for name, kind in EFFECTS.items():
        if name == "flank_wear":
            continue  # solves for its pressures first; all else of it is as of the others
        own = next(p for p in parameters(kind) if p.tolerance is not None)
        mean = {"mean": own.tolerance, "plus_minus": 0.1 * own.tolerance} if own.name.startswith("stiff") else {}
        try:
            (one,) = scattered({"name": name, own.name: mean}).scatters
        except SpecError:
            refused.add(name)
        else:
            assert one.kind is kind
    assert refused == {
        "coulomb_friction", "elastoslide_friction", "stribeck_friction", "load_proportional_friction",
        "pin_support_compliance", "crank_bearing_compliance",
    }  # fmt: skip


# What cannot be.

WRONG: dict[str, tuple[dict[str, Any], str, str]] = {
    "unknown effect": ({**BODY, "name": "equidistant_eror"}, "name", "did you mean equidistant_error?"),
    "no name": ({"amount_um": {}}, "name", "see docs/effects.md"),
    "unknown key": ({**BODY, "amont_um": {}}, "amont_um", "did you mean amount_um?"),
    "unknown key of a size": (size(plus_minsu=1.0), "amount_um.plus_minsu", "amount_um.plus_minus?"),
    "negative plus_minus": (size(plus_minus=-1.0), "amount_um.plus_minus", "give a number from"),
    "negative sigma": (size(sigma=-1.0), "amount_um.sigma", "give a number from"),
    "no number": (size(sigma="wide"), "amount_um.sigma", "give a number"),
    "a truth": (size(plus_minus=True), "amount_um.plus_minus", "give a number"),
    "not a number": (size(sigma=math.nan), "amount_um.sigma", "give a number"),
    "beyond every float": (size(sigma=10**400), "amount_um.sigma", "give a number"),
    "both widths": (size(sigma=1.0, plus_minus=3.0), "amount_um.sigma", "give one of them"),
    "sigma of a uniform": (size(sigma=1.0, distribution="uniform"), "amount_um.sigma", "give plus_minus"),
    "sigma inspected": (size(sigma=1.0, inspected=True), "amount_um.sigma", "give plus_minus"),
    "sigma with cp": (size(sigma=1.0, cp=1.3), "amount_um.cp", "give plus_minus"),
    "cp of zero": (size(plus_minus=1.0, cp=0.0), "amount_um.cp", "give a number from"),
    "mean out of bounds": (size(mean=1e4), "amount_um.mean", "give a number within"),
    "unknown distribution": (size(distribution="weibull"), "amount_um.distribution", "choose from"),
    "a list for a distribution": (size(distribution=["normal"]), "amount_um.distribution", "choose from"),
    "Rayleigh of a signed size": (size(distribution="rayleigh"), "amount_um.distribution", "choose normal"),
    "Rayleigh of a signed size by sigma": (
        size(distribution="rayleigh", sigma=1.0), "amount_um.distribution", "choose normal",
    ),
    "Rayleigh with a mean": (
        {**RUNOUT, "amplitude_um": {"mean": 2.0, "plus_minus": 1.0}}, "amplitude_um.distribution", "choose normal",
    ),
    "Rayleigh with a mean by sigma": (
        {**RUNOUT, "amplitude_um": {"mean": 2.0, "sigma": 1.0}}, "amplitude_um.distribution", "choose normal",
    ),
    "Rayleigh inspected by sigma": (
        {**RUNOUT, "amplitude_um": {"inspected": True, "sigma": 1.0}}, "amplitude_um.sigma", "give plus_minus",
    ),
    "inspected is a word": (size(inspected="no"), "amount_um.inspected", "true or false"),
    "no size": ({"name": "equidistant_error"}, "amount_um", "give amount_um = { plus_minus = "),
    "size is a number": ({**BODY, "amount_um": 2.0}, "amount_um", "give amount_um = { plus_minus = "),
    "size is a word": ({**BODY, "amount_um": "wide"}, "amount_um", "give amount_um = { plus_minus = "),
    "two sizes": (
        {"name": "grinding_chatter", "amplitude_um": {}, "waves_per_turn": {}}, "waves_per_turn", "give one of them",
    ),
    "a part that scatters": ({"name": "single_pin_error", "amount_um": {}, "pin": {}}, "pin", "each"),
    "unknown part": ({**PIN, "each": "tooth"}, "each", "choose from pin"),
    "a part the effect has not": ({**BODY, "each": "pin"}, "each", "choose from disc"),
    "a part of an effect without": (
        {"name": "pin_radius_error", "each": "pin", "amount_um": {}}, "each", "leave 'each' out",
    ),
    "a number for parts": ({**PIN, "each": 3}, "each", "choose from pin"),
    "a list in parts": ({**PIN, "each": [["pin"]]}, "each", "choose from pin"),
    "a part twice": ({**BODY, "each": ["disc", "disc"]}, "each", "once"),
    "a part fixed and free": ({**PIN, "pin": 3}, "each", "leave one of them out"),
    "a part beyond the count": ({"name": "single_pin_error", "pin": 12, "amount_um": {}}, "pin", "1 to 11"),
    "a part that is no number": ({"name": "single_pin_error", "pin": "three", "amount_um": {}}, "pin", "pin"),
    "a direction out of bounds": ({**RUNOUT, "phase_deg": {"mean": 1e5}}, "phase_deg.mean", "give a number from"),
    "a direction too wide": ({**RUNOUT, "phase_deg": {"plus_minus": 200}}, "phase_deg.plus_minus", "from 0 to 180"),
    "a direction with another key": ({**RUNOUT, "phase_deg": {"sigma": 1.0}}, "phase_deg.sigma", "mean"),
    "a direction that is a word": ({**RUNOUT, "phase_deg": "north"}, "phase_deg", "angle"),
    "a share above one": ({**BODY, "batch_share": 1.2}, "batch_share", "give a number from"),
    "negative neighbours": ({**PIN, "neighbours": -1.0}, "neighbours", "give a number from"),
    "neighbours of one part": ({**BODY, "neighbours": 2.0}, "neighbours", "each"),
    "a cost that is no number": ({**BODY, "cost": "dear"}, "cost", "give a number"),
    "a cost below zero": ({**BODY, "cost": -1.0}, "cost", "give a number from"),
    "finest above coarsest": ({**BODY, "cost": 1.0, "finest": 2.0, "coarsest": 1.0}, "finest", "swap them"),
    "a stiffness that can be none": (
        {"name": "series_compliance", "stiffness_nm_per_arcmin": {"mean": 100.0, "plus_minus": 80.0}},
        "stiffness_nm_per_arcmin", "narrower",
    ),
    "a shape that scatters": ({"name": "flank_wear", "amount_um": {}, "exponent": {}}, "exponent", "give its value"),
    "friction": ({"name": "coulomb_friction", "torque_nm": {}}, "name", "[[effects]]"),
    "friction by load": ({"name": "load_proportional_friction", "coefficient": {}}, "name", "[[effects]]"),
    "a property of the design": ({"name": "pin_support_compliance", "added_um_per_kn": {}}, "name", "[[effects]]"),
}  # fmt: skip


def sentence_of(caught: pytest.ExceptionInfo[SpecError]) -> str:
    error = caught.value
    assert error.what
    assert error.limit
    assert error.remedy
    sentence = str(error)
    assert "\n" not in sentence
    assert len(sentence) < 1000
    return sentence


@pytest.mark.parametrize("wrong", WRONG)
def test_what_cannot_be_is_refused_in_one_sentence(scattered, wrong):
    table, key, remedy = WRONG[wrong]
    with pytest.raises(SpecError) as caught:
        scattered(PIN, table)
    sentence = sentence_of(caught)
    # The second table, the key at fault, and what to do.
    assert sentence.startswith("tolerance.effects[2]")
    assert key in caught.value.what
    assert remedy in caught.value.remedy


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"name": "crank_hole_error", "each": "crank", "amplitude_um": {}}, "a part this drive has not"),
        ({"name": "crank_hole_error", "amplitude_um": {}}, "which this drive has not"),
        ({"name": "planet_runout", "each": "planet", "amplitude_um": {}}, "a part this drive has not"),
        ({"name": "planet_runout", "amplitude_um": {}}, "which this drive has not"),
        ({"name": "disc_runout", "disc": 2, "amplitude_um": {}}, "more than there are"),
    ],
)
def test_what_the_drive_has_not_is_refused(plain, table, said):
    with pytest.raises(SpecError) as caught:
        tolerances_of([table], [], plain)
    assert said in sentence_of(caught)


A, B, C = "equidistant_error.amount_um", "radial_moving_error.amount_um", "disc_runout.amplitude_um"


@pytest.mark.parametrize(
    ("between", "said"),
    [
        ([{"between": [A, B], "value": 1.0}], "positive definite"),
        ([{"between": [A, B], "value": 0.9}, {"between": [B, C], "value": 0.9}, {"between": [A, C], "value": -0.9}],
         "positive definite"),
        ([{"between": [A, B], "value": 1.5}], "must be <= 1.0: give a number from -1 to 1"),
        ([{"between": [A, B], "value": "much"}], "give a number from -1 to 1"),
        ([{"between": [A, B]}], "is missing"),
        ([{"between": [A, A], "value": 0.5}], "are not two tolerances"),
        ([{"between": [A, "single_pin_error.amount_um"], "value": 0.5}], "as many parts"),
        ([{"between": [A], "value": 0.5}], "is not two names"),
        ([{"between": A, "value": 0.5}], "is not two names"),
        ([{"value": 0.5}], "is not two names"),
        ([{"between": [A, "radial_error.amount_um"], "value": 0.5}], "did you mean radial_moving_error.amount_um?"),
        ([{"between": [A, 3], "value": 0.5}], "is none of the tolerances"),
        ([{"between": [A, B], "value": 0.5}, {"between": [B, A], "value": 0.2}], "is given twice"),
        ([{"between": [A, B], "vlaue": 0.5}], "correlations[1].value?"),
    ],
)  # fmt: skip
def test_correlations_that_cannot_be_are_refused(scattered, between, said):
    tables = (BODY, {"name": "radial_moving_error", "amount_um": {}}, RUNOUT, PIN)
    with pytest.raises(SpecError) as caught:
        scattered(*tables, correlations=tuple(between))
    sentence = sentence_of(caught)
    assert sentence.startswith("tolerance.correlations")
    assert said in sentence
