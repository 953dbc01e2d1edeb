"""The option ``--plugin`` from a scan to the ground disc: simulate, diagnose, correct, tolerance, plan."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from cycloid_profile.cli.main import run
from tests.plugins import NAME, THREE_JAW, forget
from tests.spec_texts import PLAIN, RV40E

HIDDEN = f"[[effects]]\nname = '{NAME}'\namplitude_um = 3.0\nphase_deg = 10.0\ndisc = 1\n"
SCATTER = (
    f"[tolerance]\nsamples = 200\nloaded_samples = 0\n[[tolerance.effects]]\nname = '{NAME}'\namplitude_um = {{}}\n"
)


@pytest.fixture(autouse=True)
def _forgotten() -> Iterator[None]:
    """Each command starts without the plug-in, as it does in a shell."""
    forget("three_jaw")
    yield
    forget()


def command(*words: str | Path, plugin: bool = True) -> int:
    forget()
    option = ["--plugin", str(THREE_JAW)] if plugin else []
    return run([*(str(word) for word in words), *option])


@pytest.mark.slow
def test_a_workshop_finds_and_cancels_its_own_effect(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    drawn, built, scan = (tmp_path / name for name in ("drawn.toml", "built.toml", "scan.csv"))
    drawn.write_text(RV40E, encoding="utf-8")
    built.write_text(RV40E + HIDDEN, encoding="utf-8")
    noise = ("--points", "1200", "--noise", "0.3", "--seed", "2")
    assert command("simulate", built, "--kind", "profile_scan", *noise, "--out", scan) == 0
    assert command("diagnose", drawn, scan, "--out", tmp_path / "out", "--json", tmp_path / "result.json") == 0
    (effect,) = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["effects"]
    assert effect["name"] == NAME
    assert effect["parameters"]["amplitude_um"] == pytest.approx(3.0, abs=0.1)
    # The spec that the diagnosis writes names the effect, and needs the plug-in to be read.
    new = tmp_path / "out" / "drawn_diagnosed.toml"
    capsys.readouterr()
    assert command("compare", new, scan, "--out", tmp_path / "cmp", plugin=False) == 2
    assert "--plugin" in capsys.readouterr().err
    assert command("compare", new, scan, "--out", tmp_path / "cmp", "--json") == 0
    capsys.readouterr()
    assert command("correct", drawn, scan, "--out", tmp_path / "ground", "--json") == 0
    values = json.loads(capsys.readouterr().out)
    assert [one["name"] for one in values["effects"]] == [NAME]
    assert values["rms_expected_um"] == pytest.approx(0.3, rel=0.1)


@pytest.mark.slow
def test_a_study_and_the_plan_know_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "mine.toml"
    spec.write_text(PLAIN + "[load]\ndisc_body = 'rigid'\n" + SCATTER, encoding="utf-8")
    assert command("tolerance", spec, "--out", tmp_path / "study", plugin=False) == 2
    assert "--plugin" in capsys.readouterr().err
    assert command("tolerance", spec, "--out", tmp_path / "study") == 0
    assert command("diagnose", spec, "--plan", "--out", tmp_path / "plan") == 0
    assert NAME in capsys.readouterr().out
