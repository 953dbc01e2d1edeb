"""Calls to the file system that change an output folder; the only place that makes them, so that tests can fail each.

Every function raises ``OSError`` as the system does.
"""

from __future__ import annotations

import ctypes
import os
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path

_AT_FDCWD = -100  # paths relative to the working folder
_EXCHANGE = 2  # RENAME_EXCHANGE of linux/fs.h


def rename(source: Path, target: Path) -> None:
    """Move a file or folder in one step; a file at ``target`` is replaced."""
    source.replace(target)


def link(source: Path, target: Path) -> None:
    """A second name for a file; a symbolic link is linked itself."""
    os.link(source, target, follow_symlinks=False)


def remove(file: Path) -> None:
    """Remove a file."""
    file.unlink()


def exchange(one: Path, other: Path) -> None:
    """Swap two folders in one step; at no time is either name missing."""
    call = _renameat2()
    if call is None:
        raise OSError(95, "no exchange on this system", str(other))
    if call(_AT_FDCWD, os.fsencode(one), _AT_FDCWD, os.fsencode(other), _EXCHANGE) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), str(other))


def sync(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk; folders only where the system can."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:
        if path.is_dir():
            return
        raise
    try:
        os.fsync(handle)
    except OSError as error:
        # EINVAL: this kind of file system cannot wait.
        if error.errno != 22:
            raise
    finally:
        os.close(handle)


def sync_tree(folder: Path) -> None:
    """Wait for all files and folders in ``folder``."""
    for path in sorted(folder.rglob("*"), reverse=True):
        if not path.is_symlink():
            sync(path)
    sync(folder)


@cache
def _renameat2() -> ctypes._FuncPointer | None:  # type: ignore[name-defined,unused-ignore]
    if not sys.platform.startswith("linux"):
        return None
    with suppress(OSError, AttributeError):
        call = ctypes.CDLL(None, use_errno=True).renameat2
        call.argtypes = (ctypes.c_int, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_uint)
        return call
    return None
