"""The same contour, polar and wire programs on four controls, run by interpreters that share no code with the writer.

The exact curve is the textbook formula. All four are run at 1 µm, which keeps the programs short, one of them at
0.05 µm; to this half a unit of the last decimals adds.
"""

from __future__ import annotations

import itertools
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from dialects import Step, along, run, seconds
from independent import ExactCurve

from cycloid_profile.design import DesignRecord
from cycloid_profile.errors import ExportError
from cycloid_profile.export.nc import GcodeExporter, GcodePathExporter, PolarExporter, WireExporter

DIALECTS = ("linuxcnc", "fanuc", "siemens", "heidenhain")
COARSE, FINE = 1.0, 0.05  # µm
# mm, ends and centres with the decimals that the built-in machines keep
ROUNDED = {"linuxcnc": 1.5e-5, "fanuc": 1.5e-4, "siemens": 1.5e-5, "heidenhain": 1.5e-4}
SHARES = (np.arange(3) + 0.5) / 3
# Each control at a coarse tolerance, one at a fine one.
RUNS = [*((dialect, COARSE) for dialect in DIALECTS), pytest.param("linuxcnc", FINE, marks=pytest.mark.slow)]
# Wire programs are made of the blocks that the contour has, with stops between them.
FEW_RUNS = [RUNS[0], *(pytest.param(*run, marks=pytest.mark.slow) for run in RUNS[1:4]), RUNS[4]]


@pytest.fixture(scope="module")
def exact(rv40e_record: DesignRecord) -> ExactCurve:
    assert rv40e_record.compensation is not None
    return ExactCurve(equidistant=0.006, delta_max=rv40e_record.compensation.delta_max)


def asked(record: DesignRecord, **keys: Any) -> DesignRecord:
    """The same design with other keys under ``[export]``."""
    export = msgspec.structs.replace(record.spec.export, **keys)
    return replace(record, spec=msgspec.structs.replace(record.spec, export=export))


def off(exact: ExactCurve, z: np.ndarray, every: int = 1) -> np.ndarray:
    """Distance from the exact tooth, of every so many points [mm]."""
    chosen = z[::every]
    return exact.distance(np.stack([chosen.real, chosen.imag], axis=-1))


def passes_of(steps: list[Step]) -> list[list[Step]]:
    """Steps at the working height between the ways down and up, one list a pass."""
    ways = [k for k, step in enumerate(steps) if step.z != step.z_start]
    return [steps[down + 1 : up] for down, up in zip(ways[1::2], ways[2::2], strict=True)]


def contour_of(one: list[Step]) -> list[Step]:
    """A pass without the line and arc of lead-in and lead-out."""
    assert [step.code for step in (one[0], one[-1])] == [1, 1]
    return one[2:-2]


@pytest.mark.parametrize(("dialect", "tolerance_um"), RUNS)
def test_contour_follows_the_tooth_on_every_control(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, dialect: str, tolerance_um: float
) -> None:
    record = asked(rv40e_record, nc_dialect=dialect, chord_tolerance_um=tolerance_um)
    (written,) = GcodeExporter().write(record, tmp_path)
    steps = run((tmp_path / "grinding.nc").read_text(encoding="ascii"), dialect)
    (one,) = passes_of(steps)
    contour = contour_of(one)
    z = np.concatenate([along(step, SHARES) for step in contour])
    assert np.max(off(exact, z, 7)) <= 1e-3 * tolerance_um + ROUNDED[dialect]
    assert written.deviation is not None
    assert written.deviation.largest <= 1e-3 * tolerance_um + ROUNDED[dialect]
    rotated = np.unwrap(np.angle(z))
    assert rotated[-1] - rotated[0] == pytest.approx(-2.0 * math.pi, abs=1e-2)
    assert contour[0].start == contour[-1].end
    assert {step.side for step in steps} == {""}
    assert {step.feed for step in one[1:-1]} == {200.0}
    assert {step.feed for step in (one[0], one[-1])} == {500.0}


