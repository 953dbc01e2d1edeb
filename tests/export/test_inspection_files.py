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

from cycloid_profile.design import DesignRecord, design_disc
from cycloid_profile.errors import ExportError
from cycloid_profile.export.inspection import DmisExporter, datum_system, inspection_plan, plan_rows
from cycloid_profile.export.points import CmmExporter, ProfileCsvExporter, VdaExporter
from cycloid_profile.geometry import DiscOutline, circular_contour
from cycloid_profile.spec.model import DiscSpec, Spec
from cycloid_profile.spec.model.drive import DriveSpec, HolesSpec, KeywaySpec
from cycloid_profile.spec.model.export import InspectionSpec


def nominal(record: DesignRecord, folder: Path) -> np.ndarray:
    """x y z and normal of the nominal points by ``cmm_nominal.csv``, which other tests hold to the exact curve."""
    CmmExporter().write(record, folder)
    table = np.loadtxt(folder / "cmm_nominal.csv", delimiter=",", skiprows=1)
    return table[:, 3:]


NUMBER, NAME = r"-?\d+(?:\.\d+)?", r"[A-Z0-9]+"
# Every statement that the programs may hold; names are defined before they are used.
GRAMMAR = [
    ("head", r"DMISMN/'[A-Z0-9 ._-]+',05\.2"),
    ("head", r"UNITS/MM,ANGDEC|WKPLAN/XYPLAN|PRCOMP/ON|TECOMP/OFF|SNSET/(?:APPRCH|RETRCT),1|ENDFIL"),
    ("mode", r"MODE/(MAN|PROG,MAN)"),
    ("feature", rf"F\(({NAME})\)=FEAT/(POINT|PLANE|CIRCLE|LINE)(?:,INNER|,OUTER|,UNBND)?,CART((?:,{NUMBER})+)"),
    ("measure", rf"MEAS/(POINT|PLANE|CIRCLE),F\(({NAME})\),(\d+)"),
    ("touch", rf"PTMEAS/CART,({NUMBER}(?:,{NUMBER}){{5}})"),
    ("end", r"ENDMES"),
    ("move", rf"GOTO/({NUMBER},{NUMBER},{NUMBER})"),
    ("datum", rf"DATDEF/FA\(({NAME})\),DAT\(([A-Z]+)\)"),
    ("set", r"D\(\d\)=DATSET/DAT\((\w+)\),ZDIR,ZORIG,DAT\((\w+)\),XORIG,YORIG,DAT\((\w+)\),XDIR"),
    ("shift", rf"D\(\d\)=(?:TRANS/ZORIG|ROTATE/ZAXIS),({NUMBER})"),
    ("turn", rf"D\(\d\)=ROTATE/ZAXIS,FA\(({NAME})\),XDIR"),
    ("tolerance", r"T\((\d+)\)=TOL/(PROFP|CRNOUT|DISTB|ANGLB),(.*)"),
    ("construct", rf"CONST/(?:(?:LINE|CIRCLE),F\(({NAME})\),BF|POINT,F\(({NAME})\),MIDPT)((?:,FA\({NAME}\))+)"),
    ("output", rf"OUTPUT/FA\(({NAME})\)(?:,FA\(({NAME})\))?(?:,TA\((\d+)\))?"),
]


def statements(path: Path) -> list[tuple[str, tuple[str, ...]]]:
    """Kind and words of every statement of a program; comments are left out, continued lines joined."""
    text = path.read_text(encoding="ascii").replace("$\n", "")
    found = []
    for line in text.splitlines():
        if line.startswith("$$"):
            continue
        matches = [(kind, match) for kind, pattern in GRAMMAR if (match := re.fullmatch(pattern, line))]
        assert len(matches) == 1, line
        found.append((matches[0][0], matches[0][1].groups()))
    return found


