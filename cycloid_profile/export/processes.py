"""Another process that loads the CAD kernel while the design is computed, and then does a part of the work."""

from __future__ import annotations

import contextlib
import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from typing import Any

from cycloid_profile.effects import load_plugins, plugin_sources
from cycloid_profile.errors import CycloidError, PluginError
from cycloid_profile.export.writing import signals_deferred

# Formats that load the CAD kernel, the DXF for its area.
WITH_KERNEL = frozenset({"dxf", "step", "step-assembly", "parts-step", "parts-3mf", "parts-stl"})
_COMMAND = (
    "import signal; signal.signal(signal.SIGINT, signal.SIG_IGN); "
    "import cycloid_profile.export.formats; "  # what most jobs need, before they come
    "from cycloid_profile.export.processes import work_for_another_process as work; work()"
)


class CadProcess:
    """A process for the formats of ``WITH_KERNEL`` among ``formats``; none where there are none.

    build123d takes 3 s to import. The process imports it while the design is computed, and writes while other files
    are made here. Ctrl-C does not reach it: it ends with this object, or with its parent.
    """

    def __init__(self, formats: Sequence[str]) -> None:
        self.formats = tuple(name for name in dict.fromkeys(formats) if name in WITH_KERNEL)
        self._has_job = False
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
        command = [sys.executable, "-c", _COMMAND]
        # A group of its own: the terminal sends its signals to the group of this process.
        options: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "process_group": 0}
        # An interrupt between the start of the process and its handle would leave it without an owner.
        with signals_deferred():
            self._process = subprocess.Popen(command, env=environment, **options) if self.formats else None

    def __enter__(self) -> CadProcess:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is not None:
            with signals_deferred():
                self._process.kill()
                self._process.communicate()

    def start(self, job: Callable[[], Any]) -> None:
        """Begin the job, which can be pickled unless it holds what another process cannot import."""
        if self._process is None or self._process.stdin is None:
            return
        # Effects and laws of a script or notebook cannot be imported by another process.
        with contextlib.suppress(PluginError, pickle.PicklingError, AttributeError, TypeError, BrokenPipeError):
            # Plugins first: the job may hold their effects.
            packed = (plugin_sources(), pickle.dumps(job))
            pickle.dump(packed, self._process.stdin)
            self._process.stdin.flush()
            self._has_job = True

    def result(self) -> Any:
        """What the job returned, when it is done; raises its errors.

        None where no other process has taken the job, or was ended by others.
        """
        if self._process is None or not self._has_job or self._process.stdout is None:
            return None
        # Its input stays open: the process ends where it is closed.
        try:
            outcome = pickle.load(self._process.stdout)
        except (EOFError, pickle.UnpicklingError):
            return None
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome


def work_for_another_process() -> None:
    """Do the job on standard input; the outcome goes to standard output."""
    # Only the result goes to the pipe, whatever the kernel prints.
    pipe = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    jobs: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(jobs,), daemon=True).start()
    # The exporters say what is missing.
    with contextlib.suppress(ImportError):
        import build123d  # noqa: F401 - while the design is computed
    try:
        plugins, packed = jobs.get()
        load_plugins(plugins, must_register=False)
        job = pickle.loads(packed)
    except (AttributeError, ImportError, PluginError, pickle.UnpicklingError):
        return
    try:
        outcome = job()
    except (CycloidError, OSError, MemoryError) as error:
        outcome = error
    with pipe:
        pickle.dump(outcome, pipe)


def _listen(jobs: queue.SimpleQueue[Any]) -> None:
    """Pass the job on, and end the process when the one that wants the files has gone."""
    with contextlib.suppress(EOFError, OSError, pickle.UnpicklingError), os.fdopen(os.dup(0), "rb") as source:
        jobs.put(pickle.load(source))
        # The other side writes no more; this returns when it closes, even by a kill.
        os.read(0, 1)
    os._exit(1)
