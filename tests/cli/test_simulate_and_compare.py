"""The commands ``simulate`` and ``compare`` as a user meets them: whole files, JSON, and one-sentence refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from cycloid_profile.cli.main import run
from cycloid_profile.measurement import KINDS, read_measurement
from cycloid_profile.spec import read_spec
from cycloid_profile.units import sign_of
from tests.spec_texts import RV40E

ROOT = Path(__file__).parents[2]
CATALOG = ROOT / "cycloid_profile" / "catalog"
# Short files: what is drawn and written does not depend on how many rows there are.
OVAL = """[[effects]]
name = "series_compliance"
stiffness_nm_per_arcmin = 134.0
[[effects]]
name = "disc_oval"
amplitude_um = 2.0
"""
NOISE = {"profile_scan": 0.3, "hysteresis": 0.004, "transmission_error": 0.15, "lost_motion_map": 0.004}
UNIT = {"profile_scan": "um", "hysteresis": "arcmin", "transmission_error": "arcsec", "lost_motion_map": "arcmin"}
FIGURE = {
    "profile_scan": "root_radius_mm",
    "hysteresis": "lost_motion_arcmin",
    "transmission_error": "peak_to_peak_arcsec",
    "lost_motion_map": "mean_arcmin",
}
Written = Callable[..., Path]


@pytest.fixture
def spec(tmp_path: Path) -> Written:
    """Writes the spec with more text behind it."""

    def write(more: str = "", name: str = "mine.toml") -> Path:
        path = tmp_path / name
        path.write_text(RV40E + more, encoding="utf-8")
        return path

    return write


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    """Runs a command that must end in one sentence and leave no file behind; gives the sentence."""

    def refuse(folder: Path, *words: str, status: int = 2) -> str:
        before = sorted(folder.rglob("*"))
        assert run(words) == status
        out, err = capsys.readouterr()
        assert out == ""
        # Progress goes before it on the same stream, a line each.
        sentences = [line for line in err.splitlines() if not line.startswith("…")]
        assert len(sentences) == 1
        assert sentences[0].startswith("cycloid-profile: ")
        assert sorted(folder.rglob("*")) == before
        return sentences[0]

    return refuse


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_file_that_was_simulated_differs_from_its_spec_by_the_noise(
    kind: str, spec: Written, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "bench" / f"{kind}.csv"
    path = spec(OVAL)
    words = ["simulate", str(path), "--kind", kind, "--out", str(file), "--points", "400", "--seed", "1"]
    assert run([*words, "--noise", str(NOISE[kind]), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["schema"] == 1
    assert (values["name"], values["kind"]) == ("RV-40E", kind)
    assert values["figures"][FIGURE[kind]] > 0.0
    assert Path(values["file"]) == file
    picture = Path(values["picture"])
    assert picture.parent == file.parent
    # Whole: a picture that ends as PNG files do, a table that reads, and no scratch folder next to them.
    assert picture.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert b"IEND" in picture.read_bytes()[-12:]
    assert read_measurement(file).kind.name == kind
    assert sorted(f.name for f in file.parent.iterdir()) == sorted([file.name, picture.name])

    out = tmp_path / "out"
    assert run(["compare", str(path), str(file), "--out", str(out), "--json"]) == 0
    values = json.loads(capsys.readouterr().out)
    assert values["schema"] == 1
    (row,) = values["gap"]
    assert (row["file"], row["kind"], row["unit"]) == (file.name, kind, UNIT[kind])
    assert row["noise"] == NOISE[kind]
    # The root mean square of 400 rows scatters by 3.5 %.
    assert row["rms"] == pytest.approx(NOISE[kind], rel=0.1)
    assert Path(row["picture"]).read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    assert (
        set(row["registration"])
        == {
            "profile_scan": {"turn_deg"},
            "hysteresis": {"zero_arcmin"},
            "transmission_error": {"zero_arcsec"},
            "lost_motion_map": set(),
        }[kind]
    )


@pytest.mark.slow
def test_figures_of_every_kind_with_their_tolerances(
    spec: Written, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    limits = "[tolerance.limits]\nlost_motion_arcmin = 1.25\ntransmission_error_arcsec = 7.5\n"
    measured = {kind: tmp_path / f"{kind}.csv" for kind in KINDS}
    for kind, file in measured.items():
        assert run(["simulate", str(spec(OVAL)), "--kind", kind, "--out", str(file), "--points", "400", "-q"]) == 0
    capsys.readouterr()
    plain, out = spec(limits, "plain.toml"), tmp_path / "out"
    assert run(["compare", str(plain), *map(str, measured.values()), "--out", str(out), "--json"]) == 0
    found = {row["kind"]: row["figures"] for row in json.loads(capsys.readouterr().out)["gap"]}
    for figures in found.values():
        for key, figure in figures.items():
            assert set(figure) == {"name", "measured", "predicted", "difference", "noise", "tolerance"}
            assert sign_of(key), f"{key} ends with no unit"
            if None not in (figure["measured"], figure["predicted"]):
                assert figure["difference"] == figure["measured"] - figure["predicted"]
    loop, scan = found["hysteresis"], found["profile_scan"]
    # The simulated shafts: 134 N·m/′ in series with the stage that is predicted.
    for key in ("rigidity_50_to_100_forward_nm_per_arcmin", "rigidity_50_to_100_backward_nm_per_arcmin"):
        soft, stiff = loop[key]["measured"], loop[key]["predicted"]
        assert 1.0 / soft == pytest.approx(1.0 / stiff + 1.0 / 134.0, rel=0.02)
    assert loop["lost_motion_arcmin"]["tolerance"] == 1.25
    assert loop["loss_energy_nm_arcmin"]["tolerance"] is None
    assert found["lost_motion_map"]["largest_arcmin"]["tolerance"] == 1.25
    assert found["transmission_error"]["peak_to_peak_arcsec"]["tolerance"] == 7.5

    # A scan has the numbers of its inspection.
    assert run(["inspect", str(plain), str(measured["profile_scan"]), "--out", str(tmp_path / "i"), "--json"]) < 2
    checks = json.loads(capsys.readouterr().out)["checks"]
    assert [one["measured"] for one in scan.values()] == pytest.approx([c["value_um"] for c in checks], abs=1e-4)
    assert [one["tolerance"] for one in scan.values()] == pytest.approx([c["tolerance_um"] for c in checks], abs=1e-4)
    assert [one["predicted"] for one in scan.values()] == pytest.approx([0.0] * 4, abs=1e-3)


def test_figures_fit_a_terminal_of_80_columns(
    spec: Written, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cycloid_profile.cli.output._terminal.terminal_width", lambda: 80)
    files = [tmp_path / f"{kind}.csv" for kind in ("hysteresis", "transmission_error", "lost_motion_map")]
    for file in files:
        words = ["simulate", str(spec()), "--kind", file.stem, "--out", str(file), "--points", "300", "-q"]
        assert run([*words, "--noise", str(NOISE[file.stem])]) == 0
    capsys.readouterr()
    assert run(["compare", str(spec()), *map(str, files), "--out", str(tmp_path / "out")]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(len(line) for line in lines if "pictures:" not in line) <= 80
    # One table for each file, none of which continues below.
    assert len([line for line in lines if line.startswith("figure")]) == 3


@pytest.mark.slow
def test_without_the_effects_the_gap_is_what_they_do(
    spec: Written, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = [tmp_path / folder / "scan.csv" for folder in ("first", "second")]
    for points, file in zip(("800", "900"), files, strict=True):
        words = ["simulate", str(spec(OVAL)), "--kind", "profile_scan", "--out", str(file), "--points", points]
        assert run(words) == 0
        assert "root_radius_mm" in capsys.readouterr().out
    # Repeats of one name have a picture each.
    words = ["compare", str(spec(name="plain.toml")), *map(str, files), "--out", str(tmp_path / "out")]
    assert run([*words, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["gap"]
    assert [row["rms"] for row in rows] == pytest.approx([2.0 / np.sqrt(2.0)] * 2, rel=0.01)
    assert len({row["picture"] for row in rows}) == 2
    assert run(words) == 0
    out = capsys.readouterr().out
    assert "scan.csv" in out
    assert "1.4" in out


def test_names_that_nobody_gave(spec: Written, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = spec()
    monkeypatch.chdir(tmp_path)
    assert run(["simulate", str(path), "--kind", "lost_motion_map", "--points", "20"]) == 0
    assert {f.name for f in tmp_path.iterdir()} == {"mine.toml", "mine_lost_motion_map.csv", "mine_lost_motion_map.png"}


def test_where_and_how_it_is_measured(spec: Written, tmp_path: Path) -> None:
    path, file = spec(), tmp_path / "f.csv"
    words = ["simulate", str(path), "--out", str(file), "--kind"]
    assert run([*words, "hysteresis", "--torque-nm", "200", "--output-angle-deg", "12", "--points", "50"]) == 0
    loop = read_measurement(file)
    assert loop.number("output_angle_deg") == pytest.approx(12.0)
    assert np.max(loop["torque_nm"]) == 200.0
    assert run([*words, "transmission_error", "--torque-nm", "12.36", "--points", "40"]) == 0
    error = read_measurement(file)
    assert error.number("torque_nm") == 12.36
    assert error["error_arcsec"].size == 40
    assert run([*words, "profile_scan", "--disc", "2", "--points", "400"]) == 0
    assert read_measurement(file).keys["specimen"] == "disc 2"


FAULTS = {
    "an unknown kind": (("--kind", "te_curve"), "profile_scan"),
    "no kind": ((), "--kind"),
    "less than no noise": (("--kind", "profile_scan", "--noise", "-1"), "noise"),
    "noise that is no number": (("--kind", "profile_scan", "--noise", "nan"), "noise"),
    "noise without end": (("--kind", "transmission_error", "--points", "40", "--noise", "inf"), "noise"),
    "a disc that is not there": (("--kind", "profile_scan", "--disc", "3"), "disc = 3"),
    "disc 0": (("--kind", "profile_scan", "--disc", "0"), "disc = 0"),
    "no torque": (("--kind", "transmission_error", "--torque-nm", "0"), "torque"),
    "a loop without torque": (("--kind", "hysteresis", "--torque-nm", "0"), "torque"),
    "few points of a scan": (("--kind", "profile_scan", "--points", "10"), "points = 10"),
    "one point": (("--kind", "transmission_error", "--points", "1"), "points = 1"),
    "less than no points": (("--kind", "transmission_error", "--points", "-5"), "points = -5"),
    "a seed below zero": (("--kind", "lost_motion_map", "--points", "20", "--seed", "-1"), "seed = -1"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_simulate_refuses(fault: str, spec: Written, tmp_path: Path, refused: Callable[..., str]) -> None:
    words, named = FAULTS[fault]
    file = tmp_path / "f.csv"
    assert named in refused(tmp_path, "simulate", str(spec()), *words, "--out", str(file))


def test_picture_and_table_have_two_names(spec: Written, tmp_path: Path, refused: Callable[..., str]) -> None:
    words = ("simulate", str(spec()), "--kind", "profile_scan", "--out", str(tmp_path / "f.png"))
    assert ".csv" in refused(tmp_path, *words)


@pytest.mark.slow
def test_a_reducer_that_binds_ends_in_a_sentence(spec: Written, tmp_path: Path, refused: Callable[..., str]) -> None:
    path = spec("[[effects]]\nname = 'disc_runout'\namplitude_um = 200.0\n")
    words = ("simulate", str(path), "--kind", "transmission_error", "--points", "5", "--out", str(tmp_path / "f.csv"))
    assert "equilibrium" in refused(tmp_path, *words, status=1)


@pytest.mark.parametrize(
    ("effect", "named", "remedy"),
    [
        ("name = 'disc_ovl'\namplitude_um = 2.0", "effects[1].name", "disc_oval"),
        ("name = 'disc_oval'\namplitud_um = 2.0", "effects[1]: disc_oval.amplitud_um", "amplitude_um"),
        ("name = 'disc_oval'", "effects[1]: disc_oval.amplitude_um", "amplitude"),
        ("name = 'disc_oval'\namplitude_um = -2.0", "effects[1]: disc_oval.amplitude_um", "amplitude"),
        ("name = 'disc_oval'\namplitude_um = 'two'", "effects[1]: disc_oval.amplitude_um", "amplitude"),
        ("name = 'disc_oval'\namplitude_um = 2.0\ndisc = 3", "disc_oval.disc", "1 to 2"),
        ("amplitude_um = 2.0", "effects[1].name", ""),
    ],
)
def test_an_effect_with_a_fault_is_named(
    effect: str, named: str, remedy: str, spec: Written, tmp_path: Path, refused: Callable[..., str]
) -> None:
    path = spec(f"[[effects]]\n{effect}\n")
    sentence = refused(tmp_path, "simulate", str(path), "--kind", "profile_scan", "--out", str(tmp_path / "f.csv"))
    assert named in sentence
    assert remedy in sentence


def test_the_second_effect_is_the_second(spec: Written, tmp_path: Path, refused: Callable[..., str]) -> None:
    path = spec(OVAL.replace("amplitude_um", "amplitud_um"))
    sentence = refused(tmp_path, "simulate", str(path), "--kind", "profile_scan", "--out", str(tmp_path / "f.csv"))
    assert "effects[2]: disc_oval.amplitud_um" in sentence


def test_compare_refuses_what_is_not_there(spec: Written, tmp_path: Path, refused: Callable[..., str]) -> None:
    path, out = spec(), str(tmp_path / "out")
    assert "nothing.csv" in refused(tmp_path, "compare", str(path), str(tmp_path / "nothing.csv"), "--out", out)
    assert "at least one CSV file" in refused(tmp_path, "compare", str(path), "--out", out)
    assert "does not exist" in refused(tmp_path, "compare", str(tmp_path / "no.toml"), str(path), "--out", out)
    assert "kind" in refused(tmp_path, "compare", str(path), str(path), "--out", out)


def test_compare_refuses_a_scan_of_another_drive(
    spec: Written, tmp_path: Path, refused: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    scan = tmp_path / "printed.csv"
    words = ["simulate", str(CATALOG / "printed_11.toml"), "--kind", "profile_scan", "--out", str(scan)]
    assert run([*words, "--points", "400"]) == 0
    capsys.readouterr()
    # A good file before it is not half a result.
    good = tmp_path / "good.csv"
    path = spec()
    assert run(["simulate", str(path), "--kind", "profile_scan", "--out", str(good), "--points", "400"]) == 0
    capsys.readouterr()
    sentence = refused(tmp_path, "compare", str(path), str(good), str(scan), "--out", str(tmp_path / "out"))
    assert "printed.csv" in sentence
    assert "scan of another disc" in sentence


@pytest.mark.parametrize("disc", ["0", "3"])
def test_compare_refuses_a_disc_that_is_not_there(
    disc: str, spec: Written, tmp_path: Path, refused: Callable[..., str], capsys: pytest.CaptureFixture[str]
) -> None:
    file, path = tmp_path / "scan.csv", spec()
    assert run(["simulate", str(path), "--kind", "profile_scan", "--out", str(file), "--points", "400"]) == 0
    capsys.readouterr()
    words = ("compare", str(path), str(file), "--disc", disc, "--out", str(tmp_path / "out"))
    assert f"disc = {disc}" in refused(tmp_path, *words)


def test_every_drive_of_the_catalogue_can_be_measured(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    # With cranks and without, one disc and two, with a first stage and without.
    for toml in sorted(CATALOG.glob("*.toml")):
        file = tmp_path / f"{toml.stem}.csv"
        words = ["simulate", str(toml), "--kind", "lost_motion_map", "--points", "12", "--out", str(file), "--json"]
        assert run(words) == 0
        values = json.loads(capsys.readouterr().out)
        assert values["name"] == read_spec(toml).name
        assert values["figures"]["mean_arcmin"] > 0.0


@pytest.mark.parametrize("command", ["simulate", "compare"])
def test_help_has_an_example(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert f"Example: cycloid-profile {command} examples/rv40e.toml" in out
