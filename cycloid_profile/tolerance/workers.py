"""Who computes the chunks of a study: threads of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

import gc
import os
import pickle
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from cycloid_profile.arrays import FloatArray
from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.quantities import Answers
from cycloid_profile.tolerance.study import Study

# Chunks under way for each worker: enough to keep it busy, few enough to hold their answers.
_AHEAD = 3
_TIMEOUT = 10.0  # s to find a scheduler


class Workers(Protocol):
    """Someone who computes chunks."""

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        """Chunks with their answers, in the order they are done."""
        ...


@dataclass(frozen=True, slots=True)
class Threads:
    """``count`` threads of this machine, None for one a core."""

    count: int | None = None

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        """See ``Workers.results``."""
        # What all chunks share is made before they start: two threads would make it twice.
        assert study.measures.answers
        count = self.count or cores()
        left = list(numbers)[::-1]
        under_way: dict[Future[FloatArray], int] = {}
        with ThreadPoolExecutor(count) as pool:
            try:
                while left or under_way:
                    while left and len(under_way) < _AHEAD * count:
                        number = left.pop()
                        under_way[pool.submit(study.values, number)] = number
                    done, _ = wait(under_way, return_when=FIRST_COMPLETED)
                    for future in done:
                        yield under_way.pop(future), future.result()
            finally:
                for future in under_way:
                    future.cancel()


def cores() -> int:
    """Cores this process may run on, where the system tells; those of the machine elsewhere."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class SideBySide:
    """``answers`` computed by all cores, each for some of the reducers; the same answers."""

    answers: Answers

    @property
    def names(self) -> tuple[str, ...]:
        """See ``Answers.names``."""
        return self.answers.names

    def of(self, x: FloatArray) -> FloatArray:
        """See ``Answers.of``."""
        with ThreadPoolExecutor(cores()) as pool:
            return np.concatenate(list(pool.map(self.answers.of, np.array_split(x, min(cores(), max(len(x), 1))))))


@dataclass(frozen=True, slots=True)
class Cluster:
    """The workers of the Dask cluster at ``scheduler``, such as ``tcp://host:8786``.

    A task carries all it needs: where a worker is lost, the scheduler gives its chunks to the others.
    """

    scheduler: str

    def results(self, study: Study, numbers: Sequence[int]) -> Iterator[tuple[int, FloatArray]]:
        """See ``Workers.results``.

        Raises ``ToleranceError`` if there is no such scheduler, it has no workers, or they cannot compute.
        """
        distributed = _distributed()
        data = pickle.dumps(replace(study))
        name = f"cycloid-{study.fingerprint[:24]}-{study.samples}"
        client = self._client(distributed)
        try:
            if not client.scheduler_info()["workers"]:
                raise self._refusal("has no workers", "start some with 'dask worker ADDRESS'")
            left = list(numbers)[::-1]
            done = distributed.as_completed(with_results=False, raise_errors=False)
            ahead = _AHEAD * max(1, sum(client.nthreads().values()))
            while left and ahead:
                done.add(self._submitted(client, data, name, left.pop()))
                ahead -= 1
            for future in done:
                yield self._answer(future)
                if left:
                    done.add(self._submitted(client, data, name, left.pop()))
        finally:
            client.close()

    def _submitted(self, client: Any, data: bytes, name: str, number: int) -> Any:
        return client.submit(chunk_values, data, number, key=f"{name}-{number}")

    def _answer(self, future: Any) -> tuple[int, FloatArray]:
        if future.status != "finished":
            reason = future.exception() if future.status == "error" else future.status
            raise self._refusal(
                f"lost a chunk ({reason})", "install the same version of cycloid-profile on its workers"
            )
        answer: tuple[int, FloatArray] = future.result()
        return answer

    def _client(self, distributed: Any) -> Any:
        try:
            return distributed.Client(self.scheduler, timeout=_TIMEOUT)
        except (OSError, TimeoutError, ValueError) as error:
            reason = str(error).split("\n")[0] or "no answer"
        # A client that came to nothing closes as it is collected, and would wait for ever were that while the next
        # one starts. Outside the handler nothing holds it any more.
        gc.collect()
        raise self._refusal(
            f"cannot be reached ({reason})", "start one with 'dask scheduler', or leave --scheduler out"
        )

    def _refusal(self, what: str, remedy: str) -> ToleranceError:
        return ToleranceError("scheduler", f"'{self.scheduler}'", what, remedy, " ")


def chunk_values(data: bytes, number: int) -> tuple[int, FloatArray]:
    """Answers of a chunk of a pickled study: what a worker of a cluster runs."""
    return number, _unpickled(data).values(number)


@lru_cache(maxsize=4)
def _unpickled(data: bytes) -> Study:
    """The study with what all its chunks share, made once in each worker."""
    study: Study = pickle.loads(data)
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
