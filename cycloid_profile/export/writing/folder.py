"""Output folders: files that appear all together or not at all, over nothing that is not ours."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from cycloid_profile.errors import ExportError
from cycloid_profile.export.writing._staging import Stage, staging
from cycloid_profile.export.writing.manifest import (
    MANIFEST,
    file_hash,
    is_inside,
    read_manifest,
    remember,
    unchanged_entries,
    was_made_here,
)
from cycloid_profile.export.writing.signals import signals_deferred


@dataclass(frozen=True, slots=True)
class Protection:
    """What a write must leave alone: the ``inputs`` of the command, and files made by others; nothing by ``force``."""

    inputs: tuple[Path, ...] = ()
    force: bool = False

    def check(self, target: Path) -> None:
        """Raises ``ExportError`` where ``target`` is a folder, a device or a pipe, an input, or a file that this
        program did not make or that was changed since; ``force`` allows the last two."""
        if target.is_dir():
            raise _refusal(target, "a folder has that name")
        if target.exists() and not target.is_file():
            raise _refusal(target, "it is no plain file")
        if self.force or not os.path.lexists(target):
            return
        if any(one.exists() and target.exists() and one.samefile(target) for one in self.inputs):
            raise ExportError(
                "output file", f"'{target}'", "is an input of this command", "choose another name, or add --force", " "
            )
        if not _is_ours(target):
            raise _foreign(target)

    def check_folder(self, folder: Path, names: Iterable[str] = ()) -> None:
        """Raises ``ExportError`` where ``folder`` cannot be one, or ``check`` refuses one of ``names`` in it."""
        standing = next(one for one in (folder, *folder.absolute().parents) if one.exists())
        if not standing.is_dir():
            raise _refusal(standing, "it is a file, not a folder")
        for name in names:
            self.check(folder / name)


PROTECTED = Protection()  # nothing that this program did not make is replaced
_written: list[Path] = []


@contextmanager
def atomic_folder(
    folder: Path, protection: Protection = PROTECTED, *, replaces: bool = False, shared: bool = False
) -> Iterator[Path]:
    """A scratch folder whose files take their place in ``folder`` at the end, all at once, or vanish.

    One exchange of folders where the system has it, else renames that the next run completes. ``replaces``: unaltered
    files of an older manifest in ``folder`` that are not written again are removed. ``shared``: the folder holds files
    of others, such as the working folder, and stays the same folder.

    Raises ``ExportError`` if ``folder`` cannot be written to, is being written by another process, or holds a file
    under one of the names that ``protection`` keeps.
    """
    shown = folder
    try:
        folder = _resolved(folder)
        protection.check_folder(shown)
        # From the first renamed file to the removal of the scratch folder no signal takes effect.
        with ExitStack() as to_the_end, staging(folder, shared) as stage:
            yield stage.new
            to_the_end.enter_context(signals_deferred())
            _commit(stage, shown, protection, replaces)
    except OSError as error:
        named = error.filename2 or error.filename or shown
        raise _refusal(Path(os.fsdecode(named)), error.strerror or str(error)) from None


def _resolved(folder: Path) -> Path:
    """The folder that links lead to; raises ``OSError`` where they lead round in a circle."""
    try:
        return folder.resolve()
    except RuntimeError:
        raise OSError(40, "links lead round in a circle", str(folder)) from None


def written_folders() -> tuple[Path, ...]:
    """Folders that received their files since this process began."""
    return tuple(_written)


def _commit(stage: Stage, shown: Path, protection: Protection, replaces: bool) -> None:
    folder = stage.folder
    names = sorted(path.relative_to(stage.new).as_posix() for path in stage.new.rglob("*") if path.is_file())
    for name in names:
        target = shown / name
        if not is_inside(name, folder):
            raise _refusal(target, "a link leads out of the folder")
        if file_hash(target) != file_hash(stage.new / name):
            protection.check(target)
    entries = unchanged_entries(folder) if replaces else []
    kept = {one.resolve() for one in protection.inputs}
    stale = {e["path"]: e["sha256"] for e in entries if e["path"] not in names and folder / e["path"] not in kept}
    digests = [digest for name in names if (digest := file_hash(stage.new / name)) is not None]
    stage.commit(names, stale)
    _written.append(shown)
    remember(digests)


def _is_ours(file: Path) -> bool:
    """Whether this program made ``file`` and nobody changed it; a manifest is ours if it reads as one."""
    if file.name == MANIFEST and read_manifest(file.parent) is not None:
        return True
    if was_made_here(digest := file_hash(file)):
        return True
    # A package that was made on another machine is certified by its manifest, one or more folders up.
    for folder in file.absolute().parents[:2]:
        name = file.absolute().relative_to(folder).as_posix()
        read = read_manifest(folder)
        if read is not None and any(e["path"] == name and e["sha256"] == digest for e in read["files"]):
            return True
    return False


def _foreign(target: Path) -> ExportError:
    limit = "was not made by this program, or was changed since"
    return ExportError("output file", f"'{target}'", limit, "move it, choose another --out, or add --force", " ")


def _refusal(path: Path, reason: str) -> ExportError:
    return ExportError("output file", f"'{path}'", f"cannot be written ({reason})", "choose another with --out", " ")
