"""A real cluster of two worker processes: the same answers, one of them killed in the middle.

The processes are those a user would start, without nannies, so that what is killed stays dead.
"""

from __future__ import annotations

import contextlib
import gc
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from cycloid_profile.errors import ToleranceError
from cycloid_profile.tolerance.inputs import tolerances_of
from cycloid_profile.tolerance.study import Cluster, Draws, Study, Threads, run

pytest.importorskip("distributed")
# A worker without a scheduler leaves by itself, should these tests be killed before they can see to it.
ALONE = ("--no-nanny", "--no-dashboard", "--host", "127.0.0.1", "--death-timeout", "300")
PATIENCE = 300.0  # s; a worker imports for a while on a busy machine
pytestmark = [
    pytest.mark.slow,
    # A client that loses its scheduler or closes leaves sockets and coroutines to the garbage collector.
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
]


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_for(what: Callable[[], bool]) -> None:
    until = time.monotonic() + PATIENCE
    while not what():
        assert time.monotonic() < until, "in vain"
        time.sleep(0.05)


@pytest.fixture
def started(tmp_path: Path) -> Iterator[Callable[..., subprocess.Popen[bytes]]]:
    """Starts processes and kills them at the end, whatever happened."""
    begun: list[subprocess.Popen[bytes]] = []
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), "OMP_NUM_THREADS": "1"}

    def start(*arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", *arguments]
        with (tmp_path / f"{arguments[0]}-{len(begun)}.log").open("wb") as log:
            begun.append(subprocess.Popen(command, cwd=tmp_path, env=environment, stdout=log, stderr=log))
        return begun[-1]

    yield start
    for process in begun:
        with contextlib.suppress(ProcessLookupError):
            process.kill()
    for process in begun:
        process.wait(timeout=PATIENCE)


def listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture
def scheduler(started) -> str:
    port = free_port()
    started("scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard", "--idle-timeout", "600 s")
    wait_for(lambda: listens(port))
    return f"tcp://127.0.0.1:{port}"


@pytest.fixture
def workers(started, scheduler: str) -> list[subprocess.Popen[bytes]]:
    """Two workers of one thread each, in touch with the scheduler."""
    begun = [started("worker", scheduler, *ALONE, "--nthreads", "1") for _ in range(2)]
    import distributed

    with distributed.Client(scheduler, timeout=PATIENCE) as client:
        client.wait_for_workers(2, timeout=PATIENCE)
    return begun


@pytest.fixture(scope="module")
def study(small) -> Study:
    tables = [{"name": "single_pin_error", "each": "pin", "amount_um": {}, "batch_share": 0.3}]
    return Study(small, Draws(tolerances_of(tables, [], small)), ("backlash_arcmin",), 1000, chunk=32)


@pytest.fixture(scope="module")
def local(study, tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("local")
    run(study, folder, Threads(2))
    return contents(folder)


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def test_a_cluster_gives_the_same_bits(study, local, scheduler, workers, tmp_path):
    run(study, tmp_path / "out", Cluster(scheduler))
    assert contents(tmp_path / "out") == local
    # A second study on the same workers, longer: what was there stays.
    said: list[str] = []
    run(study, tmp_path / "out", Cluster(scheduler), said.append)
    assert said == ["32 of 32 chunks are there from a run before"]
    assert all(one.poll() is None for one in workers)


def test_a_worker_that_is_killed_is_made_good_by_the_other(study, local, scheduler, workers, tmp_path):
    lines: list[str] = []

    def interrupt(line: str) -> None:
        lines.append(line)
        if len(lines) == 4:
            workers[0].send_signal(signal.SIGKILL)

    run(study, tmp_path / "out", Cluster(scheduler), interrupt)
    assert workers[0].wait(timeout=PATIENCE) == -signal.SIGKILL
    assert workers[1].poll() is None
    assert len(lines) == study.chunks
    assert contents(tmp_path / "out") == local


def test_the_last_worker_killed_and_another_come(study, local, scheduler, workers, started, tmp_path):
    lines: list[str] = []

    def interrupt(line: str) -> None:
        lines.append(line)
        if len(lines) == 2:
            for one in workers:
                one.kill()
            started("worker", scheduler, *ALONE, "--nthreads", "2")

    run(study, tmp_path / "out", Cluster(scheduler), interrupt)
    assert contents(tmp_path / "out") == local


def test_workers_or_a_scheduler_that_stay_away_end_in_a_sentence(study, scheduler, workers, tmp_path, monkeypatch):
    monkeypatch.setattr("cycloid_profile.tolerance.study.workers._SILENCE", 2.0)
    lines: list[str] = []

    def interrupt(line: str) -> None:
        lines.append(line)
        if len(lines) == 2:
            for one in workers:
                one.kill()

    with pytest.raises(ToleranceError, match="without workers") as caught:
        run(study, tmp_path / "out", Cluster(scheduler), interrupt)
    assert "finished chunks are kept" in sentence(caught, scheduler)
    kept = len(list((tmp_path / "out").glob("part-*.parquet")))
    assert kept >= 2
    run(study, tmp_path / "out", Threads(1), lines.append)
    assert f"{kept} of {study.chunks} chunks are there from a run before" in lines


def sentence(caught: pytest.ExceptionInfo[ToleranceError], address: str) -> str:
    error = caught.value
    assert error.what == "scheduler"
    assert address in str(error.value)
    assert error.limit
    assert error.remedy
    assert "\n" not in str(error)
    return str(error)


def test_no_scheduler_is_one_sentence(study, tmp_path, monkeypatch):
    monkeypatch.setattr("cycloid_profile.tolerance.study.workers._TIMEOUT", 1.0)
    address = f"tcp://127.0.0.1:{free_port()}"
    with pytest.raises(ToleranceError) as caught:
        run(study, tmp_path, Cluster(address))
    assert "cannot be reached" in sentence(caught, address)
    assert not list(tmp_path.glob("part-*"))


@pytest.mark.parametrize(
    "address", ["nowhere at all", "tcp://", "smoke://127.0.0.1:1", "tls://127.0.0.1:1", "tcp://127.0.0.1:99999", ""]
)
def test_an_address_that_is_none_is_one_sentence(study, tmp_path, monkeypatch, address):
    monkeypatch.setattr("cycloid_profile.tolerance.study.workers._TIMEOUT", 1.0)
    with pytest.raises(ToleranceError) as caught:
        run(study, tmp_path, Cluster(address))
    sentence(caught, address)


@pytest.mark.parametrize(
    "says",
    [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n" * 50, b"\xff" * 64, (3 * 2**60).to_bytes(8, "little") * 4],
    ids=["nothing", "a web server", "bytes", "a length of 3 EiB"],
)
def test_another_program_at_the_address_is_one_sentence(study, tmp_path, monkeypatch, says):
    monkeypatch.setattr("cycloid_profile.tolerance.study.workers._TIMEOUT", 1.0)
    with socket.create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            kept = []
            with contextlib.suppress(OSError):
                while True:
                    kept.append(server.accept()[0])
                    kept[-1].sendall(says)

        threading.Thread(target=answer, daemon=True).start()
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with pytest.raises(ToleranceError) as caught:
            run(study, tmp_path, Cluster(address))
    assert "cannot be reached" in sentence(caught, address)
    assert not list(tmp_path.iterdir())


def test_what_came_of_no_address_does_not_outlive_the_sentence(study, tmp_path, monkeypatch):
    # A client left to the garbage collector can be closed while the next one starts, and both wait for ever.
    import distributed

    def still_open() -> set[int]:
        return {id(one) for one in gc.get_objects() if type(one) is distributed.Client and one.status != "closed"}

    monkeypatch.setattr("cycloid_profile.tolerance.study.workers._TIMEOUT", 1.0)
    of_other_tests = still_open()
    for address in ("tcp://", f"tcp://127.0.0.1:{free_port()}"):
        with pytest.raises(ToleranceError):
            run(study, tmp_path, Cluster(address))
        assert still_open() <= of_other_tests


def test_a_scheduler_without_workers_is_one_sentence(study, scheduler, tmp_path):
    with pytest.raises(ToleranceError) as caught:
        run(study, tmp_path, Cluster(scheduler))
    assert "has no workers" in sentence(caught, scheduler)


def test_a_chunk_that_fails_everywhere_is_one_sentence(study, scheduler, workers):
    # A study that the workers cannot compute: its reducers have no balance to start from.
    case = replace(study.reducer.case, torque=1e12)
    broken = replace(study, reducer=replace(study.reducer, case=case), wanted=("lost_motion_arcmin",))
    with pytest.raises(ToleranceError) as caught:
        for _ in Cluster(scheduler).results(broken, [0]):
            pass
    assert "lost a chunk" in sentence(caught, scheduler)
    # And the workers are there for the next.
    assert all(one.poll() is None for one in workers)
