"""Files for measuring machines: DMIS and VDA-FS read by an independent grammar, and the plan's tolerances."""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest
from independent import textbook_curve

from cycloid_profile.design import DesignRecord
from cycloid_profile.export.inspection import DmisExporter, inspection_plan
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, VdaExporter


def nominal(record: DesignRecord, folder: Path) -> np.ndarray:
    """x y z and normal of the nominal points by ``cmm_nominal.csv``, which other tests hold to the exact curve."""
    CmmExporter().write(record, folder)
    table = np.loadtxt(folder / "cmm_nominal.csv", delimiter=",", skiprows=1)
    return table[:, 3:]


def test_dmis_program_measures_every_nominal_point(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    DmisExporter().write(rv40e_record, tmp_path)
    lines = (tmp_path / "cmm.dmi").read_text(encoding="ascii").splitlines()
    assert lines[0].startswith("DMISMN/'RV-40E TEETH',05.")
    assert lines[-1] == "ENDFIL"
    assert {"UNITS/MM,ANGDEC", "PRCOMP/ON", "MODE/PROG,MAN"} <= set(lines)
    features: dict[str, list[str]] = {}
    touched: dict[str, list[list[float]]] = {}
    tolerances, outputs, datums, inside = {}, {}, [], ""
    for line in lines:
        if line.startswith("$$"):
            continue
        if match := re.fullmatch(r"F\((\w+)\)=FEAT/(.*)", line):
            assert match[1] not in features
            features[match[1]] = match[2].split(",")
        elif match := re.fullmatch(r"T\((\d+)\)=TOL/PROFP,(-[\d.]+),([\d.]+)", line):
            tolerances[match[1]] = (float(match[2]), float(match[3]))
        elif match := re.fullmatch(r"MEAS/(POINT|CIRCLE),F\((\w+)\),(\d+)", line):
            assert not inside
            assert features[match[2]][0] == match[1]
            inside, touched[match[2]] = match[2], []
            wanted = int(match[3])
        elif match := re.fullmatch(r"PTMEAS/CART,(.*)", line):
            touched[inside].append([float(v) for v in match[1].split(",")])
        elif line == "ENDMES":
            assert len(touched[inside]) == wanted
            inside = ""
        elif match := re.fullmatch(r"OUTPUT/FA\((\w+)\),TA\((\d+)\)", line):
            outputs[match[1]] = tolerances[match[2]]
        elif match := re.fullmatch(r"DATDEF/FA\((\w+)\),DAT\((\w)\)", line):
            datums.append((match[2], match[1]))
    assert datums == [("A", "BORE"), ("B", "CRANK1")]
    assert [float(v) for v in features["BORE"][3:]] == [0.0, 0.0, 5.75, 0.0, 0.0, 1.0, 32.0]
    for name, centre, radius in (("BORE", (0.0, 0.0), 16.0), ("CRANK1", (36.0, 0.0), 13.0)):
        at = np.array(touched[name])
        from_axis = at[:, :2] - centre
        assert np.hypot(*from_axis.T) == pytest.approx(radius, abs=1e-8)
        # The normal points out of the material, into the hole.
        assert at[:, 3:5] == pytest.approx(-from_axis / radius, abs=1e-8)
    points = np.array([touched[str(k)][0] for k in range(1, 1561)])
    assert np.array_equal(points, np.array([features[str(k)][2:] for k in range(1, 1561)], float))
    expected = nominal(rv40e_record, tmp_path)
    assert np.max(np.abs(points - expected)) <= 1e-9
    assert len(outputs) == 1560
    # A quarter of the least backlash, as an arc of the flank at ψ0, rounded down to 0.1 µm.
    assert rv40e_record.compensated_accuracy is not None
    share = 0.25 * rv40e_record.compensated_accuracy.backlash.least * 1.3 * 39.0
    limit = math.floor(1e4 * share) / 1e4
    assert set(outputs.values()) == {(-limit, limit)}


def test_dmis_probe_goes_over_the_disc_between_holes(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    DmisExporter().write(rv40e_record, tmp_path)
    places, was_touching = [], False
    for line in (tmp_path / "cmm.dmi").read_text(encoding="ascii").splitlines():
        if line.startswith("GOTO/"):
            places.append([float(v) for v in line[5:].split(",")])
        was_touching |= line.startswith("PTMEAS")
    assert was_touching
    for before, after in itertools.pairwise(places):
        sideways = math.hypot(after[0] - before[0], after[1] - before[1])
        assert sideways == 0.0 or min(before[2], after[2]) > 11.5 + 10.0


def test_vda_file_obeys_its_columns_and_holds_the_points(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    VdaExporter().write(rv40e_record, tmp_path)
    lines = (tmp_path / "cmm_nominal.vda").read_text(encoding="ascii").splitlines()
    assert {len(line) for line in lines} == {80}
    assert [int(line[72:]) for line in lines] == list(range(1, len(lines) + 1))
    head = re.fullmatch(r"\w{1,8} = HEADER / (\d+)", lines[0][:72].strip())
    assert head is not None
    body = "".join(line[:72].rstrip() for line in lines[1 + int(head[1]) :])
    found = re.findall(r"([A-Z]\w{0,7}) = (MDI|END)(?: / ([-\d.,]+?))?(?=[A-Z]|$)", body)
    assert [kind for _, kind, _ in found] == 39 * ["MDI"] + ["END"]
    assert len({name for name, _, _ in found}) == 40
    rows = []
    for _, _, words in found[:-1]:
        count, *values = words.split(",")
        rows.append(np.array(values, float).reshape(int(count), 6))
    assert np.max(np.abs(np.concatenate(rows) - nominal(rv40e_record, tmp_path))) <= 1e-9


def test_tolerances_share_out_the_play(rv40e_record: DesignRecord) -> None:
    plan = inspection_plan(rv40e_record)
    # Backlash over the lever arm of 50.7 mm, halved for each flank.
    play = 0.5 * rv40e_record.compensated_accuracy.backlash.least * 50.7
    assert plan.flank_play == pytest.approx(play, rel=1e-12)
    found = {check.name: check.tolerance for check in plan.checks}
    assert all(tolerance is not None for tolerance in found.values())
    # The radius at which pitch is read is that of the textbook tooth where the lever arm is longest.
    delta = rv40e_record.compensation.delta_max if rv40e_record.compensation else 0.0
    radius = float(np.hypot(*textbook_curve(np.array(math.acos(0.8125)), 0.006, delta)))
    assert plan.pitch_radius == pytest.approx(radius, abs=1e-9)
    for name, share in (("profile", 0.5), ("single pitch", 0.5 * radius / 50.7), ("runout", 1.0),
                        ("cumulative pitch", radius / 50.7)):  # fmt: skip
        # Rounded down to a tenth of a micrometre.
        assert 0.0 <= share * play - found[name] < 1e-4 + 1e-12


def test_tolerances_of_the_spec_win_and_no_play_leaves_none(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    asked = msgspec.structs.replace(rv40e_record.spec.export.inspection, profile_tolerance_um=3.0)
    export = msgspec.structs.replace(rv40e_record.spec.export, inspection=asked)
    backlash = rv40e_record.compensated_accuracy.backlash
    tight = replace(backlash, forward=0.0 * backlash.forward, backward=0.0 * backlash.backward)
    record = replace(
        rv40e_record,
        spec=msgspec.structs.replace(rv40e_record.spec, export=export),
        compensated_accuracy=replace(rv40e_record.compensated_accuracy, backlash=tight),
    )
    plan = inspection_plan(record)
    assert [check.tolerance for check in plan.checks] == [0.003, None, None, None]
    DmisExporter().write(record, tmp_path)
    page = (tmp_path / "inspection_plan.md").read_text(encoding="utf-8")
    assert "± 3.0" in page
    assert page.count("to be agreed") >= 3
    assert "TOL/PROFP,-0.003" in (tmp_path / "cmm.dmi").read_text(encoding="ascii")


@pytest.mark.parametrize(("spacing", "count"), [("equal-arc", None), ("equal-normal-angle", None), ("equal-arc", 50)])
def test_spacing_of_the_profile_is_chosen(
    rv40e_record: DesignRecord, tmp_path: Path, spacing: str, count: int | None
) -> None:
    export = msgspec.structs.replace(
        rv40e_record.spec.export, point_spacing=spacing, points_per_lobe=count, chord_tolerance_um=1.0
    )
    record = replace(rv40e_record, spec=msgspec.structs.replace(rv40e_record.spec, export=export))
    (written,) = ProfileCsvExporter().write(record, tmp_path)
    assert written.deviation is not None
    assert written.tolerance is not None
    assert written.deviation.largest <= written.tolerance
    assert written.tolerance == (1e-9 if count else 1e-3)
    psi, x, y, nx, ny, _ = np.loadtxt(tmp_path / "profile.csv", delimiter=",", skiprows=1).T
    lobe = psi < 2.0 * math.pi
    assert count is None or np.count_nonzero(lobe) == count
    # On one flank, between its corners: equal steps of arc, or of the normal's angle.
    flank = lobe & (psi > 0.0) & (psi < math.pi)
    if spacing == "equal-arc":
        step = np.hypot(np.diff(x[flank]), np.diff(y[flank]))
        assert np.ptp(step) < 0.02 * np.mean(step)
    else:
        turn = np.abs(np.diff(np.unwrap(np.arctan2(ny, nx)[flank])))
        # The step over the inflection turns to and fro.
        assert np.sum(np.abs(turn / np.median(turn) - 1.0) > 1e-3) <= 1
