"""``cycloid-profile new``: proposals that can be built, asked for at a terminal or taken from rules."""

from __future__ import annotations

import json
import tomllib
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cycloid_profile.cli.main import run
from cycloid_profile.design import DriveRequest, design_disc, disc_outline, drive_of, propose, rule_table
from cycloid_profile.design.from_spec import conventional_profile, thinnest_wall
from cycloid_profile.errors import SpecError
from cycloid_profile.geometry import undercut_limit
from cycloid_profile.spec import parse_spec, read_spec
from cycloid_profile.spec.model import MATERIALS
from tests.cli.terminals import ROOT, in_terminal

NAMES = [one.name for one in MATERIALS]


@given(
    ratio=st.integers(3, 87), outer=st.none() | st.floats(15.0, 600.0), material=st.sampled_from(NAMES),
    torque=st.none() | st.floats(0.01, 1e3),
)  # fmt: skip
@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_every_proposal_has_a_tooth_walls_and_clearance(
    ratio: int, outer: float | None, material: str, torque: float | None
) -> None:
    proposal = propose(DriveRequest(ratio, outer_diameter=outer, material=material, torque_nm=torque))
    spec = parse_spec(proposal.text)
    drive = drive_of(spec)
    profile = conventional_profile(spec, drive)
    assert drive.reduction_ratio == ratio
    assert profile.pin_radius < undercut_limit(profile.trochoid)
    assert thinnest_wall(disc_outline(spec, drive, profile))[0] > 0.0
    holes = spec.disc.output_holes
    assert holes is not None
    assert holes.radius_mm >= 1.4 * spec.drive.eccentricity_mm, "an output pin must be left"
    if outer is not None:
        assert 2.0 * (spec.drive.pin_circle_radius_mm + spec.drive.pin_radius_mm) < outer
    assert torque is None or spec.load.rated_torque_nm == pytest.approx(torque)


@pytest.mark.parametrize(
    ("ratio", "outer", "material"),
    [(3, 30.0, "PLA"), (5, 30.0, "PLA"), (11, 60.0, "PLA"), (12, 400.0, "steel"), (23, 120.0, "POM")],
)
def test_proposals_build_without_a_failed_check(ratio: int, outer: float, material: str) -> None:
    assert design_disc(propose(DriveRequest(ratio, outer_diameter=outer, material=material)).spec).failures == ()


@pytest.mark.slow
@pytest.mark.parametrize("material", ["PLA", "aluminium", "steel"])
@pytest.mark.parametrize("outer", [None, 30.0, 120.0, 400.0])
@pytest.mark.parametrize("ratio", [5, 9, 12, 24, 39, 60, 87])
def test_many_proposals_build_without_a_failed_check(ratio: int, outer: float | None, material: str) -> None:
    assert design_disc(propose(DriveRequest(ratio, outer_diameter=outer, material=material)).spec).failures == ()


@given(ratio=st.integers(3, 300), outer=st.none() | st.floats(1.0, 2000.0), pin=st.floats(0.05, 50.0))
def test_given_pins_fit_or_are_refused_in_one_sentence(ratio: int, outer: float | None, pin: float) -> None:
    try:
        spec = propose(DriveRequest(ratio, pin_diameter=pin, outer_diameter=outer)).spec
    except SpecError as error:
        assert error.what == "--pin-diameter"  # noqa: PT017 - either outcome is right
        return
    drive = drive_of(spec)
    assert drive.pin_radius == pytest.approx(0.5 * pin)
    assert thinnest_wall(disc_outline(spec, drive, conventional_profile(spec, drive)))[0] > 0.0


def test_given_values_are_kept() -> None:
    spec = propose(DriveRequest(11, pin_diameter=3.0, outer_diameter=60.0, material="pla", torque_nm=2.0)).spec
    assert (spec.drive.pins, spec.drive.pin_radius_mm, spec.load.rated_torque_nm) == (12, 1.5, 2.0)
    assert spec.materials.disc.name == "PLA"
    assert spec.materials.pin.youngs_modulus_gpa == 206.0


@pytest.mark.parametrize("total", [57.0, 81.0, 121.0, 153.0])
def test_a_total_ratio_adds_a_first_stage(total: float) -> None:
    spec = propose(DriveRequest(total_ratio=total, outer_diameter=160.0, material="steel")).spec
    assert drive_of(spec).reduction_ratio == pytest.approx(total, rel=0.01)
    stage = spec.drive.first_stage
    assert stage is not None
    assert spec.drive.cranks is not None
    distance = 0.5 * stage.module_mm * (stage.sun_teeth + stage.planet_teeth)
    assert distance == pytest.approx(spec.drive.cranks.circle_radius_mm)