def test_dmis_program_aligns_before_it_moves_and_measures_every_nominal_point(
    rv40e_record: DesignRecord, tmp_path: Path
) -> None:
    DmisExporter().write(rv40e_record, tmp_path)
    assert (tmp_path / "cmm.dmi").read_text(encoding="ascii").startswith("DMISMN/'RV-40E TEETH',05.")
    features: dict[str, list[float]] = {}
    touched: dict[str, list[list[float]]] = {}
    datums: dict[str, str] = {}
    tolerances: dict[str, tuple[str, list[float]]] = {}
    outputs: dict[str, list[tuple[str, ...]]] = {}
    constructed: dict[str, list[str]] = {}
    sets, shifts, mode, inside, wanted = [], [], "", "", 0
    for kind, words in statements(tmp_path / "cmm.dmi"):
        if kind == "mode":
            mode = words[0]
        elif kind == "feature":
            assert words[0] not in features
            features[words[0]] = [float(v) for v in words[2].split(",")[1:]]
        elif kind == "measure":
            assert not inside
            inside, wanted = words[1], int(words[2])
            assert inside in features
            touched[inside] = []
        elif kind == "touch":
            touched[inside].append([float(v) for v in words[0].split(",")])
        elif kind == "end":
            assert len(touched[inside]) == wanted
            inside = ""
        elif kind == "move":
            # The operator moves by hand until there is a first alignment.
            assert (mode, len(sets), len(shifts)) >= ("PROG,MAN", 1, 1)
        elif kind == "datum":
            assert touched[words[0]]
            datums[words[1]] = words[0]
        elif kind == "turn":
            # Before the flanks, about the axis and through the middle of root 1.
            assert "1" not in touched
            assert constructed[words[0]] == ["AXIS", "MID1"]
        elif kind == "set":
            assert set(words) <= datums.keys()
            sets.append(tuple(datums[letter] for letter in words))
        elif kind == "shift":
            shifts.append(float(words[0]))
        elif kind == "tolerance":
            numbers = [float(v) for v in re.findall(rf"(?<![A-Z(]){NUMBER}(?=,|$)", words[2])]
            tolerances[words[0]] = (words[1], numbers)
        elif kind == "construct":
            name = words[0] or words[1]
            constructed[name] = re.findall(r"FA\((\w+)\)", words[2])
            assert all(part in touched or part in constructed for part in constructed[name])
            assert name in features
        elif kind == "output":
            assert all(name in touched or name in constructed for name in words[:2] if name)
            outputs.setdefault(tolerances[words[2]][0], []).append(words)
    assert sets == [("FACEM", "AXISM", "TURNM"), ("FACE", "AXIS", "TURN")]
    assert shifts == [-11.5, -11.5]
    assert [datums[letter] for letter in "ABC"] == ["FACE", "AXIS", "TURN"]
    assert features["AXIS"] == [0.0, 0.0, 5.75, 0.0, 0.0, 1.0, 32.0]
    for name, centre, radius in (("AXIS", (0.0, 0.0), 16.0), ("TURN", (36.0, 0.0), 13.0)):
        at = np.array(touched[name])
        from_axis = at[:, :2] - centre
        assert np.hypot(*from_axis.T) == pytest.approx(radius, abs=1e-8)
        # The normal points out of the material, into the hole.
        assert at[:, 3:5] == pytest.approx(-from_axis / radius, abs=1e-8)
    # The face is touched in the material, a ball and 3 mm away from bore, crank holes and teeth.
    face = np.array(touched["FACE"])
    assert np.all(face[:, 2:] == [11.5, 0.0, 0.0, 1.0])
    z = face[:, 0] + 1j * face[:, 1]
    assert np.all(np.abs(z) > 16.0 + 3.5)
    tooth = textbook_curve(np.linspace(0.0, 78.0 * math.pi, 39 * 400), 0.006, 0.0)
    curve = tooth @ [1.0, 1j]
    assert all(np.min(np.abs(curve - at)) > 3.5 - 1e-2 and abs(at) < 60.0 for at in z)
    assert all(np.min(np.abs(z - 36.0 * np.exp(2j * np.pi * k / 3))) > 13.0 + 3.5 for k in range(3))
    points = np.array([touched[str(k)][0] for k in range(1, 1561)])
    assert np.array_equal(points, np.array([features[str(k)] for k in range(1, 1561)], float))
    expected = nominal(rv40e_record, tmp_path)
    assert np.max(np.abs(points - expected)) <= 1e-9
    assert len(outputs["PROFP"]) == 1560
    assert tolerances["1"] == ("PROFP", [-0.006, 0.006])  # IT4 at 128 mm is 12 µm
    # Pitch of both flanks of 39 lobes as distances to the flank before, and as angles from the first.
    plan = inspection_plan(rv40e_record)
    single, cumulative, runout = (check.tolerance for check in plan.checks[1:])
    hole, *angles = outputs["ANGLB"]
    assert (len(outputs["DISTB"]), len(angles)) == (78, 76)
    # Crank hole 1 of disc 1 lies on the axis of root 1.
    assert hole == ("HOLE", "ROOT1", "3")
    assert constructed["HOLE"] == ["AXIS", "TURN"]
    assert plan.hole_angle_arcmin is not None
    limit = plan.hole_angle_arcmin.size / 60.0
    assert tolerances["3"] == ("ANGLB", pytest.approx([0.0, -limit, limit], abs=1e-9))
    flanks = np.array([touched[name][0] for name in ("ROOT1L", "ROOT1R")])
    assert np.hypot(*flanks[:, :2].T) == pytest.approx(plan.pitch_radius, abs=1e-9)
    assert flanks[:, 1].sum() == pytest.approx(0.0, abs=1e-9)
    for one, other, label in outputs["DISTB"]:
        apart = np.hypot(*(np.array(features[one]) - np.array(features[other]))[:2])
        assert tolerances[label][1] == pytest.approx([apart, -single, single], abs=2e-9)
        assert apart == pytest.approx(2.0 * np.hypot(*features[one][:2]) * math.sin(math.pi / 39), abs=1e-6)
    for one, other, label in angles:
        a, b = (np.array(features[constructed[name][1]])[:2] @ [1.0, 1j] for name in (one, other))
        turn = math.degrees(cumulative / plan.pitch_radius)
        assert tolerances[label][1] == pytest.approx([abs(np.degrees(np.angle(b / a))), -turn, turn], abs=1e-8)
    assert outputs["CRNOUT"] == [("ROOTS", None, "2")]
    assert tolerances["2"] == ("CRNOUT", pytest.approx([runout]))
    assert len(constructed["ROOTS"]) == 39


