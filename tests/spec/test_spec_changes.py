"""Specs changed and built in Python: the checks and messages are those of a file."""

from __future__ import annotations

from typing import Any

import msgspec
import numpy as np
import pytest

from cycloid_profile.errors import SpecError
from cycloid_profile.spec import Spec, parse_spec
from cycloid_profile.spec.model import CranksSpec, DriveSpec
from tests.spec_texts import PLAIN, RV40E

DRIVE = {
    "pins": 11, "pin_circle_radius_mm": 30.0, "pin_radius_mm": 3.0, "eccentricity_mm": 1.5, "disc_width_mm": 8.0,
    "discs": 1,
}  # fmt: skip


@pytest.fixture(scope="module")
def spec() -> Spec:
    return parse_spec(RV40E)


def test_one_key_is_replaced_and_the_rest_kept(spec: Spec) -> None:
    changed = spec.replace("load.contact_law", "johnson")
    assert changed == msgspec.structs.replace(spec, load=msgspec.structs.replace(spec.load, contact_law="johnson"))
    assert spec.load.contact_law is None


def test_several_keys_are_replaced_at_once(spec: Spec) -> None:
    changed = spec.replace({
        "drive.pins": 30,
        "modification.equidistant_um": np.float64(4.0),
        "drive.cranks": CranksSpec(count=2, circle_radius_mm=30.0),
        "drive.first_stage": None,
        "disc.windows": {"count": 3, "inner_radius_mm": 20.0, "outer_radius_mm": 40.0, "span_deg": 30.0},
        "effects": [{"name": "disc_runout", "amplitude_um": 2.0}],
    })  # fmt: skip
    assert (changed.drive.pins, changed.modification.equidistant_um) == (30, 4.0)
    assert changed.drive.cranks is not None
    assert changed.drive.cranks.count == 2
    assert changed.drive.first_stage is None
    assert changed.disc.windows is not None
    assert changed.effects[0]["name"] == "disc_runout"


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        ("load.contact_lw", "johnson", "load.contact_lw = \"johnson\" is not a key of the spec file: did you mean"),
        ("contact_law", "johnson", "did you mean load.contact_law?"),
        ("laod.contact_law", "johnson", "did you mean load?"),
        ("drive.pins", 2, "drive.pins = 2 must be >= 3: give 3 to 1000 pins"),
        ("drive.pins", None, "drive.pins = None must be of type int, not null"),
        ("drive.pin_radius_um", 3000, "write pin_radius_mm = 3"),
        ("load.contact_law", "jonson", "choose from roark, johnson"),
        ("name.first", "x", "name = {…} must be of type str, not object"),
        ("drive.cranks.count", 3, ""),
        ("drive.first_stage", {"sun_teeth": 12}, "drive.first_stage.planet_teeth is missing though it has no default"),
        ("modification.equidistant_um", np.nan, "is not a finite number"),
        ("effects", [{"name": "disk_runout"}], "did you mean disc_runout?"),
    ],
)  # fmt: skip
def test_a_refused_change_says_why_in_one_sentence(spec: Spec, path: str, value: Any, says: str) -> None:
    if not says:
        assert spec.replace(path, value) == spec
        return
    with pytest.raises(SpecError) as caught:
        spec.replace(path, value)
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_tables_may_be_given_as_dictionaries() -> None:
    spec = Spec(name="plain", drive=DRIVE, modification={"equidistant_um": 20.0})  # type: ignore[arg-type]
    assert spec == parse_spec(PLAIN)
    drive = DriveSpec(**DRIVE, cranks={"count": 3, "circle_radius_mm": 15.0})  # type: ignore[arg-type]
    assert drive.cranks == CranksSpec(count=3, circle_radius_mm=15.0)


@pytest.mark.parametrize(
    ("drive", "says"),
    [
        (DRIVE | {"pinz": 11}, "drive.pinz = 11 is not a key of the spec file: did you mean drive.pins?"),
        (DRIVE | {"pins": 2}, "drive.pins = 2 must be >= 3: give 3 to 1000 pins"),
        (DRIVE | {"cranks": {"count": 3}}, "drive.cranks.circle_radius_mm is missing though it has no default"),
        (5, "drive = 5 must be of type object, not int"),
    ],
)
def test_a_dictionary_that_is_no_table_is_refused(drive: Any, says: str) -> None:
    with pytest.raises(SpecError) as caught:
        Spec(drive=drive)
    assert says in str(caught.value)


def test_a_misspelt_attribute_offers_the_nearest(spec: Spec) -> None:
    with pytest.raises(AttributeError, match=r"DriveSpec\.pinz does not exist: did you mean pins\?"):
        _ = spec.drive.pinz  # type: ignore[attr-defined]
    with pytest.raises(AttributeError, match=r"did you mean replace\?"):
        _ = spec.replce  # type: ignore[attr-defined]


def test_repr_is_short_and_names_the_drive(spec: Spec) -> None:
    text = repr(spec)
    assert len(text.splitlines()) <= 15
    assert all(part in text for part in ("RV-40E", "40, 39", "64 mm", "1.3 mm", "412 N·m", "equidistant 6 µm"))