@pytest.mark.parametrize(
    ("request_", "says"),
    [
        (DriveRequest(), "give --ratio or --total-ratio"),
        (DriveRequest(2), "is outside 3 to 300"),
        (DriveRequest(11, outer_diameter=-5.0), "--outer-diameter = -5 is not above zero"),
        (DriveRequest(39, pin_diameter=10.0, outer_diameter=60.0), "leaves no wall between 40 pins"),
        (DriveRequest(11, material="plastic"), "is not in the table of materials"),
        (DriveRequest(11, total_ratio=500.0), "needs a first stage of z2/z1"),
    ],
)
def test_what_does_not_fit_is_one_sentence(request_: DriveRequest, says: str) -> None:
    with pytest.raises(SpecError) as caught:
        propose(request_)
    assert says in str(caught.value)


def test_a_torque_above_the_usual_one_is_advised_with_the_size_that_carries_it() -> None:
    request = DriveRequest(39, outer_diameter=60.0, material="PETG", torque_nm=50.0)
    (advice,) = propose(request).advice
    larger = float(advice.split()[-1])
    assert larger > 60.0
    assert propose(replace(request, outer_diameter=larger)).advice == ()
    assert propose(replace(request, torque_nm=None)).advice == ()


def test_the_thickest_pins_that_are_offered_fit() -> None:
    with pytest.raises(SpecError) as caught:
        propose(DriveRequest(39, pin_diameter=10.0, outer_diameter=60.0))
    thickest = float(caught.value.remedy.split()[3])
    assert propose(DriveRequest(39, pin_diameter=thickest, outer_diameter=60.0)).spec.drive.pins == 40


def test_every_number_of_the_file_has_its_reason() -> None:
    text = propose(DriveRequest(11, outer_diameter=60.0)).text
    lines = text.splitlines()
    bare = [b for a, b in pairwise(lines) if " = " in b and not b.startswith("#") and a[:1] != "#"]
    assert [line.split(" = ")[0] for line in bare] == ["circle_radius_mm", "reference"]
    assert tomllib.loads(text)["drive"]["ratio"] == 11


def test_the_page_holds_the_rules() -> None:
    assert rule_table() in (ROOT / "docs" / "spec.md").read_text(encoding="utf-8")


def test_without_a_terminal_proposals_fill_everything_but_the_ratio(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.toml"
    assert run(["new", "--ratio", "11", "--out", str(file)]) == 0
    assert f"cycloid-profile build {file} --out" in capsys.readouterr().out
    assert read_spec(file).drive.pins == 12
    assert (tmp_path / "cycloid-profile.schema.json").is_file()
    assert run(["new", "--out", str(tmp_path / "none.toml")]) == 2
    assert "give --ratio or --total-ratio" in capsys.readouterr().err
    assert not (tmp_path / "none.toml").exists()
    assert run(["new", "--ratio", "11"]) == 0
    assert capsys.readouterr().out == file.read_text(encoding="utf-8")
    assert run(["new", "--ratio", "11", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["drive"]["pins"] == 12


@pytest.mark.parametrize("words", [["new", "--ratio", "11"], ["catalog", "rv40e"]])
def test_an_edited_spec_is_not_overwritten(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.toml"
    assert run([*words, "--out", str(file)]) == 0
    assert run([*words, "--out", str(file)]) == 0, "the same file again"
    file.write_text("# mine\n", encoding="utf-8")
    assert run([*words, "--out", str(file)]) == 2
    assert "add --force" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == "# mine\n"
    assert run([*words, "--out", str(file), "--force"]) == 0
    assert read_spec(file).drive.pins > 3


def test_a_terminal_is_asked_for_what_is_missing(tmp_path: Path) -> None:
    words = ["-m", "cycloid_profile", "new", "--pin-diameter", "3", "--out", "mine.toml"]
    status, shown = in_terminal(words, 80, "eleven\n11\n60\n\n2,5\n", tmp_path)
    assert status == 0, shown
    assert "Please give a number." in shown
    assert "Diameter of the pins" not in shown
    spec = read_spec(tmp_path / "mine.toml")
    assert (spec.drive.pins, spec.drive.pin_radius_mm, spec.load.rated_torque_nm) == (12, 1.5, 2.5)
    assert spec.materials.disc.name == "PLA"
