"""Measured files of other programs on the command line: one command, ``--columns``, and the mapping that is kept."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from cycloid_profile.cli.main import run
from tests.diagnosis.blind import Reducer, spec_text

FILES = Path(__file__).parents[1] / "measurement" / "foreign" / "files"
MAPPING = ".mapping.toml"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a spec and some files."""
    (tmp_path / "spec.toml").write_text(spec_text(Reducer()), encoding="utf-8")
    for name in ("pandas_x_y_dev.csv", "bench_german.csv", "cmm_unnamed.csv", "faults_many.csv", "cmm_origin_off.csv"):
        shutil.copy(FILES / name, tmp_path / name)
    return tmp_path


def compare(folder: Path, name: str, *more: str) -> int:
    return run(["compare", str(folder / "spec.toml"), str(folder / name), "--out", str(folder / "out"), *more])


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("pandas_x_y_dev.csv", ("x=X,y=Y", "decimal commas", "datum bore, as nothing else is said", "measured points")),
        ("bench_german.csv", ("torque=Drehmoment[Nm]", "angle=Verdrehung[°]", "cp1252", "not used: Temp.")),
    ],
)
def test_a_foreign_file_takes_one_command(
    name: str, said: tuple[str, ...], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(folder, name) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert f"note: {name}: read as" in out
    for word in said:
        assert word in out
    assert compare(folder, name, "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)["gap"]
    assert row["notes"][0].startswith("read as")
    assert row["rms"] > 0.0
    assert not (folder / MAPPING).exists()


def test_columns_are_kept_for_the_next_file_of_that_header(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert compare(folder, "cmm_unnamed.csv") == 2
    assert "name them with --columns" in capsys.readouterr().err
    assert compare(folder, "cmm_unnamed.csv", "--columns", "x=Q1,y=Q2,unit=mm") == 0
    assert f"columns are kept in {folder / MAPPING}" in capsys.readouterr().err
    shutil.copy(folder / "cmm_unnamed.csv", folder / "next.csv")
    assert compare(folder, "next.csv") == 0
    assert f"columns from {MAPPING}" in capsys.readouterr().out
    # A file of another header is not touched by it.
    assert compare(folder, "bench_german.csv") == 0
    assert MAPPING not in capsys.readouterr().out


def test_the_torque_of_one_file_is_not_kept(folder: Path) -> None:
    shutil.copy(FILES / "pandas_te_without_torque.csv", folder / "te.csv")
    assert compare(folder, "te.csv", "--columns", "torque_nm=412") == 0
    assert not (folder / MAPPING).exists()
    assert compare(folder, "te.csv") == 2


def test_columns_for_files_of_our_own_are_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(FILES.parent / "reference" / "scan.csv", folder / "own.csv")
    assert compare(folder, "own.csv", "--columns", "datum=free") == 2
    assert "no file of another program" in capsys.readouterr().err


def test_a_file_of_that_name_that_is_not_ours_stays(folder: Path) -> None:
    (folder / MAPPING).write_text("mine = 1\n", encoding="utf-8")
    assert compare(folder, "cmm_unnamed.csv", "--columns", "x=Q1,y=Q2,unit=mm") == 0
    assert (folder / MAPPING).read_text(encoding="utf-8") == "mine = 1\n"


def test_the_spec_can_hold_the_columns(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (folder / "spec.toml").read_text(encoding="utf-8")
    columns = '[measurement]\ncolumns = ["torque=M[N·m],angle=phi[deg]", "x=Q1,y=Q2,unit=mm"]\n'
    (folder / "spec.toml").write_text(f"{text}\n{columns}", encoding="utf-8")
    assert compare(folder, "cmm_unnamed.csv") == 0
    assert "columns from [measurement] of the spec" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "columns", "said"),
    [
        ("cmm_unnamed.csv", "x=Q1,y=Q3", "'Q3' is not a column among Q1, Q2: did you mean Q2?"),
        ("cmm_unnamed.csv", "x=Q1,yy=Q2", "'yy' is not known: did you mean y?"),
        ("cmm_unnamed.csv", "x=Q1,x=Q2", "'x' is given twice"),
        ("cmm_unnamed.csv", "x=Q1[furlong],y=Q2", "'furlong' is not a unit of it"),
        ("cmm_unnamed.csv", "x=Q1,y=Q2,unit=ell", "'ell' is not known"),
        ("cmm_unnamed.csv", "x=Q1,y=Q2,probe_radius_mm=-1", "is not between 0 and 50 mm"),
        ("cmm_unnamed.csv", "x=Q1,y=Q2,torque_nm=1_0", "'1_0' is not a number"),
        ("cmm_unnamed.csv", "x", "'x' has no value"),
        ("faults_many.csv", "unit=arcmin", "line 6 = '5_9.694'"),
        ("cmm_origin_off.csv", "unit=mm", "--columns datum=free"),
    ],
)
def test_faults_end_in_one_sentence_and_leave_nothing(
    name: str, columns: str, said: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = sorted(folder.rglob("*"))
    assert compare(folder, name, "--columns", columns) == 2
    out, err = capsys.readouterr()
    assert out == ""
    (sentence,) = [line for line in err.splitlines() if not line.startswith("…")]
    assert said in sentence
    assert sorted(folder.rglob("*")) == before


def test_all_files_are_checked_before_the_first_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = [str(folder / name) for name in ("faults_many.csv", "cmm_unnamed.csv")]
    assert run(["diagnose", str(folder / "spec.toml"), *words, "--out", str(folder / "out")]) == 2
    err = capsys.readouterr().err
    assert "faults_many.csv: line 6" in err
    assert "'Q1', 'Q2'" in err


def test_a_file_given_twice_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scan = str(folder / "pandas_x_y_dev.csv")
    assert compare(folder, "pandas_x_y_dev.csv", scan) == 2
    assert "name each file once" in capsys.readouterr().err
    assert run(["diagnose", str(folder / "spec.toml"), scan, "--held-out", scan, "--out", str(folder / "out")]) == 2
    assert "hold out another file" in capsys.readouterr().err


@pytest.mark.slow
def test_correct_reads_them_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["correct", str(folder / "spec.toml"), str(folder / "cmm_unnamed.csv"), "--out", str(folder / "out")]
    assert run([*words, "--columns", "x=Q1,y=Q2,unit=mm", "--json"]) == 0
    out, err = capsys.readouterr()
    assert "read as profile scan" in err
    assert [one["name"] for one in json.loads(out)["effects"]] == ["disc_runout"]
