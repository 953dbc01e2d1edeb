"""Output folders under kills, faults, signals and rivals: the old package or the new one, never a mixture of both.

Each call of the writer to the file system is a place where a process may die. A child process dies at call n, for
n = 1, 2, … until it survives; the folder is then read as another program would read it.
"""

from __future__ import annotations

import errno
import json
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from cycloid_profile import filesystem
from cycloid_profile.errors import ExportError
from cycloid_profile.export.writing import PROTECTED, Protection, _staging, atomic_folder, write_manifest
from cycloid_profile.export.writing.manifest import file_hash

CALLS = ("rename", "exchange", "link", "remove", "sync")
OLD = {"disc.step": "old", "profile.csv": "old", "plots/tooth.svg": "old", "stale.nc": "old"}
NEW = {"disc.step": "new", "profile.csv": "new", "plots/tooth.svg": "new", "inspection/plan.dmis": "new"}
FOREIGN = {"notes.txt": "mine", "deep/er/scan.csv": "mine", "plots/photo.png": "mine"}

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")


def write(folder: Path, files: dict[str, str], protection: Protection = PROTECTED) -> None:
    """A package of text files with its manifest, as ``build`` writes one."""
    with atomic_folder(folder, protection, replaces=True) as scratch:
        entries = []
        for name, text in files.items():
            path = scratch / name
            path.parent.mkdir(exist_ok=True)
            path.write_text(f"{text} {name}", encoding="utf-8")
            digest = file_hash(path)
            entries.append(
                {"path": name, "format": "x", "bytes": path.stat().st_size, "sha256": digest, "spec_sha256": "0"}
            )
        write_manifest(next(iter(files.values())), entries, {}, scratch)


def contents(folder: Path) -> dict[str, str]:
    """Name and first word of every file but the manifest."""
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
    return {
        name: path.read_text(encoding="utf-8").split()[0] for name, path in files.items() if name != "manifest.json"
    }


def assert_whole(folder: Path) -> str:
    """Which package is there; the test fails if it is a mixture, or a file of others is gone."""
    assert not FOREIGN.items() - contents(folder).items(), "a file of others is gone"
    ours = dict(contents(folder).items() - FOREIGN.items())
    assert ours in (OLD, NEW)
    listed = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    assert {entry["path"] for entry in listed["files"]} == set(ours)
    assert all(file_hash(folder / entry["path"]) == entry["sha256"] for entry in listed["files"])
    return "old" if ours == OLD else "new"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The old package among files of others."""
    place = tmp_path / "drive"
    write(place, OLD)
    for name, text in FOREIGN.items():
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        (place / name).write_text(text, encoding="utf-8")
    return place


@pytest.fixture(params=["exchange", "journal"])
def method(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """How the files take their place: as on Linux, or on a system that cannot exchange folders."""
    if request.param == "journal":

        def cannot(*_: object) -> None:
            raise OSError(errno.EINVAL, "Invalid argument")

        monkeypatch.setattr(filesystem, "exchange", cannot)
    elif not sys.platform.startswith("linux"):
        pytest.skip("renameat2 is a call of Linux")
    return str(request.param)


def at_call(number: int, act: Callable[[], None]) -> Callable[[], int]:
    """Make the ``number``-th call to the file system ``act`` first; returns the count of calls so far."""
    count = 0

    def counted(call: Callable[..., None]) -> Callable[..., None]:
        def wrapper(*paths: Path) -> None:
            nonlocal count
            count += 1
            if count == number:
                act()
            call(*paths)

        return wrapper

    for name in CALLS:
        setattr(filesystem, name, counted(getattr(filesystem, name)))
    return lambda: count


def died(folder: Path, number: int) -> bool:
    """Write the new package in a child process that is killed at its ``number``-th call; whether it was."""
    child = os.fork()
    if child == 0:
        at_call(number, lambda: os.kill(os.getpid(), signal.SIGKILL))
        write(folder, NEW)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    return os.WIFSIGNALED(status)


@pytest.fixture
def restored() -> Iterator[None]:
    """Puts the calls of the writer back."""
    before = {name: getattr(filesystem, name) for name in CALLS}
    yield
    for name, call in before.items():
        setattr(filesystem, name, call)


def reset(folder: Path) -> None:
    write(folder, OLD)


@pytest.mark.slow
def test_killed_at_every_call_leaves_no_mixture(folder: Path, method: str) -> None:
    ends: dict[str, int] = {"old": 0, "new": 0}
    for number in range(1, 200):
        killed = died(folder, number)
        if method == "journal" and killed:
            # The next start ends what this one began, before anything else.
            with pytest.raises(RuntimeError), atomic_folder(folder):
                raise RuntimeError
        ends[assert_whole(folder)] += 1
        if not killed:
            break
        reset(folder)
        assert [path.name for path in folder.parent.iterdir()] == ["drive"], "nothing of the dead run is left"
    else:
        raise AssertionError("the writer never came to an end")
    assert ends["old"] > 5
    assert ends["new"] >= 2


@pytest.mark.slow
@pytest.mark.usefixtures("restored")
def test_a_fault_at_every_call_is_one_sentence_and_no_mixture(folder: Path, method: str) -> None:
    said = []

    def fail() -> None:
        raise OSError(errno.EIO, "Input/output error", "somewhere")

    originals = {name: getattr(filesystem, name) for name in CALLS}
    for number in range(1, 200):
        count = at_call(number, fail)
        try:
            write(folder, NEW)
        except ExportError as error:
            said.append(str(error))
        reached = count() >= number
        for name, call in originals.items():
            setattr(filesystem, name, call)
        assert_whole(folder)
        if not reached:
            break
        reset(folder)
    assert len(said) > (5 if method == "exchange" else 15)
    assert all("Input/output error" in sentence for sentence in said)


@pytest.mark.usefixtures("restored")
@pytest.mark.parametrize("number", [1, 6, 12])
@pytest.mark.parametrize("received", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_waits_for_the_end_of_the_exchange(folder: Path, number: int, received: signal.Signals) -> None:
    class Asked(BaseException):
        pass

    def ask(*_: object) -> None:
        raise Asked

    before = signal.signal(received, ask)
    try:
        at_call(number, lambda: signal.raise_signal(received))
        with pytest.raises(Asked):
            write(folder, NEW)
    finally:
        signal.signal(received, before)
    assert assert_whole(folder) == "new"
    assert [path.name for path in folder.parent.iterdir()] == ["drive"]


@pytest.fixture
def interrupted_by_sigint() -> Iterator[None]:
    """SIGINT raises ``KeyboardInterrupt``, also where a shell that started the tests in the background ignores it."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def signal_at_line(number: int) -> Callable[[], int]:
    """Send SIGINT at the ``number``-th line that the writer runs; returns the count of lines so far."""
    count = 0

    def trace(frame: FrameType, event: str, _: object) -> Any:
        nonlocal count
        if Path(frame.f_code.co_filename).parent.name != "writing":
            return None
        count += event == "line"
        if event == "line" and count == number:
            sys.settrace(None)
            signal.raise_signal(signal.SIGINT)
        return trace

    sys.settrace(trace)
    return lambda: count