@pytest.mark.parametrize("turned", [0.0, 0.3])
def test_dmis_alignment_without_bore_or_with_a_turned_crank_hole(
    rv40e_record: DesignRecord, tmp_path: Path, turned: float
) -> None:
    hole = circular_contour("crank hole 1", 36.0 * complex(math.cos(turned), math.sin(turned)), 8.0)
    openings = (hole, circular_contour("bore", 0j, 10.0)) if turned else ()
    record = replace(rv40e_record, outline=DiscOutline(rv40e_record.profile, openings))
    DmisExporter().write(record, tmp_path)
    found = statements(tmp_path / "cmm.dmi")
    rotations = [float(words[0]) for kind, words in found if kind == "shift" and words[0] != "-11.500000000"]
    assert rotations == pytest.approx(2 * [-math.degrees(turned)] if turned else [])
    # Without a bore the origin is the centre of the roots, and the first root gives the direction.
    counts = {words[1]: int(words[2]) for kind, words in found if kind == "measure" and not words[1].isdigit()}
    assert counts["AXIS"] == (8 if turned else 39)
    assert counts["TURN"] == (8 if turned else 1)
    moves = [[float(v) for v in words[0].split(",")] for kind, words in found if kind == "move"]
    for before, after in itertools.pairwise(moves):
        sideways = math.hypot(after[0] - before[0], after[1] - before[1])
        assert sideways == 0.0 or min(before[2], after[2]) > 11.5 + 10.0


