"""Each case of the corpus in this process: its status, one sentence, no traceback, and no byte changed."""

from __future__ import annotations

import importlib.util
import os
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

from cycloid_profile.cli.main import run


def _corpus() -> ModuleType:
    """The table next to this file, whatever the way tests are imported."""
    path = Path(__file__).with_name("hostile_cases.py")
    specification = importlib.util.spec_from_file_location("hostile_cases", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["hostile_cases"] = module
    specification.loader.exec_module(module)
    return module


corpus = _corpus()


def contents(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_the_corpus_is_large_and_names_are_unique() -> None:
    names = [case.name for case in corpus.CASES]
    assert len(names) == len(set(names)) >= 250


@pytest.mark.parametrize("case", corpus.CASES, ids=corpus.identifier)
def test_hostile_command(
    case: corpus.Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    (here / "spec.toml").write_text(case.spec, encoding="utf-8")
    for name, text in case.files.items():
        (here / name).parent.mkdir(parents=True, exist_ok=True)
        (here / name).write_text(text, encoding="utf-8")
    if "pipe" in case.words:
        os.mkfifo(here / "pipe")
    (tmp_path / "here-victim.txt").write_text("precious", encoding="utf-8")
    before = contents(tmp_path)
    folders = {path for path in tmp_path.rglob("*") if path.is_dir()}
    status = run([word.replace("{here}", "here") for word in case.words])
    printed, errors = capsys.readouterr()
    assert status == case.status, errors
    assert "Traceback" not in printed + errors
    sentences = [line for line in errors.splitlines() if not line.startswith("… ")]
    assert len(sentences) == 1, errors
    assert re.search(case.says, sentences[0]), sentences[0]
    assert sentences[0].startswith("cycloid-profile: ")
    assert len(sentences[0]) < 1000
    after = contents(tmp_path)
    assert {name: text for name, text in after.items() if name not in case.leaves} == before
    assert {path for path in tmp_path.rglob("*") if path.is_dir()} == folders