# A signal between the opening of a file and its block leaves the closing to the collector.
@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.usefixtures("interrupted_by_sigint")
def test_a_signal_at_any_line_leaves_one_package_and_nothing_else(tmp_path: Path) -> None:
    seen = set()
    number, reached = 0, True
    while reached:
        number += 1
        place = tmp_path / str(number)
        place.mkdir()
        folder = place / "drive"
        write(folder, {"profile.csv": "old"})
        lines = signal_at_line(number)
        try:
            write(folder, {"profile.csv": "new"})
        except KeyboardInterrupt:
            seen.add((folder / "profile.csv").read_text(encoding="utf-8").split()[0])
        finally:
            sys.settrace(None)
        reached = lines() >= number
        assert [path.name for path in place.iterdir()] == ["drive"], f"line {number}"
        assert sorted(path.name for path in folder.iterdir()) == ["manifest.json", "profile.csv"]
    assert seen == {"old", "new"}


def test_interrupted_while_the_files_are_made_leaves_the_old_ones(folder: Path) -> None:
    def interrupted() -> None:
        with atomic_folder(folder) as scratch:
            (scratch / "profile.csv").write_text("new", encoding="utf-8")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert assert_whole(folder) == "old"
    assert [path.name for path in folder.parent.iterdir()] == ["drive"]


def test_two_processes_end_with_the_package_of_one(folder: Path) -> None:
    children = []
    for files in (OLD, NEW, OLD, NEW):
        child = os.fork()
        if child == 0:
            write(folder, files)
            os._exit(0)
        children.append(child)
    assert {os.waitpid(child, 0)[1] for child in children} == {0}
    assert_whole(folder)


