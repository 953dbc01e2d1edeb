"""Every disc that differs from disc 1 has its own files, with its openings where the assembly needs them."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dxf_codes import entities, numbers

from cycloid_profile.design import DesignRecord, disc_outline, disc_parts, disc_parts_sentence, disc_records, drive_of
from cycloid_profile.export import file_names, write_formats
from cycloid_profile.export.cad import disc_placements
from cycloid_profile.report.design import export_package
from cycloid_profile.spec.model import Spec
from cycloid_profile.spec.model.drive import DiscSpec, DriveSpec, HolesSpec, KeywaySpec, WindowsSpec

FORMATS = ("csv", "dxf", "gcode", "cmm", "dmis", "svg")


def spec_of(pins: int, discs: int, disc: DiscSpec) -> Spec:
    drive = DriveSpec(
        pins=pins, pin_circle_radius_mm=60.0, pin_radius_mm=3.0, eccentricity_mm=1.2, disc_width_mm=10.0, discs=discs
    )
    return Spec(name="drive", drive=drive, disc=disc)


def numbers_of(spec: Spec) -> list[tuple[int, ...]]:
    drive = drive_of(spec)
    return [part.discs for part in disc_parts(drive, disc_outline(spec, drive, drive.theoretical_profile))]


@pytest.mark.parametrize(
    ("spec", "discs"),
    [
        (spec_of(10, 1, DiscSpec(output_holes=HolesSpec(6, 30.0, 5.0))), [(1,)]),
        (spec_of(10, 2, DiscSpec(output_holes=HolesSpec(6, 30.0, 5.0))), [(1, 2)]),
        (spec_of(11, 2, DiscSpec(output_holes=HolesSpec(6, 30.0, 5.0))), [(1,), (2,)]),
        (spec_of(11, 2, DiscSpec(output_holes=HolesSpec(4, 30.0, 5.0))), [(1, 2)]),
        (spec_of(11, 2, DiscSpec(bore_radius_mm=12.0)), [(1, 2)]),
        (spec_of(11, 2, DiscSpec(keyway=KeywaySpec(3.0, 1.0))), [(1,), (2,)]),
        (spec_of(11, 2, DiscSpec(windows=WindowsSpec(4, 20.0, 40.0, 40.0))), [(1, 2)]),
        (spec_of(11, 3, DiscSpec(output_holes=HolesSpec(5, 30.0, 5.0))), [(1,), (2,), (3,)]),
        (spec_of(11, 3, DiscSpec(output_holes=HolesSpec(6, 30.0, 5.0))), [(1, 2, 3)]),
    ],
)
def test_discs_differ_unless_their_openings_repeat(spec: Spec, discs: list[tuple[int, ...]]) -> None:
    assert numbers_of(spec) == discs


def test_disc_2_of_the_rv40e_is_another_part(rv40e_record: DesignRecord) -> None:
    first, second = disc_records(rv40e_record)
    assert first is rv40e_record
    assert math.degrees(second.openings_turn) == pytest.approx(180.0 / 39.0)
    assert disc_parts_sentence(rv40e_record) == (
        "Disc 2 is another part than disc 1: its openings are turned by 4.6154° against the teeth; "
        "its files have disc_2 in their names."
    )
    # In the assembly the crank holes of both discs lie about the same axes, shifted by the eccentricity.
    place = disc_placements(rv40e_record.drive)[1]
    centres = [hole.centre * np.exp(1j * place.rotation) for hole in second.outline.holes if "crank" in hole.name]
    assert np.allclose(centres, [hole.centre for hole in first.outline.holes if "crank" in hole.name], atol=1e-12)


def test_files_of_disc_2_have_its_openings(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    written, _ = write_formats(rv40e_record, FORMATS, tmp_path)
    names = {file.name for file in written}
    assert names == {path.name for path in tmp_path.iterdir()}
    assert names == {name for form in FORMATS for name in file_names(form, (1, 2))}
    assert {"profile_disc_2.csv", "profile_disc_2.dxf", "grinding_disc_2.nc", "cmm_nominal_disc_2.csv"} <= names

    def hole_angles(name: str) -> list[float]:
        holes = entities(tmp_path / name, "CIRCLE", "HOLES")
        at = [complex(numbers(tags, 10)[0], numbers(tags, 20)[0]) for tags in holes]
        return sorted(math.degrees(np.angle(z)) for z in at if abs(z) > 1.0)

    turned = np.array(hole_angles("profile_disc_2.dxf")) - hole_angles("profile.dxf")
    assert turned == pytest.approx(3 * [180.0 / 39.0], abs=1e-6)
    assert "DISC 2: ROOT 1 ON THE X AXIS, OPENINGS 4.6154 DEG" in (tmp_path / "grinding_disc_2.nc").read_text()
    assert "OPENINGS" not in (tmp_path / "grinding.nc").read_text()
    program = (tmp_path / "cmm_disc_2.dmi").read_text()
    # In the alignment by hand, again in that by the machine; the tooth is then measured from its root.
    turned_by = [("3", "-4.615384615"), ("6", "-4.615384615"), ("7", "FA(ROOT1),XDIR")]
    assert re.findall(r"D\((\d)\)=ROTATE/ZAXIS,(.*)", program) == turned_by
    assert re.findall("ROTATE/ZAXIS,(.*)", (tmp_path / "cmm.dmi").read_text()) == ["FA(ROOT1),XDIR"]
    # The tooth is the same in both.
    assert (tmp_path / "profile.csv").read_bytes() == (tmp_path / "profile_disc_2.csv").read_bytes()


@pytest.mark.slow
def test_equal_discs_have_one_set_of_files_and_a_sentence(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    outline = replace(rv40e_record.outline, contours=rv40e_record.outline.contours[:1])
    record = replace(rv40e_record, outline=outline)
    entries, _ = export_package(record, ("dxf", "gcode"), tmp_path)
    assert [entry["path"] for entry in entries] == ["profile.dxf", "grinding.nc"]
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    assert manifest["discs"] == "Discs 1 to 2 are the same part."


def test_file_names_of_discs() -> None:
    assert file_names("step", (1, 2)) == ("disc.step", "disc_2.step")
    assert file_names("drawing", (2,)) == ("drawing_disc_2.dxf", "drawing_disc_2.svg", "drawing_disc_2.pdf")
    assert file_names("step-assembly", (1, 2)) == ("assembly.step",)
