"""A package killed at every call to the system that changes a folder: ``python -m tests.hostile.kills``; needs strace.

The tests of the writer die at its own calls. Here the system kills it at each rename, exchange, link, unlink, mkdir and
rmdir, those of the standard library included. The folder is then read as another program would read it.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path

from cycloid_profile.export.writing import atomic_folder
from tests.export.test_writing import FOREIGN, NEW, OLD, assert_whole, write

CALLS = ("rename", "renameat", "renameat2", "link", "linkat", "unlink", "unlinkat", "mkdir", "mkdirat", "rmdir")
CHILD = "import sys; from tests.hostile.kills import child; child(*sys.argv[1:])"
METHODS = ("exchange", "journal")


def child(folder: str, method: str) -> None:
    """Write the new package over the old one; the child process of ``killed_at``."""
    from cycloid_profile import filesystem

    def cannot(*_: object) -> None:
        raise OSError(22, "Invalid argument")

    if method == "journal":
        filesystem.exchange = cannot
    write(Path(folder), NEW)


def killed_at(call: str, number: int, folder: Path, method: str) -> bool:
    """Kill a child at its ``number``-th ``call`` to the system; whether it made that many."""
    words = ["strace", "-f", "-qqq", "-o", "/dev/null", "-e", f"inject=?{call}:signal=KILL:when={number}"]
    done = subprocess.run([*words, sys.executable, "-B", "-c", CHILD, str(folder), method], check=False)
    return done.returncode != 0


def mixed(call: str, method: str) -> tuple[int, int]:
    """Number of kills at one kind of call, and of those that left neither the old package nor the new one."""
    kills = bad = 0
    while True:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "drive"
            write(folder, OLD)
            for other, text in FOREIGN.items():
                (folder / other).parent.mkdir(parents=True, exist_ok=True)
                (folder / other).write_text(text, encoding="utf-8")
            if not killed_at(call, kills + 1, folder, method):
                assert assert_whole(folder) == "new"
                return kills, bad
            kills += 1
            if method == "journal":
                # The next start ends what this one began.
                with suppress(RuntimeError), atomic_folder(folder):
                    raise RuntimeError
            try:
                assert_whole(folder)
            except AssertionError as error:
                bad += 1
                print(f"{method}, {call} {kills}: {error}")


def main() -> None:
    for method in METHODS:
        found = {call: mixed(call, method) for call in CALLS}
        kills, bad = (sum(each) for each in zip(*found.values(), strict=True))
        by_call = ", ".join(f"{count} {call}" for call, (count, _) in found.items() if count)
        print(f"{method}: {bad} mixed of {kills} kills ({by_call})", flush=True)


if __name__ == "__main__":
    main()
