"""Files on their way into an output folder: the lock, the scratch folder, one exchange or a journal of renames.

The scratch folder ``.NAME.cycloid-profile.partial`` lies next to the output folder NAME, or inside it where its parent
cannot be written to. Holding its lock is the right to write. What an interrupted run leaves there, the next one ends:
``exchange.json`` and ``journal.json`` say how far it came.
"""

from __future__ import annotations

import json
import logging
import os
import shutil
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cycloid_profile import filesystem as system
from cycloid_profile.errors import ExportError
from cycloid_profile.export.writing.manifest import file_hash, is_inside
from cycloid_profile.export.writing.signals import signals_deferred

PARTIAL = "cycloid-profile.partial"
_EXCHANGE, _JOURNAL = "exchange.json", "journal.json"
_PATIENCE = 30.0  # s to wait for another process that writes into the same folder
_log = logging.getLogger("cycloid_profile")


@dataclass(frozen=True)
class Stage:
    """The scratch folder ``place`` of an output ``folder``; files are made in ``new``."""

    place: Path
    folder: Path
    shared: bool

    @property
    def new(self) -> Path:
        return self.place / "new"

    def commit(self, names: Sequence[str], removed: Mapping[str, str]) -> None:
        """Put the files ``names`` into the folder and remove ``removed``, name to hash; all or nothing.

        Raises ``OSError`` after which the folder is as it was.
        """
        system.sync_tree(self.new)
        if not self.folder.exists():
            system.rename(self.new, self.folder)
            system.sync(self.folder.parent)
        elif self.shared or self.place.parent == self.folder or not self._exchanged(names, removed):
            self._renamed(names, removed)

    def _exchanged(self, names: Sequence[str], removed: Mapping[str, str]) -> bool:
        """Whether the folder could be exchanged for ``new``, with everything else in it as a second name."""
        try:
            # A process that stands in the folder would find itself in the old one.
            if Path.cwd().is_relative_to(self.folder):
                return False
            _link_others(self.folder, self.new, {*names, *removed})
            _write_json(self.place / _EXCHANGE, {"inode": self.new.stat().st_ino, "removed": sorted(removed)})
            system.exchange(self.new, self.folder)
        except OSError:
            # A mount, or a file system without exchange or second names: the journal serves there.
            (self.place / _EXCHANGE).unlink(missing_ok=True)
            return False
        system.sync(self.folder.parent)
        return True

    def _renamed(self, names: Sequence[str], removed: Mapping[str, str]) -> None:
        moves = [[name, file_hash(self.folder / name), file_hash(self.new / name)] for name in names]
        journal = {"moves": moves, "removed": dict(removed)}
        if len(names) == 1 and not removed:
            (self.folder / names[0]).parent.mkdir(parents=True, exist_ok=True)
            system.rename(self.new / names[0], self.folder / names[0])
            return
        _write_json(self.place / _JOURNAL, journal)
        try:
            _complete(self.place, self.folder, journal)
        except OSError:
            _undo(self.place, self.folder, journal)
            (self.place / _JOURNAL).unlink()
            raise


@contextmanager
def staging(folder: Path, shared: bool) -> Iterator[Stage]:
    """A locked scratch folder for ``folder``, after the end of what an earlier run left; removed at the end.

    ``shared``: the folder holds files of others, and is never exchanged as a whole. Raises ``OSError``, and
    ``ExportError`` where another process keeps writing into it.
    """
    # Missing folders, innermost first: a failed attempt removes them again.
    created = [path for path in folder.parents if not path.exists()]
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        place = _place(folder)
        with _locked(place, folder):
            _end_earlier_run(place, folder)
            stage = Stage(place, folder, shared)
            stage.new.mkdir()
            yield stage
    finally:
        for path in created:
            with suppress(OSError):
                path.rmdir()  # refused by the system unless empty


def _place(folder: Path) -> Path:
    sibling = folder.parent / f".{folder.name}.{PARTIAL}"
    if not folder.exists():
        return sibling
    sibling_possible = os.access(folder.parent, os.W_OK) and folder.stat().st_dev == folder.parent.stat().st_dev
    return sibling if sibling_possible and folder.name else folder / f".{PARTIAL}"


@contextmanager
def _locked(place: Path, folder: Path) -> Iterator[None]:
    """The lock of a scratch folder, which is made if need be, and ended before others can have the lock."""
    until = time.monotonic() + _PATIENCE
    handle: int | None = None
    try:
        while handle is None:
            if time.monotonic() > until:
                limit = "is being written by another process"
                remedy = "wait for it, or choose another with --out"
                raise ExportError("output folder", f"'{folder}'", limit, remedy, " ")
            # A signal between the making of the folder and its lock would leave it without an owner.
            with signals_deferred():
                handle = _grabbed(place)
            if handle is None:
                time.sleep(0.05)
        yield
    finally:
        if handle is not None:
            with signals_deferred():
                _end(place, folder)
                os.close(handle)


