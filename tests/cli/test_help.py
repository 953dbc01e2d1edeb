"""Help without internals, ``--json`` the same everywhere, quiet commands, shell completion."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from cycloid_profile.cli.main import COMMANDS, application, run
from cycloid_profile.cli.output._terminal import with_json_file

RV40E = "examples/rv40e.toml"


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_no_internals(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run([command, "--help"]) == 0
    shown = capsys.readouterr().out
    for internal in ("ARGS", "--empty", "--no-", "default: (", "default: False", "default: None", "CHOICE]"):
        assert internal not in shown
    assert "--json [FILE]" in shown
    assert "--quiet -q" in shown
    example = " ".join(shown.split()).partition("Example: ")[2].partition(" ╭")[0]
    assert f"cycloid-profile {command} " in example
    assert "--out " in example


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("accuracy a.toml --json", "accuracy a.toml --json=-"),
        ("accuracy --json a.toml", "accuracy --json=- a.toml"),
        ("accuracy a.toml --json out.json", "accuracy a.toml --json=out.json"),
        ("accuracy a.toml --json out", "accuracy a.toml --json=out"),
        ("accuracy a.toml --json=out", "accuracy a.toml --json=out"),
        ("diagnose a.toml --json r.json b.csv", "diagnose a.toml --json=r.json b.csv"),
        ("diagnose a.toml --json b.csv", "diagnose a.toml --json=- b.csv"),
        ("diagnose a.toml b.csv --json - --plan", "diagnose a.toml b.csv --json=- --plan"),
        ("build a.toml --json --out x", "build a.toml --json=- --out x"),
    ],
)
def test_json_is_a_flag_or_names_a_file(line: str, words: str) -> None:
    assert with_json_file(shlex.split(line)) == shlex.split(words)


def test_json_is_written_next_to_the_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "drives.json"
    for words in (["--json", str(file)], [f"--json={file}"]):
        assert run(["catalog", *words]) == 0
        assert "rv80e" in capsys.readouterr().out
        assert "rv40e" in json.loads(file.read_text(encoding="utf-8"))["drives"]


def test_json_replaces_no_file_of_another_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scan.txt"
    file.write_text("1 2 3\n", encoding="utf-8")
    assert run(["catalog", "--json", str(file)]) == 2
    assert "was not made by this program" in capsys.readouterr().err
    assert file.read_text(encoding="utf-8") == "1 2 3\n"
    spec = tmp_path / "mine.toml"
    assert run(["catalog", "rv40e", "--out", str(spec)]) == 0
    assert run(["catalog", f"--json={spec}"]) == 2
    assert "is a file of another kind" in capsys.readouterr().err
    assert run(["catalog", f"--json={file}", "--force"]) == 0
    assert "rv40e" in json.loads(file.read_text(encoding="utf-8"))["drives"]


def test_quiet_prints_no_progress(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["export", RV40E, "--format", "cmm", "--out", str(tmp_path)]
    assert run(words) == 0
    assert "… " in capsys.readouterr().err
    assert run([*words, "-q"]) == 0
    shown = capsys.readouterr()
    assert "… " not in shown.err
    assert "cmm_nominal.csv" in shown.out


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_shells_can_complete_commands_and_options(shell: str) -> None:
    script = application().generate_completion(shell=shell)
    for word in (*COMMANDS, "held-out", "loaded-samples"):
        assert word in script


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["new", "--ratio", "11.5"], "--ratio: '11.5' is no whole number"),
        (["simulate", RV40E, "--kind", "profile_scan", "--disc=1.6"], "--disc: '1.6' is no whole number"),
        (["new", "--ratio", "11", "--outer-diameter", "60,5"], "'60,5' is no number: write a decimal point"),
    ],
)
def test_a_word_that_is_no_number_is_refused_and_not_rounded(
    words: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(words) == 2
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.out == ""
