"""Commands in a pseudo-terminal of a given width."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from rich.text import Text

ROOT = Path(__file__).parents[2]


def in_terminal(words: Sequence[str], width: int, answers: str = "", cwd: Path = ROOT) -> tuple[int, str]:
    """Exit status of Python with these ``words`` in a terminal of ``width`` cells, and what it shows, without colours.

    ``answers`` are typed in.
    """
    fcntl, pty, termios = (pytest.importorskip(name) for name in ("fcntl", "pty", "termios"))  # not on Windows
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 50, width, 0, 0))
    unsized = {key: value for key, value in os.environ.items() if key not in ("COLUMNS", "LINES")}
    environment = {**unsized, "TERM": "xterm", "PYTHONIOENCODING": "utf-8", "PYTHONPATH": str(ROOT)}
    running = subprocess.Popen(
        [sys.executable, *words], cwd=cwd, env=environment, stdin=theirs, stdout=theirs, stderr=theirs
    )
    os.close(theirs)
    os.write(ours, answers.encode())
    shown = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # Linux: the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(ours)
    return running.wait(), Text.from_ansi(shown.decode().replace("\r\n", "\n")).plain