def _grabbed(place: Path) -> int | None:
    """Handle of the locked folder, None where another process holds it; the system frees it when a process ends."""
    with suppress(FileExistsError):
        place.mkdir()
    if place.is_symlink():
        raise OSError(40, "a link has the name of the scratch folder", str(place))
    handle: int | None = None
    try:
        handle = system.lock(place)
        # The process before may have removed the folder between the two calls.
        if handle is None or os.fstat(handle).st_ino == place.stat().st_ino:
            return handle
    except ImportError:
        return _grabbed_by_age(place)
    except FileNotFoundError:
        pass
    if handle is not None:
        os.close(handle)
    return None


def _grabbed_by_age(place: Path) -> int | None:
    # Age decides where the system has no locks.
    if any(place.iterdir()) and time.time() - place.stat().st_mtime < system.ABANDONED:
        return None
    return os.open(os.devnull, os.O_RDONLY)


def _end_earlier_run(place: Path, folder: Path) -> None:
    if not any(place.iterdir()):
        return
    minutes = max(0.0, time.time() - place.stat().st_mtime) / 60.0
    completed = _end(place, folder)
    place.mkdir(exist_ok=True)
    what = "completed" if completed else "removed the remains of"
    _log.warning("%s a run into '%s' that was interrupted %.0f min ago", what, folder, minutes)


def _end(place: Path, folder: Path) -> bool:
    """Complete what began to take effect, and remove the scratch folder; whether there was anything to complete."""
    exchange, journal = _read_json(place / _EXCHANGE), _read_json(place / _JOURNAL)
    began = False
    with suppress(OSError):
        if exchange is not None and folder.exists() and folder.stat().st_ino == exchange.get("inode"):
            began = True
            _rescue(place / "new", folder, exchange.get("removed", ()))
        elif journal is not None:
            began = True
            _complete(place, folder, journal)
        for inner in place.iterdir():
            if inner.is_dir() and not inner.is_symlink():
                shutil.rmtree(inner)
            else:
                inner.unlink()
        place.rmdir()
    return began


def _link_others(old: Path, new: Path, ours: set[str]) -> None:
    """Give every file of ``old`` but ``ours`` a second name in ``new``; folders are made again."""
    shutil.copystat(old, new)
    for name, path in _files(old):
        target = new / name
        if path.is_dir() and not path.is_symlink():
            target.mkdir(exist_ok=True)
            shutil.copystat(path, target)
        elif name not in ours:
            system.link(path, target)


def _rescue(old: Path, folder: Path, removed: Sequence[str]) -> None:
    """Move files that reached the ``old`` folder after its files got their second names."""
    for name, path in _files(old):
        target = folder / name
        if path.is_dir() and not path.is_symlink():
            target.mkdir(exist_ok=True)
        elif name not in removed and not os.path.lexists(target) and path.stat(follow_symlinks=False).st_nlink == 1:
            system.rename(path, target)


def _files(folder: Path) -> list[tuple[str, Path]]:
    """Relative names and paths of everything in a folder, folders before their files; no link is followed."""
    found: list[tuple[str, Path]] = []

    def fail(error: OSError) -> None:
        raise error

    for top, folders, files in os.walk(folder, onerror=fail):
        paths = [Path(top) / name for name in sorted(folders) + sorted(files)]
        found += [(path.relative_to(folder).as_posix(), path) for path in paths]
    return found


def _complete(place: Path, folder: Path, journal: Mapping[str, Any]) -> None:
    """Carry out what is left of a journal; a file that was changed since the journal was written is left alone."""
    for name, before, after in journal["moves"]:
        staged, target = place / "new" / name, folder / name
        if not staged.is_file() or not is_inside(name, folder):
            continue
        if os.path.lexists(target) and file_hash(target) not in (before, after):
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        _keep_old(place, folder, name)
        system.rename(staged, target)
    for name, digest in journal["removed"].items():
        if is_inside(name, folder) and file_hash(folder / name) == digest:
            _keep_old(place, folder, name)
            system.remove(folder / name)
    for parent in {(folder / name).parent for name, _, _ in journal["moves"]}:
        if parent.is_dir():
            system.sync(parent)


def _keep_old(place: Path, folder: Path, name: str) -> None:
    target, kept = folder / name, place / "old" / name
    if not os.path.lexists(target) or kept.exists():
        return
    kept.parent.mkdir(parents=True, exist_ok=True)
    try:
        system.link(target, kept)
    except OSError:
        shutil.copy2(target, kept, follow_symlinks=False)


def _undo(place: Path, folder: Path, journal: Mapping[str, Any]) -> None:
    """Put the old files back; what the journal brought is removed."""
    for name, _, after in journal["moves"]:
        kept, target = place / "old" / name, folder / name
        if kept.exists():
            kept.replace(target)
        elif not (place / "new" / name).exists() and file_hash(target) == after:
            target.unlink()
            if target.parent != folder:
                with suppress(OSError):
                    target.parent.rmdir()
    for name in journal["removed"]:
        kept = place / "old" / name
        if kept.exists():
            kept.replace(folder / name)


def _write_json(path: Path, value: Mapping[str, Any]) -> None:
    with system.new_file(path) as scratch:
        scratch.write_text(json.dumps(value), encoding="utf-8")


def _read_json(path: Path) -> dict[str, Any] | None:
    try:
        value = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    return value if isinstance(value, dict) else None
