"""The command line as a user meets it: contracts of its JSON, exit status, one-sentence refusals, whole files."""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import subprocess
import sys
import time
import xml.dom.minidom
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.design import design_disc, summary
from cycloid_profile.report.design import terminal_tables, warnings
from cycloid_profile.spec import read_spec
from tests.spec_texts import RIGID_EXAMPLE

ROOT = Path(__file__).parents[2]
RV40E = ROOT / "examples" / "rv40e.toml"
TEXT = RIGID_EXAMPLE
SHARING_KEYS = {"max_force_n", "delta_max_um", "loaded_pins", "max_pressure_mpa"}
ACCURACY_KEYS = {
    "backlash_arcmin", "lost_motion_arcmin", "torsional_rigidity_nm_per_arcmin", "transmission_error_arcsec",
}  # fmt: skip
# Short files, where their content is not asked.
COARSE = ("chord_tolerance_um = 0.05", "chord_tolerance_um = 1.0")
CONTRACT = {
    "classical": SHARING_KEYS, "equilibrium": SHARING_KEYS, "conventional": ACCURACY_KEYS, "compensated": ACCURACY_KEYS,
}  # fmt: skip


@pytest.fixture
def changed(tmp_path: Path) -> Callable[..., Path]:
    """Writes the RV-40E spec with some text replaced."""

    def write(*pairs: tuple[str, str]) -> Path:
        text = TEXT
        for old, new in pairs:
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / "spec.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="module")
def build_of_rv40e(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The RV-40E built once: the folder, and what was printed."""
    parent, out = tmp_path_factory.mktemp("built"), io.StringIO()
    (parent / "spec.toml").write_text(TEXT, encoding="utf-8")
    folder = parent / "rv40e"
    with contextlib.redirect_stdout(out):
        assert run(["build", str(parent / "spec.toml"), "--out", str(folder)]) == 0
    return folder, out.getvalue()


@pytest.fixture
def reducer(build_of_rv40e: tuple[Path, str]) -> Path:
    return build_of_rv40e[0]


@pytest.fixture(scope="module")
def accuracy_of_rv40e(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], str]:
    """Figures of the RV-40E with elastic discs, and what was printed besides."""
    folder, out, err = tmp_path_factory.mktemp("accuracy"), io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        assert run(["accuracy", str(RV40E), "--json", "--out", str(folder)]) == 0
    return json.loads(out.getvalue()), err.getvalue()


def test_accuracy_json_keeps_its_contract(accuracy_of_rv40e: tuple[dict[str, Any], str]) -> None:
    figures, err = accuracy_of_rv40e
    assert figures["schema"] == 1
    assert figures["name"] == "RV-40E"
    assert figures["short_width_ratio"] == 0.8125
    assert figures["radial_clearance_um"] == 6.0
    for table, keys in CONTRACT.items():
        assert keys <= set(figures[table])
        assert all(isinstance(figures[table][key], int | float) for key in keys)
    assert err, "progress belongs on stderr"
    assert Path(figures["picture"]).is_file()


def test_accuracy_of_the_rv40e_with_elastic_discs(accuracy_of_rv40e: tuple[dict[str, Any], str]) -> None:
    # An independent finite-element model of one disc (ring of 61 mm, no lobes) has 3.75 µm, 3.47 to 4.21 over a pitch.
    figures, _ = accuracy_of_rv40e
    assert 3.47 < figures["compensation"]["delta_max_um"] < 4.21
    assert figures["conventional"]["backlash_arcmin"] == pytest.approx(0.8137, rel=0.004)
    change = figures["compensated"]["backlash_arcmin"] - figures["conventional"]["backlash_arcmin"]
    delta = figures["compensation"]["delta_max_um"]
    assert change == pytest.approx(-2e-3 * delta / (1.3 * 39) * 3437.747, rel=1e-2)


def test_accuracy_of_the_rv40e_with_rigid_discs(
    changed: Callable[..., Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    # Lost motion 0.851′ and rigidity about 560 N·m/′ come from an independent simulation of the same drive;
    # backlash of 6 µm is 2·6 µm/(a z_c), up to 0.3 % more between the poses with a pin at ψ0.
    run(["accuracy", str(changed()), "--json", "--out", str(tmp_path)])
    figures = json.loads(capsys.readouterr().out)
    assert figures["conventional"]["lost_motion_arcmin"] == pytest.approx(0.851, abs=0.001)
    assert figures["conventional"]["torsional_rigidity_nm_per_arcmin"] == pytest.approx(560.0, rel=0.01)
    assert figures["conventional"]["backlash_arcmin"] == pytest.approx(0.8137, rel=0.004)
    change = figures["compensated"]["backlash_arcmin"] - figures["conventional"]["backlash_arcmin"]
    delta = figures["compensation"]["delta_max_um"]
    assert change == pytest.approx(-2e-3 * delta / (1.3 * 39) * 3437.747, rel=1e-3)


def test_given_limits_decide_the_exit_status_and_assumed_data_do_not(
    changed: Callable[..., Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    torque = "rated_torque_nm = 412.0"
    too_long = f"{torque}\nrequired_life_h = 50000.0"
    rated = f"[drive.crank_bearing]\ndynamic_load_rating_n = 13000.0\n{TEXT[TEXT.index('[drive.first_stage]') :]}"
    assert run(["accuracy", str(changed((torque, too_long))), "--out", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert "at least 50000 h: advised against" in out
    assert "not checked: give load.allowable_pin_stress_mpa" in out
    assert "seals, churning, main bearings and first stage are excluded" in out
    assert "advice: life of a crank bearing" in err
    assert "estimated" in err
    given = changed((TEXT[TEXT.index("[drive.first_stage]") :], rated), (torque, too_long))
    assert run(["accuracy", str(given), "--out", str(tmp_path)]) == 1
    out, err = capsys.readouterr()
    assert "at least 50000 h: failed" in out
    assert "life of a crank bearing" in err


def test_build_writes_the_whole_set(reducer: Path) -> None:
    names = {str(path.relative_to(reducer)) for path in reducer.rglob("*") if path.is_file()}
    files = {"profile.csv", "profile.dxf", "grinding.nc", "cmm_nominal.csv", "manifest.json", "report.html"}
    assert files <= names
    plots = {name for name in names if name.startswith("plots")}
    assert len(plots) == 16
    assert {Path(name).suffix for name in plots} == {".png", ".svg"}
    assert not list(reducer.glob(".*")), "scratch folders are gone"


def test_manifest_lists_every_file_with_its_hash_and_measured_error(reducer: Path) -> None:
    manifest = json.loads((reducer / "manifest.json").read_text(encoding="utf-8"))
    listed = {entry["path"]: entry for entry in manifest["files"]}
    present = {str(path.relative_to(reducer)) for path in reducer.rglob("*") if path.is_file()} - {"manifest.json"}
    assert set(listed) == present
    for name, entry in listed.items():
        data = (reducer / name).read_bytes()
        assert entry["bytes"] == len(data)
        assert entry["sha256"] == hashlib.sha256(data).hexdigest()
        if entry["tolerance_um"] is not None:
            assert 0.0 < entry["deviation_um"] <= entry["tolerance_um"]
            assert entry["read_back_with"]


def test_report_stands_alone_and_holds_the_pictures(reducer: Path) -> None:
    html = (reducer / "report.html").read_text(encoding="utf-8")
    assert html.count("<svg") == 8
    assert "src=" not in html
    assert "No check failed, but 4 could not be made for want of data." in html
    ids = [part.split('"')[0] for part in html.split(' id="')[1:]]
    assert len(ids) == len(set(ids)), "ids of the pictures must not clash"


def test_build_prints_figures_with_units(build_of_rv40e: tuple[Path, str]) -> None:
    for unit in ("[′]", "[N·m/′]", "[″]", "[N]", "[µm]", "[MPa]"):
        assert unit in build_of_rv40e[1]


BAD = [
    ("unknown key", [("pins = 40", "pinz = 40")], "did you mean drive.pins?"),
    ("wrong unit", [("pin_radius_mm = 3.0", "pin_radius_um = 3000.0")], "write pin_radius_mm = 3"),
    ("not toml", [("pins = 40", "pins = ")], "is not valid TOML"),
    ("K1", [("eccentricity_mm = 1.3", "eccentricity_mm = 1.6")], "keep the eccentricity below 1.6000 mm"),
    ("overlap", [("pins = 40", "pins = 80"), ("eccentricity_mm = 1.3", "eccentricity_mm = 0.4")], "pins overlap"),
    ("undercut", [("pin_radius_mm = 3.0", "pin_radius_mm = 4.7")], "undercut limit 4.6117 mm"),
    ("zero width", [("disc_width_mm = 11.5", "disc_width_mm = 0")], "must be >= 0.001"),
    ("negative width", [("disc_width_mm = 11.5", "disc_width_mm = -2.0")], "must be >= 0.001"),
    ("torque 0", [("rated_torque_nm = 412.0", "rated_torque_nm = 0")], "must be >= 1e-06"),
    ("nan", [("pin_circle_radius_mm = 64.0", "pin_circle_radius_mm = nan")], "not a finite number"),
    ("modification beyond the pin", [("equidistant_um = 6.0", "equidistant_um = -3001.0")], "smaller modification"),
    ("modified tooth undercut", [("equidistant_um = 6.0", "equidistant_um = 1700.0")], "undercut limit"),
    ("holes cut", [("crank_hole_radius_mm = 13.0", "crank_hole_radius_mm = 24.0")], "make the holes smaller"),
    ("negative compensation", [("compensation = true", "compensation = -1.0")], "positive amount"),
    ("stage without cranks", [("[drive.cranks]\ncount = 3\ncircle_radius_mm = 36.0\n", "[drive.eccentric]\n")],
     "add [drive.cranks]"),
]  # fmt: skip


@pytest.mark.parametrize(("name", "pairs", "says"), BAD, ids=[name for name, _, _ in BAD])
@pytest.mark.parametrize("command", ["build", "accuracy"])
def test_bad_input_is_one_sentence_and_leaves_no_file(
    name: str, pairs: list[tuple[str, str]], says: str, command: str, changed: Callable[..., Path],
    tmp_path: Path, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    out = tmp_path / "out"
    assert run([command, str(changed(*pairs)), "--out", str(out), "--json"]) == 2, name
    printed, errors = capsys.readouterr()
    sentences = [line for line in errors.splitlines() if not line.startswith("… ")]
    assert printed == ""
    assert len(sentences) == 1
    assert says in sentences[0]
    assert "Traceback" not in errors
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["build", "nowhere.toml"], "does not exist"),
        (["build"], "requires an argument"),
        (["bild", "x.toml"], 'Did you mean "build"'),
        (["build", "x.toml", "--ouT", "y"], "Unknown option"),
        (["export", str(RV40E), "--format", "dwg"], 'Choose from: "csv"'),
        (["catalog", "rv4oe"], "did you mean rv40e?"),
        (["catalog", "--out", "x.toml"], "needs a drive"),
    ],
)
def test_wrong_words_are_one_sentence(words: list[str], says: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(words) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if not line.startswith("… ")]
    assert len(lines) == 1
    assert says in lines[0]


def test_an_output_folder_that_is_a_file_is_refused(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "taken"
    target.write_text("mine", encoding="utf-8")
    assert run(["export", str(changed()), "--format", "cmm", "--out", str(target)]) == 2
    assert "cannot be written" in capsys.readouterr().err
    assert target.read_text(encoding="utf-8") == "mine"


def test_an_output_folder_without_permission_is_refused(
    changed: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # The superuser may write anywhere, so the refusal of the system is played.
    def denied(*_: object, **__: object) -> str:
        raise PermissionError(13, "Permission denied", str(tmp_path))

    monkeypatch.setattr("cycloid_profile.export.writing._staging._grabbed", denied)
    assert run(["export", str(changed()), "--format", "cmm", "--out", str(tmp_path / "locked")]) == 2
    assert "cannot be written (Permission denied): choose another with --out" in capsys.readouterr().err


def test_a_failure_half_way_leaves_the_old_files_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: Callable[..., Path]
) -> None:
    from cycloid_profile.export.points import CmmExporter

    out = tmp_path / "out"
    assert run(["export", str(changed(COARSE)), "--format", "csv", "--out", str(out)]) == 0
    before = (out / "profile.csv").read_bytes()

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device", "cmm_nominal.csv")

    monkeypatch.setattr(CmmExporter, "write", full)
    spec = changed(COARSE, ("equidistant_um = 6.0", "equidistant_um = 9.0"))
    assert run(["export", str(spec), "--format", "csv", "--format", "cmm", "--out", str(out)]) == 2
    assert (out / "profile.csv").read_bytes() == before
    assert sorted(path.name for path in out.iterdir()) == ["manifest.json", "profile.csv", "profile_disc_2.csv"]


BINDING = [
    ([("equidistant_um = 6.0", "equidistant_um = 0.0")], "would leave a backlash of"),
    ([("compensation = true", "compensation = 9.0")], "set deformation_compensation to at most 6.0"),
    ([("equidistant_um = 6.0", "equidistant_um = -6.0"), ("= true", "= false")], "would bind"),
    ([("equidistant_um = 6.0", "equidistant_um = -6.0")], "overlap before any load"),
]


@pytest.mark.parametrize(("pairs", "says"), BINDING)
def test_a_disc_that_would_bind_is_a_failure(
    pairs: list[tuple[str, str]], says: str, changed: Callable[..., Path]
) -> None:
    figures = summary(design_disc(read_spec(changed(*pairs))))
    assert figures["failures"]
    assert says in " ".join(warnings(figures))


@pytest.mark.slow
def test_a_disc_that_would_bind_ends_with_1_and_its_files(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pairs, says = BINDING[0]
    spec = changed(*pairs, ('["dxf", "step", "csv", "gcode", "cmm"]', '["csv"]'))
    assert run(["build", str(spec), "--out", str(tmp_path / "out"), "--json"]) == 1
    out, err = capsys.readouterr()
    assert says in err
    assert json.loads(out)["failures"]
    assert (tmp_path / "out" / "profile.csv").is_file()
    assert "cannot work as specified" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_a_drive_without_an_equilibrium_is_no_success(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = changed(
        ("rated_torque_nm = 412.0", "rated_torque_nm = 100000.0"), ("= 4.0e5", "= 1.0"), ("= true", "= false")
    )
    assert run(["accuracy", str(spec), "--out", str(tmp_path), "--json"]) == 1
    out, err = capsys.readouterr()
    assert "the equilibrium of the whole drive was not found at every pose and load: check torque" in err
    assert json.loads(out)["conventional"]["converged"] is False


@pytest.mark.slow
def test_any_name_can_be_built(changed: Callable[..., Path], tmp_path: Path) -> None:
    # Comments of G-code, HTML, formulas of the plots, other scripts, quotes of STEP.
    name = "(O1000) <b>% a$_{$b RV减速器 é '\\"
    spec = changed(('name = "RV-40E"', f"name = {json.dumps(name, ensure_ascii=False)}"))
    assert run(["build", str(spec), "--out", str(tmp_path / "out")]) == 0
    program = (tmp_path / "out" / "grinding.nc").read_text(encoding="ascii")
    assert all(line.count("(") == line.count(")") <= 1 for line in program.splitlines())
    assert max(len(line) for line in program.splitlines()) < 100
    assert (tmp_path / "out" / "disc.step").read_bytes().isascii()
    for svg in (tmp_path / "out" / "plots").glob("*.svg"):
        xml.dom.minidom.parse(str(svg))


def test_a_set_is_written_whole_or_not_at_all(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    (out / "cmm_nominal.csv").mkdir(parents=True)
    words = ["export", str(changed(COARSE)), "--format", "csv", "--format", "cmm", "--out", str(out)]
    assert run(words) == 2
    assert f"'{out / 'cmm_nominal.csv'}' cannot be written (a folder has that name)" in capsys.readouterr().err
    assert [path.name for path in out.iterdir()] == ["cmm_nominal.csv"]


def test_a_promise_that_is_not_kept_is_no_success(
    changed: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from cycloid_profile.export.curves import biarc

    rough = biarc.disc_arcs
    monkeypatch.setattr("cycloid_profile.export.nc.contour.disc_arcs", lambda profile, _: rough(profile, 1e-3))
    assert run(["export", str(changed()), "--format", "gcode", "--out", str(tmp_path / "out")]) == 2
    assert "exceeds the promised" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_manifest_follows_an_export_and_a_smaller_build(changed: Callable[..., Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert run(["export", str(changed()), "--format", "csv", "--format", "cmm", "--out", str(out)]) == 0
    spec = changed(("equidistant_um = 6.0", "equidistant_um = 8.0"))
    assert run(["export", str(spec), "--format", "csv", "--out", str(out)]) == 0
    entries = json.loads((out / "manifest.json").read_text(encoding="utf-8"))["files"]
    # Disc 2 of the RV-40E is another part.
    names = ["cmm_nominal.csv", "cmm_nominal_disc_2.csv", "profile.csv", "profile_disc_2.csv"]
    assert [entry["path"] for entry in entries] == names
    assert entries[0]["spec_sha256"] != entries[2]["spec_sha256"], "the two come from different specs"
    assert entries[2]["sha256"] == hashlib.sha256((out / "profile.csv").read_bytes()).hexdigest()
    mine = out / "mine.txt"
    mine.write_text("kept", encoding="utf-8")
    only_cmm = changed(('["dxf", "step", "csv", "gcode", "cmm"]', '["cmm"]'))
    assert run(["build", str(only_cmm), "--out", str(out)]) == 0
    assert not (out / "profile.csv").exists(), "an old disc must not lie next to a new report"
    assert mine.exists()


def test_an_assumed_torque_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "short.toml"
    drive = TEXT.split("[drive.cranks]")[0]
    path.write_text(drive, encoding="utf-8")
    assert run(["accuracy", str(path), "--out", str(tmp_path)]) == 0
    assert "N·m is assumed from the size" in capsys.readouterr().err


def test_export_lists_before_it_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert run(["export", str(RV40E), "--list", "--json", "--out", str(out)]) == 0
    listed = json.loads(capsys.readouterr().out)["files"]
    # Both discs of the RV-40E.
    formats = ("dxf", "step", "csv", "gcode", "cmm")
    assert [entry["format"] for entry in listed] == [name for name in formats for _ in range(2)]
    assert not out.exists()
    assert run(["export", str(RV40E), "--list"]) == 0
    assert "disc.step" in capsys.readouterr().out


def test_export_writes_the_formats_asked_for(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = str(changed(COARSE))
    tmp_path = tmp_path / "out"
    assert run(["export", spec, "--format", "gcode", "--format", "cmm", "--out", str(tmp_path), "--json"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert [entry["path"] for entry in files] == [
        "grinding.nc",
        "grinding_disc_2.nc",
        "cmm_nominal.csv",
        "cmm_nominal_disc_2.csv",
    ]
    assert all(entry["deviation_um"] <= entry["tolerance_um"] for entry in files)
    assert run(["export", spec, "--format", "cmm", "--out", str(tmp_path)]) == 0
    assert "cmm_nominal.csv" in capsys.readouterr().out


@pytest.mark.slow
def test_without_the_cad_kernel_everything_but_step_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # The kernel is imported by another process, which takes the path of this one.
    (tmp_path / "build123d.py").write_text("raise ImportError('not installed')\n", encoding="utf-8")
    monkeypatch.delitem(sys.modules, "build123d", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    assert run(["build", str(RV40E), "--out", str(tmp_path), "--json"]) == 0
    out, err = capsys.readouterr()
    assert "pip install build123d" in json.loads(out)["skipped"]["step"]
    assert "disc.step not written" in err
    manifest = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))
    assert [entry["format"] for entry in manifest["skipped"]] == ["step"]
    assert (tmp_path / "profile.dxf").is_file()
    assert run(["export", str(RV40E), "--format", "step", "--out", str(tmp_path / "step")]) == 1


def test_a_missing_system_library_is_named_with_its_remedy(
    changed: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    fault = "libGL.so.1: cannot open shared object file: No such file or directory"
    (tmp_path / "build123d.py").write_text(f"raise ImportError({fault!r})\n", encoding="utf-8")
    monkeypatch.delitem(sys.modules, "build123d", raising=False)
    monkeypatch.syspath_prepend(tmp_path)
    assert run(["export", str(changed()), "--format", "step", "--out", str(tmp_path / "out")]) == 1
    assert "apt install libgl1" in capsys.readouterr().err


def test_the_module_is_the_command() -> None:
    words = [sys.executable, "-m", "cycloid_profile", "catalog", "nothing"]
    ended = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ended.returncode == 2
    assert "is not in the catalogue" in ended.stderr


def test_effects_of_the_spec_are_measured_on_the_rig(
    changed: Callable[..., Path], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = changed(("[export]", "[[effects]]\nname = 'series_compliance'\nstiffness_nm_per_arcmin = 134.0\n[export]"))
    assert run(["accuracy", str(spec), "--out", str(tmp_path / "out"), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["effects"] == ["series_compliance"]
    # Springs in series: the compliances of stage and shafts add.
    stage = figures["compensated"]["torsional_rigidity_nm_per_arcmin"]
    together = 1.0 / (1.0 / stage + 1.0 / 134.0)
    assert figures["as_built"]["torsional_rigidity_nm_per_arcmin"] == pytest.approx(together, rel=0.01)
    *_, as_built = terminal_tables(figures)
    rows = dict(as_built.rows)
    shown = f"{figures['as_built']['torsional_rigidity_nm_per_arcmin']:.4g}"
    assert rows["torsional rigidity, 50–100 % [N·m/′]"] == shown


def test_catalog_lists_prints_and_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["catalog"]) == 0
    assert "rv80e" in capsys.readouterr().out
    assert run(["catalog", "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)["drives"]) >= {"rv40e", "rv80e"}
    assert run(["catalog", "rv80e", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["name"] == "RV-80E"
    assert run(["catalog", "rv80e"]) == 0
    assert capsys.readouterr().out.startswith("#:schema")
    path = tmp_path / "new" / "mine.toml"
    assert run(["catalog", "rv80e", "--out", str(path)]) == 0
    assert read_spec(path).name == "RV-80E"
    assert (path.parent / "cycloid-profile.schema.json").is_file()


@pytest.mark.parametrize("command", [[], ["build"], ["accuracy"], ["export"], ["catalog"]])
def test_help_has_an_example(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert run([*command, "--help"]) == 0
    out = capsys.readouterr().out
    assert f"Example: cycloid-profile {command[0] if command else ''}" in " ".join(out.split())


def test_help_and_import_leave_the_heavy_libraries_alone() -> None:
    # Importing the CAD kernel alone takes seconds: it must not happen before a STEP file is asked for.
    code = (
        "import sys, cycloid_profile\n"
        "from cycloid_profile.cli.main import run\n"
        "assert run(['--help']) == 0\n"
        "heavy = {'OCP', 'build123d', 'lib3mf', 'ezdxf', 'matplotlib', 'scipy', 'shapely', 'jinja2'}\n"
        "heavy &= set(sys.modules)\n"
        "assert not heavy, heavy\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


def test_the_help_of_a_command_imports_that_command_only() -> None:
    code = (
        "import sys\n"
        "from cycloid_profile.cli.main import run\n"
        "assert run(['diagnose', '--help']) == 0\n"
        "assert 'numpy' not in sys.modules\n"
        "assert 'cycloid_profile.cli.build' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=ROOT, stdout=subprocess.DEVNULL)


def test_a_misspelt_command_gets_the_nearest_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["diagnos"]) == 2
    assert 'Did you mean "diagnose"' in capsys.readouterr().err


def test_a_step_that_lasts_is_shown_again(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    from cycloid_profile.cli.output import _progress, _terminal

    # Without durations of an earlier run.
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(_terminal, "_HEARTBEAT", 0.05)
    monkeypatch.setattr(_progress, "SHORTEST", 0.01)
    with _terminal.progress() as show_step:
        show_step("a long search")
        time.sleep(0.3)
    lines = capsys.readouterr().err.splitlines()
    assert lines[0] == "… a long search"
    assert lines[1].startswith("… a long search (0 s so far)")
    assert len(lines) > 2