def test_dmis_touches_a_keyed_bore_clear_of_its_keyways_and_takes_its_middle_for_datum_c(tmp_path: Path) -> None:
    keyway = KeywaySpec(6.0, 2.8, 2, 0.3, 30.0)
    spec = Spec(
        name="KEYED", drive=DriveSpec(11, 30.0, 3.0, 1.5, 8.0, 1), disc=DiscSpec(bore_radius_mm=10.0, keyway=keyway)
    )
    record = design_disc(spec)
    DmisExporter().write(record, tmp_path)
    found = statements(tmp_path / "cmm.dmi")
    touched: dict[str, list[complex]] = {}
    for kind, words in found:
        if kind == "measure":
            touched[words[1]] = list[complex]()
            last = touched[words[1]]
        elif kind == "touch":
            x, y, *_ = map(float, words[0].split(","))
            last.append(complex(x, y))
    # Both keyways, at 30° and 210°, are 6 mm wide: the ball of 0.5 mm is clear of their edges.
    bore = np.array(touched["AXIS"]) * np.exp(-1j * math.radians(30.0))
    assert np.abs(bore) == pytest.approx(10.0, abs=1e-8)
    assert len(bore) == 8
    assert np.min(np.abs(bore.imag)) > 3.0 + 0.5
    sides = np.array([*touched["SIDE1"], *touched["SIDE2"]]) * np.exp(-1j * math.radians(30.0))
    assert sides.imag == pytest.approx([3.0, -3.0], abs=1e-8)
    assert np.all((sides.real > math.sqrt(91.0)) & (sides.real < 12.8 - 0.3))
    assert ("construct", (None, "TURN", ",FA(SIDE1),FA(SIDE2)")) in found
    assert [float(words[0]) for kind, words in found if kind == "shift"] == 2 * [-8.0, -30.0]
    large = msgspec.structs.replace(spec.export, inspection=InspectionSpec(probe_radius_mm=3.0))
    record = replace(record, spec=msgspec.structs.replace(spec, export=large))
    with pytest.raises(ExportError, match="does not fit into the keyway"):
        DmisExporter().write(record, tmp_path)


@pytest.mark.parametrize(("disc", "names", "holes"), [
    (DiscSpec(output_holes=HolesSpec(6, 17.0, 3.5)), ["bore", "output hole 1"], ("A", "B")),
    (DiscSpec(keyway=KeywaySpec(4.0, 2.0)), ["bore", "keyway 1"], ("A", "B", "C")),
    (DiscSpec(), ["bore"], ("A", "B")),
])  # fmt: skip
def test_datum_c_is_the_opening_that_gives_the_direction(
    disc: DiscSpec, names: list[str], holes: tuple[str, ...]
) -> None:
    datums = datum_system(design_disc(Spec(name="central", drive=DriveSpec(11, 30.0, 3.0, 1.5, 8.0, 1), disc=disc)))
    assert [*datums.names.items()] == [*zip("ABC", ["upper face", *names], strict=False)]
    assert datums.of_holes([complex(17.0, 0.0), complex(-17.0, 0.0)]) == holes


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


def test_pitch_is_read_where_the_lever_is_longest_and_the_play_is_named(rv40e_record: DesignRecord) -> None:
    plan = inspection_plan(rv40e_record)
    # Backlash over the lever arm of 50.7 mm, halved for each flank.
    play = 0.5 * rv40e_record.compensated_accuracy.backlash.least * 50.7
    assert plan.flank_play == pytest.approx(play, rel=1e-12)
    assert f"{1e3 * play:.2f} µm, less than the profile tolerance" in plan_rows(plan)[-1]
    # The radius at which pitch is read is that of the textbook tooth where the lever arm is longest.
    delta = rv40e_record.compensation.delta_max if rv40e_record.compensation else 0.0
    radius = float(np.hypot(*textbook_curve(np.array(math.acos(0.8125)), 0.006, delta)))
    assert plan.pitch_radius == pytest.approx(radius, abs=1e-9)


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