@pytest.mark.parametrize(
    ("dialect", "compensation", "side", "turn"),
    [
        ("linuxcnc", "G41", "left", -1.0),
        ("fanuc", "G42", "right", 1.0),
        ("siemens", "G41", "left", -1.0),
        ("heidenhain", "G42", "right", 1.0),
    ],
)
def test_compensated_contour_keeps_the_wheel_outside(
    rv40e_record: DesignRecord,
    exact: ExactCurve,
    tmp_path: Path,
    dialect: str,
    compensation: str,
    side: str,
    turn: float,
) -> None:
    record = asked(
        rv40e_record,
        nc_dialect=dialect,
        wheel_compensation=compensation,
        wheel_radius_mm=2.5,
        chord_tolerance_um=COARSE,
    )
    GcodeExporter().write(record, tmp_path)
    steps = run((tmp_path / "grinding.nc").read_text(encoding="ascii"), dialect)
    passes = passes_of(steps)
    assert len(passes) == 4 + 2  # 20 µm of stock at 5 µm a pass, and two of spark-out
    for one, left in zip(passes, (0.015, 0.010, 0.005, 0.0, 0.0, 0.0), strict=True):
        # Set off on the first straight move, which is longer than the wheel, taken off on the last.
        assert [step.side for step in one] == [*(len(one) - 1) * [side], ""]
        assert abs(one[0].end - one[0].start) >= 2.5
        contour = contour_of(one)
        z = np.concatenate([along(step, SHARES) for step in contour])
        assert np.sign(np.unwrap(np.angle(z))[-1] - np.angle(z[0])) == turn
        assert np.max(np.abs(off(exact, z, 31) - left)) <= 1e-3 * COARSE + ROUNDED[dialect]
        # The disc is opposite the wheel along the whole path; in the leads the wheel is outside the tips.
        tip = np.max(np.abs(z))
        for step in (one[0], one[1], *contour[::50], one[-2]):
            here, ahead = along(step, np.array([0.5, 0.501]))
            wheel = here + (1j if side == "left" else -1j) * 2.5 * (ahead - here) / abs(ahead - here)
            assert abs(wheel) > (abs(here) if step in contour else tip + 2.5 - 2e-4)
        # The lead-in goes round a circle that the wheel goes into.
        assert abs(one[1].start - one[1].centre) > 2.5


@pytest.mark.parametrize("dialect", DIALECTS)
@pytest.mark.parametrize("exporter", [GcodeExporter(), PolarExporter()], ids=["contour", "polar"])
def test_a_program_is_safe_from_its_first_block_to_its_last(
    eleven_lobes: DesignRecord, tmp_path: Path, dialect: str, exporter: GcodeExporter | PolarExporter
) -> None:
    record = asked(
        eleven_lobes, nc_dialect=dialect, wheel_compensation="G41", wheel_radius_mm=2.5, chord_tolerance_um=COARSE
    )
    exporter.write(record, tmp_path)
    text = (tmp_path / exporter_file(exporter)).read_text(encoding="ascii")
    steps = run(text, dialect)
    first, last = steps[0], steps[-1]
    assert first.code == 0
    assert first.start == first.end == 0j
    assert first.z == last.z == 11.5 + 20.0
    for step in steps[1:]:
        if step.code == 0:
            # Fast at the safe height, or straight up to it.
            assert min(step.z_start, step.z) == 31.5 or (step.start == step.end and step.z == 31.5)
        else:
            assert (step.spindle, step.coolant) == (3000.0, True)
    for word in {"heidenhain": ("TOOL CALL 1 Z", "Q339=+1", "M3", "M8")}.get(dialect, ("T1 ", "G54", "M3", "M8")):
        assert word in text
    assert re.findall(r"\bM(?:8|9|5|30)\b", text) == ["M8", "M9", "M5", "M30"]
    # A minute in air at the feed of the infeed is no more: that feed begins in front of the stock.
    slow = [step for step in steps if step.code == 1 and step.feed == 5.0 and step.c == step.c_start]
    assert sum(abs(step.end - step.start) for step in slow) <= 0.1 + 0.02 + 1e-9


def exporter_file(exporter: GcodeExporter | PolarExporter) -> str:
    return exporter.filenames[0]


@pytest.mark.parametrize("dialect", DIALECTS)
def test_feeds_stay_in_the_range_of_the_control_after_rounding(
    rv40e_record: DesignRecord, tmp_path: Path, dialect: str
) -> None:
    # At 2 m/min the shortest steps would need more than 9999.999 1/min of F.
    record = asked(
        rv40e_record, nc_dialect=dialect, wheel_radius_mm=2.5, feed_mm_per_min=2000.0, chord_tolerance_um=0.5
    )
    PolarExporter().write(record, tmp_path)
    text = (tmp_path / "grinding_polar.nc").read_text(encoding="ascii")
    words: list[str] = re.findall(r" F(\d+(?:\.\d+)?)\b", re.sub(r"\(.*?\)|;.*", "", text))
    decimals, most = {"linuxcnc": (4, 1e6), "fanuc": (3, 9999.999)}.get(dialect, (3, 99999.999))
    assert max(len(word.partition(".")[2]) for word in words) <= decimals
    assert min(map(float, words)) >= 0.001
    assert max(map(float, words)) <= most
    if dialect == "fanuc":
        assert max(map(float, words)) == pytest.approx(most, rel=1e-2)


