"""Parts and assemblies as objects of build123d, and the process that writes them."""

from __future__ import annotations

import math
import pickle
import re
from pathlib import Path

import numpy as np
import pytest

import cycloid_profile as cp
from cycloid_profile.design import DesignRecord, disc_records
from cycloid_profile.errors import ExportError, SpecError
from cycloid_profile.export.cad import disc_placements

pytest.importorskip("build123d", reason="build123d is not installed")


def test_the_disc_is_a_part_with_label_colour_and_the_area_of_the_tooth(rv40e_record: DesignRecord) -> None:
    from build123d import Axis, Part

    disc = cp.export.to_build123d(rv40e_record)
    assert isinstance(disc, Part)
    assert disc.is_valid
    assert disc.label == "RV-40E"
    assert disc.color is not None
    assert len(disc.faces()) == 78 + 4 + 2
    assert disc.faces().sort_by(Axis.Z)[-1].area == pytest.approx(rv40e_record.outline.area, rel=1e-5)
    assert pytest.approx((0.0, 11.5), abs=1e-6) == (disc.bounding_box().min.Z, disc.bounding_box().max.Z)


@pytest.mark.slow
def test_the_stage_is_a_compound_of_parts_in_their_places(rv40e_record: DesignRecord) -> None:
    angle = 0.7
    stage = cp.export.stage_to_build123d(rv40e_record, angle)
    labels = [child.label for child in stage.children]
    assert len(labels) == 54
    assert labels[:2] == ["disc 1", "disc 2"]
    for child, place in zip(stage.children, disc_placements(rv40e_record.drive, angle), strict=False):
        assert complex(child.location.position.X, child.location.position.Y) == pytest.approx(place.shift)
        assert math.radians(child.location.orientation.Z) == pytest.approx(place.rotation)
    pins = [child.location.position for child in stage.children if re.fullmatch(r"pin \d+", child.label)]
    assert np.allclose([math.hypot(pin.X, pin.Y) for pin in pins], 64.0)
    assert len(pins) == 40


@pytest.mark.slow
def test_another_process_writes_the_same_files(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir(), there.mkdir()
    formats = ("csv", "step", "cmm")
    expected, _ = cp.export.write_formats(rv40e_record, formats, here)
    drawn: list[str] = []
    with cp.export.CadProcess(formats) as process:
        assert process.formats == ("step",)
        written, skipped = cp.export.write_in_two_processes(
            disc_records(rv40e_record), formats, there, process, meanwhile=lambda: drawn.append("picture")
        )
    assert written == expected
    assert (skipped, drawn) == ({}, ["picture"])
    for path in here.iterdir():
        assert (there / path.name).read_bytes() == path.read_bytes()


def test_a_record_that_another_process_cannot_take_is_written_here(
    rv40e_record: DesignRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: object) -> bytes:
        raise pickle.PicklingError("a law of a notebook")

    with cp.export.CadProcess(("step",)) as process:
        monkeypatch.setattr(pickle, "dumps", refuse)
        written, _ = cp.export.write_in_two_processes(disc_records(rv40e_record), ("step",), tmp_path, process)
    assert [file.name for file in written] == ["disc.step", "disc_2.step"]


def test_errors_cross_to_another_process_whole() -> None:
    error = ExportError("deviation of disc.step", "1 µm", "exceeds the promised 0.5 µm", "raise the tolerance")
    back = pickle.loads(pickle.dumps(error))
    assert (type(back), str(back), back.remedy) == (ExportError, str(error), "raise the tolerance")
    renamed = pickle.loads(pickle.dumps(SpecError("a", 1, "is too small", "raise it").renamed("b")))
    assert str(renamed) == "b = 1 is too small: raise it"


def test_formats_without_solids_start_no_process() -> None:
    with cp.export.CadProcess(("csv", "gcode")) as process:
        assert process.formats == ()
        assert process.result() is None
