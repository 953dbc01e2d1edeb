"""Defective measured files are refused in one sentence or reported in a note; sound files are never refused.

Files come from the independent generator in ``blind``; the defects are applied to their columns here.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cycloid_profile.cli.main import run
from cycloid_profile.design import as_built_reducer
from cycloid_profile.diagnosis import Diagnosis, diagnose, screen_files
from cycloid_profile.diagnosis.data.recording import record
from cycloid_profile.diagnosis.data.screening import screen
from cycloid_profile.effects import AsBuiltReducer
from cycloid_profile.errors import MeasurementError
from cycloid_profile.measurement import Measurement, format_measurement, parse_measurement, read_measurement
from cycloid_profile.rig import Settings, simulate
from cycloid_profile.spec import parse_spec
from tests.diagnosis.blind import (
    KINDS,
    Hidden,
    Noise,
    Reducer,
    loop,
    lost_motion,
    scan,
    spec_text,
    transmission_error,
)

REDUCER = Reducer()
LOBES = REDUCER.lobes
RATED = REDUCER.rated_torque_nm
RUNOUT = (Hidden("disc_runout", {"amplitude_um": 3.0, "phase_deg": 40.0, "disc": 1}),)
SOFT = (Hidden("series_compliance", {"stiffness_nm_per_arcmin": 134.0}),)
OFF_CENTRE = (Hidden("encoder_eccentricity", {"amplitude_arcsec": 5.0, "phase_deg": 30.0}),)
RAD = math.radians(1.0)
Change = Callable[[Measurement], Measurement]


@cache
def reducer() -> AsBuiltReducer:
    """The reducer of the drawing."""
    return as_built_reducer(parse_spec(spec_text(REDUCER)))


@cache
def good(name: str) -> Measurement:
    """A file without defects."""
    text = {
        "scan": lambda: scan(REDUCER, RUNOUT, points=1200, noise=Noise(0.3), turn_deg=1.5, seed=1),
        "free": lambda: scan(
            REDUCER, RUNOUT, points=1200, noise=Noise(0.3), offset_um=(15.0, -8.0), datum="free", seed=1
        ),
        "loop": lambda: loop(REDUCER, SOFT, rows=120, noise=Noise(0.004), seed=1),
        "te": lambda: transmission_error(REDUCER, OFF_CENTRE, torque_nm=RATED, rows=240, noise=Noise(0.15), seed=1),
        "lost": lambda: lost_motion(REDUCER, RUNOUT, rows=240, noise=Noise(0.004), seed=1),
    }[name]()
    return parse_measurement(text, "bad.csv")


def times(factor: float, *columns: str) -> Change:
    """Columns in another unit, or with another sign."""
    return lambda m: replace(m, columns=dict(m.columns) | {c: factor * m[c] for c in columns})


def rows(chosen: Callable[[int], Any]) -> Change:
    """Selected or reordered rows; ``chosen`` receives the number of rows."""

    def change(m: Measurement) -> Measurement:
        which = chosen(next(iter(m.columns.values())).size)
        return replace(m, columns={c: values[which] for c, values in m.columns.items()})

    return change


def key(name: str, value: str) -> Change:
    return lambda m: replace(m, keys=dict(m.keys) | {name: value})


def backwards(n: int) -> slice:
    return slice(n - 1, None, -1)


def shuffled(n: int) -> np.ndarray:
    return np.random.default_rng(1).permutation(n)


REFUSED: dict[str, tuple[str, Change, str]] = {
    "scan in inch": ("scan", times(1.0 / 25.4, "x_mm", "y_mm"), "in inch"),
    "scan in µm": ("scan", times(1e3, "x_mm", "y_mm"), "in µm"),
    "scan in m": ("scan", times(1e-3, "x_mm", "y_mm"), "in m, not in mm"),
    "free scan in inch": ("free", times(1.0 / 25.4, "x_mm", "y_mm"), "in inch"),
    "free scan in µm": ("free", times(1e3, "x_mm", "y_mm"), "in µm"),
    "free scan in m": ("free", times(1e-3, "x_mm", "y_mm"), "in m, not in mm"),
    "scan of few points": ("scan", rows(lambda _: slice(0, 30)), "too few"),
    "scan of one point only": ("scan", rows(lambda n: np.zeros(n, dtype=int)), "points = 1 are too few"),
    "turn in rad": ("te", times(RAD, "output_angle_deg"), "in rad"),
    "turn of lost motion in rad": ("lost", times(RAD, "output_angle_deg"), "in rad"),
    "turn in arcmin": ("te", times(60.0, "output_angle_deg"), "arcmin"),
    "error in rad": ("te", times(RAD / 3600.0, "error_arcsec"), "rad"),
    "error in degrees": ("te", times(1.0 / 3600.0, "error_arcsec"), "degrees"),
    "no error at all": ("te", times(0.0, "error_arcsec"), "smaller than any encoder"),
    "error at no torque": ("te", key("torque_nm", "0"), "torque_nm = 0"),
    "torque of the error in N·mm": ("te", key("torque_nm", "412000"), "N·mm"),
    "torque of lost motion in N·mm": ("lost", key("torque_nm", "12360"), "N·mm"),
    "one output angle": ("te", times(0.0, "output_angle_deg"), "too few"),
    "few rows of error": ("te", rows(lambda _: slice(0, 5)), "too few"),
    "lost motion in arcsec": ("lost", times(60.0, "lost_motion_arcmin"), "may be in arcsec"),
    "lost motion in degrees": ("lost", times(1.0 / 60.0, "lost_motion_arcmin"), "may be in degrees"),
    "lost motion in rad": ("lost", times(RAD / 60.0, "lost_motion_arcmin"), "may be in rad"),
    "lost motion the other way round": ("lost", times(-1.0, "lost_motion_arcmin"), "+torque"),
    "loop in degrees": ("loop", times(1.0 / 60.0, "angle_arcmin"), "may be in degrees"),
    "loop in arcsec": ("loop", times(60.0, "angle_arcmin"), "may be in arcsec"),
    "loop in rad": ("loop", times(RAD / 60.0, "angle_arcmin"), "may be in rad"),
    "loop in N·mm": ("loop", times(1e3, "torque_nm"), "N·mm"),
    "loop in kN·m": ("loop", times(1e-3, "torque_nm"), "kN·m"),
    "loop without torque": ("loop", times(0.0, "torque_nm"), "torque"),
    "loop at one torque": ("loop", lambda m: replace(m, columns=dict(m.columns) | {
        "torque_nm": np.full_like(m["torque_nm"], RATED)}), "hardly changes"),
    "loop without angle": ("loop", times(0.0, "angle_arcmin"), "angle"),
    "loop with its angle turned round": ("loop", times(-1.0, "angle_arcmin"), "signs"),
    "loop with its torque turned round": ("loop", times(-1.0, "torque_nm"), "signs"),
    "loop in disorder": ("loop", rows(shuffled), "order"),
    "loop of few rows": ("loop", rows(lambda _: slice(0, 8)), "rows = 8"),
}  # fmt: skip
# With the same number of teeth, and with others.
OTHER_DRIVES = {
    "one pin more": {"pins": 41},
    "one pin fewer": {"pins": 39},
    "30 pins": {"pins": 30, "eccentricity_mm": 1.6},
    "less eccentricity": {"eccentricity_mm": 1.25},
    "more eccentricity": {"eccentricity_mm": 1.35},
    "smaller pin circle": {"pin_circle_radius_mm": 63.9},
    "much smaller pin circle": {"pin_circle_radius_mm": 63.0},
    "larger pin circle": {"pin_circle_radius_mm": 64.2},
    "thinner pins": {"pin_radius_mm": 2.9},
    "a ball that was left on": {"pin_radius_mm": 2.0},
}


# The rules that all commands share; ``diagnose`` and ``compare`` are asked below, with a mistake of each kind of file.
@pytest.mark.parametrize("mistake", REFUSED)
def test_mistake_is_refused(mistake: str) -> None:
    name, change, named = REFUSED[mistake]
    with pytest.raises(MeasurementError, match=r"bad\.csv") as refusal:
        screen_files(reducer(), [change(good(name))])
    sentence = str(refusal.value)
    assert named in sentence
    assert "\n" not in sentence
    assert "nan" not in sentence


@pytest.mark.parametrize("mistake", ["loop in N·mm", "loop in disorder", "turn in rad", "loop at one torque"])
def test_compare_refuses_what_diagnose_refuses(
    mistake: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, change, named = REFUSED[mistake]
    assert named in _refused_by_the_command(format_measurement(change(good(name))), tmp_path, capsys, "compare")


def test_file_of_another_program_in_another_unit_is_read_as_its_refusal_advises(tmp_path: Path) -> None:
    ours, file = times(1e3, "x_mm", "y_mm")(good("scan")), tmp_path / "bad.csv"
    np.savetxt(file, np.stack([ours["x_mm"], ours["y_mm"]], axis=1), header="x,y", delimiter=",", comments="")
    with pytest.raises(MeasurementError, match="in µm") as refusal:
        screen_files(reducer(), [read_measurement(file)])
    advice = re.search(r"or add --columns (\S+)", str(refusal.value))
    assert advice is not None
    screen_files(reducer(), [read_measurement(file, [advice[1]])])
    # A file of our own names its columns.
    with pytest.raises(MeasurementError, match="in µm") as refusal:
        screen_files(reducer(), [ours])
    assert "--columns" not in str(refusal.value)


def test_scan_about_another_origin_is_refused_with_its_distance() -> None:
    text = scan(REDUCER, (), points=1200, noise=Noise(0.3), offset_um=(180.0, -240.0), seed=1)
    measured = parse_measurement(text, "bad.csv")
    with pytest.raises(MeasurementError, match=r"origin = 0\.300 mm off the bore axis .*'# datum: free'"):
        screen(reducer(), measured)
    screen(reducer(), key("datum", "free")(measured))


def test_small_transmission_error_is_believed_where_the_prediction_is_as_small() -> None:
    light = simulate(reducer(), "transmission_error", Settings(torque=8e3, points=240))
    assert np.std(light["error_arcsec"]) < 0.01  # no encoder resolves less, and at full load none is as small
    assert diagnose(reducer(), [light]).verdict == "agrees"
    # Rounding of another machine: no error, though it is all that is left.
    rounded = light["error_arcsec"] * (1.0 + 1e-13 * np.random.default_rng(0).normal(size=240))
    again = replace(light, columns={**light.columns, "error_arcsec": rounded})
    assert diagnose(reducer(), [again]).verdict == "agrees"
    rated = replace(light, keys={**light.keys, "torque_nm": f"{RATED}"})
    with pytest.raises(MeasurementError, match="smaller than any encoder sees"):
        diagnose(reducer(), [rated])


@pytest.mark.parametrize("torque", ["412000", "-412000"])
def test_turn_at_an_overload_of_either_sign_is_refused(torque: str) -> None:
    turn = good("te")
    with pytest.raises(MeasurementError, match=r"is over 20 times the rated 412 N·m: check the unit"):
        diagnose(reducer(), [replace(turn, keys={**turn.keys, "torque_nm": torque})])


@pytest.mark.parametrize("held_out", [False, True])
def test_file_given_twice_is_refused(held_out: bool) -> None:
    scan, loop = good("scan"), good("loop")
    copy = replace(scan, name="copy.csv")
    files, checks = ([scan, loop], [copy]) if held_out else ([scan, loop, copy], [])
    with pytest.raises(MeasurementError, match=r"copy\.csv: rows are those of bad\.csv"):
        diagnose(reducer(), files, held_out=checks)


@pytest.mark.parametrize("datum", ["bore", "free"])
@pytest.mark.parametrize("drive", OTHER_DRIVES)
def test_scan_of_another_drive_is_refused(drive: str, datum: str) -> None:
    other = replace(REDUCER, **OTHER_DRIVES[drive])
    measured = parse_measurement(scan(other, (), points=1200, noise=Noise(0.3), datum=datum, seed=2), "bad.csv")
    reason = {"less eccentricity": "median deviation .*", "thinner pins": "median distance .*"}.get(drive, "")
    if other.pins != REDUCER.pins:
        reason = f"lobes = {other.pins - 1} are not the {REDUCER.pins - 1} of this drive.*"
    with pytest.raises(MeasurementError, match=f"{reason}scan of another disc"):
        diagnose(reducer(), [measured])


@pytest.mark.parametrize("mistake", ["scan in µm", "turn in rad", "loop in disorder", "lost motion in arcsec"])
def test_command_refuses_in_one_sentence_and_writes_nothing(
    mistake: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    name, change, named = REFUSED[mistake]
    assert named in _refused_by_the_command(format_measurement(change(good(name))), tmp_path, capsys)


@pytest.mark.parametrize(
    ("body", "named"),
    [
        ("", "kind"),
        ("# kind: profile_scan\n", "header"),
        ("# kind: profile_scan\nx_mm,y_mm\n", "rows = 0"),
        ("# kind: profile_scan\nx_mm,y_mm\n59.7,0.0\n", "rows = 1"),
        ("# kind: profile_scan\nx_mm,y_mm\n59.7,0.0\n59.7,0.1\n", "points = 2"),
        ("# kind: profile_scan\nx_mm,y_mm\n59.7,0.0\nnan,nan\n", "line 4"),
        ("# kind: profile_scan\nx_mm,y_mm\n59.7,0.0\n59.7\n", "line 4"),
        ("# kind: hysteresis\ntorque_nm,angle_arcmin\n0.0,0.0\n1.0,inf\n", "line 4"),
        ("# kind: transmission_error\noutput_angle_deg,error_arcsec\n0.0,0.0\n", "torque_nm"),
    ],
)
def test_file_with_hardly_anything_in_it_is_refused(
    body: str, named: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert named in _refused_by_the_command(body, tmp_path, capsys)


def _refused_by_the_command(
    text: str, folder: Path, capsys: pytest.CaptureFixture[str], command: str = "diagnose"
) -> str:
    """The sentence of the command, which wrote nothing else."""
    spec, file = folder / "spec.toml", folder / "bad.csv"
    spec.write_text(spec_text(REDUCER), encoding="utf-8")
    file.write_text(text, encoding="utf-8")
    json = [] if command == "compare" else ["--json", str(folder / "result.json")]
    assert run([command, str(spec), str(file), "--out", str(folder / "out"), *json]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (sentence,) = [line for line in err.splitlines() if not line.startswith("…")]
    assert sentence.startswith("cycloid-profile: ")
    assert sorted(f.name for f in folder.iterdir()) == ["bad.csv", "spec.toml"]
    return sentence


def _is_the_runout(found: Diagnosis, phase: float = 40.0) -> None:
    (effect,) = found.effects
    assert effect.candidate.name == "disc_runout"
    # The stated uncertainty is 0.02 µm and 0.3°; the noise is drawn once.
    assert effect.parameters["amplitude_um"] == pytest.approx(3.0, abs=0.1)
    assert effect.parameters["phase_deg"] == pytest.approx(phase, abs=2.0)


@pytest.mark.parametrize(
    ("change", "phase", "note"),
    [
        pytest.param(rows(backwards), 40.0, "anticlockwise", marks=pytest.mark.slow),
        # Seen from behind all angles are mirrored, which only the order of the points reveals.
        (times(-1.0, "y_mm"), 320.0, "anticlockwise"),
        pytest.param(
            rows(lambda n: np.sort(np.concatenate([np.arange(n), np.arange(0, n, 10)]))),
            40.0,
            "repeat a position",
            marks=pytest.mark.slow,
        ),
        (rows(lambda n: np.concatenate([np.arange(n), np.arange(0, n, 10)])), 40.0, "repeat a position"),
        (rows(lambda n: slice(0, n // 2)), 40.0, "of 39 lobes were not scanned"),
        (rows(shuffled), 40.0, ""),
    ],
    ids=["reversed", "mirrored", "points twice", "beginning again", "half of the disc", "shuffled"],
)
def test_scan_with_reordered_rows_is_diagnosed(change: Change, phase: float, note: str) -> None:
    found = diagnose(reducer(), [change(good("scan"))])
    # The scan is rotated by 1.5°, which rotates the angle of the runout.
    _is_the_runout(found, phase)
    assert (note in " ".join(found.notes)) if note else not found.notes


def test_scan_with_missing_lobes_is_diagnosed() -> None:
    text = scan(REDUCER, RUNOUT, points=1600, noise=Noise(0.3), missing_lobes=range(1, LOBES, 2), seed=1)
    found = diagnose(reducer(), [parse_measurement(text, "half.csv")])
    _is_the_runout(found)
    assert any("half.csv: 19 of 39 lobes were not scanned" in note for note in found.notes)


@pytest.mark.parametrize(
    "size_um", [pytest.param(10.0, marks=pytest.mark.slow), 100.0, pytest.param(500.0, marks=pytest.mark.slow)]
)
def test_scan_with_gross_errors_is_diagnosed(size_um: float) -> None:
    draw = np.random.default_rng(3)
    measured = good("scan")
    x, y = measured["x_mm"].copy(), measured["y_mm"].copy()
    hit = draw.choice(x.size, x.size // 100, replace=False)
    # Errors along the radius; on the sides of the lobes only a component is normal to the flank.
    grown = 1.0 + draw.choice([-1.0, 1.0], hit.size) * size_um * 1e-3 / np.hypot(x[hit], y[hit])
    x[hit], y[hit] = x[hit] * grown, y[hit] * grown
    found = diagnose(reducer(), [replace(measured, columns={"x_mm": x, "y_mm": y})])
    _is_the_runout(found)
    assert any("reading errors are omitted" in note for note in found.notes)


def test_note_on_few_gross_errors_gives_their_lobe() -> None:
    measured = good("scan")
    x, y = measured["x_mm"].copy(), measured["y_mm"].copy()
    grown = 1.0 - 0.02 / np.hypot(x[1000], y[1000])
    x[1000], y[1000] = x[1000] * grown, y[1000] * grown
    found = record(reducer(), replace(measured, columns={"x_mm": x, "y_mm": y}))
    (note,) = found.notes
    named_lobe = re.search(r"on lobe (\d+): a pit narrower than the point spacing", note)
    assert named_lobe is not None
    # Equal arcs from the root of lobe 1, clockwise; the file may be rotated by less than half a lobe.
    assert abs(int(named_lobe[1]) - (1.0 + 39.0 * 1000 / x.size)) < 1.0


@pytest.mark.slow
def test_loop_with_gross_errors_is_diagnosed() -> None:
    measured = good("loop")
    angle = measured["angle_arcmin"].copy()
    angle[[30, 80]] += 10.0
    found = diagnose(reducer(), [replace(measured, columns=dict(measured.columns) | {"angle_arcmin": angle})])
    (effect,) = found.effects
    assert effect.candidate.name == "series_compliance"
    assert effect.parameters["stiffness_nm_per_arcmin"] == pytest.approx(134.0, rel=0.01)
    assert any("2 reading errors are omitted" in note for note in found.notes)


@pytest.mark.slow
def test_loop_with_repeated_rows_is_diagnosed() -> None:
    twice = rows(lambda n: np.sort(np.concatenate([np.arange(n), np.arange(0, n, 10)])))
    (effect,) = diagnose(reducer(), [twice(good("loop"))]).effects
    assert effect.candidate.name == "series_compliance"
    assert effect.parameters["stiffness_nm_per_arcmin"] == pytest.approx(134.0, rel=0.01)


@pytest.mark.slow
def test_transmission_error_with_decreasing_angles_is_sorted() -> None:
    measured = good("te")
    there, back = record(reducer(), measured), record(reducer(), rows(backwards)(measured))
    assert not there.notes
    assert "the angles decrease" in back.notes[0]
    # The same rows in the same order with the same held-out rows give the same result.
    size = measured["error_arcsec"].size
    np.testing.assert_array_equal(size - 1 - back.rows, there.rows)
    np.testing.assert_array_equal(back.held_out, there.held_out)
    assert back.noise == there.noise
    found = diagnose(reducer(), [rows(backwards)(measured)])
    (effect,) = found.effects
    assert effect.candidate.name == "encoder_eccentricity"
    assert effect.parameters["amplitude_arcsec"] == pytest.approx(5.0, abs=0.2)
    assert any("the angles decrease" in note for note in found.notes)


OF_SCANS = sorted(name for name, kind in KINDS.items() if "scan" in kind.shows)


def _sized(names: Sequence[str], size: float, seed: int) -> list[Hidden]:
    """Effects of this size, other parameters random; on disc 1."""
    draw = np.random.default_rng(seed)
    found = []
    for name in names:
        kind = KINDS[name]
        one = kind.draw(name, REDUCER, 1.0, (1,), draw)
        sign = math.copysign(1.0, one[kind.key])
        found.append(Hidden(name, {k: v for k, v in one.parameters.items() if k != "disc"} | {kind.key: sign * size}))
    return found


@given(
    names=st.lists(st.sampled_from(OF_SCANS), unique=True, max_size=len(OF_SCANS)),
    size=st.floats(0.1, 5.0),
    free=st.booleans(),
    turn=st.floats(-180.0, 180.0),
    first=st.integers(1, LOBES),
    missing=st.integers(0, 29),
    seed=st.integers(0, 2**20),
)
def test_healthy_scan_is_never_refused(
    names: list[str], size: float, free: bool, turn: float, first: int, missing: int, seed: int
) -> None:
    text = scan(
        REDUCER,
        _sized(names, size, seed),
        points=800,
        noise=Noise(0.3),
        turn_deg=turn,
        datum="free" if free else "bore",
        offset_um=(20.0, -20.0) if free else (0.0, 0.0),
        missing_lobes=[(first - 1 + i) % LOBES + 1 for i in range(missing)],
        seed=seed,
    )
    measured = parse_measurement(text, "good.csv")
    screen(reducer(), measured)
    record(reducer(), measured)


HEALTHY = {
    "none": (),
    "soft shafts": (Hidden("series_compliance", {"stiffness_nm_per_arcmin": 60.0}),),
    "play": (Hidden("crank_bearing_clearance", {"radial_um": 10.0}),),
    "tight": (Hidden("equidistant_error", {"amount_um": -5.0}),),
    "loose": (Hidden("equidistant_error", {"amount_um": 5.0}),),
    "soft, loose and with play": (
        Hidden("series_compliance", {"stiffness_nm_per_arcmin": 60.0}),
        Hidden("crank_bearing_clearance", {"radial_um": 10.0}),
        Hidden("equidistant_error", {"amount_um": 5.0}),
    ),
}
FRICTION = (Hidden("coulomb_friction", {"torque_nm": 20.0}),)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.3, 1.0, 1.5])
@pytest.mark.parametrize("effects", HEALTHY)
def test_healthy_loop_is_never_refused(effects: str, share: float) -> None:
    for friction in ((), FRICTION):
        text = loop(REDUCER, HEALTHY[effects] + friction, rows=120, peak_nm=share * RATED, noise=Noise(0.01), seed=4)
        screen(reducer(), parse_measurement(text, "good.csv"))


@pytest.mark.slow
@pytest.mark.parametrize("torque", [0.03 * RATED, RATED])
@pytest.mark.parametrize("effects", HEALTHY)
def test_healthy_turn_is_never_refused(effects: str, torque: float) -> None:
    error = transmission_error(REDUCER, HEALTHY[effects], torque_nm=torque, rows=90, noise=Noise(0.05), seed=5)
    lost = lost_motion(REDUCER, HEALTHY[effects], torque_nm=torque, rows=90, noise=Noise(0.004), seed=5)
    for text in (error, lost):
        screen(reducer(), parse_measurement(text, "good.csv"))


def test_clearance_is_accepted_for_a_spec_without_clearance() -> None:
    tight = as_built_reducer(parse_spec(spec_text(replace(REDUCER, equidistant_um=0.0))))
    loose = replace(REDUCER, equidistant_um=10.0)
    for peak in (0.1 * RATED, RATED):
        screen(tight, parse_measurement(loop(loose, HEALTHY["play"], rows=120, peak_nm=peak), "good.csv"))
    screen(tight, parse_measurement(lost_motion(loose, HEALTHY["play"], rows=90), "good.csv"))
