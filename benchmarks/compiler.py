"""What compiling costs and brings: ``python -m benchmarks.compiler`` measures one process and prints JSON."""

from __future__ import annotations

import importlib
import json
import sys
from collections.abc import Callable
from time import perf_counter
from typing import Any

from benchmarks.rv40e import loaded_rv40e
from benchmarks.touched import TouchedDisc
from cycloid_profile.contact.disc.equilibrium import balance_moments, balance_moments_numpy

POSES = 10_000
ROUNDS = 150


def main() -> None:
    disc = TouchedDisc(loaded_rv40e(), POSES)
    given: tuple[Any, ...] = (disc.law, disc.contact, disc.gap, disc.lever, disc.torque)
    imported = _seconds(lambda: importlib.import_module("numba"))
    numba = sys.modules["numba"]
    first = _seconds(lambda: balance_moments(*given))
    cores = numba.get_num_threads()
    plain, alone, together = [], [], []
    for _ in range(ROUNDS):
        plain.append(_seconds(lambda: balance_moments_numpy(*given)))
        for threads, times in ((1, alone), (cores, together)):
            numba.set_num_threads(threads)
            times.append(_seconds(lambda: balance_moments(*given)))
    found = {"import": imported, "first": first, "plain": min(plain), "alone": min(alone), "together": min(together)}
    print(json.dumps(found))


def _seconds(call: Callable[[], Any]) -> float:
    start = perf_counter()
    call()
    return perf_counter() - start


if __name__ == "__main__":
    main()