def test_a_second_process_that_waits_too_long_is_reported(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(_staging, "_PATIENCE", 0.2)
    said = []

    def second() -> None:
        try:
            write(folder, NEW)
        except ExportError as error:
            said.append(str(error))

    with atomic_folder(folder):
        rival = threading.Thread(target=second)
        rival.start()
        rival.join()
    assert "is being written by another process" in said[0]
    assert assert_whole(folder) == "old"


def test_what_a_killed_run_left_is_removed_with_its_age(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    left = folder.parent / ".drive.cycloid-profile.partial"
    (left / "new").mkdir(parents=True)
    (left / "new" / "profile.csv").write_text("half", encoding="utf-8")
    os.utime(left, (left.stat().st_atime, left.stat().st_mtime - 180.0))
    write(folder, NEW)
    assert not left.exists()
    assert "interrupted 3 min ago" in caplog.text


MANIFESTS = {
    "relative": lambda victim: {"path": f"../{victim.name}", "sha256": file_hash(victim)},
    "absolute": lambda victim: {"path": str(victim), "sha256": file_hash(victim)},
    "unknown content": lambda victim: {"path": f"../{victim.name}", "sha256": None},
    "through a link": lambda victim: {"path": f"out/{victim.name}", "sha256": file_hash(victim)},
    "hidden steps": lambda victim: {"path": f"plots/../../{victim.name}", "sha256": file_hash(victim)},
}


@pytest.mark.parametrize("kind", MANIFESTS)
@pytest.mark.parametrize("force", [False, True])
def test_a_manifest_of_others_removes_nothing(folder: Path, kind: str, force: bool) -> None:
    victim = folder.parent / "victim.txt"
    victim.write_text("precious", encoding="utf-8")
    (folder / "out").symlink_to(folder.parent)
    entry = {"format": "x", "bytes": 8, "spec_sha256": "0", **MANIFESTS[kind](victim)}
    manifest = folder / "manifest.json"
    manifest.write_text(json.dumps({"schema": 1, "name": "x", "files": [entry], "skipped": []}), encoding="utf-8")
    if force:
        write(folder, NEW, Protection(force=True))
    else:
        with pytest.raises(ExportError, match=r"'.*manifest\.json' was not made by this program"):
            write(folder, NEW)
    assert victim.read_text(encoding="utf-8") == "precious"
    assert FOREIGN.items() <= contents(folder).items()


def test_a_file_of_ours_that_was_changed_is_kept_unless_forced(folder: Path) -> None:
    (folder / "profile.csv").write_text("edited by hand", encoding="utf-8")
    with pytest.raises(ExportError, match=r"profile\.csv' was not made by this program, or was changed since"):
        write(folder, NEW)
    assert contents(folder)["disc.step"] == "old"
    write(folder, NEW, Protection(force=True))
    assert assert_whole(folder) == "new"


def test_a_changed_file_that_is_no_longer_written_stays(folder: Path) -> None:
    (folder / "stale.nc").write_text("edited", encoding="utf-8")
    write(folder, NEW)
    assert contents(folder)["stale.nc"] == "edited"


def test_an_input_is_no_output(folder: Path) -> None:
    read = folder / "profile.csv"
    with pytest.raises(ExportError, match="is an input of this command"):
        write(folder, NEW, Protection(inputs=(read,)))
    assert assert_whole(folder) == "old"


def test_a_stale_file_that_is_an_input_stays(folder: Path) -> None:
    write(folder, NEW, Protection(inputs=(folder / "stale.nc",)))
    assert contents(folder)["stale.nc"] == "old"


def test_a_folder_that_is_a_link_stays_one_and_links_out_of_it_are_refused(folder: Path) -> None:
    link = folder.parent / "link"
    link.symlink_to(folder)
    write(link, NEW)
    assert link.is_symlink()
    assert assert_whole(folder) == "new"
    elsewhere = folder.parent / "elsewhere"
    elsewhere.mkdir()
    (folder / "sub").symlink_to(elsewhere)
    with pytest.raises(ExportError, match="a link leads out of the folder"):
        write(folder, {"sub/x.csv": "new"})
    assert not any(elsewhere.iterdir())


def test_the_working_folder_stays_the_working_folder(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    inode = folder.stat().st_ino
    write(Path(), NEW)
    assert folder.stat().st_ino == inode
    assert assert_whole(folder) == "new"


def test_what_others_add_meanwhile_is_kept(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    exchange = filesystem.exchange

    def late(one: Path, other: Path) -> None:
        (folder / "deep" / "late.csv").write_text("mine", encoding="utf-8")
        exchange(one, other)

    monkeypatch.setattr(filesystem, "exchange", late)
    write(folder, NEW)
    assert contents(folder)["deep/late.csv"] == "mine"


def test_a_link_to_a_folder_that_is_still_to_be_made_is_followed(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "new")
    PROTECTED.check_folder(tmp_path / "link", ["report.html"])
    write(tmp_path / "link", NEW)
    assert contents(tmp_path / "new") == contents(tmp_path / "link") != {}


def test_links_that_lead_round_in_a_circle_and_pipes_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a").symlink_to(tmp_path / "b")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    with pytest.raises(ExportError, match="cannot be written"), atomic_folder(tmp_path / "a" / "out"):
        pass
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ExportError, match="no plain file"):
        Protection(force=True).check(tmp_path / "pipe")
