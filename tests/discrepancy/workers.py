"""What every process of a pool does first."""

from __future__ import annotations

import os


def one_core() -> None:
    """Keep compiled code to one core, before it is loaded: there are as many processes as cores, and to wait for each
    other's threads takes them several times as long.
    """
    os.environ["NUMBA_NUM_THREADS"] = "1"
