"""The spec file in and out: round trips, defaults, schema, and the parts of a refusal."""

from __future__ import annotations

import json
import math
import tomllib
from pathlib import Path

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.errors import SpecError
from cycloid_profile.spec import SCHEMA_FILE, Spec, format_spec, parse_spec, read_spec, spec_schema
from cycloid_profile.spec.model import EFFECT_NAMES, CranksSpec, DriveSpec, ExportSpec, ModificationSpec
from cycloid_profile.spec.model.export import FORMATS

ROOT = Path(__file__).parents[2]
RV40E = ROOT / "examples" / "rv40e.toml"
TEXT = RV40E.read_text(encoding="utf-8")
SHORT = """
[drive]
pins = 11
pin_circle_radius_mm = 30.0
pin_radius_mm = 3.0
eccentricity_mm = 1.5
disc_width_mm = 8.0
discs = 2
"""


def refusal(old: str, new: str) -> SpecError:
    """The error that the RV-40E file raises with ``old`` replaced."""
    assert old in TEXT
    with pytest.raises(SpecError) as caught:
        parse_spec(TEXT.replace(old, new))
    return caught.value


def test_a_hobbyists_file_of_eight_lines_reads_with_sensible_defaults() -> None:
    spec = parse_spec(SHORT)
    assert spec.drive.cranks is None
    assert spec.drive.first_stage is None
    assert spec.materials.disc.youngs_modulus_gpa == 206.0
    assert spec.modification.deformation_compensation is False
    assert spec.export.formats == FORMATS


def test_the_example_reads_as_written() -> None:
    spec = read_spec(RV40E)
    assert spec.drive == DriveSpec(
        pins=40, pin_circle_radius_mm=64.0, pin_radius_mm=3.0, eccentricity_mm=1.3, disc_width_mm=11.5, discs=2,
        cranks=spec.drive.cranks, first_stage=spec.drive.first_stage,
    )  # fmt: skip
    assert spec.modification.deformation_compensation is True


amounts = st.floats(-500.0, 500.0)
lengths = st.floats(0.01, 1e3)


@given(
    pins=st.integers(3, 300), lengths=st.lists(lengths, min_size=6, max_size=6), amounts=st.tuples(amounts, amounts),
    compensation=st.one_of(st.booleans(), st.floats(0.0, 20.0)), cranks=st.booleans(),
    name=st.text(st.characters(codec="utf-8", exclude_categories=["Cs", "Cc"]), max_size=20),
    formats=st.lists(st.sampled_from(FORMATS), unique=True),
    effect=st.none() | st.sampled_from(sorted(EFFECT_NAMES)),
)  # fmt: skip
def test_any_spec_written_reads_back_equal(
    pins: int, lengths: list[float], amounts: tuple[float, float], compensation: bool | float, cranks: bool,
    name: str, formats: list[str], effect: str | None,
) -> None:  # fmt: skip
    spec = Spec(
        name=name,
        drive=DriveSpec(
            pins=pins, pin_circle_radius_mm=lengths[0], pin_radius_mm=lengths[1], eccentricity_mm=lengths[2],
            disc_width_mm=lengths[3], discs=2,
            cranks=CranksSpec(count=3, circle_radius_mm=lengths[4]) if cranks else None,
        ),
        modification=ModificationSpec(
            equidistant_um=amounts[0], radial_moving_um=amounts[1], deformation_compensation=compensation
        ),
        export=ExportSpec(formats=tuple(formats)),
        effects=() if effect is None else ({"name": effect, "amplitude_um": 1.5},),
    )  # fmt: skip
    assert parse_spec(format_spec(spec)) == spec


def test_written_text_is_plain_toml_that_points_to_its_schema() -> None:
    text = format_spec(read_spec(RV40E))
    assert text.startswith(f"#:schema {SCHEMA_FILE}\n")
    assert tomllib.loads(text)["drive"]["pins"] == 40


def test_committed_schema_is_the_models_own() -> None:
    assert (ROOT / "docs" / SCHEMA_FILE).read_text(encoding="utf-8") == spec_schema()


def test_schema_accepts_what_the_reader_accepts_and_refuses_what_it_refuses() -> None:
    validator = jsonschema.Draft202012Validator(json.loads(spec_schema()))
    raw = tomllib.loads(TEXT)
    validator.validate(raw)
    for table, key, value in (("drive", "pins", 2), ("drive", "pinz", 40), ("load", "rated_torque_nm", 0)):
        wrong = {**raw, table: {**raw[table], key: value}}
        assert not validator.is_valid(wrong), (table, key, value)
    for name in (*EFFECT_NAMES, "sun_runuot"):
        effects = [{"name": name, "amplitude_um": {}}]
        for tables in ({"effects": effects}, {"tolerance": {"effects": effects}}):
            assert validator.is_valid({**raw, **tables}) == (name in EFFECT_NAMES), (name, tables)


