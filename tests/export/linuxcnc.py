"""LinuxCNC's own interpreter as a reader, where it is installed, or unpacked in the folder ``LINUXCNC_ROOT``.

The Debian packages linuxcnc-uspace and libboost-python1.74.0 unpacked into one folder are enough. This file is
also the program that runs the interpreter, in a separate process, because its libraries are found by
``LD_LIBRARY_PATH`` only.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

_ABSENT = 3


class Interpreted(NamedTuple):
    """Moves ("rapid" or "line", x, y, c, z) and ("arc", x, y, centre x, centre y, turns) in mm and degrees.

    ``rates``: feed of each line [mm/min, or 1/min in inverse time]; ``error`` the program ended with, or None.
    """

    moves: list[tuple[Any, ...]]
    rates: list[float]
    error: str | None


def interpreted(path: Path, folder: Path) -> Interpreted:
    """A program as LinuxCNC interprets it; skips the test where it is not installed."""
    import pytest

    root = os.environ.get("LINUXCNC_ROOT", "/")
    libraries = f"{root}/usr/lib:{root}/usr/lib/x86_64-linux-gnu"
    environment = os.environ | {"LD_LIBRARY_PATH": libraries, "PYTHONPATH": f"{root}/usr/lib/python3/dist-packages"}
    # Its table of tools is a file in the home folder.
    environment["HOME"] = str(folder)
    command = [sys.executable, __file__, str(path), str(folder)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    if done.returncode == _ABSENT:
        pytest.skip(f"LinuxCNC's interpreter is not here ({done.stderr.strip()}): unpack it and set LINUXCNC_ROOT")
    assert done.returncode == 0, done.stderr
    report = json.loads((folder / "interpreted.json").read_text())
    return Interpreted([tuple(move) for move in report["moves"]], report["rates"], report["error"])


def arc_points(here: np.ndarray, move: tuple[Any, ...], per_arc: int = 7) -> np.ndarray:
    """Points along an arc of the interpreter, shape (per_arc, 2)."""
    _, x, y, cx, cy, turns = move
    a0, a1 = np.arctan2(here[1] - cy, here[0] - cx), np.arctan2(y - cy, x - cx)
    sweep = (a1 - a0) % (2.0 * np.pi) if turns > 0 else -((a0 - a1) % (2.0 * np.pi))
    t = (np.arange(per_arc) + 0.5) / per_arc
    r0, r1 = np.hypot(here[0] - cx, here[1] - cy), np.hypot(x - cx, y - cy)
    radius, angle = r0 + (r1 - r0) * t, a0 + sweep * t
    return np.stack([cx + radius * np.cos(angle), cy + radius * np.sin(angle)], axis=-1)


class _Recorder:
    """Called by the interpreter for all that a machine would do; lengths come in inches."""

    def __init__(self, folder: str) -> None:
        self.moves: list[tuple[Any, ...]] = []
        self.rates: list[float] = []
        self.parameter_file = f"{folder}/parameters.var"
        self._rate = 0.0

    def straight_traverse(self, *axes: float) -> None:
        self.moves.append(("rapid", 25.4 * axes[0], 25.4 * axes[1], axes[5], 25.4 * axes[2]))

    def straight_feed(self, *axes: float) -> None:
        self.moves.append(("line", 25.4 * axes[0], 25.4 * axes[1], axes[5], 25.4 * axes[2]))
        self.rates.append(self._rate)

    def arc_feed(self, x: float, y: float, cx: float, cy: float, turns: int, *_: float) -> None:
        self.moves.append(("arc", 25.4 * x, 25.4 * y, 25.4 * cx, 25.4 * cy, turns))

    def set_feed_rate(self, rate: float) -> None:
        self._rate = rate

    def get_tool(self, pocket: int) -> tuple[float, ...]:
        # Tool 1, without length or radius, as the programs call it.
        return (1 if pocket in (0, 1) else -1, *(0.0 for _ in range(9)), 0.0, 0.0, 0.0, 0)

    def get_axis_mask(self) -> int:
        return 0b100111

    def get_external_length_units(self) -> float:
        return 1.0 / 25.4

    def get_external_angular_units(self) -> float:
        return 1.0

    def get_block_delete(self) -> bool:
        return False

    def check_abort(self) -> bool:
        return False

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_: None


def _make_tool_table(folder: str) -> None:
    """A table with tool 1 in shared memory, without which the interpreter crashes; a running LinuxCNC makes it."""
    import ctypes

    try:
        library = ctypes.CDLL("libtooldata.so.0")
        create, load = library._Z17tool_mmap_creatorPK13EMC_TOOL_STATi, library._Z13tooldata_loadPKcPPc
    except (OSError, AttributeError):
        return  # versions that keep it elsewhere
    create.argtypes, load.argtypes = [ctypes.c_void_p, ctypes.c_int], [ctypes.c_char_p, ctypes.c_void_p]
    create(None, 0)
    table = Path(folder) / "tool.tbl"
    table.write_text("T1 P1 Z0.0 D0.0 ;\n", encoding="ascii")
    load(str(table).encode(), None)


def _run(path: str, folder: str) -> int:
    try:
        import gcode
    except ImportError as missing:
        print(missing, file=sys.stderr)
        return _ABSENT
    _make_tool_table(folder)
    recorder = _Recorder(folder)
    result, _ = gcode.parse(path, recorder, "G21", "")
    error = gcode.strerror(result) if result > gcode.MIN_ERROR else None
    report = {"moves": recorder.moves, "rates": recorder.rates, "error": error}
    (Path(folder) / "interpreted.json").write_text(json.dumps(report))
    return 0


if __name__ == "__main__":
    raise SystemExit(_run(*sys.argv[1:]))
