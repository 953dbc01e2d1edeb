"""Calls to the file system that must leave an old file or a new one: rename, exchange, wait for the disk.

No other module makes them, so that tests can fail each. Every function raises ``OSError`` as the system does.
"""

from __future__ import annotations

import ctypes
import glob
import os
import secrets
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

_AT_FDCWD = -100  # paths relative to the working folder
_EXCHANGE = 2  # RENAME_EXCHANGE of linux/fs.h
ABANDONED = 3600.0  # s after which what no process holds counts as left behind; no single file takes as long


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """A scratch name next to ``path`` for its new content, which takes its place at the end of the block, or vanishes.

    The content is on the disk before. Scratch files that a killed process left for ``path`` are removed.
    """
    if path.exists() and not path.is_file():
        raise OSError(22, "it is no plain file", str(path))
    for old in path.parent.glob(f".{glob.escape(path.name)}.*.partial"):
        with suppress(OSError):
            if time.time() - old.stat().st_mtime > ABANDONED:
                old.unlink()
    # Two processes that write the same file have a scratch file each; the last one to end wins.
    scratch = path.with_name(f".{path.name}.{secrets.token_hex(4)}.partial")
    try:
        yield scratch
        sync(scratch)
        rename(scratch, path)
        sync(path.parent)
    finally:
        scratch.unlink(missing_ok=True)


def lock(folder: Path) -> int | None:
    """A handle that holds the lock of a folder until it is closed, None where another process holds it.

    The system frees the lock when a process ends. Raises ``ImportError`` where the system has no such locks.
    """
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        return None
    except OSError:
        os.close(handle)
        raise
    return handle


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