@pytest.mark.parametrize(
    ("old", "new", "what", "value", "says"),
    [
        ("pins = 40", "pinz = 40", "drive.pinz", "40", "did you mean drive.pins?"),
        ("pins = 40", "pins = 2", "drive.pins", "2", "must be >= 3"),
        ("pins = 40", "pins = 40.5", "drive.pins", "40.5", "must be of type int"),
        ("pins = 40\n", "", "drive.pins", "is missing", "give 3 to 1000 pins"),
        ("pin_radius_mm = 3.0", "pin_radius_um = 3000", "drive.pin_radius_um", "3000", "write pin_radius_mm = 3"),
        ("pin_radius_mm = 3.0", "pin_radius_gpa = 3", "drive.pin_radius_gpa", "3", "write pin_radius_mm and convert"),
        ("pin_radius_mm = 3.0", "pin_radius = 3.0", "drive.pin_radius", "3.0", "no unit in its key"),
        ("rated_torque_nm = 412.0", "rated_torque_nmm = 4e5", "load.rated_torque_nmm", "400000.0", "torque_nm = 400"),
        ("rated_torque_nm = 412.0", "rated_torque_nm = 0", "load.rated_torque_nm", "0", "must be >= 1e-06"),
        ("disc_width_mm = 11.5", "disc_width_mm = -1", "drive.disc_width_mm", "-1", "must be >= 0.001"),
        ("disc_width_mm = 11.5", "disc_width_mm = nan", "drive.disc_width_mm", "nan", "not a finite number"),
        ("disc_share = 0.55", "disc_share = 1.5", "load.disc_share", "1.5", "must be <= 1"),
        ("poisson_ratio = 0.3", "poisson_ratio = 0.5", "materials.disc.poisson_ratio", "0.5", "must be < 0.5"),
        ('"dxf"', '"dwg"', "export.formats[0]", '"dwg"', "choose from csv, dxf, "),
        ("deformation_compensation = true", 'deformation_compensation = "on"', "modification.deformation_compensation",
         '"on"', "give true, false or delta_max"),
        ("discs = 2", "discs = 2\nrated_torque_nm = 4", "drive.rated_torque_nm", "4", "mean load.rated_torque_nm?"),
        ("[disc] ", "[dics] ", "dics", "{…}", "did you mean disc?"),
        ("discs = 2", "discs = 2\nzzz = 1", "drive.zzz", "1", "known here are pins"),
        ("[drive]\n", "[[effects]]\nname = 'disk_runout'\n[drive]\n", "effects[1].name", '"disk_runout"',
         "did you mean disc_runout?"),
        ("[drive]\n", "[[effects]]\nname = ['disc_runout']\n[drive]\n", "effects[1].name",
         "['disc_runout']", "did you mean disc_runout?"),
        ('name = "RV-40E"', 'name = "a\\u0001b"', "name", '"a\\u0001b"', "one line of at most 80"),
        ('name = "RV-40E"', 'name = "a\\uffffb"', "name", '"a\uffffb"', "one line of at most 80"),
        ('name = "RV-40E"', 'name = "' + 90 * "a" + '"', "name", '"' + 59 * "a" + "…", "one line of at most 80"),
        ("= 412.0", "= 1" + 400 * "0", "load.rated_torque_nm", "1" + 59 * "0" + "…", ""),
    ],
)  # fmt: skip
def test_a_refusal_has_four_parts(old: str, new: str, what: str, value: str, says: str) -> None:
    error = refusal(old, new)
    assert error.what == what
    assert str(error.value) == value
    assert error.limit
    assert error.remedy
    assert says in str(error)
    assert "\n" not in str(error)
    assert error.exit_code == 2


def test_a_file_that_is_not_toml_is_refused_with_its_line() -> None:
    with pytest.raises(SpecError, match=r"line 2"):
        parse_spec("[drive]\npins = \n")


@pytest.mark.parametrize("kind", ["missing", "folder", "binary"])
def test_a_file_that_cannot_be_read_is_named(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "spec.toml"
    if kind == "folder":
        path.mkdir()
    if kind == "binary":
        path.write_bytes(b"\xff\xfe\x00drive")
    with pytest.raises(SpecError, match=r"spec\.toml' (does not exist|cannot be read)"):
        read_spec(path)


def test_numbers_in_effects_must_be_finite_too() -> None:
    with pytest.raises(SpecError, match=r"effects\.0\.amplitude_um"):
        parse_spec(SHORT + f"[[effects]]\nname = 'disc_runout'\namplitude_um = {math.inf}\n")


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path: Path) -> None:
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbf" + TEXT.replace("\n", "\r\n").encode("utf-8"))
    assert read_spec(path) == read_spec(RV40E)


def test_a_bottomless_file_is_refused() -> None:
    with pytest.raises(SpecError, match="nests tables too deeply"):
        parse_spec("a = " + 100_000 * "[")


