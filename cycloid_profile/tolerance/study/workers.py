"""Run a study: its chunks are computed by threads of this machine or by the workers of a Dask cluster."""

from __future__ import annotations

import gc
import os
import pickle
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any, Protocol, TypeVar

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.effects import load_plugins, plugin_sources
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.model import Quantities
from cycloid_profile.tolerance.study.chunks import Study
from cycloid_profile.tolerance.study.store import Store

# Queued chunks per thread of a cluster: enough to keep it busy, few enough for the memory of the scheduler.
_QUEUED = 3
_TIMEOUT = 10.0  # s to find a scheduler
_SILENCE = 20.0  # s without a scheduler or any worker after which a study ends; finished chunks are kept
_POLL = 0.02  # s between two looks at a cluster; a chunk takes longer
_MOST_THREADS = 1024
# Times that a chunk is computed whose result dies with its worker; each needs one more worker to die.
_TRIES = 5

T = TypeVar("T")


class Workers(Protocol):
    """A method to compute chunks."""

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        """Chunks with their results, in order of completion or of number."""
        ...


def run(
    study: Study, folder: Path, workers: Workers | None = None, progress: Callable[[str], None] = lambda _: None
) -> Store:
    """All results of a study in ``folder``, each chunk written when it is finished; chunks of an interrupted run are
    reused.

    Raises ``ToleranceError`` if the folder cannot be written to, or the workers cannot compute.
    """
    store = Store(folder, study, study.quantity_model.names)
    missing = store.missing()
    known, began = study.chunks - len(missing), time.monotonic()
    if known:
        progress(f"{known} of {study.chunks} chunks are there from a run before")
    with ExitStack() as claimed:
        # Files of another study are not touched before there is a result: the workers may be out of reach.
        for done, (number, values) in enumerate((workers or Threads()).results(study, missing), start=1):
            if done == 1:
                claimed.enter_context(store.claimed())
            store.put(number, values)
            seconds = (time.monotonic() - began) / done * (len(missing) - done)
            reducers = min((known + done) * study.chunk, study.samples)
            progress(f"{reducers:,} of {study.samples:,} reducers, {seconds:.0f} s to go")
        if not missing:
            claimed.enter_context(store.claimed())
    return store


@dataclass(frozen=True, slots=True)
class Threads:
    """``count`` threads of this machine, None for one a core."""

    count: int | None = None

    def __post_init__(self) -> None:
        if self.count is not None and not 1 <= self.count <= _MOST_THREADS:
            remedy = "leave it out for one a core"
            raise ToleranceError("threads", self.count, f"is no number from 1 to {_MOST_THREADS}", remedy)

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        # The models that chunks share are made before they start: two threads would make them twice.
        assert study.quantity_model.answers
        with ThreadPoolExecutor(self.count or cores()) as pool:
            try:
                yield from zip(numbers, pool.map(study.values, numbers), strict=True)
            finally:
                pool.shutdown(cancel_futures=True)


