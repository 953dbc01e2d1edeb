"""Run a study: every chunk that is not on disk yet, written as it comes."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from cycloid_profile.tolerance.store import Store, open_store
from cycloid_profile.tolerance.study import Study
from cycloid_profile.tolerance.workers import Threads, Workers


def run(
    study: Study, folder: Path, workers: Workers | None = None, tell: Callable[[str], None] = lambda _: None
) -> Store:
    """All answers of a study in ``folder``; what is there from a run that was stopped is kept.

    Raises ``ToleranceError`` if the folder cannot be written to, or the workers cannot compute.
    """
    store = open_store(folder, study)
    missing = store.missing()
    left, began = len(missing), time.monotonic()
    if len(missing) < study.chunks:
        tell(f"{study.chunks - left} of {study.chunks} chunks are there from a run before")
    for number, values in (workers or Threads()).results(study, missing):
        store.put(number, values)
        left -= 1
        done = len(missing) - left
        seconds = (time.monotonic() - began) / done * left
        reducers = min((study.chunks - left) * study.chunk, study.samples)
        tell(f"{reducers:,} of {study.samples:,} reducers, {seconds:.0f} s to go")
    return store