def test_a_machine_file_is_found_next_to_the_spec(tmp_path: Path) -> None:
    spec = tmp_path / "spec.toml"
    text = (ROOT / "examples" / "rv40e.toml").read_text(encoding="utf-8")
    spec.write_text(text.replace("[export]\n", '[export]\nmachine = "my.toml"\n'), encoding="utf-8")
    assert read_spec(spec).export.machine == str(tmp_path / "my.toml")


def test_every_fault_of_a_file_is_reported_in_one_go() -> None:
    wrong = (
        TEXT.replace("pins = 40", "pinz = 40")
        .replace("discs = 2", "discs = 22")
        .replace("rated_torque_nm = 412.0", "rated_torque_nm = -1")
    )
    with pytest.raises(SpecError) as caught:
        parse_spec(wrong + "[[effects]]\nname = 'disk_runout'\n")
    assert [fault.what for fault in caught.value.faults] == [
        "drive.pinz", "drive.discs", "load.rated_torque_nm", "effects[1].name",
    ]  # fmt: skip
    assert caught.value.sentences == tuple(map(str, caught.value.faults))


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("pin_radius_mm = 3.0", "pin_diameter = 6.0", "write pin_radius_mm = 3"),
        ("pin_radius_mm = 3.0", "pin_diameter_um = 6000", "write pin_radius_mm = 3"),
        ("pin_radius_mm = 3.0", "pin_dia = 6", "write pin_radius_mm = 3"),
        ("pin_circle_radius_mm = 64.0", "pitch_diameter_mm = 128", "write pin_circle_radius_mm = 64"),
        ("pin_circle_radius_mm = 64.0", "pin_circ = 64", "did you mean drive.pin_circle_radius_mm?"),
        ("eccentricity_mm = 1.3", "eccentricity = 1.3", "write eccentricity_mm = 1.3"),
        ("disc_width_mm = 11.5", "thickness_mm = 11.5", "write disc_width_mm = 11.5"),
        ("pins = 40", "lobes = 39", "write pins = 40"),
        ("discs = 2", "discs = 2\ntorque = 412", "write load.rated_torque_nm = 412"),
        ("poisson_ratio = 0.3\n\n[load]", "nu = 0.3\n\n[load]", "write poisson_ratio = 0.3"),
    ],
)
def test_words_that_users_have_are_understood(old: str, new: str, says: str) -> None:
    error = refusal(old, new)
    assert says in str(error)
    assert not error.faults, "the key that is meant is not missing as well"


def test_ratio_pin_diameter_and_material_stand_for_the_keys_of_the_spec() -> None:
    text = SHORT.replace("pins = 11", "ratio = 10").replace("pin_radius_mm = 3.0", "pin_diameter_mm = 6.0")
    disc = "[materials.disc]\n"
    spec = parse_spec(f'{text}{disc}material = "pla"\n')
    material = disc + 'youngs_modulus_gpa = 3.0\npoisson_ratio = 0.36\nname = "PLA"\n'
    assert spec == parse_spec(SHORT + material)
    assert parse_spec(format_spec(spec)) == spec
    assert parse_spec(f'{text}{disc}material = "PLA"\npoisson_ratio = 0.3\n').materials.disc.poisson_ratio == 0.3


@pytest.mark.parametrize(
    ("old", "new", "what", "says"),
    [
        ("pins = 11", "pins = 11\nratio = 10", "drive.ratio", "is given next to drive.pins = 11: give one of the two"),
        ("pins = 11", "ratio = 1", "drive.ratio", "must be >= 2"),
        ("pin_radius_mm = 3.0", "pin_diameter_mm = 'x'", "drive.pin_diameter_mm", "must be of type float"),
        ("discs = 2", "discs = 2\n[materials.pin]\nmaterial = 'PLE'", "materials.pin.material", "did you mean pla"),
        ("discs = 2", "discs = 2\n[materials.pin]\nmaterial = 'PLA'\nyoungs_modulus_gpa = 3", "materials.pin.material",
         "give one of the two"),
    ],
)  # fmt: skip
def test_a_wrong_second_form_is_one_fault(old: str, new: str, what: str, says: str) -> None:
    with pytest.raises(SpecError) as caught:
        parse_spec(SHORT.replace(old, new))
    assert caught.value.what == what
    assert says in str(caught.value)
    assert not caught.value.faults


def test_the_schema_takes_exactly_one_of_each_pair() -> None:
    validator = jsonschema.Draft202012Validator(json.loads(spec_schema()))
    drive = tomllib.loads(SHORT)["drive"]
    without = {key: value for key, value in drive.items() if key != "pins"}
    assert validator.is_valid({"drive": {**without, "ratio": 10}})
    assert not validator.is_valid({"drive": without})
    assert not validator.is_valid({"drive": {**drive, "ratio": 10}})
    disc = {"material": "PLA"}
    assert validator.is_valid({"drive": drive, "materials": {"disc": disc}})
    assert not validator.is_valid({"drive": drive, "materials": {"disc": {**disc, "youngs_modulus_gpa": 3.0}}})