# A digit more changes the numbers alone, not how a dialect turns: absolute steps once, incremental ones once.
@pytest.mark.parametrize(
    ("dialect", "c", "angle_decimals"),
    [
        *((each, "absolute", 3) for each in DIALECTS),
        ("siemens", "absolute", 4),
        ("fanuc", "incremental", 3),
        pytest.param("fanuc", "incremental", 4, marks=pytest.mark.slow),
    ],
)
def test_c_ends_on_whole_turns_at_the_digits_of_the_control(
    eleven_lobes: DesignRecord, tmp_path: Path, dialect: str, c: str, angle_decimals: int
) -> None:
    machine = tmp_path / "my.toml"
    machine.write_text(
        f'control = "{dialect}"\n[numbers]\nangle_decimals = {angle_decimals}\nc = "{c}"\n', encoding="utf-8"
    )
    # One digit lost in any of its thousands of steps shows.
    record = asked(eleven_lobes, machine=str(machine), wheel_radius_mm=2.5, chord_tolerance_um=COARSE)
    PolarExporter().write(record, tmp_path)
    text = (tmp_path / "grinding_polar.nc").read_text(encoding="ascii")
    assert {len(word) for word in re.findall(r"C[+-]?\d+\.(\d+)", text)} == {angle_decimals}
    turning = [step for step in run(text, dialect) if step.c != step.c_start and step.code == 1]
    # A control that keeps no more digits than it is given adds the steps up without loss.
    assert turning[-1].c - turning[0].c_start == pytest.approx(6 * 360.0, abs=1e-6)


