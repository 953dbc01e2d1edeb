"""Single files that are replaced: the old content or the new one, whatever goes wrong."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest

from cycloid_profile import filesystem
from cycloid_profile.filesystem import ABANDONED, new_file


def replace(path: Path, text: str = "new") -> None:
    with new_file(path) as scratch:
        scratch.write_text(text, encoding="utf-8")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def test_the_new_content_takes_the_place_of_the_old(tmp_path: Path):
    for text in ("old", "new"):
        replace(tmp_path / "file[1]", text)
        assert (tmp_path / "file[1]").read_text(encoding="utf-8") == text
        assert names(tmp_path) == ["file[1]"]


@pytest.mark.parametrize("call", ["sync", "rename"])
def test_a_fault_of_the_disk_leaves_the_old_content(call: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    replace(tmp_path / "file", "old")

    def fail(*_: Path) -> None:
        raise OSError(5, "Input/output error")

    monkeypatch.setattr(filesystem, call, fail)
    with pytest.raises(OSError, match="Input/output"):
        replace(tmp_path / "file")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "old"
    assert names(tmp_path) == ["file"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_interrupted_write_leaves_the_old_content(error: type[BaseException], tmp_path: Path):
    def interrupted() -> None:
        with new_file(tmp_path / "file") as scratch:
            scratch.write_text("half", encoding="utf-8")
            raise error

    replace(tmp_path / "file", "old")
    with pytest.raises(error):
        interrupted()
    assert (tmp_path / "file").read_text(encoding="utf-8") == "old"
    assert names(tmp_path) == ["file"]


def test_the_content_is_on_the_disk_before_it_has_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    calls: list[str] = []
    monkeypatch.setattr(filesystem, "sync", lambda path: calls.append(f"sync {path.suffix or path.name}"))
    monkeypatch.setattr(filesystem, "rename", lambda *_: calls.append("rename"))
    replace(tmp_path / "file")
    assert calls == ["sync .partial", "rename", f"sync {tmp_path.name}"]


def test_scratch_files_of_killed_processes_are_removed_and_those_of_rivals_kept(tmp_path: Path):
    dead, rival, other = (tmp_path / name for name in (".file.0.partial", ".file.1.partial", ".file2.0.partial"))
    for path in (dead, rival, other):
        path.write_text("half", encoding="utf-8")
    for path in (dead, other):
        os.utime(path, (0.0, path.stat().st_mtime - ABANDONED - 1.0))
    replace(tmp_path / "file")
    assert names(tmp_path) == [rival.name, other.name, "file"]


@pytest.mark.skipif(os.name != "posix", reason="modes and pipes of POSIX")
def test_others_may_read_the_file_and_what_is_no_file_stays(tmp_path: Path):
    before = os.umask(0o022)
    try:
        replace(tmp_path / "file")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "file").stat().st_mode) == 0o644
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "folder").mkdir()
    for name in ("pipe", "folder"):
        with pytest.raises(OSError, match="no plain file"):
            replace(tmp_path / name)
    assert names(tmp_path) == ["file", "folder", "pipe"]


@pytest.mark.skipif(os.name != "posix", reason="locks of POSIX")
def test_one_handle_holds_the_lock_of_a_folder(tmp_path: Path):
    held = filesystem.lock(tmp_path)
    assert held is not None
    assert filesystem.lock(tmp_path) is None
    os.close(held)
    again = filesystem.lock(tmp_path)
    assert again is not None
    os.close(again)
