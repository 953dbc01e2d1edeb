"""Hostile surroundings of the process: pipes that break, streams that are closed, full disks, signals and kills."""

from __future__ import annotations

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
RV40E = ROOT / "examples" / "rv40e.toml"
COMMAND = [sys.executable, "-m", "cycloid_profile"]
# Streams are buffered, as on most machines: what is left in a buffer is written, or fails, at the end of the process.
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT), "PYTHONUNBUFFERED": ""}

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and shells of POSIX")


def shell(line: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """A line of bash with ``$RUN`` for the command line; its status is that of the first command of a pipe."""
    return subprocess.run(
        ["bash", "-c", f'RUN="{" ".join(COMMAND)}"; {line}'],
        cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("line", "status", "says"),
    [
        ("$RUN catalog | true; exit ${PIPESTATUS[0]}", (0, 141), ""),
        ("$RUN catalog --json | true; exit ${PIPESTATUS[0]}", (0, 141), ""),
        ("$RUN --help | true; exit ${PIPESTATUS[0]}", (0, 141), ""),
        ("$RUN catalog >&-", (0,), ""),
        ("$RUN catalog rv40e >&- 2>&-", (0,), ""),
        ("$RUN catalog <&- >&- 2>&-", (0,), ""),
        ("$RUN catalog >/dev/full", (2,), "cannot be printed"),
        ("$RUN catalog rv40e >/dev/full", (2,), "cannot be printed"),
        ("$RUN build nowhere.toml 2>/dev/full", (2,), ""),
    ],
)
def test_streams_that_fail_are_no_traceback(line: str, status: tuple[int, ...], says: str, tmp_path: Path) -> None:
    done = shell(line, tmp_path)
    assert done.returncode in status, done.stderr
    assert "Traceback" not in done.stderr
    assert "Exception ignored" not in done.stderr
    assert says in done.stderr
    assert not any(tmp_path.iterdir())


def test_a_file_does_not_receive_what_a_closed_stream_would(tmp_path: Path) -> None:
    assert shell("$RUN catalog rv40e --out mine.toml >&- 2>&-", tmp_path).returncode == 0
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8").startswith("#:schema")


@pytest.mark.slow
@pytest.mark.parametrize("format_name", ["csv", "dxf", "step", "3mf", "stl", "drawing", "gcode"])
def test_a_full_disk_is_one_sentence_and_leaves_nothing(format_name: str, tmp_path: Path) -> None:
    # A limit on the size of files fails a write as a full disk does, in every library.
    done = shell(f"ulimit -f 20; trap '' XFSZ; $RUN export {RV40E} --format {format_name} --out out", tmp_path)
    assert done.returncode == 2, done.stderr
    assert "Traceback" not in done.stderr
    assert not any(tmp_path.iterdir())


def package(folder: Path) -> str:
    """Hash of the spec of a package, each file of which is as its manifest says."""
    listed = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["files"]
    for entry in listed:
        assert hashlib.sha256((folder / entry["path"]).read_bytes()).hexdigest() == entry["sha256"], entry["path"]
    (spec,) = {entry["spec_sha256"] for entry in listed}
    return str(spec)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_signal_at_any_time_leaves_one_package_whole(number: signal.Signals, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    text = RV40E.read_text(encoding="utf-8").replace("equidistant_um = 6.0", "equidistant_um = 7.0")
    text = text.replace('["dxf", "step", "csv", "gcode", "cmm"]', '["dxf", "csv", "step"]')
    other.write_text(text, encoding="utf-8")
    out = tmp_path / "out"
    assert shell(f"$RUN build {RV40E} --out {out}", tmp_path).returncode == 0
    first = package(out)
    began = time.monotonic()
    assert shell(f"$RUN build other.toml --out {tmp_path / 'second'}", tmp_path).returncode == 0
    whole = time.monotonic() - began
    seen = set()
    for share in (0.4, 0.9, 1.0):
        with subprocess.Popen(
            [*COMMAND, "build", str(other), "--out", str(out)],
            cwd=tmp_path, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        ) as process:  # fmt: skip
            time.sleep(share * whole)
            process.send_signal(number)
            _, errors = process.communicate(timeout=300)
        assert package(out) in (first, package(tmp_path / "second"))
        assert "Traceback" not in errors
        seen.add(process.returncode)
        if number != signal.SIGKILL and process.returncode == 128 + number:
            new = package(out) != first
            said = f"the new files in {str(out)!r} are whole" if new else "files of earlier runs are as they were"
            assert said in errors
            assert not list(tmp_path.glob(".*partial")), "nothing half done is left"
        if package(out) != first:
            break
    assert seen & {128 + number, -number}


def is_running(process: int) -> bool:
    # A process that has ended, but that nobody has waited for, still has a number.
    done = subprocess.run(["ps", "-o", "stat=", "-p", str(process)], capture_output=True, text=True, check=False)
    return bool(done.stdout.strip()) and not done.stdout.startswith("Z")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL])
def test_a_signal_while_the_kernel_loads_leaves_the_old_package_and_no_process(
    number: signal.Signals, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    assert shell(f"$RUN export {RV40E} --format csv --out {out}", tmp_path).returncode == 0
    first = {path.name: path.read_bytes() for path in out.iterdir()}
    # The process of the kernel says that it has begun to load, and takes long.
    (tmp_path / "build123d.py").write_text(
        "import os, pathlib, time\n"
        "file = pathlib.Path(__file__).with_name('loading')\n"
        "file.with_suffix('.new').write_text(str(os.getpid()))\n"
        "file.with_suffix('.new').rename(file)\n"
        "time.sleep(100.0)\n",
        encoding="utf-8",
    )
    process = subprocess.Popen(
        [*COMMAND, "export", str(RV40E), "--format", "csv", "step", "--out", str(out)],
        env={**ENVIRONMENT, "PYTHONPATH": f"{tmp_path}:{ROOT}"}, start_new_session=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    loading = tmp_path / "loading"
    while not loading.exists():
        assert process.poll() is None
        time.sleep(0.01)
    # As from a terminal: to the whole group.
    os.killpg(process.pid, number)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == (-number if number == signal.SIGKILL else 128 + number), errors
    assert "Traceback" not in errors
    assert {path.name: path.read_bytes() for path in out.iterdir()} == first
    child, until = int(loading.read_text()), time.monotonic() + 10.0
    while is_running(child) and time.monotonic() < until:
        time.sleep(0.05)
    assert not is_running(child)


@pytest.mark.slow
def test_an_interrupt_of_the_import_of_the_kernel_is_one(tmp_path: Path) -> None:
    # The kernel in C turns an interrupt of its import into an ImportError, as this module does.
    (tmp_path / "build123d.py").write_text(
        "import os, signal\n"
        "try:\n    os.kill(os.getpid(), signal.SIGINT)\n    sum(range(10**6))\n"
        "except KeyboardInterrupt:\n    raise ImportError('interrupted') from None\n",
        encoding="utf-8",
    )
    (tmp_path / "script.py").write_text(
        "from cycloid_profile.export.writing import require_cad_kernel\nrequire_cad_kernel()\n", encoding="utf-8"
    )
    done = subprocess.run(
        [sys.executable, str(tmp_path / "script.py")],
        env=ENVIRONMENT, capture_output=True, text=True, timeout=300, check=False,
    )  # fmt: skip
    assert done.returncode == -signal.SIGINT, done.stderr
    assert "KeyboardInterrupt" in done.stderr
    assert "LibraryMissing" not in done.stderr
