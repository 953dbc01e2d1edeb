"""What all code compiled by numba shares: its options, and a call on all cores; imported inside functions only."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from typing import Protocol, TypeVar

from numba import get_num_threads, njit

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


def on_all_cores(solve: Callable[[int, int], None], count: int) -> None:
    """Call ``solve`` for consecutive parts of ``range(count)``, begin and end, one a core.

    Threads and not numba's own parallel loops, which take five times as long to compile.
    """
    parts = min(get_num_threads(), count)
    if parts < 2:
        return solve(0, count)
    ends = [count * i // parts for i in range(parts + 1)]
    with ThreadPoolExecutor(parts) as pool:
        list(pool.map(lambda part: solve(*part), pairwise(ends)))
    return None
