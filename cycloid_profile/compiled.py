"""What all code compiled by numba shares: its options, and a call on all cores; imported inside functions only."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from itertools import pairwise
from typing import Protocol, TypeVar

from numba import config, get_num_threads, njit

from cycloid_profile.language import translated

R = TypeVar("R")
_log = logging.getLogger("cycloid_profile")


class _Decorator(Protocol):
    def __call__(self, function: Callable[..., R], /) -> Callable[..., R]: ...


def _compiler(**options: object) -> _Decorator:
    shared = {"nogil": True, "error_model": "numpy", **options}

    def compiler(function: Callable[..., R], /) -> Callable[..., R]:
        kept: _Decorator = njit(cache=True, **shared)
        uncached: _Decorator = njit(**shared)
        try:
            return kept(function)
        except RuntimeError:
            # No folder takes the compiled code, as in a container whose file system is read-only.
            _warn_of_compiling_again()
            return uncached(function)

    return compiler


@cache
def _warn_of_compiling_again() -> None:
    sentence = "every run compiles again: neither the package nor the home folder can be written; set NUMBA_CACHE_DIR"
    _log.warning(translated(sentence))


# Called from Python.
kernel = _compiler()
# Called from compiled code alone: without the entry for Python, which takes a quarter of the time of the compiler.
_NO_ENTRY = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
inner = _compiler(**_NO_ENTRY)
inlined = _compiler(forceinline=True)
# May fuse a product and a sum: sums of products round once instead of twice, and loops become vectors.
contracted = _compiler(fastmath={"contract"}, **_NO_ENTRY)


@cache
def _threads() -> ThreadPoolExecutor:
    """Threads of this process, started once: a block of poses takes little longer than the start of a thread."""
    return ThreadPoolExecutor(config.NUMBA_NUM_THREADS)


if hasattr(os, "register_at_fork"):  # a child has no threads of its parent
    os.register_at_fork(after_in_child=_threads.cache_clear)


def on_all_cores(solve: Callable[[int, int], None], count: int) -> None:
    """Call ``solve`` for consecutive parts of ``range(count)``, begin and end, one a core.

    Threads and not numba's own parallel loops, which take five times as long to compile. ``solve`` is compiled code and
    must not call this again.
    """
    parts = max(min(get_num_threads(), count), 1)
    ends = [count * i // parts for i in range(parts + 1)]
    others = [_threads().submit(solve, *part) for part in pairwise(ends[:-1])]
    try:
        solve(ends[-2], ends[-1])
    finally:
        wait(others)
    for one in others:
        one.result()
