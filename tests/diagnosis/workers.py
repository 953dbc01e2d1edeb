"""Initialisation of worker processes."""

from __future__ import annotations

import os


def one_core() -> None:
    """Limit compiled code to one core before it is loaded: one process per core runs several times as fast without
    thread contention.
    """
    os.environ["NUMBA_NUM_THREADS"] = "1"