def cores() -> int:
    """Number of cores this process may use; all cores of the machine if the system does not report it."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def on_all_cores(compute: Callable[[T], FloatArray], items: Iterable[T]) -> list[FloatArray]:
    """Arrays of all ``items`` in their order, computed by one thread a core."""
    with ThreadPoolExecutor(cores()) as pool:
        return list(pool.map(compute, items))


@dataclass(frozen=True)
class ParallelQuantities:
    """Quantities evaluated in parallel: each core computes some of the reducers."""

    answers: Quantities

    @property
    def names(self) -> tuple[str, ...]:
        return self.answers.names

    def of(self, x: FloatArray) -> FloatArray:
        return np.concatenate(on_all_cores(self.answers.of, np.array_split(x, min(cores(), max(len(x), 1)))))


@dataclass(frozen=True, slots=True)
class Cluster:
    """The workers of the Dask cluster at ``scheduler``, such as ``tcp://host:8786``.

    Each task contains all its data. If a worker is lost, the scheduler gives its chunks to the others.
    """

    scheduler: str

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        """See ``Workers.results``.

        Raises ``ToleranceError`` if there is no such scheduler, it has no workers, or they cannot compute.
        """
        distributed = _distributed()
        data = portable(study)
        name = f"cycloid-{study.fingerprint[:24]}-{study.samples}"
        client = self._client(distributed)
        try:
            if not client.scheduler_info()["workers"]:
                raise self._refusal("has no workers", "start some with 'dask worker ADDRESS'")
            tries = dict.fromkeys(numbers, 0)

            def submitted(number: int) -> Any:
                tries[number] += 1
                return client.submit(chunk_values, data, number, key=(f"{name}-{number}", tries[number]))

            waiting = iter(numbers)
            queued = {submitted(n): n for n in islice(waiting, _QUEUED * max(1, sum(client.nthreads().values())))}
            done = distributed.as_completed(list(queued), with_results=False, raise_errors=False)
            while queued:
                future = self._next(done, client)
                number = queued.pop(future)
                answer = self._answer(future, client)
                if answer is not None:
                    yield answer
                    again = list(islice(waiting, 1))
                elif tries[number] < _TRIES:
                    again = [number]
                else:
                    raise self._refusal(f"lost chunk {number} {_TRIES} times", "see the logs of its workers")
                more = {submitted(n): n for n in again}
                queued.update(more)
                done.update(list(more))
        finally:
            client.close()

    def _next(self, done: Any, client: Any) -> Any:
        """The next task that ends. Raises ``ToleranceError`` if the scheduler or all its workers are gone for long."""
        alive = time.monotonic()
        while not done.has_ready():
            now = time.monotonic()
            if self._has_workers(client):
                alive = now
            if now - alive > _SILENCE:
                raise self._gone()
            time.sleep(_POLL)
        return next(done)

    def _answer(self, future: Any, client: Any) -> tuple[int, FloatArray] | None:
        """Result of a finished task, None where it was lost with the worker that held it."""
        if future.status == "error":
            raise self._refusal(
                f"lost a chunk ({future.exception()})", "install the same version of cycloid-profile on its workers"
            )
        while True:
            try:
                answer: tuple[int, FloatArray] = future.result(timeout=_SILENCE)
            except CancelledError:
                return None
            except TimeoutError:
                # Its worker died after it had finished: it waits for another one.
                if not self._has_workers(client):
                    raise self._gone() from None
            else:
                return answer

    @staticmethod
    def _has_workers(client: Any) -> bool:
        return client.status == "running" and bool(client.scheduler_info()["workers"])

    def _gone(self) -> ToleranceError:
        return self._refusal(
            f"has been without workers for {_SILENCE:.0f} s, or has ended",
            "start it and its workers again, then repeat the command: finished chunks are kept",
        )

    def _client(self, distributed: Any) -> Any:
        connected: list[Any] = []
        reasons: list[str] = []

        def connect() -> None:
            try:
                connected.append(distributed.Client(self.scheduler, timeout=_TIMEOUT))
            except Exception as error:
                # Another program may answer at that address with anything at all.
                reasons.append(str(error).split("\n")[0] or "no answer")

        # Its own time limit does not hold where another program keeps the connection open.
        attempt = threading.Thread(target=connect, daemon=True)
        attempt.start()
        attempt.join(2.0 * _TIMEOUT)
        if connected:
            return connected[0]
        # An unconnected client closes only on garbage collection, which could deadlock while the next one starts.
        gc.collect()
        reason = reasons[0] if reasons else "it is no Dask scheduler"
        raise self._refusal(
            f"cannot be reached ({reason})", "start one with 'dask scheduler', or leave --scheduler out"
        )

    def _refusal(self, what: str, remedy: str) -> ToleranceError:
        return ToleranceError("scheduler", f"'{self.scheduler}'", what, remedy, " ")


def portable(study: Study) -> bytes:
    """A study with the plug-ins whose effects it may hold, for another process.

    Raises ``PluginError`` for an effect that another process cannot import.
    """
    return pickle.dumps((plugin_sources(), pickle.dumps(replace(study))))


def chunk_values(data: bytes, number: int) -> tuple[int, FloatArray]:
    """Results of a chunk of a ``portable`` study; runs on a worker of a cluster."""
    return number, _unpickled(data).values(number)


@lru_cache(maxsize=4)
def _unpickled(data: bytes) -> Study:
    """The study with the models that its chunks share, made once in each worker."""
    plugins, held = pickle.loads(data)
    load_plugins(plugins, must_register=False)  # first: pickle finds their classes in the modules they come from
    study: Study = pickle.loads(held)
    return study


def _distributed() -> Any:
    try:
        import distributed
    except ImportError as error:
        raise ToleranceError(
            "--scheduler", "given", f"needs Dask, which cannot be imported ({error})",
            "install it with 'pip install \"cycloid-profile[cluster]\"'", " ",
        ) from None  # fmt: skip
    return distributed
