"""Tests collected once, then run for one mutant after another, each in a fork of this process; see ``mutants.py``.

A mutant comes as a line of JSON on standard input: path, old text, new text. Those tests run that call a function which
differs, fastest first. The answer is a line with the status of the run.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import pickle
import resource
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from types import CodeType, FrameType, FunctionType
from typing import TextIO

import pytest
from _pytest.main import pytest_runtestloop

ROOT = Path(__file__).parents[2]
SECONDS = 120  # of a processor; a mutant whose tests need more has no end

# A mutant must neither find what another run computed, nor leave what others would find.
CACHE = "XDG_CACHE_HOME"

Place = tuple[str, str, int]


def place_of(code: CodeType) -> Place:
    """File, name and first line of a function."""
    return code.co_filename, code.co_qualname, code.co_firstlineno


def codes(text: str, path: str) -> Iterator[CodeType]:
    """Code of a module, its classes and all functions, in order."""
    waiting = [compile(text, path, "exec", dont_inherit=True)]
    while waiting:
        code = waiting.pop()
        yield code
        waiting += [part for part in code.co_consts if isinstance(part, CodeType)]


def change(path: str, old: str, new: str) -> set[Place]:
    """Give the functions of a module the code of its new text; the places of the functions that differ."""
    # Many modules are imported inside functions only: not loaded yet, they would come unchanged.
    importlib.import_module(".".join(Path(path).relative_to(ROOT).with_suffix("").parts))
    kept = set(codes(old, path))
    found = {place_of(code): code for code in codes(new, path) if code not in kept}
    for function in gc.get_objects():
        if isinstance(function, FunctionType) and function.__code__.co_filename == path:
            code = found.get(place_of(function.__code__))
            if code is not None and len(code.co_freevars) == len(function.__code__.co_freevars):
                function.__code__ = code
    return set(found)


class Touched:
    """Plug-in that notes which functions of the package each test and each fixture calls, and how long a test takes."""

    def __init__(self) -> None:
        self.by_name: dict[str, set[Place]] = {}
        self.seconds: dict[str, float] = {}
        self.stack: list[set[Place]] = [set()]

    def _trace(self, frame: FrameType, *_: object) -> None:
        if "/cycloid_profile/" in frame.f_code.co_filename:
            self.stack[-1].add(place_of(frame.f_code))

    def _noted(self, name: str) -> Iterator[None]:
        self.stack.append(self.by_name.setdefault(name, set()))
        for trace in (sys.settrace, threading.settrace):  # kernels run in threads, one a core
            trace(self._trace)
        yield
        self.stack.pop()
        if len(self.stack) == 1:
            for trace in (sys.settrace, threading.settrace):
                trace(None)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_fixture_setup(self, fixturedef: pytest.FixtureDef[object]) -> Iterator[None]:
        yield from self._noted(fixturedef.argname)

    @pytest.hookimpl(hookwrapper=True)
    def pytest_runtest_call(self, item: pytest.Item) -> Iterator[None]:
        yield from self._noted(item.nodeid)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        self.seconds[report.nodeid] = self.seconds.get(report.nodeid, 0.0) + report.duration


class Runs:
    """Plug-in of pytest that waits for mutants instead of running the tests once."""

    def __init__(self, mutants: TextIO, answers: TextIO) -> None:
        self.mutants, self.answers = mutants, answers

    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        touched, seconds = self.noted(session)
        session.items.sort(key=lambda item: seconds[item.nodeid])
        for line in self.mutants:
            with TemporaryDirectory() as cache:
                if not (child := os.fork()):
                    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 5))
                    os.environ[CACHE] = cache
                    places = change(*json.loads(line))
                    session.items = [item for item in session.items if touched[item.nodeid] & places]
                    os._exit(status(session))
                ended = os.waitpid(child, 0)[1]
            print("\nstatus", os.waitstatus_to_exitcode(ended), file=self.answers, flush=True)
        return True

    @staticmethod
    def noted(session: pytest.Session) -> tuple[dict[str, set[Place]], dict[str, float]]:
        """Functions that each test touches, by itself or by its fixtures, and its time. All tests pass, or it ends."""
        read, write = os.pipe()
        cache = TemporaryDirectory()
        if not os.fork():
            os.environ[CACHE] = cache.name
            session.config.pluginmanager.register(notes := Touched())
            if status(session) == 0:
                calls = {
                    i.nodeid: [notes.by_name.get(name, ()) for name in (i.nodeid, *i.fixturenames)]
                    for i in session.items
                }
                with os.fdopen(write, "wb") as file:
                    pickle.dump(({test: set().union(*sets) for test, sets in calls.items()}, notes.seconds), file)
            os._exit(0)
        os.close(write)
        with cache, os.fdopen(read, "rb") as file:
            return pickle.load(file)


def status(session: pytest.Session) -> int:
    """1 if a test fails, 8 if there is none, else 0."""
    if not session.items:
        return 8
    try:
        pytest_runtestloop(session)
    except BaseException:
        return 1
    return int(session.testsfailed > 0)


if __name__ == "__main__":
    runs = Runs(os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w"))
    pytest.main(["-p", "no:cacheprovider", "-n", "0", "-x", "-q", *sys.argv[1:]], plugins=[runs])