def test_a_wheel_larger_than_the_least_concave_radius_is_refused(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    # 3.0714 mm is the published least concave radius; 6 µm of equidistant modification add to it.
    for exporter, keys in ((GcodeExporter(), {"wheel_compensation": "G41"}), (PolarExporter(), {})):
        with pytest.raises(
            ExportError, match=r"wheel_radius_mm = 3\.1 is not below the least concave radius"
        ) as caught:
            exporter.write(asked(rv40e_record, wheel_radius_mm=3.1, **keys), tmp_path)  # type: ignore[attr-defined]
        assert "3.077" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_contour_table_holds_arcs_normals_and_curvature(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path
) -> None:
    GcodePathExporter().write(rv40e_record, tmp_path)
    head, *rows = (tmp_path / "grinding_path.csv").read_text(encoding="ascii").splitlines()
    assert head == (
        "segment,x0_mm,y0_mm,x1_mm,y1_mm,turn,centre_x_mm,centre_y_mm,radius_mm,"
        "nx0,ny0,nx1,ny1,curvature_per_mm,length_mm,feed_mm_per_min"
    )
    t = dict(zip(head.split(","), np.array([row.split(",") for row in rows], float).T, strict=True))
    start, end = t["x0_mm"] + 1j * t["y0_mm"], t["x1_mm"] + 1j * t["y1_mm"]
    assert np.max(np.abs(start[1:] - end[:-1])) == 0.0
    centre = t["centre_x_mm"] + 1j * t["centre_y_mm"]
    n0, n1 = t["nx0"] + 1j * t["ny0"], t["nx1"] + 1j * t["ny1"]
    assert np.all((np.conj(start) * n0).real > 0.0)
    # Radial from the centre: outwards on a convex arc, inwards on a concave one.
    arcs = t["turn"] != 0.0
    for z, n in ((start, n0), (end, n1)):
        radial = (z - centre)[arcs] / t["radius_mm"][arcs]
        assert np.max(np.abs(radial + np.sign(t["curvature_per_mm"][arcs]) * n[arcs])) < 1e-6
    swept = np.angle(n1 / n0)
    assert t["length_mm"][arcs] == pytest.approx(np.abs(swept[arcs]) * t["radius_mm"][arcs], rel=1e-4)
    assert np.max(off(exact, start)) <= 1e-3 * FINE


@pytest.mark.parametrize(("dialect", "tolerance_um"), RUNS)
def test_polar_program_is_tangent_and_closes(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, dialect: str, tolerance_um: float
) -> None:
    record = asked(rv40e_record, nc_dialect=dialect, wheel_radius_mm=2.5, chord_tolerance_um=tolerance_um)
    PolarExporter().write(record, tmp_path)
    steps = run((tmp_path / "grinding_polar.nc").read_text(encoding="ascii"), dialect)
    turning = [step for step in steps if step.c != step.c_start and step.code == 1]
    turns = 4 + 2  # 20 µm of stock at 5 µm a turn, and two of spark-out
    count = len(turning) // turns
    assert len(turning) == turns * count
    last = turning[-count:]
    c, x = np.array([step.c_start for step in last]), np.array([step.start.real for step in last])
    assert np.all(np.diff(c) > 0.0)
    assert last[-1].c - last[0].c_start == pytest.approx(360.0, abs=1e-9)
    assert last[-1].end.real == pytest.approx(last[0].start.real, abs=1e-9)
    assert last[0].c_start == pytest.approx(180.0 / 39 + 360.0 * (turns - 1), abs=1e-4)
    # The envelope: the wheel's centre is one radius from the exact tooth, all along the steps.
    for share in (0.0, 0.25, 0.5, 0.75):
        at_c = np.radians(c + share * np.array([step.c - step.c_start for step in last]))
        at_x = x + share * np.array([step.end.real - step.start.real for step in last])
        wheel = off(exact, at_x * np.exp(-1j * at_c), 17)
        # Half a unit of X, and of C at 64 mm.
        assert np.max(np.abs(wheel - 2.5)) <= 1e-3 * tolerance_um + 0.8 * ROUNDED[dialect]
    # Infeeds of 5 µm from 15 µm away; the last three turns are identical.
    starts = [turning[k * count].start.real - last[0].start.real for k in range(turns)]
    assert starts == pytest.approx([0.015, 0.010, 0.005, 0.0, 0.0, 0.0], abs=1e-9)
    # At 200 mm/min along the flank no limit binds: the time of a step is proportional to its length along the tooth.
    time = np.array([seconds(step, dialect) for step in last])
    table = np.loadtxt(tmp_path / "grinding_polar_path.csv", delimiter=",", skiprows=1)
    flank = table[:, 4] + 1j * table[:, 5]
    # Apart from the steps that pass over a groove at root or tip, where the contact jumps.
    from_corner = np.abs((table[:, 3] + 0.5 * math.pi) % math.pi - 0.5 * math.pi)
    smooth = np.minimum(from_corner[:-1], from_corner[1:]) > 0.05
    # Chords fall short of arcs by the square of their bending, and five decimals of a step are worth 1e-4 of it.
    speed = 60.0 * np.abs(np.diff(flank))[smooth] / time[smooth]
    assert speed == pytest.approx(200.0, rel=2e-3)


@pytest.mark.parametrize(("dialect", "tolerance_um"), FEW_RUNS)
def test_wire_goes_round_everything_one_offset_away(
    rv40e_record: DesignRecord, exact: ExactCurve, tmp_path: Path, dialect: str, tolerance_um: float
) -> None:
    within = 1e-3 * tolerance_um + ROUNDED[dialect]
    record = asked(rv40e_record, nc_dialect=dialect, chord_tolerance_um=tolerance_um)
    (written,) = WireExporter().write(record, tmp_path)
    text = (tmp_path / "wire_edm.nc").read_text(encoding="ascii")
    steps = run(text, dialect)
    assert written.entities["contours"] == sum(step.code == 0 for step in steps) == 5
    assert text.count("THREAD THE WIRE") == text.count("CUT THE WIRE") == 5
    begins = [k for k, step in enumerate(steps) if step.code == 0]
    *openings, teeth = [steps[a:b] for a, b in itertools.pairwise([*begins, len(steps)])]
    # Bore and crank holes from their centres, at 0.18, 0.15 and 0.14 mm from the edge.
    crank_holes = [(36.0 * complex(np.exp(2j * np.pi * k / 3)), 13.0) for k in range(3)]
    for moves, (centre, radius) in zip(openings, [(0j, 16.0), *crank_holes], strict=True):
        assert abs(moves[0].end - centre) < ROUNDED[dialect]
        gaps = np.array([radius - np.abs(along(step, SHARES) - centre) for step in moves if step.code in (2, 3)])
        assert np.unique(np.round(gaps, 3)).tolist() == [0.14, 0.15, 0.18]
        assert np.max(np.abs(gaps - np.round(gaps, 2))) < 1.5 * ROUNDED[dialect]
    # From the start hole outside, to the teeth, round them, and away.
    assert abs(teeth[0].end) == pytest.approx(np.max(np.hypot(*exact.points.T)) + 3.0, abs=1e-3)
    z = np.concatenate([along(step, SHARES) for step in teeth[2:-1]])
    distance, angle = off(exact, z, 5), np.angle(z[::5])
    # Nothing is nearer to the tooth than the finishing cut, and each cut covers the whole disc.
    assert np.min(distance) >= 0.14 - within
    for offset in (0.14, 0.15, 0.18):
        there = np.sort(angle[np.abs(distance - offset) <= within])
        assert np.max(np.diff(np.append(there, there[0] + 2.0 * np.pi))) < 0.04


def test_wire_refuses_stock_that_does_not_fall(rv40e_record: DesignRecord, tmp_path: Path) -> None:
    wire = msgspec.structs.replace(rv40e_record.spec.export.wire, skim_stock_um=(10.0, 20.0))
    with pytest.raises(ExportError, match="skim_stock_um"):
        WireExporter().write(asked(rv40e_record, wire=wire), tmp_path)
